"""Inlay hints show the inputs that a call omits."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from cursor import FOLDER, index_of
from structured_text.editor.features.hints import hints

_PUMP = """TYPE Mode : (OFF, AUTO); END_TYPE
FUNCTION_BLOCK Pump
VAR_INPUT
  Speed : INT := 3;
  On : BOOL;
  How : Mode := AUTO;
  Rest : TIME;
  All : ARRAY [1..2] OF INT;
END_VAR
METHOD Start VAR_INPUT Fast : BOOL; END_VAR END_METHOD
END_FUNCTION_BLOCK
FUNCTION Twice : INT VAR_INPUT n : INT; more : INT := 2; END_VAR Twice := n * more; END_FUNCTION
"""


def _hints(body: str) -> list[tuple[int, int, object]]:
    text = f"PROGRAM Main\nVAR P : Pump; a : INT; t1 : TON; END_VAR\n{body}\nEND_PROGRAM\n"
    index = index_of(Main=text, Pump=_PUMP)
    whole = lsp.Range(lsp.Position(2, 0), lsp.Position(2, 999))
    found = hints(index, FOLDER / "Main.st", text, whole)
    return [(one.position.line, one.position.character, one.label) for one in found]


@pytest.mark.parametrize(
    ("body", "found"),
    [
        ("P();", [(2, 2, "Speed := 3, On := FALSE, How := AUTO, Rest := T#0s")]),
        ("P(Speed := 1, How := OFF);", [(2, 24, "On := FALSE, Rest := T#0s")]),
        ("P.Speed := 1; P(On := TRUE);", [(2, 26, "How := AUTO, Rest := T#0s")]),
        ("P.Start();", [(2, 8, "Fast := FALSE")]),
        ("a := Twice(n := 1);", [(2, 17, "more := 2")]),
        ("a := Twice(1, 2) + (a);", []),
        ("t1(IN := TRUE);", [(2, 13, "PT := T#0s")]),
        ("t1(TRUE, T#1s);", []),
        ("P(\n", []),
    ],
)
def test_a_hint_shows_the_omitted_inputs(body: str, found: list[tuple[int, int, object]]) -> None:
    """An array has no short value; an input that a statement writes does not keep its default."""
    assert _hints(body) == found


def test_an_input_of_another_call_of_the_instance_has_no_hint() -> None:
    """The second call gives Speed, which the first call then keeps in the next scan."""
    found = _hints("P(On := TRUE); P(Speed := 1, How := OFF, Rest := T#1s);")
    assert found == []


def test_many_inputs_are_in_the_tooltip() -> None:
    """Only four are shown in the line."""
    block = "FUNCTION_BLOCK Many VAR_INPUT a, b, c, d, e : INT; END_VAR END_FUNCTION_BLOCK\n"
    text = "PROGRAM Main VAR M : Many; END_VAR\nM();\nEND_PROGRAM\n"
    index = index_of(Main=text, Many=block)
    whole = lsp.Range(lsp.Position(0, 0), lsp.Position(9, 0))
    (found,) = hints(index, FOLDER / "Main.st", text, whole)
    assert found.label == "a := 0, b := 0, c := 0, d := 0, ..."
    assert found.tooltip == "This call omits:\na := 0\nb := 0\nc := 0\nd := 0\ne := 0"
