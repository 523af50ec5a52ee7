"""Errors and violated rules that are reported to the user."""

from __future__ import annotations

import errno
import os
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

__all__ = [
    "BLOCKS",
    "NO_COLUMN",
    "VARIABLES",
    "InputError",
    "OutputError",
    "UnreadError",
    "Violation",
    "did_you_mean",
    "in_network",
    "legible",
    "located",
    "near",
    "place_text",
    "refused",
    "shown_column",
    "similar",
]

try:  # a distribution that ships this package may define its own names in this module
    from structured_text_names import COMMAND as COMMAND
    from structured_text_names import DISTRIBUTION as DISTRIBUTION
except ModuleNotFoundError:
    COMMAND, DISTRIBUTION = "st", "structured-text"

BLOCKS = f"{COMMAND.upper()}_"
"""Prefix for the names of blocks that this package adds to a program."""
VARIABLES = COMMAND.capitalize()
"""Prefix for the names of variables that this package adds to a program."""

NO_COLUMN = 1_000_000
"""Columns beyond this number only tell apart the statements of a line, and are not shown."""

#: A list of names is shown in full up to this length [characters].
_LISTED = 200
#: All control characters except tab and line feed.
_CONTROLS = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f]")


def legible(text: str) -> str:
    r"""Return a message in which each control character is written as an escape such as `\x1b`.

    Names of files, variables and keys in the message may come from a third-party project. An escape
    sequence in them could clear the reader's screen or display forged lines.
    """
    return _CONTROLS.sub(lambda found: f"\\x{ord(found[0]):02x}", text)


def place_text(file: str | Path | None, line: int | None, column: int | None = None) -> str:
    """Return `file:line:column` as compilers print it, behind it the rung or network of the line.

    Parts that are None are left out. An example is `main.xml:120: Main, rung 3`.
    """
    where = ":".join(str(part) for part in (file, line, shown_column(column)) if part)
    network = getattr(line, "place", "")
    return f"{where}: {network}" if network else where


def shown_column(column: int | None) -> int | None:
    """Return a column of a file; None for a column that only tells apart statements."""
    return None if column is None or column > NO_COLUMN else column


def in_network(line: int | None, text: str) -> str:
    """Return a message that begins with the rung or network of its line, if the line has one."""
    network = getattr(line, "place", "")
    return f"{network}: {text}" if network else text


def located(file: str | Path, line: int) -> str:
    """Return file and line for a place inside a sentence, such as `main.xml:120 (Main, rung 3)`."""
    network = getattr(line, "place", "")
    return f"{file}:{line} ({network})" if network else f"{file}:{line}"


@dataclass(frozen=True)
class Violation:
    """A violation of a rule: its time [us], the name of the rule and one clear sentence."""

    t_us: int
    rule: str
    text: str


class InputError(Exception):
    """Bad input by the user. It is reported in one message, never as a traceback.

    Args:
        message: What is wrong, one sentence without a full stop.
        file: The file with the mistake, if there is one.
        line: Line in that file, from 1.
        column: Column in that line, from 1.
        hint: What to do about it, one sentence without a full stop.

    Attributes:
        exit_code: Exit code of the command that ends with this error.
    """

    exit_code = 2

    def __init__(
        self,
        message: str,
        *,
        file: str | Path | None = None,
        line: int | None = None,
        column: int | None = None,
        hint: str = "",
    ) -> None:
        # One source may have lines from two files, see `language.source.Extract`.
        place = getattr(file, "place", None)
        if place is not None and line is not None:
            file, line = place(line)
        self.message = message
        self.file = str(file) if file is not None else None
        self.line = line
        self.column = shown_column(column)
        self.hint = hint
        super().__init__(str(self))

    def __str__(self) -> str:
        """Return `file:line:column: message; hint`, as compilers print it.

        Before the message is the rung or network, if the line was translated from a drawing.
        """
        where = place_text(self.file, self.line, self.column)
        text = f"{where}: {self.message}" if where else self.message
        return legible(f"{text}; {self.hint}" if self.hint else text)


class OutputError(OSError):
    """Standard output cannot be written. Any other OSError has another cause."""


class UnreadError(OutputError):
    """The program that reads standard output has closed the pipe.

    The error has no errno, because click would then end with exit code 1.
    """


def did_you_mean(names: Sequence[str]) -> str:
    """Return a hint that suggests the given names, or an empty string without names."""
    return f"did you mean {' or '.join(names)}" if names else ""


def similar(name: str, known: Iterable[str], most: int = 2) -> list[str]:
    """Return the known names that are spelt like a name; case and underscores do not count."""
    plain = {one.lower().replace("_", ""): one for one in known}
    found = get_close_matches(name.lower().replace("_", ""), plain, most, cutoff=0.8)
    return [plain[one] for one in found]


def near(name: str, known: Iterable[str], every: str = "there are") -> str:
    """Return the hint for an unknown name: similar names, or all known names."""
    names = list(known)
    if meant := get_close_matches(name, names):
        return did_you_mean(meant)
    listed = ", ".join(names)
    if len(listed) <= _LISTED:
        return f"{every} {listed}"
    nearest = ", ".join(get_close_matches(name, names, cutoff=0.0))
    return f"the most similar of {len(names)} are {nearest}"


def refused(error: OSError) -> InputError:
    """Return the message for a failed system call, with the file if the call was for a file."""
    reason = error.strerror or str(error) or type(error).__name__
    if error.filename is not None:
        return InputError(f"cannot be accessed: {reason}", file=os.fsdecode(error.filename))
    if error.errno in (errno.EMFILE, errno.ENFILE):
        hint = "raise the limit with `ulimit -n`"
        return InputError(f"files cannot be opened: {reason}", hint=hint)
    try:
        os.getcwd()
    except OSError:
        hint = "change to another one"
        return InputError("the current folder cannot be accessed: it may be gone", hint=hint)
    return InputError(f"the operating system refused a request: {reason}")
