"""Sweeps: each fault in each scan of a good run, to find scans after which the cell fails."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import Any, NamedTuple

from rcx_harness.cell import EVENTS
from rcx_harness.cell.stimulus import Entry
from rcx_harness.cell.surroundings import check, opposite
from rcx_harness.verify.storm.cells import Cells, CellsOf
from rcx_harness.verify.storm.course import RECOVERY, Course
from rcx_harness.verify.storm.replay import Replay, replay_of
from rcx_harness.verify.storm.shrink import thin_out
from rcx_harness.verify.storm.storms import Failure
from structured_text.errors import InputError, did_you_mean
from structured_text.output.units import format_us

__all__ = ["Failing", "Inject", "Moments", "Shown", "Sweep", "injects", "pieces", "ranges", "told"]

#: Number of scans in one work item.
_PIECE = 25
_ONCE = ("power_cycle", "alarm", "plc_overrun", "program_end")


@dataclass(frozen=True)
class Inject:
    """An injection: an event at a controller, or temporary values of inputs."""

    name: str
    event: str = ""
    controller: int = 1
    values: Mapping[str, Any] = field(default_factory=dict)
    held_us: int | None = None

    def at(self, t_us: int) -> Entry:
        """Return the action that executes this injection at the given time [us]."""
        events: tuple[tuple[str, Mapping[str, Any]], ...] = ()
        if self.event:
            events = ((self.event, {}),)
        return Entry(
            t_us,
            values=self.values,
            events=events,
            controller=self.controller,
            held_us=self.held_us,
        )


class Moments(NamedTuple):
    """Scans for an injection: every `step`th from `first` to before `end`."""

    inject: Inject
    first: int
    end: int
    step: int


class Shown(NamedTuple):
    """The work item that searches the shortest run to the failure of one scan."""

    inject: Inject
    scan: int
    kind: str


#: Maps a failing scan to its kinds of failures, each with a sentence.
Failing = dict[int, dict[str, str]]


def injects(names: Sequence[str], controllers: int, hold_us: int) -> list[Inject]:
    """Return the injections that a user names.

    A name is an event (`link_down`, at every controller; `link_down@2`), or an input with a value
    (`Main.CellSafe=false`). `hold_us` is the duration of an injection that lasts.
    """
    found: list[Inject] = []
    for name in names:
        path, is_, value = name.partition("=")
        if is_:
            if value.lower() not in ("true", "false"):
                raise InputError(f"--inject {name}: the value is not true or false")
            to = value.lower() == "true"
            found.append(Inject(name, values={path: to}, held_us=hold_us))
            continue
        event, at, number = name.partition("@")
        if event not in EVENTS:
            near = did_you_mean(get_close_matches(event, EVENTS))
            raise InputError(
                f"--inject {name}: there is no such event", hint=near or "rcx run --help lists them"
            )
        held_us = None
        if event not in _ONCE:
            opposite(event, {})
            held_us = hold_us
        if at and not (number.isdecimal() and 1 <= int(number) <= controllers):
            raise InputError(f"--inject {name}: the cell has {controllers} controller(s)")
        if event.startswith("plc_"):
            check(event, {})
            found.append(Inject(event, event, held_us=held_us))
            continue
        wanted = [int(number)] if at else range(1, controllers + 1)
        for one in wanted:
            shown = f"{event}@{one}" if controllers > 1 else event
            found.append(Inject(shown, event, one, held_us=held_us))
    if len({one.name for one in found}) < len(found):
        raise InputError("--inject has a name twice")
    return found


def pieces(what: Sequence[Inject], scans: int, step: int) -> list[Moments]:
    """Return the work items of a sweep."""
    size = _PIECE * step
    return [
        Moments(one, first, min(first + size, scans), step)
        for one in what
        for first in range(0, scans, size)
    ]


def ranges(scans: Sequence[int], step: int) -> list[tuple[int, int]]:
    """Return consecutive scans as pairs of first and last."""
    found: list[tuple[int, int]] = []
    for scan in sorted(scans):
        if found and scan - found[-1][1] <= step:
            found[-1] = (found[-1][0], scan)
        else:
            found.append((scan, scan))
    return found


@dataclass(frozen=True)
class Sweep:
    """The work of a sweep for one worker: it injects in scans, or shortens a failing run."""

    cells: CellsOf
    seed: int = 0

    def prepare(self) -> Callable[[Moments | Shown], Any]:
        """Compile the program, and return the function that handles a work item."""
        return _Worker(self.cells.make(), self.seed).do


class _Worker:
    def __init__(self, cells: Cells, seed: int) -> None:
        self._cells, self._seed = cells, seed
        self._good: Course | None = None
        """The good run. None if the compiled program has run another cell since then."""
        self._known: dict[int, object] = {}

    def do(self, item: Moments | Shown) -> Any:
        """Return the failing scans of a `Moments`, or the replay of a `Shown`."""
        return self._shown(item) if isinstance(item, Shown) else self._moments(item)

    def _begun(self, entries: Sequence[Entry]) -> Course:
        demands = replace(self._cells.demands, start=tuple(entries))
        course = Course(self._cells.cell(self._seed), demands)
        course.wanted = ""
        for entry in entries:
            course.plan(entry)
        return course

    def _moments(self, item: Moments) -> Failing:
        if self._good is None:
            self._good = self._begun(self._cells.demands.start)
            self._known = {0: self._good.snapshot()}
        course = self._good
        course.restore(self._known[max(scan for scan in self._known if scan <= item.first)])
        failing: Failing = {}
        for scan in range(item.first, item.end, item.step):
            _go_to(course, scan)
            before = course.snapshot()
            if scan == item.first:
                self._known[scan] = before
            _fails(course, item.inject)
            if course.failures:
                failing[scan] = {kind: one.text for kind, one in course.failures.items()}
            course.restore(before)
        return failing

    def _shown(self, item: Shown) -> Replay | None:
        """Return the replay of a failing scan, with only the necessary part of the good run."""
        self._good = None
        course = self._begun(self._cells.demands.start)
        _go_to(course, item.scan)
        moment_us = course.cell.now_us

        def run(entries: Sequence[Entry]) -> tuple[Course, Failure | None]:
            course = self._begun(entries)
            course.cell.run(moment_us)
            course.wanted = item.kind
            return course, _fails(course, item.inject)

        def still(entries: Sequence[Entry]) -> bool:
            return run(entries)[1] is not None

        ends_us = moment_us + (item.inject.held_us or 0) + 1_000
        begun = [one for one in self._cells.demands.start if one.t_us < ends_us]
        course, failure = run(thin_out(begun, still))
        if failure is None:
            return None
        expect = course.expect if failure.kind == RECOVERY else course.judge.expected(failure.kind)
        scan_us = course.cell.timing.scan_us
        return replay_of(course.done, failure, expect, self._seed, scan_us)


def _go_to(course: Course, scan: int) -> None:
    """Run the good run until shortly after the given scan."""
    cell = course.cell
    if cell.scans <= scan:
        cell.scan(scan + 1 - cell.scans)
        cell.run(min(1_000, cell.timing.scan_us // 2))
    course.check()
    if course.failures:
        first = next(iter(course.failures.values()))
        hint = "begin the sweep with a run in which nothing fails"
        raise InputError(f"the run breaks a rule without any fault: {first}", hint=hint)


def _fails(course: Course, inject: Inject) -> Failure | None:
    """Inject now, wait for the end, and recover. Return a failure of a wanted kind, or None."""
    cell = course.cell
    try:
        course.plan(inject.at(cell.now_us))
        course.let_pass((inject.held_us or 0) + min(1_000, cell.timing.scan_us // 2))
        course.let_go()
        course.come_to_rest()
        course.recover()
    except Failure as failure:
        course.failures.setdefault(failure.kind, failure)
        return failure if failure.kind == course.wanted else None
    return None


def told(moments: Sequence[tuple[int, int]], scan_us: int) -> str:
    """Return ranges of scans as text, with the time of the first scan."""
    return (
        ", ".join(f"{first}" if first == last else f"{first} to {last}" for first, last in moments)
        + f" (the first at {format_us(moments[0][0] * scan_us)})"
    )
