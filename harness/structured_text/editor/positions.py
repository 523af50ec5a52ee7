"""Conversion of positions: the editor counts UTF-16 units from 0, the language characters from 1.

A tab is one character in both. A character beyond the basic plane has two UTF-16 units.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.language.syntax import Position

__all__ = ["from_editor", "location", "range_of", "span", "to_editor", "units", "uri_of"]

#: The largest character with a single UTF-16 unit.
_BASIC = 0xFFFF


def units(text: str) -> int:
    """Return the number of UTF-16 units of a text."""
    if text.isascii():
        return len(text)
    return len(text) + sum(ord(letter) > _BASIC for letter in text)


def to_editor(lines: Sequence[str], at: Position) -> lsp.Position:
    """Return a position of the language as a position of the editor."""
    line = lines[at.line - 1] if 0 < at.line <= len(lines) else ""
    return lsp.Position(max(0, at.line - 1), units(line[: max(0, at.column - 1)]))


def from_editor(lines: Sequence[str], position: lsp.Position) -> Position:
    """Return a position of the editor as a position of the language.

    A position behind the end of a line is the end of the line. A position inside of a character is
    the beginning of the character.
    """
    line = lines[position.line] if position.line < len(lines) else ""
    column = used = 0
    for letter in line:
        used += units(letter)
        if used > position.character:
            break
        column += 1
    return Position(position.line + 1, column + 1)


def range_of(lines: Sequence[str], at: Position, length: int) -> lsp.Range:
    """Return the range of some characters in a line."""
    return span(lines, at, Position(at.line, at.column + length))


def span(lines: Sequence[str], begin: Position, end: Position) -> lsp.Range:
    """Return the range between two positions."""
    return lsp.Range(to_editor(lines, begin), to_editor(lines, end))


def uri_of(path: Path | str) -> str:
    """Return the URI of a file."""
    return Path(str(path)).absolute().as_uri()


def location(path: Path | str, lines: Sequence[str], at: Position, length: int) -> lsp.Location:
    """Return the place of some characters in a file."""
    return lsp.Location(uri_of(path), range_of(lines, at, length))
