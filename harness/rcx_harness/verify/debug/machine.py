"""What is debugged: a cell, or the program of a recording; scan by scan, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from rcx_harness.cell import Cell
from rcx_harness.cell.image import Image
from rcx_harness.robot import Violation
from rcx_harness.trace import Record, Scan
from rcx_harness.verify.debug.telegrams import Telegrams
from structured_text.engines.base import Program
from structured_text.engines.builtin.program import BuiltinProgram
from structured_text.errors import InputError

__all__ = ["CellMachine", "Machine", "builtin_of", "live_input"]


class Machine(Protocol):
    """A program and what is around it.

    Attributes:
        program: The program, on the built-in engine.
        violations: The broken rules so far.
    """

    program: BuiltinProgram
    violations: list[Violation]

    @property
    def telegrams(self) -> Sequence[Telegrams]:
        """The last telegrams of each controller."""

    @property
    def images(self) -> Sequence[Image]:
        """The areas of each controller in the process image."""

    @property
    def ended(self) -> str:
        """Why there is no further scan; empty while there is one."""

    @property
    def scans(self) -> int:
        """How many scans have run."""

    @property
    def now_us(self) -> int:
        """The time of the last scan."""

    def scan(self) -> None:
        """Let all happen until one more scan has run."""

    def snapshot(self) -> Any:
        """The state between two scans."""

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave, also from the middle of a scan."""

    def inject(self, event: str, controller: int) -> None:
        """Let something befall a controller, as in a stimulus."""

    def close(self) -> None:
        """Free what it holds."""


def builtin_of(program: Program) -> BuiltinProgram:
    """The program, if it is one of the built-in engine.

    Raises:
        InputError: it runs on another.
    """
    if not isinstance(program, BuiltinProgram):
        hint = "leave the engine out"
        raise InputError(f"the {program.engine} engine cannot be debugged", hint=hint)
    return program


def live_input(image: Image, program: Program, size: int) -> bytes:
    """The area from the controller as it stands in the process image."""
    area = bytearray(size)
    for slot in image.slots:
        value = int(program.read(slot.path))
        if slot.width:
            mask = (1 << 8 * slot.width) - 1
            part = (value & mask).to_bytes(slot.width, "little")
            area[slot.start : slot.start + slot.width] = part
        else:
            area[slot.start] |= value << slot.bit
    return bytes(area)


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
        self.images: Sequence[Image] = cell.images
        self.telegrams: Sequence[Telegrams] = [Telegrams(size) for size, _, _ in cell.areas]
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

    def inject(self, event: str, controller: int) -> None:
        """Let something befall a controller."""
        self.cell.inject(event, controller=controller)

    def close(self) -> None:
        """End the cell."""
        self.cell.close()
