"""Positions of the editor count UTF-16 units from 0; those of the language characters from 1."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from structured_text.editor.positions import from_editor, range_of, to_editor
from structured_text.language.syntax import Position

#: A tab, a letter beyond ASCII, and a character of two UTF-16 units.
_LINES = ["\tä := 1;", "(* 😀 *) x", ""]


@pytest.mark.parametrize(
    ("at", "line", "character"),
    [
        ((1, 1), 0, 0),
        ((1, 2), 0, 1),
        ((1, 3), 0, 2),
        ((2, 4), 1, 3),
        ((2, 5), 1, 5),
        ((2, 9), 1, 9),
    ],
)
def test_positions_convert_in_both_directions(
    at: tuple[int, int], line: int, character: int
) -> None:
    """The emoji in line 2 is one character and two units of UTF-16."""
    assert to_editor(_LINES, Position(*at)) == lsp.Position(line, character)
    assert from_editor(_LINES, lsp.Position(line, character)) == Position(*at)


def test_a_position_inside_of_a_character_is_its_beginning() -> None:
    """Unit 4 of line 2 is the second half of the emoji, which is character 4."""
    assert from_editor(_LINES, lsp.Position(1, 4)) == Position(2, 4)


def test_positions_outside_of_the_text_are_moved_into_it() -> None:
    """An editor may send a position behind the last line or the end of a line."""
    assert from_editor(_LINES, lsp.Position(0, 99)) == Position(1, 9)
    assert from_editor(_LINES, lsp.Position(9, 5)) == Position(10, 1)
    assert to_editor(_LINES, Position(9, 5)) == lsp.Position(8, 0)


def test_a_range_covers_the_units_of_its_characters() -> None:
    """Two characters from the emoji on are three units."""
    found = range_of(_LINES, Position(2, 4), 2)
    assert found == lsp.Range(lsp.Position(1, 3), lsp.Position(1, 6))
