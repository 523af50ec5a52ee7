"""FB_Interlock is explored in all states that it reaches in a limited number of scans.

Bugs that are put into the block are detected. `make explore` explores each model to its end.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from rcx_tools.evidence.explore.interlock import (
    MODELS,
    SEEDED,
    InterlockModel,
    explored,
    replay,
    told,
)
from rcx_tools.evidence.explore.search import LIBRARY
from rcx_tools.evidence.explore.seeded import Seeded

_BOUND = 100


@pytest.mark.exhaustive(but=["gone", "entry"])
@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_nothing_is_broken_within_a_small_bound(model: InterlockModel) -> None:
    result = explored(model, limit=_BOUND)
    assert result.broken is None, [*result.broken.rules, *told(result.broken.path)]
    assert result.checked > 0


def test_two_robots_are_explored_to_the_end() -> None:
    pair = InterlockModel("pair", "two robots", robots=2, moves=("go", "out"), at_once=2)
    result = explored(pair)
    assert result.met
    assert result.states > 50


@pytest.mark.exhaustive
def test_a_waiting_robot_gets_the_area_after_the_other_has_left() -> None:
    """A robot that keeps requesting the area gets it after the other robot has left.

    In each scan the other robot requests again, gives up, or is outside. Robot 2 is called after
    robot 1, so it enters in the scan in which robot 1 leaves. Robot 1
    enters one scan later.
    """
    pair = InterlockModel("pair", "two robots", robots=2, moves=("go", "out", "called"))
    result = explored(pair)
    assert result.met
    assert result.bounds == {
        "robot 1 keeps asking, the others leave": 4,
        "robot 2 keeps asking, the others leave": 3,
    }


def test_of_a_robot_with_a_time_limit_no_grant_is_demanded() -> None:
    pair = InterlockModel("pair", "two robots", robots=2, moves=("go", "out"), timeout=2)
    assert set(explored(pair).bounds) == {"robot 1 keeps asking, the others leave"}


@pytest.mark.exhaustive(
    but=[
        "released while it is inside",
        "two hold it",
        "granted in the first scan",
    ]
)
@pytest.mark.parametrize(
    "bug", [one for one in SEEDED if one.model == "entry"], ids=lambda bug: bug.name
)
def test_a_seeded_bug_is_found(bug: Seeded, tmp_path: Path) -> None:
    model = next(one for one in MODELS if one.name == bug.model)
    result = explored(model, bug.library(tmp_path))
    assert result.broken is not None
    assert any(rule.startswith(bug.rule) for rule in result.broken.rules)
    assert replay(model, result.broken, bug.library(tmp_path)) == result.broken.rules
    assert told(result.broken.path)[-1].startswith(f"scan {len(result.broken.path)}:")


def test_every_seeded_bug_changes_the_block(tmp_path: Path) -> None:
    for bug in SEEDED:
        changed = [file for file in bug.library(tmp_path) if file not in LIBRARY]
        assert [file.stem for file in changed] == ["FB_Interlock"]
