"""The functions whose loops are summed up, proved."""

from __future__ import annotations

from pathlib import Path

from proving import library
from rcx_harness.verify.prove.solve import ask
from rcx_tools.evidence.prove.functions import PROPERTIES

(_FUNCTIONS,) = PROPERTIES
_PART = "FC_RCXMILLISECONDS"


def test_the_loops_lose_nothing(tmp_path: Path) -> None:
    """The last goals, which take seconds, are left to `make prove`.

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
