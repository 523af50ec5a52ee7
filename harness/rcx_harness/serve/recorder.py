"""A recording of a served controller: a separate trace that the user starts and stops."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rcx_harness.robot import Controller
from rcx_harness.robot.listing import Tasks, listings
from rcx_harness.robot.positions import axes_of, where
from rcx_harness.robot.shape import poses, shapes
from rcx_harness.spec.wire import CYCLE_US
from rcx_harness.trace import Cycle, Trace
from structured_text.errors import Violation

__all__ = ["MOST_CYCLES", "Recorder"]

#: Maximum number of recorded cycles: an hour of continuous motion.
MOST_CYCLES = 720_000
_UNIT = "mm"


class Recorder:
    """A trace of the cycles in which areas, positions or tasks have changed, and of broken rules.

    Its time begins at 0. `rcx view` and `rcx judge` read it.
    """

    def __init__(self, controller: Controller, host: str, file: Path, now_us: int) -> None:
        size = controller.config.size
        header = {"by": "rcx serve", "of": host, "cycle_us": CYCLE_US, "size": size}
        self._trace = Trace(
            {**header, "only": "changes"},
            file,
            keep=0,
            axes=axes_of([controller], _UNIT),
            robots=[shapes(controller)],
            programs=[listings(controller)],
        )
        self._tasks = Tasks(controller)
        self._controller, self._begin_us = controller, now_us
        self._seen: tuple[bytes, bytes] | None = None
        self._stood: tuple[float, ...] | None = None
        self._posed: tuple[dict[str, Any], ...] = tuple({} for _ in poses(controller))
        self.cycles = 0

    @property
    def is_full(self) -> bool:
        """Return whether the maximum number of cycles is reached."""
        return self.cycles >= MOST_CYCLES

    def note(self, now_us: int, cycle: int, si: bytes, so: bytes, *, last: bool = False) -> None:
        """Record a cycle if it has a change or is the last cycle."""
        stood, posed = where(self._controller, _UNIT), tuple(poses(self._controller))
        tasks, before = self._tasks.changed(), (self._seen, self._stood, self._posed)
        if ((si, so), stood, posed) == before and tasks is None and not last:
            return
        moved = None if stood == self._stood else stood
        turned = None if posed == self._posed else posed
        self._seen, self._stood, self._posed = (si, so), stood, posed
        self._trace.add(Cycle(now_us - self._begin_us, cycle, si, so, 1, moved, turned, tasks))
        self.cycles += 1

    def broken(self, violation: Violation) -> None:
        """Record a broken rule."""
        t_us = max(0, violation.t_us - self._begin_us)
        self._trace.add(Violation(t_us, violation.rule, violation.text))

    def close(self) -> None:
        """Write buffered data, and close the file."""
        self._trace.close()
