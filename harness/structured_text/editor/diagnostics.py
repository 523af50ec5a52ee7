"""The mistakes and warnings of a program, in the form that an editor shows."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types

from structured_text.errors import InputError, in_network, shown_column
from structured_text.language.source import Unread

__all__ = ["Note", "diagnostic", "note_of_error", "note_of_unread", "place_of"]

_WORD = re.compile(r"[^\W\d]\w*|\d[\w#.]*|\S")
_SEVERITIES = {
    "error": types.DiagnosticSeverity.Error,
    "warning": types.DiagnosticSeverity.Warning,
    "information": types.DiagnosticSeverity.Information,
}


@dataclass(frozen=True)
class Note:
    """Something to show at a place of a file.

    Attributes:
        line: Line in the file, from 1.
        column: Column in the line, from 1; 0 for the whole line.
        text: What is wrong, and what to do.
        level: error, warning or information.
        code: The kind of the finding.
        href: The address of a page that explains it; empty if there is none.
        data: What a code action needs to know.
    """

    file: str
    line: int
    column: int
    text: str
    level: str = "error"
    code: str = "error"
    href: str = ""
    data: Mapping[str, object] | None = None


def note_of_error(error: InputError, otherwise: Path) -> Note:
    """Return the note for an error; an error without a file is shown in the file `otherwise`."""
    text = in_network(error.line, error.message)
    if error.hint:
        text = f"{text}; {error.hint}"
    line, column = int(error.line or 1), shown_column(error.column) or 0
    return Note(error.file or str(otherwise), line, column, text)


def note_of_unread(body: Unread) -> Note:
    """Return the note for a body in another language than Structured Text."""
    text = f"the body of {body.name} {body.says}: nothing is checked in it"
    return Note(str(body.file), body.at, 0, text, "information", "unread-body")


def diagnostic(note: Note, lines: Sequence[str], source: str) -> types.Diagnostic:
    """Return the diagnostic of a note; `lines` are those of its file."""
    return types.Diagnostic(
        range=place_of(lines, note.line, note.column),
        message=note.text,
        severity=_SEVERITIES[note.level],
        source=source,
        code=note.code,
        code_description=types.CodeDescription(note.href) if note.href else None,
        data=note.data,
    )


def place_of(lines: Sequence[str], line: int, column: int) -> types.Range:
    """Return the range of the word at a line and column, or of the text of the line.

    Line and column count from 1. The result counts UTF-16 units, as the protocol requires.
    """
    line = min(max(line, 1), max(len(lines), 1))
    text = lines[line - 1] if lines else ""
    begin, end = len(text) - len(text.lstrip()), len(text.rstrip())
    if column:
        begin = min(column - 1, len(text))
        word = _WORD.match(text, begin)
        end = word.end() if word else begin
        if end == begin and begin:  # something is missing behind the end of the line
            begin -= 1
    return types.Range(
        types.Position(line - 1, _units(text[:begin])),
        types.Position(line - 1, _units(text[: max(begin, end)])),
    )


def _units(text: Iterable[str]) -> int:
    return sum(2 if character > "\uffff" else 1 for character in text)
