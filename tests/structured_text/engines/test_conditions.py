"""Conditions in Structured Text are evaluated over the variables of a running program."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.base import Program
from structured_text.engines.conditions import conditions
from structured_text.engines.load import build
from structured_text.errors import InputError

_PROGRAM = """TYPE STEP_OF : (STEP_IDLE, STEP_MOVE); END_TYPE
PROGRAM Work
  VAR
    Step  : STEP_OF;
    Open  : BOOL;
    Count : DINT := 3;
    Limit : TIME := T#2s;
    Fault : WORD := WORD#16#8011;
    Name  : STRING := 'Main.Open';
    Place : ARRAY [1..3] OF INT;
    Divisor : DINT;
  END_VAR
  Count := Count + DINT#1;
END_PROGRAM
"""


@pytest.fixture
def program(tmp_path: Path) -> Program:
    file = tmp_path / "work.st"
    file.write_text(_PROGRAM)
    return build([file], "builtin").program


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("Main.Step = STEP_IDLE", True),
        ("Main.Step = STEP_OF#STEP_MOVE OR Main.Open", False),
        ("NOT (Main.Open AND Main.Count > 2)", True),
        ("main.count = 3 AND ABS(Main.Count) <= 3", True),
        ("Main.Limit > T#1s", True),
        ("Main.Fault <> WORD#16#8011", False),
        ("Main.Name = 'Main.Open'", True),
        ("Main.Place[2] = 0 (* Main.Gone *)", True),
    ],
)
def test_a_condition_holds_or_not(program: Program, text: str, holds: bool) -> None:
    """A condition gives the expected value for the initial values of the program."""
    assert conditions(program, [text])[0].holds() is holds


def test_before_gives_the_value_at_the_last_mark(program: Program) -> None:
    condition = conditions(program, ["Main.Count > BEFORE(Main.Count)"])[0]
    assert not condition.holds()
    program.scan(0)
    assert condition.holds()
    assert condition.fixed(["3"]) == "Main.Count > 3"
    condition.mark()
    assert not condition.holds()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Main.Opn", "Main.Opn: Main of type Work has no member Opn; did you mean Open"),
        ("Main.Count", "Main.Count: a BOOL is expected here, not a DINT"),
        ("Main.Open AND", "an expression is expected"),
        ("Main.Step = STEP_GONE", "STEP_GONE is not declared"),
        ("Main.Place", "Main.Place is not a single value"),
        (" ", "the condition is empty"),
    ],
)
def test_a_wrong_condition_is_one_clear_message(program: Program, text: str, message: str) -> None:
    with pytest.raises(InputError) as raised:
        conditions(program, ["Main.Open", text])
    assert message in str(raised.value)
    assert "conditions.st" not in str(raised.value)


def test_a_division_by_0_is_an_error_of_the_condition(program: Program) -> None:
    condition = conditions(program, ["Main.Count / Main.Divisor > 1"])[0]
    with pytest.raises(InputError, match=r"Main.Count / Main.Divisor > 1: "):
        condition.holds()
