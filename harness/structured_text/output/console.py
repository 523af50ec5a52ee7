"""What is printed can always be printed, also where a console knows a few characters only."""

from __future__ import annotations

import io
import re
import sys

__all__ = ["draws", "escaped", "quoted", "spare_no_character"]

#: All that charts and tables draw with.
_DRAWN = "▁▂▃▄▅▆▇█▔╱╲─╳▲…●○"  # noqa: RUF001 - drawn lines


def draws(encoding: str | None) -> bool:
    """Can lines be drawn in this encoding? Else charts are of ASCII."""
    try:
        _DRAWN.encode(encoding or "ascii")
    except (UnicodeEncodeError, LookupError):
        return False
    return True


def quoted(word: object) -> str:
    """A file's name in a command to copy, for POSIX shells, cmd and PowerShell."""
    text = str(word)
    return text if re.fullmatch(r"[\w./\\:~+-]+", text) else f'"{text}"'


def escaped(text: str) -> str:
    r"""Return a text of somebody else's with what is no character to print written as `\x1b`.

    Escape sequences would clear the screen of who reads it, or show lines that nobody has written.
    """
    return "".join(
        each if each.isprintable() else each.encode("unicode_escape").decode() for each in text
    )


def spare_no_character() -> None:
    r"""Have characters that a console does not know written as `\xe9`, `\u2022`."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper) and stream.errors == "strict":
            stream.reconfigure(errors="backslashreplace")
