"""Campaigns: random storms on a user's cell, classes of failures, a short run for each class."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.cells import Cells, CellsOf
from rcx_harness.verify.storm.course import RECOVERY, Course
from rcx_harness.verify.storm.draw import draw_storms
from rcx_harness.verify.storm.moments import moments
from rcx_harness.verify.storm.reached import Line, Reached
from rcx_harness.verify.storm.replay import Replay, replay_of
from rcx_harness.verify.storm.shrink import shrink
from rcx_harness.verify.storm.storms import Failure, Storm
from structured_text.farm import Farm, ResultFile

__all__ = ["Explained", "Seed", "Storms", "Straight", "Unexplained", "classes", "storms"]

#: Greatest number of runs to shorten a failure, and to separate two classes of failures.
_TRIES, _OTHERS = 150, 12
#: Greatest number of additional runs that remove unnecessary actions of recoveries.
_MORE_TRIES = 80
#: Greatest number of classes for failures of one kind.
_MOST_OF_A_KIND = 5


class Seed(NamedTuple):
    """The result of a seed.

    Attributes:
        failures: Maps a kind of failure to its time [us] and its text.
        virtual_us: Virtual time of the run [us].
        scans: Number of scans.
        acts: Number of events.
        lines: Lines of robot programs that the run reached.
        reached: Names of the properties `sometimes` that held.
    """

    failures: dict[str, tuple[int, str]]
    virtual_us: int
    scans: int
    acts: int
    lines: tuple[Line, ...] = ()
    reached: tuple[str, ...] = ()


class Unexplained(NamedTuple):
    """Work item: seeds that fail with the same kind of failure. The shortest run comes first."""

    kind: str
    seeds: tuple[int, ...]


class Straight(NamedTuple):
    """Work item: a failing run from a cold start, as a list of all its actions.

    Attributes:
        kind: The kind of failure.
        seed: The seed of the cell.
        acts: All actions, the start included.
        ends_us: The time [us] at which the failure occurs, or at which the last recovery begins.
            None: already the start of the cell fails.
    """

    kind: str
    seed: int
    acts: tuple[Entry, ...]
    ends_us: int | None


class Explained(NamedTuple):
    """A class of failures.

    Attributes:
        causes: The events and inputs that the failure needs in the shortest run. If there is no
            shortest run, the failure did not occur again.
        rest: Seeds that fail even without these causes, so they belong to another class.
        seeds: Seeds that belong to this class.
    """

    replay: Replay | None
    causes: tuple[str, ...]
    rest: tuple[int, ...]
    seeds: tuple[int, ...]


@dataclass(frozen=True)
class Storms:
    """The work of a campaign for one worker: run a seed, or explain failing seeds."""

    cells: CellsOf

    def prepare(self) -> Callable[[int | Unexplained | Straight], Any]:
        """Compile the program, and return the function that handles a work item."""
        return _Worker(self.cells.make()).do


class _Worker:
    def __init__(self, cells: Cells) -> None:
        self._cells, self._demands = cells, cells.demands
        start, length_us = self._demands.start, self._demands.length_us
        self._moments = moments(self._course(0, ""), start, length_us, cells.library)

    def do(self, item: int | Unexplained | Straight) -> Any:
        """Return the result of a seed, or the class of failures of another item."""
        if isinstance(item, Straight):
            return self._shortened(item)
        return self._explained(item) if isinstance(item, Unexplained) else self._seed(item)

    def _storms(self, seed: int, course: Course) -> list[Storm]:
        """Return all storms of a seed. If there is a good run, it is a part of the first storm."""
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
        reached = Reached(course.cell)
        storms = self._storms(seed, course)
        try:
            course.of(storms)
        except Failure as failure:
            course.failures.setdefault(failure.kind, failure)
        failures = {one.kind: (one.t_us, one.text) for one in course.failures.values()}
        cell, acts = course.cell, sum(len(one.acts) for one in storms)
        goals = course.judge.reached
        return Seed(failures, cell.now_us, cell.scans, acts, reached.lines, goals)

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

    def _shortened(self, item: Straight) -> Explained:
        """Return the class of a failing run that is known as a list of actions."""
        course = self._course(item.seed, item.kind)
        course.begun = course.begun or item.ends_us is not None
        ends_us = item.ends_us or 0
        failure = _failure(course, [Storm(item.acts, ends_us)])
        if failure is None:
            return Explained(None, (), (), (item.seed,))
        if item.ends_us is not None:
            course, failure = self._flat(item.seed, course, failure, _TRIES)
        expect = course.expect if failure.kind == RECOVERY else course.judge.expected(item.kind)
        told = replay_of(course.done, failure, expect, item.seed, course.cell.timing.scan_us)
        causes = dict.fromkeys(cause for act in course.done for cause in _causes(act))
        return Explained(told, tuple(causes), (), (item.seed,))

    def _flat(
        self, seed: int, course: Course, failure: Failure, tries: int = _MORE_TRIES
    ) -> tuple[Course, Failure]:
        """Return a failing run as one storm without a separate start, and shorten it further.

        Actions that started the cell, and actions of successful recoveries, may be removed.
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

        shrink(run, [Storm(acts, ends_us)], failure, tries)
        return last, found

    def _fails(self, seed: int, some: Sequence[Storm], kind: str) -> Failure | None:
        return _failure(self._course(seed, kind), some)

    def _fails_without(self, seed: int, causes: set[str], kind: str) -> bool:
        """Return whether a seed still fails in the same way if these causes are removed."""
        course = self._course(seed, kind)
        left = [
            replace(one, acts=tuple(act for act in one.acts if causes.isdisjoint(_causes(act))))
            for one in self._storms(seed, course)
        ]
        return _failure(course, left) is not None


def _failure(course: Course, some: Sequence[Storm]) -> Failure | None:
    """Return the failure of a run if it is of the wanted kind, otherwise None."""
    try:
        course.of(some)
    except Failure as failure:
        return failure if failure.kind == course.wanted else None
    return None


def _causes(act: Entry) -> list[str]:
    """Return the events or variables of an action, without time and duration."""
    return [name for name, _ in act.events] or list(act.values)


def storms(
    farm: Farm, work: Storms, seeds: Iterable[int], kept: ResultFile[Any, Any] | None = None
) -> Iterator[tuple[int, Seed]]:
    """Run the seeds, and yield the result of each."""
    yield from farm.run(work, seeds, kept=kept, title="seeds")


def classes(
    farm: Farm,
    work: Storms,
    failing: dict[str, list[tuple[int, int]]],
    kept: ResultFile[Any, Any] | None = None,
) -> list[tuple[str, Explained]]:
    """Return the classes of failures; failures of one kind with different causes are separate.

    `failing` has the failing seeds by kind of failure, each with the time of its failure [us]; the
    earliest failure is shortened. `kept` has the results of earlier calls.
    """
    # Each round explains one seed of each kind. Seeds that also fail without these causes must have
    # another cause, so the next round explains them again. The number of rounds limits the number
    # of classes of a kind.
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
