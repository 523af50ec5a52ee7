"""Real time for a controller: when its next cycle is due, and how many were missed."""

from __future__ import annotations

__all__ = ["Pace"]


class Pace:
    """Cycles on a fixed grid of a monotonic clock.

    A cycle that comes too late is done once; those that were missed meanwhile are left out and
    counted, never made up for. So neither a late wake-up nor a standstill of this computer shifts
    the cycles to come, and the controller's time, a whole number of periods, stays real time.

    Args:
        start_us: Time of the first cycle on the clock [us].
        period_us: Length of a cycle [us].

    Attributes:
        cycles: Cycles done.
        skipped: Cycles left out.
    """

    def __init__(self, start_us: int, period_us: int) -> None:
        self._start_us = start_us
        self._period_us = period_us
        self._next = 0  # number of the next cycle on the grid
        self.cycles = 0
        self.skipped = 0

    def wait_us(self, now_us: int) -> int:
        """How long to wait for the next cycle; 0 if it is due."""
        return max(0, self._start_us + self._next * self._period_us - now_us)

    def take(self, now_us: int) -> int:
        """Begin the cycle that is due.

        Returns:
            The controller's time of this cycle [us], 0 for the first.
        """
        number = max(self._next, (now_us - self._start_us) // self._period_us)
        self.skipped += number - self._next
        self.cycles += 1
        self._next = number + 1
        return number * self._period_us
