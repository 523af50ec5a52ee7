"""A cell under the debugger: scan by scan, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.trace import Record, Scan
from rcx_harness.verify.debug.around import scopes
from rcx_harness.verify.debug.telegrams import Telegrams
from structured_text.debug.machine import Scope, builtin_of

__all__ = ["CellMachine"]


class CellMachine:
    """A cell in virtual time, with a stimulus that is scheduled in it already.

    Args:
        cell: The cell; its network has to be a virtual one.
        end_us: Scans run before this time.
        shown: That time for messages.
    """

    def __init__(self, cell: Cell, end_us: int, shown: str) -> None:
        self.cell, self.program = cell, builtin_of(cell.program)
        self._end_us, self._shown = end_us, shown
        self.violations = cell.violations
        self.telegrams: Sequence[Telegrams] = [Telegrams(size) for size, _, _ in cell.areas]
        self.around: Sequence[Scope] = scopes(self.program, cell.images, self.telegrams)
        cell.trace.listen(self._take)

    def _take(self, record: Record) -> None:
        if isinstance(record, Scan):
            self.telegrams[record.controller - 1].take(record.t_us, record.so, record.si)

    @property
    def scans(self) -> int:
        """How many scans have run."""
        return self.cell.scans

    @property
    def now_us(self) -> int:
        """The time of the last scan."""
        return self.cell.now_us

    @property
    def ended(self) -> str:
        """Why there is no further scan."""
        timing = self.cell.timing
        next_us = timing.phases[-1] + self.cell.scans * timing.scan_us
        return f"the end of the run ({self._shown})" if next_us >= self._end_us else ""

    def scan(self) -> None:
        """Let all happen until one more scan has run."""
        self.cell.scan()

    def snapshot(self) -> Any:
        """The state between two scans."""
        return self.cell.snapshot(), [one.snapshot() for one in self.telegrams]

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        cell, telegrams = snapshot
        self.program.note_calls({})  # those of a scan that was left in its middle are forgotten
        self.cell.restore(cell)
        for one, state in zip(self.telegrams, telegrams, strict=True):
            one.restore(state)

    def inject(self, event: str, device: int) -> None:
        """Let something befall a controller."""
        self.cell.inject(event, controller=device)

    def close(self) -> None:
        """End the cell."""
        self.cell.close()
