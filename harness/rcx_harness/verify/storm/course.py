"""One run of a user's cell: its start, a storm, and the way back that is demanded."""

from __future__ import annotations

from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.properties import Judge
from rcx_harness.verify.recovery import NotRecoveredError, Operator, Recovery
from rcx_harness.verify.storm.demands import Demands
from rcx_harness.verify.storm.storms import Failure, Run

__all__ = ["RECOVERY", "Course"]

#: The kind of failure that is no way back.
RECOVERY = "recovery"
#: So long it goes on where no way back is demanded.
_AFTER_US = 1_000_000


class Course(Run):
    """Storms on a user's cell.

    Args:
        cell: The cell, at its beginning.
        demands: What is known and demanded of it.

    Raises:
        InputError: the demands name what is not there.
    """

    def __init__(self, cell: Cell, demands: Demands) -> None:
        super().__init__(cell)
        demands.check(cell)
        self._demands = demands
        self._operator = Operator(cell, demands.recovery or Recovery())
        self.judge = Judge(cell, demands.properties, self._found_now)
        self.begun = bool(demands.start)
        """The cell needs no start: its storms bring it."""
        self.back_us: int | None = None
        """When the last way back began."""
        self.expect = ""
        """The condition that did not come on the way back, for a replay."""

    def begin(self) -> None:
        """Start the cell, unless a good run says how."""
        if self.begun:
            return
        self.come_to_rest()
        self._back(self._operator.act)

    def come_to_rest(self) -> None:
        """Nothing befalls the cell any more; the controllers come back."""
        self._operator.wait_for_controllers(self)

    def recover(self) -> None:
        """The way back, and what has to come of it."""
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
        """What was to happen does not; nobody presses a button any more."""
        self.drop_rest()
        steps = self._demands.recovery.steps if self._demands.recovery is not None else ()
        pressed = dict.fromkeys(path for step in steps for path in step.press)
        buttons = [*dict.fromkeys([*self._demands.buttons, *pressed])]
        if down := {path: False for path in buttons if self.cell[path]}:
            self.plan(Entry(self.cell.now_us, values=down))

    def paths(self, kind: str) -> tuple[str, ...]:
        """The variables that a kind of failure is about, as far as conditions name them."""
        return self._operator.paths if kind == RECOVERY else self.judge.paths(kind)

    def snapshot(self) -> object:
        """The state of everything."""
        return super().snapshot(), self.judge.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        state, judged = snapshot
        super().restore(state)
        self.judge.restore(judged)
