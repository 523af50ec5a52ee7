"""A guided campaign does not depend on the number of workers; its corpus prefers rare states."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from feeder import feeder
from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.guided.branch import Branch, Guided, Kept, Ran
from rcx_harness.verify.guided.corpus import Corpus, guided
from rcx_harness.verify.storm.cells import CellsOf
from rcx_harness.verify.storm.course import Course
from structured_text.bench.agenda import STIMULUS
from structured_text.farm import Farm


def _ran(features: tuple[int, ...], *kept: Kept) -> Ran:
    return Ran({}, {}, kept, features, frozenset(), 1, 1, 1, (), ())


def _state(*features: int) -> Kept:
    return Kept((), 0, features, b"")


def _runs(folder: Path, workers: int, runs: int) -> list[tuple[object, ...]]:
    """Return the results of runs, as far as they can be compared by value."""
    of = CellsOf.of([folder / "Feeder.st"], {"engine": "builtin"}, [folder / "campaign.toml"])
    corpus = Corpus(7)
    found = guided(Farm(workers), Guided(of, 7), runs, corpus)
    return [
        (
            number,
            one.texts,
            one.features,
            sorted(one.met),
            [(kept.t_us, kept.features, len(kept.acts)) for kept in one.kept],
            (one.scans, one.virtual_us, one.acts),
        )
        for number, one in found
    ]


def test_the_first_runs_are_a_cold_start_and_its_branches() -> None:
    corpus = Corpus(0)
    (first,) = corpus.choose(0, 1)
    assert first == (Branch(0, None, frozenset()), -1)
    corpus.add([(-1, _ran((1, 2, 3), _state(1, 2)))])
    assert (corpus.states, corpus.features) == (1, 3)
    assert {at for _, at in corpus.choose(1, 20)} <= {0, -1}


def test_a_state_without_a_new_feature_is_not_kept() -> None:
    """Both runs of a round found feature 5; the state of the first run is kept."""
    corpus = Corpus(0)
    corpus.add([(-1, _ran((5,), _state(5))), (-1, _ran((5, 6), _state(5)))])
    assert (corpus.states, corpus.features) == (1, 2)


def test_a_rare_state_is_chosen_more_often() -> None:
    """Feature 1 was met in each of 100 runs, feature 2 in one of them."""
    corpus = Corpus(0)
    runs = [(-1, _ran((1,), _state(1)))] + [(-1, _ran((1,)))] * 98
    corpus.add([*runs, (-1, _ran((1, 2), _state(2)))])
    chosen = [at for first in range(200) for _, at in corpus.choose(first, 1)]
    assert chosen.count(1) > 3 * chosen.count(0) > 0


def test_a_button_is_released_after_a_branch_at_its_end(tmp_path: Path) -> None:
    """A state is kept in the very instant in which the button is released (300 ms)."""
    feeder(tmp_path)
    of = CellsOf.of([tmp_path / "Feeder.st"], {"engine": "builtin"}, [tmp_path / "campaign.toml"])
    cells = of.make()
    course = Course(cells.cell(0), cells.demands)
    course.plan(Entry(200_000, values={"Main.Go": True}, held_us=100_000))
    course.let_pass(300_000)
    state: Any = course.cell.snapshot()
    acts = course.begun_acts
    queue, count, periods = state.bench.agenda
    left = tuple(event for event in queue if event[1] != STIMULUS)
    course.cell.restore(state._replace(bench=state.bench._replace(agenda=(left, count, periods))))
    course.begin_at(acts)
    course.let_pass(20_000)
    assert [act.t_us for act in acts] == [200_000]
    assert course.cell["Main.Go"] is False


@pytest.mark.exhaustive
def test_two_workers_give_the_result_of_none(tmp_path: Path) -> None:
    feeder(tmp_path)
    assert _runs(tmp_path, 2, 12) == _runs(tmp_path, 0, 12)


def test_a_second_call_gives_the_same_runs(tmp_path: Path) -> None:
    feeder(tmp_path)
    first = _runs(tmp_path, 0, 4)
    assert first == _runs(tmp_path, 0, 4)
    assert any(one[4] for one in first)
