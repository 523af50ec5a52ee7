"""Storms: faults and actions of the operator on a cell, each followed by a recovery."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NoReturn

from rcx_harness.cell import Cell, CellTimeout
from rcx_harness.cell.stimulus import Entry
from rcx_harness.robot import Violation
from structured_text.output.units import format_us

__all__ = ["Failure", "Storm", "StormRun", "kind_of"]

#: The run is checked at this interval during a storm [us].
_SLICE_US = 500_000
#: The time [us] between the last action of a storm and the beginning of the recovery.
_MOMENT_US = 1_000


class Failure(AssertionError):  # noqa: N818 - a failed check, told with its run
    """A failure of a run: its kind, its time [us] and a sentence."""

    def __init__(self, kind: str, t_us: int, text: str) -> None:
        super().__init__(f"{kind} at {format_us(t_us)}: {text}")
        self.kind, self.t_us, self.text = kind, t_us, text

    def __reduce__(self) -> tuple[type[Failure], tuple[str, int, str]]:
        return Failure, (self.kind, self.t_us, self.text)


@dataclass(frozen=True)
class Storm:
    """The actions of a storm, at times from its beginning, and its duration [us]."""

    acts: Sequence[Entry]
    length_us: int


def kind_of(violation: Violation) -> str:
    """Return the kind of failure for a broken rule.

    If the rule is about a block, the kind includes the name of the block.
    """
    name = violation.text.partition(f"{violation.rule}: ")[2].partition(" ")[0].strip(":,")
    of_block = violation.rule in ("contract", "calls") and "." in name
    return f"rule {violation.rule}" + (f" of {name}" if of_block else "")


class StormRun(ABC):
    """A run of storms on a cell. A waiting time and a recovery follow each storm."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.done: list[Entry] = []
        """All actions on the cell, with times from the beginning of the run."""
        self.wanted: str | None = None
        """Only a failure of this kind ends the run. None: any failure ends it."""
        self.failures: dict[str, Failure] = {}
        """The first failure of each kind that did not end the run."""
        self._found: list[Failure] = []
        self._judged = 0
        self._dropped: set[int] = set()
        self._applied: set[int] = set()
        self._ever: list[Entry] = []
        """All planned actions. They stay in memory, because `_dropped` contains their ids."""

    def begin(self) -> None:
        """Start the cell, as a recovery does."""
        self.come_to_rest()
        self.recover()

    @abstractmethod
    def come_to_rest(self) -> None:
        """Remove the causes of all faults, and wait until the cell is at rest."""

    @abstractmethod
    def recover(self) -> None:
        """Execute the recovery, so that the cell works again."""

    def weathered(self) -> None:  # noqa: B027 - a run may have nothing to do then
        """Do something after a successful recovery. By default nothing is done."""

    def of(self, storms: Sequence[Storm]) -> None:
        """Run several storms in sequence."""
        self.begin()
        for storm in storms:
            self.weather(storm)
            self.come_to_rest()
            self.recover()
            self.weathered()

    def weather(self, storm: Storm) -> None:
        """Execute all actions of a storm, and wait until the last of them has ended."""
        begin_us = self.cell.now_us
        for act in storm.acts:
            self.plan(replace(act, t_us=begin_us + act.t_us))
        ends_us = [part.t_us + _MOMENT_US for act in storm.acts for part in act.parts()]
        self.let_pass(max(storm.length_us, *ends_us, 0))

    def plan(self, act: Entry) -> None:
        """Schedule an action at its time in the run."""
        self.done.append(act)
        for part in act.parts():
            self.cell.at(part.t_us, partial(self._apply_planned, act, part))

    def drop_rest(self) -> None:
        """Cancel planned actions that have not begun."""
        now_us = self.cell.now_us
        self._dropped |= {id(act) for act in self.done if act.t_us >= now_us}
        self._ever += self.done
        self.done = [act for act in self.done if act.t_us < now_us]

    def begin_at(self, done: Sequence[Entry]) -> None:
        """Continue after these actions, because the cell was brought into the state after them.

        Actions that last longer end at their time.
        """
        self.done, self._dropped, self._ever = list(done), set(), []
        self._applied = set(map(id, self.done))
        self.failures, self._judged = {}, len(self.cell.violations)
        self._found.clear()
        for act in done:
            for part in act.parts():
                # An end at this very time may be pending; to apply it twice changes nothing.
                if part.t_us > act.t_us and part.t_us >= self.cell.now_us:
                    self.cell.at(part.t_us, partial(self._apply_planned, act, part))

    def snapshot(self) -> object:
        """Return a snapshot of the run and its cell."""
        known = list(self.done), set(self._dropped), dict(self.failures), self._judged
        return self.cell.snapshot(), known

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the run and its cell."""
        state, (done, dropped, failures, self._judged) = snapshot
        self.cell.restore(state)
        self.done, self._dropped, self.failures = list(done), set(dropped), dict(failures)
        self._found.clear()

    def _apply_planned(self, act: Entry, part: Entry) -> None:
        if id(act) not in self._dropped:
            self._applied.add(id(act))
            self.apply(part)

    @property
    def begun_acts(self) -> list[Entry]:
        """Return the actions of `done` that have begun."""
        return [act for act in self.done if id(act) in self._applied]

    def apply(self, act: Entry) -> None:
        """Apply an action to the cell at the current time."""
        act.apply(self.cell)

    def let_pass(self, duration_us: int) -> None:
        """Run for a duration [us], and check at intervals."""
        end_us = self.cell.now_us + duration_us
        while self.cell.now_us < end_us:
            self.cell.run(min(_SLICE_US, end_us - self.cell.now_us))
            self.check()
        self.check()

    def note(self, kind: str, text: str) -> None:
        """Record a failure at the current time. `check` raises it later."""
        self._found.append(Failure(kind, self.cell.now_us, text))

    def check(self) -> None:
        """Raise the earliest failure that was found.

        If a failure is not of the wanted kind, it is added to `failures`.
        """
        new = self.cell.violations[self._judged :]
        self._judged += len(new)
        self._found += [Failure(kind_of(one), one.t_us, one.text) for one in new]
        for failure in sorted(self._found, key=lambda one: one.t_us):
            if self.wanted is None or failure.kind == self.wanted:
                raise failure
            self.failures.setdefault(failure.kind, failure)
        self._found.clear()

    def fail(self, kind: str, text: str) -> NoReturn:
        """Raise the earliest failure that was found. If there is none, raise this failure."""
        self.check()
        raise Failure(kind, self.cell.now_us, text)

    def wait(
        self, condition: Callable[[], bool], within_us: int, kind: str, what: Callable[[], str]
    ) -> int:
        """Run until a condition holds, check for failures, and return the elapsed time [us]."""
        try:
            took_us = self.cell.run_until(condition, within=within_us)
        except CellTimeout:
            self.fail(kind, f"not within {format_us(within_us)}; {what()}")
        self.check()
        return took_us
