"""Functions are proved with their loops replaced by sums."""

from __future__ import annotations

from pathlib import Path

import pytest

from proving import library
from rcx_tools.evidence.prove.functions import PROPERTIES
from rcx_tools.evidence.prove.solve import ask

pytestmark = pytest.mark.exhaustive

(_FUNCTIONS,) = PROPERTIES
_PART = "FC_RCXMILLISECONDS"


@pytest.mark.exhaustive
def test_the_proof_covers_all_rounds_of_the_loops(tmp_path: Path) -> None:
    """The proof with sums in place of loops covers all rounds of the loops.

    The last goals take seconds and are left to `make prove`.

    Source: head of FC_RcxMilliseconds.
    """
    goals = _FUNCTIONS.goals(library(tmp_path, "FC_RcxMilliseconds"), _PART)
    loops = [goal for goal in goals if goal.name.startswith("the loop")]
    assert len(loops) == 18
    assert {ask(goal.assumed, goal.claim, 20.0).status for goal in loops} == {"proved"}


def test_a_half_that_is_lost_is_not_proved(tmp_path: Path) -> None:
    broken = library(
        tmp_path, "FC_RcxMilliseconds", bug="half-a-millisecond-is-lost", bugs="functions"
    )
    (rounded,) = [
        goal for goal in _FUNCTIONS.goals(broken, _PART) if goal.name == "the result is rounded"
    ]
    assert ask(rounded.assumed, rounded.claim, 20.0).status == "refuted"


@pytest.mark.exhaustive(but=["FC_RcxBitsReal"])
@pytest.mark.parametrize("name", ["FC_RcxRealBits", "FC_RcxBitsReal"])
def test_a_real_and_its_bit_pattern_convert_to_each_other(tmp_path: Path, name: str) -> None:
    """A REAL and its bit pattern convert to each other without a loss.

    The long property, about the second loop, is left to `make prove`.

    Source: IEEE 754; heads of both.
    """
    goals = list(_FUNCTIONS.goals(library(tmp_path, name), name.upper()))
    ends = [goal for goal in goals if not goal.name.startswith("the loop")]
    assert len(goals) == len(ends) + 4
    assert {ask(goal.assumed, goal.claim, 20.0).status for goal in ends} == {"proved"}


@pytest.mark.exhaustive(
    but=[
        "FC_RcxRealBits-Exponent < 255 THEN-Exponent < 256 THEN-of infinity",
        "FC_RcxBitsReal-Exponent := 1;-Exponent := 0;-the loop of line 32 begins",
        "FC_RcxBitsReal-Value := 0.0 - Value-Value := Value-of a pattern of a number",
    ]
)
@pytest.mark.parametrize(
    ("name", "old", "new", "goal"),
    [
        ("FC_RcxRealBits", "Exponent > 1 DO", "Exponent > 0 DO", "the loop of line 28 goes on"),
        ("FC_RcxRealBits", "Rest >= 16777216.0", "Rest > 16777216.0", "of any other number"),
        ("FC_RcxRealBits", "Exponent := 0;", "Exponent := 1;", "that is denormal or 0"),
        ("FC_RcxRealBits", "Exponent < 255 THEN", "Exponent < 256 THEN", "of infinity"),
        ("FC_RcxRealBits", "IF Value < 0.0", "IF Value < -1.0", "of any other number"),
        ("FC_RcxBitsReal", "Exponent := 1;", "Exponent := 0;", "the loop of line 32 begins"),
        ("FC_RcxBitsReal", "3.4028234663852886E38", "3.4028233E38", "of infinity"),
        ("FC_RcxBitsReal", "Value := 0.0 - Value", "Value := Value", "of a pattern of a number"),
    ],
)
def test_a_slip_in_a_pattern_is_not_proved(
    tmp_path: Path, name: str, old: str, new: str, goal: str
) -> None:
    broken = library(tmp_path, name)
    (file,) = tmp_path.rglob(f"{name}.st")
    text = file.read_text(encoding="utf-8")
    assert text.count(old) == 1
    file.write_text(text.replace(old, new), encoding="utf-8")
    (asked,) = [one for one in _FUNCTIONS.goals(broken, name.upper()) if goal in one.name]
    assert ask(asked.assumed, asked.claim, 20.0).status == "refuted"
