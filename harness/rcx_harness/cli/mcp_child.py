"""The process in which `rcx mcp` answers a call of a tool; it gives the tools the commands."""

from __future__ import annotations

import io
import sys
from collections.abc import Callable, Sequence
from contextlib import redirect_stderr, redirect_stdout

from rcx_harness.assistant.call import Ran
from rcx_harness.assistant.child import serve_call
from rcx_harness.cli.app import app
from structured_text.errors import InputError

__all__ = ["command"]


class _Lines(io.TextIOBase):
    """A stream that passes each line of text on; it is not a terminal."""

    def __init__(self, tell: Callable[[str], None]) -> None:
        self._tell, self._rest = tell, ""

    def write(self, text: str) -> int:
        """Pass on the lines that are complete now."""
        *lines, self._rest = (self._rest + text).split("\n")
        for line in filter(None, lines):
            self._tell(line)
        return len(text)


def command(words: Sequence[str], tell: Callable[[str], None]) -> Ran:
    """Run a command of `rcx` in this process, and return its exit code and its output.

    `tell` is called with each line on standard error, which is progress.
    """
    printed = io.StringIO()
    try:
        with redirect_stdout(printed), redirect_stderr(_Lines(tell)):
            code = app(args=list(words), prog_name="rcx", standalone_mode=False)
    except InputError:
        raise
    except Exception as error:
        # Some versions of typer contain a copy of click, other versions depend on click.
        told = getattr(error, "format_message", None)
        if told is None:
            raise
        raise InputError(told().rstrip(".")) from None
    return Ran(code if isinstance(code, int) else 0, tuple(printed.getvalue().splitlines()))


if __name__ == "__main__":
    sys.exit(serve_call(command))
