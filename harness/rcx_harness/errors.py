"""The one kind of error a user sees: what is wrong, where, and what to do."""

from __future__ import annotations

from pathlib import Path

__all__ = ["InputError"]


class InputError(Exception):
    """Bad input of the user's: reported in one message, never as a traceback.

    Args:
        message: What is wrong, one sentence without a full stop.
        file: The file it is in, if there is one.
        line: Line in that file, from 1.
        column: Column in that line, from 1.
        hint: What to do about it, one sentence without a full stop.

    Attributes:
        exit_code: Of the command that ends with it.
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
        self.message = message
        self.file = str(file) if file is not None else None
        self.line = line
        self.column = column
        self.hint = hint
        super().__init__(str(self))

    def __str__(self) -> str:
        """`file:line:column: message (hint)`, as compilers print it."""
        where = ":".join(str(part) for part in (self.file, self.line, self.column) if part)
        text = f"{where}: {self.message}" if where else self.message
        return f"{text}; {self.hint}" if self.hint else text
