"""A program on a bench under the debugger: scan by scan, and back."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from structured_text.bench import Bench
from structured_text.debug.machine import Scope, builtin_of

__all__ = ["BenchMachine"]


class BenchMachine:
    """A bench in virtual time, with a stimulus that is scheduled in it already.

    Args:
        bench: The bench.
        end_us: Scans run before this time.
        shown: That time for messages.
    """

    around: Sequence[Scope] = ()

    def __init__(self, bench: Bench, end_us: int, shown: str) -> None:
        self.bench, self.program = bench, builtin_of(bench.program)
        self._end_us, self._shown = end_us, shown
        self.violations = bench.violations

    @property
    def scans(self) -> int:
        """How many scans have run."""
        return self.bench.scans

    @property
    def now_us(self) -> int:
        """The time of the last scan."""
        return self.bench.now_us

    @property
    def ended(self) -> str:
        """Why there is no further scan."""
        over = self.bench.next_us >= self._end_us
        return f"the end of the run ({self._shown})" if over else ""

    def scan(self) -> None:
        """Let all happen until one more scan has run."""
        self.bench.scan()

    def snapshot(self) -> Any:
        """The state between two scans."""
        return self.bench.snapshot()

    def restore(self, snapshot: Any) -> None:
        """Go back to what `snapshot` gave."""
        self.program.note_calls({})  # those of a scan that was left in its middle are forgotten
        self.bench.restore(snapshot)

    def inject(self, event: str, device: int) -> None:
        """Let something befall the PLC; there is no device around it."""
        del device
        self.bench.inject(event)

    def close(self) -> None:
        """End the bench."""
        self.bench.close()
