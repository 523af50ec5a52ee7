"""The report of an internal error: a line on stderr, and the traceback in a file."""

from __future__ import annotations

import os
import platform
import sys
import tempfile
import traceback
from importlib.metadata import PackageNotFoundError, version

__all__ = ["report"]

_SHOWN = 200


def report(error: Exception) -> None:
    """Print one line about an unexpected error, and write its details to a file."""
    told = traceback.format_exception_only(type(error), error)[-1].strip().splitlines()
    what = told[0] if told else type(error).__name__
    what = what if len(what) <= _SHOWN else f"{what[:_SHOWN]}..."
    try:
        where = _written(error)
    except OSError:  # no folder is writable
        where = ""
        traceback.print_exception(error)
    hint = f"please report it with {where}" if where else "please report it with the lines above"
    print(f"rcx: this is an error of rcx itself: {what}; {hint}", file=sys.stderr)


def _written(error: Exception) -> str:
    """Write the traceback, versions and command line to a new file in the temporary folder."""
    try:
        own = version("rcx-harness")
    except PackageNotFoundError:
        own = "?"
    head = f"rcx {own}, Python {platform.python_version()}, {platform.platform()}\n"
    head += f"{sys.argv!r}\n\n"
    file, name = tempfile.mkstemp(prefix="rcx-error-", suffix=".txt", text=True)
    with open(file, "w", encoding="utf-8", errors="backslashreplace") as stream:
        stream.write(head + "".join(traceback.format_exception(error)))
    return os.fspath(name)
