"""Storms that befall a cell one after the other, what they come to, and the shortest that fail."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import NoReturn

from rcx_harness.cell import CellTimeout
from rcx_harness.units import format_us
from rcx_tools.evidence.campaign.station import Act, Station

__all__ = ["Failure", "Outcome", "Run", "Storm", "shrink"]


class Failure(AssertionError):  # noqa: N818 - a failed check, told with its run
    """What a run has shown to be wrong: its kind, when, and a sentence."""

    def __init__(self, kind: str, t_us: int, text: str) -> None:
        super().__init__(f"{kind} at {format_us(t_us)}: {text}")
        self.kind, self.t_us, self.text = kind, t_us, text


@dataclass(frozen=True)
class Storm:
    """Acts, and how long they last [us]."""

    acts: Sequence[Act]
    length_us: int


@dataclass
class Outcome:
    """What a run, or several, came to; times in virtual microseconds."""

    virtual_us: int = 0
    storms: int = 0
    requests: int = 0
    executions: int = 0
    scans: int = 0
    acts: dict[str, int] = field(default_factory=dict)
    ends: dict[str, int] = field(default_factory=dict)
    done: dict[str, int] = field(default_factory=dict)
    packets: dict[str, int] = field(default_factory=dict)
    longest_quiet_us: int = 0
    longest_recovery_us: int = 0

    def take(self, act: Act) -> None:
        """Count an act."""
        name = act.details["name"] if act.kind == "event" else act.kind
        name = act.details["what"] if act.kind == "packets" else name
        self.acts[name] = self.acts.get(name, 0) + 1

    def add(self, other: Outcome) -> None:
        """Take the figures of another run into this one."""
        for name in ("virtual_us", "storms", "requests", "executions", "scans"):
            setattr(self, name, getattr(self, name) + getattr(other, name))
        for name in ("acts", "ends", "done", "packets"):
            into: dict[str, int] = getattr(self, name)
            for key, count in getattr(other, name).items():
                into[key] = into.get(key, 0) + count
        for name in ("longest_quiet_us", "longest_recovery_us"):
            setattr(self, name, max(getattr(self, name), getattr(other, name)))


class Run(ABC):
    """Storms on a station, each followed by the way back to a working cell.

    Args:
        station: The cell.
    """

    def __init__(self, station: Station) -> None:
        self.station = station
        self.outcome = Outcome()
        self._found: list[tuple[str, int, str]] = []

    @abstractmethod
    def come_to_rest(self) -> None:
        """All causes go: everything ends, and nothing starts by itself."""

    @abstractmethod
    def recover(self) -> None:
        """The documented way back; then the cell does its work."""

    def of(self, storms: Sequence[Storm]) -> Outcome:
        """Run storms one after the other.

        Raises:
            Failure: the first thing that is wrong.
        """
        self.come_to_rest()
        self.recover()
        for storm in storms:
            self._weather(storm)
        return self.outcome

    def note(self, kind: str, text: str) -> None:
        """Something is wrong now; `check` raises it."""
        self._found.append((kind, self.station.now_us, text))

    def check(self) -> None:
        """Raise what was found first."""
        found = [*self._found]
        found += [(f"rule {one.rule}", one.t_us, one.text) for one in self.station.violations]
        if found:
            raise Failure(*min(found, key=lambda one: one[1]))

    def fail(self, kind: str, text: str) -> NoReturn:
        """Raise what was found first, or this."""
        self.check()
        raise Failure(kind, self.station.now_us, text)

    def wait(
        self, condition: Callable[[], bool], within_us: int, kind: str, what: Callable[[], str]
    ) -> int:
        """Run until something holds, and check; how long it took [us]."""
        try:
            took_us = self.station.run_until(condition, within=within_us)
        except CellTimeout:
            self.fail(kind, f"not within {format_us(within_us)}; {what()}")
        self.check()
        return took_us

    def _weather(self, storm: Storm) -> None:
        station, begin_us = self.station, self.station.now_us
        for act in storm.acts:
            station.at(begin_us + act.t_us, partial(self._apply, act))
        end_us = begin_us + storm.length_us
        while station.now_us < end_us:
            station.run(min(500_000, end_us - station.now_us))
            self.check()
        while not station.plc_on:
            station.run(10_000)
        self.come_to_rest()
        self.recover()
        outcome, network = self.outcome, station.network
        outcome.storms += 1
        outcome.virtual_us, outcome.scans = station.now_us, station.scans
        outcome.packets = {
            "lost": network.lost,
            "late": network.late,
            "doubled": network.doubled,
        }

    def _apply(self, act: Act) -> None:
        self.outcome.take(act)
        if self.station.plc_on or act.kind != "set":
            self.station.apply(act)


#: Runs that are tried at most.
MOST_TRIES = 250


def shrink(
    run: Callable[[Sequence[Storm]], object],
    storms: Sequence[Storm],
    failure: Failure,
    tries: int = MOST_TRIES,
    tried: Callable[[], None] = lambda: None,
) -> tuple[list[Storm], Failure]:
    """Find a shorter run that fails in the same way.

    Args:
        run: Runs storms; raises the failure that they lead to.
        storms: Those that fail.
        failure: How it fails; a shorter run must fail with the same kind.
        tries: How many runs may be tried.
        tried: Called after each of them.

    Returns:
        The storms of the shortest run found, and how it fails.
    """
    best, found = list(storms), failure

    def fails(candidate: Sequence[Storm]) -> bool:
        nonlocal best, found, tries
        if tries <= 0:
            return False
        tries -= 1
        try:
            run(candidate)
        except Failure as now:
            if now.kind == failure.kind:
                best, found = list(candidate), now
                return True
        finally:
            tried()
        return False

    for count in range(1, len(best) + 1):
        if fails(storms[:count]):
            break
    if len(best) > 1:
        fails(best[-1:])
    _thin_out(best, fails)
    last = max((act.t_us for act in best[-1].acts), default=0) if best else 0
    if best:
        fails([*best[:-1], Storm(best[-1].acts, min(best[-1].length_us, last + 1_000_000))])
    return best, found


def _thin_out(storms: list[Storm], fails: Callable[[list[Storm]], bool]) -> None:
    """Take out acts of the last storm, in ever smaller pieces (delta debugging)."""
    if not storms:
        return
    *before, last = storms
    acts: list[Act] = list(last.acts)
    piece = max(1, len(acts) // 2)
    while True:
        at = 0
        shorter = False
        while at < len(acts):
            rest = acts[:at] + acts[at + piece :]
            if fails([*before, Storm(rest, last.length_us)]):
                acts, shorter = rest, True
            else:
                at += piece
        if piece == 1 and not shorter:
            return
        piece = max(1, piece // 2) if piece > 1 else 1
