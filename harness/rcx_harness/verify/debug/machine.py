"""A cell that the debugger runs scan by scan, forwards and backwards."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.trace import Record, Scan
from rcx_harness.verify.debug.around import scopes
from rcx_harness.verify.debug.robot_programs import robot_programs
from rcx_harness.verify.debug.telegrams import Telegrams
from structured_text.debug.bench import BenchMachine

__all__ = ["CellMachine"]


class CellMachine(BenchMachine):
    """A cell in virtual time with a scheduled stimulus, for the debugger.

    The network of the cell must be virtual. Scans run only before `end_us`; `shown` is this time as
    the user wrote it, for messages.
    """

    def __init__(self, cell: Cell, end_us: int, shown: str) -> None:
        super().__init__(cell, end_us, shown)
        self.cell = cell
        self.telegrams: Sequence[Telegrams] = [Telegrams(size) for size, _, _ in cell.areas]
        self.around = scopes(self.program, cell.images, self.telegrams)
        self.devices = robot_programs(cell.robots)
        cell.trace.listen(self._take)

    def _take(self, record: Record) -> None:
        if isinstance(record, Scan):
            self.telegrams[record.controller - 1].take(record.t_us, record.so, record.si)

    def snapshot(self) -> Any:
        """Return a snapshot of the cell between two scans."""
        return super().snapshot(), [one.snapshot() for one in self.telegrams]

    def restore(self, snapshot: Any) -> None:
        """Restore a snapshot of the cell."""
        cell, telegrams = snapshot
        super().restore(cell)
        for one, state in zip(self.telegrams, telegrams, strict=True):
            one.restore(state)

    def inject(self, event: str, device: int) -> None:
        """Inject an event into a controller."""
        self.cell.inject(event, controller=device)
