"""A bench as a `Machine` of the debugger."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from structured_text.bench import Bench
from structured_text.debug.devices import Devices
from structured_text.debug.machine import Scope, builtin_of

__all__ = ["BenchMachine"]


class BenchMachine:
    """A bench in virtual time, in which the stimulus is already scheduled."""

    around: Sequence[Scope] = ()
    devices: Devices | None = None

    def __init__(self, bench: Bench, end_us: int, shown: str) -> None:
        self.bench, self.program = bench, builtin_of(bench.program)
        self._end_us, self._shown = end_us, shown
        self.violations = bench.violations

    @property
    def scans(self) -> int:
        """Return the number of scans that have run."""
        return self.bench.scans

    @property
    def now_us(self) -> int:
        """Return the time of the last scan in microseconds."""
        return self.bench.now_us

    @property
    def ended(self) -> str:
        """Return the reason why no further scan can run, or an empty text."""
        over = self.bench.next_us >= self._end_us
        return f"the end of the run ({self._shown})" if over else ""

    def scan(self) -> None:
        """Advance time until one more scan has run."""
        self.bench.scan()

    def snapshot(self) -> Any:
        """Return the state between two scans."""
        return self.bench.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Restore the state from `snapshot`."""
        self.program.note_calls({})  # discard the calls that were logged in an abandoned scan
        self.bench.restore(snapshot)

    def inject(self, event: str, device: int) -> None:
        """Trigger an event of the PLC.

        `device` has no effect, because a bench has no devices.
        """
        del device
        self.bench.inject(event)

    def close(self) -> None:
        """Close the bench."""
        self.bench.close()
