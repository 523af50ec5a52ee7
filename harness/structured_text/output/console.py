"""Text for consoles: every character can be printed, also in a limited encoding."""

from __future__ import annotations

import io
import re
import sys

__all__ = ["draws", "escaped", "quoted", "spare_no_character"]

#: All characters with which charts and tables draw lines.
_DRAWN = "▁▂▃▄▅▆▇█▔╱╲─╳▲…●○"  # noqa: RUF001 - drawn lines


def draws(encoding: str | None) -> bool:
    """Return whether this encoding has characters for drawing lines; otherwise charts use ASCII."""
    try:
        _DRAWN.encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def quoted(word: object) -> str:
    """Quote a file name in a command for POSIX shells, cmd and PowerShell, if needed."""
    text = str(word)
    return text if re.fullmatch(r"[\w./\\:~+-]+", text) else f'"{text}"'


def escaped(text: str) -> str:
    r"""Return a text with its unprintable characters written as escapes, such as `\x1b`.

    Escape sequences could otherwise clear the reader's screen, or fake lines of output.
    """
    return "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode() for each in text
    )


def spare_no_character() -> None:
    r"""Make stdout and stderr write characters outside their encoding as `\xe9`, `\u2022`."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")
