"""Signature help shows the pins of the call around the cursor."""

from __future__ import annotations

import pytest

from cursor import at_cursor
from structured_text.editor.features.signature import signature

_PUMP = """// Moves water.
FUNCTION_BLOCK Pump
VAR_INPUT Speed : INT := 3; END_VAR // [1/min]
VAR_IN_OUT Tank : INT; END_VAR
VAR_OUTPUT Busy : BOOL; END_VAR
METHOD Start : BOOL VAR_INPUT Fast : BOOL; END_VAR END_METHOD
END_FUNCTION_BLOCK
FUNCTION Twice : INT VAR_INPUT n : INT; END_VAR Twice := n * 2; END_FUNCTION
"""
_CALL = "Pump(Speed : INT := 3, Tank : INT, Busy => BOOL)"


def _main(body: str) -> str:
    return f"PROGRAM Main\nVAR P : Pump; a : INT; T1 : TON; END_VAR\n{body}\nEND_PROGRAM\n"


@pytest.mark.parametrize(
    ("body", "label", "active"),
    [
        ("P(|", _CALL, "Speed : INT := 3"),
        ("P(Tank := a, Busy => |", _CALL, "Busy => BOOL"),
        ("P(1, |", _CALL, "Tank : INT"),
        ("P(Speed := Twice(1), |);", _CALL, "Tank : INT"),
        ("P(Speed := Twice(|", "Twice(n : INT) : INT", "n : INT"),
        ("P.Start(|)", "Start(Fast : BOOL) : BOOL", "Fast : BOOL"),
        ("a := (1 + LIMIT(0, a, |", "LIMIT(MN : ANY, IN : ANY, MX : ANY) : ANY", "MX : ANY"),
        ("T1(IN := TRUE, PT := |", "TON(IN : BOOL, PT : TIME, Q => BOOL, ET => TIME)", "PT : TIME"),
    ],
)
def test_the_pin_that_is_being_written_is_active(body: str, label: str, active: str) -> None:
    """The calls are unfinished, as while somebody is typing."""
    found = signature(*at_cursor(_main(""), _main(body), Pump=_PUMP).args)
    assert found is not None
    (shown,) = found.signatures
    assert shown.label == label
    assert shown.parameters is not None
    assert found.active_parameter is not None
    where = shown.parameters[found.active_parameter].label
    assert isinstance(where, tuple)
    assert label[where[0] : where[1]] == active


@pytest.mark.parametrize("body", ["P();|", "a := (|1);", "IF |P.Busy THEN", "(* P(| *)"])
def test_there_is_no_signature_outside_of_a_call(body: str) -> None:
    """A parenthesis around an expression is not a call."""
    assert signature(*at_cursor(_main(""), _main(body), Pump=_PUMP).args) is None


def test_comments_explain_block_and_pin() -> None:
    """The comments stand above the block and behind the pin."""
    found = signature(*at_cursor(_main(""), _main("P(|"), Pump=_PUMP).args)
    assert found is not None
    (shown,) = found.signatures
    assert shown.documentation == "Moves water."
    assert shown.parameters is not None
    assert [one.documentation for one in shown.parameters] == ["[1/min]", None, None]


def test_a_pin_that_does_not_exist_makes_no_other_pin_active() -> None:
    """The block has no pin Wrong."""
    found = signature(*at_cursor(_main(""), _main("P(Wrong := |"), Pump=_PUMP).args)
    assert found is not None
    assert found.active_parameter is None
