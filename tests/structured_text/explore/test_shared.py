"""An exploration gives the same result with any number of workers."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import pytest

from explore_work import EVERY, Choice, Numbers
from structured_text.errors import InputError
from structured_text.explore import shared as shared_module
from structured_text.explore.search import Result, Search
from structured_text.explore.shared import Some, Stepping, shared
from structured_text.farm import Farm
from structured_text.farm.work import LostError

_SIZE = 300


@pytest.fixture
def together(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the exploration send up to five states at once to a worker from the start."""
    monkeypatch.setattr(shared_module, "SHARE", 1)
    monkeypatch.setattr(shared_module, "MOST", 5)


def explored(workers: int | None = None, limit: int = 0, depth: int = 0, **given: Any) -> Result:
    """Return the result of an exploration; `None` explores in this process, without workers."""
    make = partial(Numbers, _SIZE, **given)
    elsewhere = None if workers is None else shared(Farm(workers), Stepping(make, 1))
    return Search[Choice](make(), EVERY, 1, elsewhere).run("numbers", limit, depth)


@pytest.mark.usefixtures("together")
@pytest.mark.parametrize("limits", [{}, {"limit": 40}, {"depth": 4}, {"limit": 1}])
@pytest.mark.parametrize("broken", [{}, {77: "seventy-seven", 78: "one more"}])
def test_a_parallel_exploration_finds_the_same(
    limits: dict[str, int], broken: dict[int, str]
) -> None:
    alone = explored(None, **limits, broken=broken)
    assert explored(0, **limits, broken=broken) == alone


@pytest.mark.usefixtures("together")
def test_several_workers_find_the_same_as_one_process() -> None:
    """Exploration with workers finds the same states and depth as in one process.

    By hand: each number leads to three others, and all numbers are reached.

    The step to 2 n + 2 reaches 300 after 8 steps.
    """
    found = explored(2)
    assert found == explored()
    assert (found.states, found.transitions, found.depth, found.checked) == (300, 900, 8, 300)
    assert found.complete


@pytest.mark.usefixtures("together")
def test_a_broken_rule_before_an_error_is_reported_first() -> None:
    """State 3 leads to a broken rule, and state 4 to an error.

    One worker gets both states, and the broken rule of state 3 is reported.
    """
    found = explored(0, broken={7: "seven"}, refused=[4])
    assert found.broken is not None
    assert found.broken.rules == ("seven",)
    assert [one.number for one in found.broken.path] == [1, 1, 1]
    assert found == explored(broken={7: "seven"}, refused=[4])


@pytest.mark.usefixtures("together")
def test_an_error_is_reported_before_a_broken_rule_in_a_later_state() -> None:
    with pytest.raises(InputError, match="4 is refused"):
        explored(0, broken={13: "thirteen"}, refused=[4])


@pytest.mark.exhaustive
def test_a_worker_that_is_killed_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "0").touch()
    assert explored(2, deaths=tmp_path) == explored()
    assert not list(tmp_path.iterdir())


@pytest.mark.exhaustive
def test_a_state_that_kills_three_workers_is_named_by_its_number(tmp_path: Path) -> None:
    for number in range(4):
        (tmp_path / str(number)).touch()
    with pytest.raises(
        LostError, match=r"^3 workers died while they worked on state \d+: ended by SIGKILL"
    ):
        explored(1, deaths=tmp_path)


def test_states_sent_together_are_named_by_their_numbers() -> None:
    assert repr(Some(7, [b"", b""])) == "states 7 to 8"


def test_a_next_state_is_sent_once_by_each_worker() -> None:
    """A worker sends a next state once; later it sends an empty text for the same state.

    By hand: 1 leads to 2, 3, 4; 2 leads to 4, 5, 6; 3 leads to 6, 7, 8.
    """
    take = Stepping(partial(Numbers, _SIZE), 1).prepare()
    assert _sent(take(Some(2, [b"2", b"3"]))) == [[b"4", b"5", b"6"], [b"", b"7", b"8"]]
    assert _sent(take(Some(4, [b"1"]))) == [[b"", b"", b""]]


def test_a_repeated_item_sends_its_states_again() -> None:
    """The worker of item 2 has ended, so another worker repeats the item.

    The repeated item sends all its next states again.
    """
    take = Stepping(partial(Numbers, _SIZE), 1).prepare()
    assert _sent(take(Some(3, [b"3"]))) == [[b"6", b"7", b"8"]]
    assert _sent(take(Some(2, [b"2"]))) == [[b"4", b"5", b"6"]]


def _sent(came: Any) -> list[list[bytes]]:
    return [[step[2] for step in steps] for steps, _ in came]
