"""One run of a user's cell: its start, its storms, and the demanded recovery."""

from __future__ import annotations

from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.properties import Judge
from rcx_harness.verify.recovery import NotRecoveredError, Operator, Recovery
from rcx_harness.verify.storm.demands import Demands
from rcx_harness.verify.storm.storms import Failure, StormRun

__all__ = ["RECOVERY", "Course"]

#: The name of the kind of failure for a recovery without success.
RECOVERY = "recovery"
#: If no recovery is demanded, the cell runs for this time after a storm [us].
_AFTER_US = 1_000_000


class Course(StormRun):
    """A run with storms on a user's cell, checked by the user's demands."""

    def __init__(self, cell: Cell, demands: Demands) -> None:
        super().__init__(cell)
        demands.check(cell)
        self._demands = demands
        self._operator = Operator(cell, demands.recovery or Recovery())
        self.judge = Judge(cell, demands.properties, self._found_now)
        self.begun = bool(demands.start)
        """Whether the cell needs no start, because its storms contain the start."""
        self.back_us: int | None = None
        """The time [us] at which the last recovery began."""
        self.expect = ""
        """The condition that did not hold in the recovery. A replay checks this condition."""

    def begin(self) -> None:
        """Start the cell, unless a good run contains the start."""
        if self.begun:
            return
        self.come_to_rest()
        self._back(self._operator.act)

    def come_to_rest(self) -> None:
        """Wait without further faults until all controllers are connected again."""
        self._operator.wait_for_controllers(self)

    def recover(self) -> None:
        """Execute the recovery, and check that the cell works again."""
        self.back_us = self.cell.now_us
        if self._demands.recovery is None:
            self.let_pass(_AFTER_US)
        else:
            self._back(self._operator.recover)

    def _back(self, way: object) -> None:
        assert callable(way)
        try:
            way(self)
        except NotRecoveredError as error:
            self.check()
            self.expect = error.expect
            raise Failure(RECOVERY, self.cell.now_us, str(error)) from None
        self.check()

    def _found_now(self, kind: str, text: str) -> None:
        self.note(kind, text)
        if self.wanted in (None, kind):
            self.check()

    def let_go(self) -> None:
        """Drop all planned actions, and release all buttons."""
        self.drop_rest()
        steps = self._demands.recovery.steps if self._demands.recovery is not None else ()
        pressed = dict.fromkeys(path for step in steps for path in step.press)
        buttons = [*dict.fromkeys([*self._demands.buttons, *pressed])]
        if down := {path: False for path in buttons if self.cell[path]}:
            self.plan(Entry(self.cell.now_us, values=down))

    def paths(self, kind: str) -> tuple[str, ...]:
        """Return the variables in the conditions of a kind of failure."""
        return self._operator.paths if kind == RECOVERY else self.judge.paths(kind)

    def snapshot(self) -> object:
        """Return the state of the run and of the properties."""
        return super().snapshot(), self.judge.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the run and of the properties."""
        state, judged = snapshot
        super().restore(state)
        self.judge.restore(judged)
