"""Storms that befall a cell one after the other, each followed by the way back."""

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

__all__ = ["Failure", "Run", "Storm", "kind_of"]

#: A storm is looked at this often.
_SLICE_US = 500_000
#: What happens at the end of a storm has happened before the way back begins.
_MOMENT_US = 1_000


class Failure(AssertionError):  # noqa: N818 - a failed check, told with its run
    """What a run has shown to be wrong: its kind, when, and a sentence."""

    def __init__(self, kind: str, t_us: int, text: str) -> None:
        super().__init__(f"{kind} at {format_us(t_us)}: {text}")
        self.kind, self.t_us, self.text = kind, t_us, text

    def __reduce__(self) -> tuple[type[Failure], tuple[str, int, str]]:
        return Failure, (self.kind, self.t_us, self.text)


@dataclass(frozen=True)
class Storm:
    """What happens, at times from its begin, and how long it lasts [us]."""

    acts: Sequence[Entry]
    length_us: int


def kind_of(violation: Violation) -> str:
    """The kind of a failure that is a broken rule; of a contract with the block that broke it."""
    name = violation.text.partition(f"{violation.rule}: ")[2].partition(" ")[0].strip(":,")
    of_block = violation.rule in ("contract", "calls") and "." in name
    return f"rule {violation.rule}" + (f" of {name}" if of_block else "")


class Run(ABC):
    """Storms on a cell, each followed by rest and recovery.

    Args:
        cell: The cell, at its beginning.
    """

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.done: list[Entry] = []
        """All that was done to the cell, at times from the run's begin."""
        self.wanted: str | None = None
        """The run ends with a failure of this kind alone; None: with any."""
        self.failures: dict[str, Failure] = {}
        """Of those with which it did not end the first of each kind."""
        self._found: list[Failure] = []
        self._judged = 0
        self._dropped: set[int] = set()
        self._ever: list[Entry] = []
        """What was planned once, so that no other act has its identity."""

    def begin(self) -> None:
        """Bring the cell into work."""
        self.come_to_rest()
        self.recover()

    @abstractmethod
    def come_to_rest(self) -> None:
        """All causes go: everything ends."""

    @abstractmethod
    def recover(self) -> None:
        """The way back to a working cell."""

    def weathered(self) -> None:  # noqa: B027 - a run may have nothing to do then
        """A storm is over, and the cell works."""

    def of(self, storms: Sequence[Storm]) -> None:
        """Run storms one after the other.

        Raises:
            Failure: the first thing that is wrong.
        """
        self.begin()
        for storm in storms:
            self.weather(storm)
            self.come_to_rest()
            self.recover()
            self.weathered()

    def weather(self, storm: Storm) -> None:
        """Let a storm pass."""
        begin_us = self.cell.now_us
        for act in storm.acts:
            self.plan(replace(act, t_us=begin_us + act.t_us))
        ends_us = [part.t_us + _MOMENT_US for act in storm.acts for part in act.parts()]
        self.let_pass(max(storm.length_us, *ends_us, 0))

    def plan(self, act: Entry) -> None:
        """Let something happen, at its time in the run."""
        self.done.append(act)
        for part in act.parts():
            self.cell.at(part.t_us, partial(self._apply_planned, act, part))

    def drop_rest(self) -> None:
        """What is planned and has not begun does not happen."""
        now_us = self.cell.now_us
        self._dropped |= {id(act) for act in self.done if act.t_us >= now_us}
        self._ever += self.done
        self.done = [act for act in self.done if act.t_us < now_us]

    def snapshot(self) -> object:
        """The state of run and cell."""
        known = list(self.done), set(self._dropped), dict(self.failures), self._judged
        return self.cell.snapshot(), known

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        state, (done, dropped, failures, self._judged) = snapshot
        self.cell.restore(state)
        self.done, self._dropped, self.failures = list(done), set(dropped), dict(failures)
        self._found.clear()

    def _apply_planned(self, act: Entry, part: Entry) -> None:
        if id(act) not in self._dropped:
            self.apply(part)

    def apply(self, act: Entry) -> None:
        """Something happens now."""
        act.apply(self.cell)

    def let_pass(self, duration_us: int) -> None:
        """Run for a while, and check on the way."""
        end_us = self.cell.now_us + duration_us
        while self.cell.now_us < end_us:
            self.cell.run(min(_SLICE_US, end_us - self.cell.now_us))
            self.check()
        self.check()

    def note(self, kind: str, text: str) -> None:
        """Something is wrong now; `check` raises it."""
        self._found.append(Failure(kind, self.cell.now_us, text))

    def check(self) -> None:
        """Raise what was found first."""
        new = self.cell.violations[self._judged :]
        self._judged += len(new)
        self._found += [Failure(kind_of(one), one.t_us, one.text) for one in new]
        for failure in sorted(self._found, key=lambda one: one.t_us):
            if self.wanted is None or failure.kind == self.wanted:
                raise failure
            self.failures.setdefault(failure.kind, failure)
        self._found.clear()

    def fail(self, kind: str, text: str) -> NoReturn:
        """Raise what was found first, or this."""
        self.check()
        raise Failure(kind, self.cell.now_us, text)

    def wait(
        self, condition: Callable[[], bool], within_us: int, kind: str, what: Callable[[], str]
    ) -> int:
        """Run until something holds, and check; how long it took [us]."""
        try:
            took_us = self.cell.run_until(condition, within=within_us)
        except CellTimeout:
            self.fail(kind, f"not within {format_us(within_us)}; {what()}")
        self.check()
        return took_us
