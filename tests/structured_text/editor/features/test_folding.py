"""Folding follows the words of a text, also while it is broken."""

from __future__ import annotations

import pytest

from cursor import FOLDER, index_of
from structured_text.editor.features.folding import folding

_TEXT = """PROGRAM Main
VAR
  a : INT;
END_VAR
IF a > 1 THEN
  a := 1;
ELSIF a > 2 THEN
  a := 2;
ELSE
  a := 3;
END_IF
CASE a OF
  1: a := 2;
END_CASE
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("text", "ranges"),
    [
        (_TEXT, [(0, 13), (1, 2), (4, 5), (6, 7), (8, 9), (11, 12)]),
        ("(* one\n two *)\n;", [(0, 1)]),
        ("// one\n// two\n\n// three\n", [(0, 1)]),
        ("PROGRAM Main\nFOR a := 1 TO 2 DO\na := 1;\n", [(0, 2), (1, 2)]),
        ("{region 'x'}\na\n{endregion}\n", [(0, 2)]),
        ("PROGRAM Main\nSet := 1;\na.IF := 2;\nEND_PROGRAM\n", [(0, 2)]),
        ("IF a THEN b; END_IF\n", []),
        ("END_IF\nEND_PROGRAM\n", []),
    ],
)
def test_parts_of_a_text_fold(text: str, ranges: list[tuple[int, int]]) -> None:
    """The line with the END, ELSE or ELSIF remains visible."""
    found = folding(index_of(), FOLDER / "Main.st", text)
    assert [(one.start_line, one.end_line) for one in found] == ranges
