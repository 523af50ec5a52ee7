"""A queue of future events on a virtual clock; their order is the same on every machine."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from heapq import heapify, heappop, heappush, heapreplace
from typing import Any

from structured_text.output.units import within_us

__all__ = ["SCAN", "STIMULUS", "Action", "Agenda", "Duration", "Snapshot", "scan_us"]

#: Kinds of events. At equal times the stimulus comes first, then the devices around the program,
#: then the program's scan.
STIMULUS, SCAN = 0, 5

Duration = str | int | timedelta

#: The function that an event calls. The argument of the function is the time of the event in
#: microseconds.
Action = Callable[[int], None]

#: The saved state of an agenda, see `Agenda.restore`.
Snapshot = tuple[tuple[Any, ...], int, dict[int, int]]


def scan_us(scan: Duration) -> int:
    """Return the period of a scan in microseconds.

    Raise InputError unless it is from 100 us to 10 s.
    """
    return within_us("the scan", scan, 100, 10_000_000)


class Agenda:
    """A queue of future events, ordered by time, then by kind, then by device.

    Events of the same time, kind and device run in the order in which they were added.

    Attributes:
        periods: Period of each kind of repeated events in microseconds. After an event of this
            kind, the queue adds the next one.
    """

    def __init__(self) -> None:
        self.periods: dict[int, int] = {}
        self._queue: list[tuple[int, int, int, int, Action]] = []
        self._count = 0

    @property
    def notice(self) -> str:
        """Return a notice for the end of a run; in virtual time it is empty."""
        return ""

    def add(self, t_us: int, kind: int, action: Action, device: int = 1) -> None:
        """Schedule `action` at the time `t_us`."""
        self._count += 1
        heappush(self._queue, (t_us, kind, device, self._count, action))

    def repeat(self, t_us: int, kind: int, period_us: int, action: Action, device: int = 1) -> None:
        """Schedule `action` at `t_us` and then every `period_us`.

        All events of a kind share the period.
        """
        self.periods[kind] = period_us
        self.add(t_us, kind, action, device)

    def delay(self, kind: int, late_us: int) -> None:
        """Delay all pending events of a kind, and their repetitions, by `late_us`."""
        self._queue = [
            (t_us + late_us * (one == kind), one, device, number, action)
            for t_us, one, device, number, action in self._queue
        ]
        heapify(self._queue)

    def first(self) -> tuple[int, int]:
        """Return time and kind of the next event; the agenda of a bench is never empty."""
        return self._queue[0][:2]

    def pop(self) -> tuple[int, Action]:
        """Remove the next event, and return its time and action.

        If the event repeats, schedule its repetition.
        """
        t_us, kind, device, number, action = self._queue[0]
        if period_us := self.periods.get(kind):
            heapreplace(self._queue, (t_us + period_us, kind, device, number, action))
        else:
            heappop(self._queue)
        return t_us, action

    def snapshot(self) -> Snapshot:
        """Return a copy of all pending events and periods."""
        return tuple(self._queue), self._count, dict(self.periods)

    def restore(self, snapshot: Snapshot) -> None:
        """Restore the state from `snapshot`."""
        queue, self._count, periods = snapshot
        self._queue, self.periods = list(queue), dict(periods)
