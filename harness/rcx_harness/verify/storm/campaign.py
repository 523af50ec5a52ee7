"""Storm after storm on a user's cell; what fails is classed, and each class made short."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.cells import Cells, CellsOf
from rcx_harness.verify.storm.course import RECOVERY, Course
from rcx_harness.verify.storm.draw import draw_storms
from rcx_harness.verify.storm.moments import moments
from rcx_harness.verify.storm.replay import Replay, replay_of
from rcx_harness.verify.storm.shrink import shrink
from rcx_harness.verify.storm.storms import Failure, Storm
from structured_text.farm import Farm, Kept

__all__ = ["Explained", "Seed", "Storms", "Unexplained", "classes", "storms"]

#: Runs that are tried to make one class short, and to part one class from another.
_TRIES, _OTHERS = 150, 12
#: And to leave out what its ways back do not need.
_MORE_TRIES = 80
#: Classes of one kind at most.
_MOST_OF_A_KIND = 5


class Seed(NamedTuple):
    """What came of a seed: kinds of failures with when [us] and a sentence; virtual time [us]."""

    failures: dict[str, tuple[int, str]]
    virtual_us: int
    scans: int
    acts: int


class Unexplained(NamedTuple):
    """Seeds that fail with one kind of failure, the shortest run first."""

    kind: str
    seeds: tuple[int, ...]


class Explained(NamedTuple):
    """A class of failures.

    Attributes:
        replay: Its shortest run; None: it did not fail again.
        causes: What it needs.
        rest: Of the seeds those that fail without these causes, too.
        seeds: All others.
    """

    replay: Replay | None
    causes: tuple[str, ...]
    rest: tuple[int, ...]
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class Storms:
    """The work of a campaign, for one worker: a seed, or seeds to be explained."""

    cells: CellsOf

    def prepare(self) -> Callable[[int | Unexplained], Any]:
        """Compile the program."""
        return _Worker(self.cells.make()).do


class _Worker:
    def __init__(self, cells: Cells) -> None:
        self._cells, self._demands = cells, cells.demands
        start, length_us = self._demands.start, self._demands.length_us
        self._moments = moments(self._course(0, ""), start, length_us, cells.library)

    def do(self, item: int | Unexplained) -> Any:
        """A seed: what came of it. Seeds that fail alike: one class of them."""
        return self._explained(item) if isinstance(item, Unexplained) else self._seed(item)

    def _storms(self, seed: int, course: Course) -> list[Storm]:
        """All that happens in a seed; a good run is part of its first storm."""
        demands = self._demands
        number, scan_us = len(course.cell.robots), course.cell.timing.scan_us
        first, *others = draw_storms(demands, seed, number, scan_us, self._moments)
        acts = sorted((*demands.start, *first.acts), key=lambda act: act.t_us)
        return [Storm(tuple(acts), first.length_us), *others]

    def _course(self, seed: int, wanted: str) -> Course:
        course = Course(self._cells.cell(seed), self._demands)
        course.wanted = wanted
        return course

    def _seed(self, seed: int) -> Seed:
        course = self._course(seed, "")
        storms = self._storms(seed, course)
        try:
            course.of(storms)
        except Failure as failure:
            course.failures.setdefault(failure.kind, failure)
        failures = {one.kind: (one.t_us, one.text) for one in course.failures.values()}
        return Seed(
            failures, course.cell.now_us, course.cell.scans, sum(len(one.acts) for one in storms)
        )

    def _explained(self, item: Unexplained) -> Explained:
        seed, *others = item.seeds
        storms = self._storms(seed, self._course(seed, item.kind))
        failure = self._fails(seed, storms, item.kind)
        if failure is None:
            return Explained(None, (), tuple(others), (seed,))

        def run(some: Sequence[Storm]) -> None:
            found = self._fails(seed, some, item.kind)
            if found is not None:
                raise found

        short, _ = shrink(run, storms, failure, _TRIES)
        course = self._course(seed, item.kind)
        found = _failure(course, short)
        assert found is not None
        course, found = self._flat(seed, course, found)
        expect = course.expect if found.kind == RECOVERY else course.judge.expected(found.kind)
        told = replay_of(course.done, found, expect, seed, course.cell.timing.scan_us)
        left = {cause for act in course.done for cause in _causes(act)}
        causes = dict.fromkeys(
            cause
            for storm in short
            for act in storm.acts
            for cause in _causes(act)
            if cause in left
        )
        rest, same = [], [seed]
        for number, other in enumerate(others):
            if causes and number < _OTHERS and self._fails_without(other, set(causes), item.kind):
                rest.append(other)
            else:
                same.append(other)
        return Explained(told, tuple(causes), tuple(rest), tuple(same))

    def _flat(self, seed: int, course: Course, failure: Failure) -> tuple[Course, Failure]:
        """A failing run as one storm without a start, made shorter still.

        What the operator did to start, and on a way back from which the cell came, may go.
        """
        ends_us = failure.t_us
        if failure.kind == RECOVERY:
            if course.back_us is None:
                return course, failure
            ends_us = course.back_us
        acts = sorted((one for one in course.done if one.t_us < ends_us), key=lambda one: one.t_us)
        last, found = course, failure

        def run(some: Sequence[Storm]) -> None:
            nonlocal last, found
            one = self._course(seed, failure.kind)
            one.begun = True
            if (now := _failure(one, some)) is not None:
                last, found = one, now
                raise now

        shrink(run, [Storm(acts, ends_us)], failure, _MORE_TRIES)
        return last, found

    def _fails(self, seed: int, some: Sequence[Storm], kind: str) -> Failure | None:
        return _failure(self._course(seed, kind), some)

    def _fails_without(self, seed: int, causes: set[str], kind: str) -> bool:
        """Does a seed fail in this way, too, when nothing of all this happens?"""
        course = self._course(seed, kind)
        left = [
            replace(one, acts=tuple(act for act in one.acts if causes.isdisjoint(_causes(act))))
            for one in self._storms(seed, course)
        ]
        return _failure(course, left) is not None


def _failure(course: Course, some: Sequence[Storm]) -> Failure | None:
    """How a run fails, if it does in the way that is wanted."""
    try:
        course.of(some)
    except Failure as failure:
        return failure if failure.kind == course.wanted else None
    return None


def _causes(act: Entry) -> list[str]:
    """What an act is, whenever it comes and however long it lasts."""
    return [name for name, _ in act.events] or list(act.values)


def storms(
    farm: Farm, work: Storms, seeds: Iterable[int], kept: Kept[Any, Any] | None = None
) -> Iterator[tuple[int, Seed]]:
    """Seed after seed."""
    yield from farm.run(work, seeds, kept=kept, title="seeds")


def classes(
    farm: Farm,
    work: Storms,
    failing: dict[str, list[tuple[int, int]]],
    kept: Kept[Any, Any] | None = None,
) -> list[tuple[str, Explained]]:
    """The classes of failures: those of one kind that have different causes are several.

    Args:
        farm: Where it is found out.
        work: The campaign.
        failing: Failing seeds by the kind of failure, each with when it fails [us]: the first to
            fail is made short.
        kept: What is known of earlier calls.
    """
    waiting = [
        Unexplained(kind, tuple(seed for _, seed in sorted(those)))
        for kind, those in failing.items()
    ]
    found: dict[tuple[str, frozenset[str]], Explained] = {}
    for _ in range(_MOST_OF_A_KIND):
        again = []
        for item, one in farm.run(work, waiting, kept=kept, title="classes"):
            key = item.kind, frozenset(one.causes)
            before = found.get(key, one)
            found[key] = before._replace(seeds=tuple(sorted({*before.seeds, *one.seeds})))
            if one.rest:
                again.append(Unexplained(item.kind, one.rest))
        waiting = again
        if not waiting:
            break
    return [(kind, one) for (kind, _), one in found.items()]
