"""What happens next on a virtual clock: a queue that is the same on every machine."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from heapq import heapify, heappop, heappush, heapreplace
from typing import Any

from structured_text.output.units import within_us

__all__ = ["SCAN", "STIMULUS", "Action", "Agenda", "Duration", "Snapshot", "scan_us"]

#: Kinds of events in the order in which they happen at equal times: what a stimulus does, what
#: devices around the program do, the scan.
STIMULUS, SCAN = 0, 5

Duration = str | int | timedelta

#: What happens at an event; it is given the time.
Action = Callable[[int], None]

#: State of an agenda, for `Agenda.restore`.
Snapshot = tuple[tuple[Any, ...], int, dict[int, int]]


def scan_us(scan: Duration) -> int:
    """The period of a scan, 100 us to 10 s, in microseconds (InputError: it is none)."""
    return within_us("the scan", scan, 100, 10_000_000)


class Agenda:
    """What happens next: a queue ordered by time, then by kind, then by device.

    Of one device's events of a kind the first come is the first served.

    Attributes:
        periods: How long after one event of a kind the next one comes by itself.
    """

    def __init__(self) -> None:
        self.periods: dict[int, int] = {}
        self._queue: list[tuple[int, int, int, int, Action]] = []
        self._count = 0

    @property
    def notice(self) -> str:
        """Something to tell at the end of a run; in virtual time there is nothing."""
        return ""

    def add(self, t_us: int, kind: int, action: Action, device: int = 1) -> None:
        """Let `action` happen at `t_us`."""
        self._count += 1
        heappush(self._queue, (t_us, kind, device, self._count, action))

    def repeat(self, t_us: int, kind: int, period_us: int, action: Action, device: int = 1) -> None:
        """Let `action` happen at `t_us` and every `period_us`, the same for all of its kind."""
        self.periods[kind] = period_us
        self.add(t_us, kind, action, device)

    def delay(self, kind: int, late_us: int) -> None:
        """Let the next events of a kind, and with them all that follow, come later."""
        self._queue = [
            (t_us + late_us * (one == kind), one, device, number, action)
            for t_us, one, device, number, action in self._queue
        ]
        heapify(self._queue)

    def first(self) -> tuple[int, int]:
        """Time and kind of the next event; the agenda of a bench is never empty."""
        return self._queue[0][:2]

    def pop(self) -> tuple[int, Action]:
        """Take the next event: its time and what happens."""
        t_us, kind, device, number, action = self._queue[0]
        if period_us := self.periods.get(kind):
            heapreplace(self._queue, (t_us + period_us, kind, device, number, action))
        else:
            heappop(self._queue)
        return t_us, action

    def snapshot(self) -> Snapshot:
        """All that is pending."""
        return tuple(self._queue), self._count, dict(self.periods)

    def restore(self, snapshot: Snapshot) -> None:
        """Go back to what `snapshot` gave."""
        queue, self._count, periods = snapshot
        self._queue, self.periods = list(queue), dict(periods)
