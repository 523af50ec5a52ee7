"""Rates, round trips and ages, as the bridge shows them."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass

__all__ = ["Figures", "Rate"]

_KEPT = 1000


@dataclass(frozen=True)
class Rate:
    """Of the exchanges kept, the last 1,000 at most.

    Attributes:
        count: All exchanges that succeeded since the start.
        per_second: Exchanges a second; 0 with fewer than two.
        median_us: Of the round trips (reading and writing), in microseconds; 0 without any.
        p99_us: 99 of 100 took at most so long.
        max_us: The longest.
        age_us: Since the last answer; None before the first.
    """

    count: int
    per_second: float
    median_us: int
    p99_us: int
    max_us: int
    age_us: int | None


class Figures:
    """Collects exchanges; one thread may add while another looks."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: deque[tuple[int, int]] = deque(maxlen=_KEPT)
        self._count = 0

    def add(self, ended_us: int, took_us: int) -> None:
        """An exchange has ended at `ended_us` and took `took_us`."""
        with self._lock:
            self._kept.append((ended_us, took_us))
            self._count += 1

    def look(self, now_us: int) -> Rate:
        """What there is to show at `now_us`, of the same clock."""
        with self._lock:
            kept, count = list(self._kept), self._count
        if not kept:
            return Rate(0, 0.0, 0, 0, 0, None)
        took = sorted(one for _, one in kept)
        span_us = kept[-1][0] - kept[0][0]
        return Rate(
            count=count,
            per_second=(len(kept) - 1) * 1e6 / span_us if span_us else 0.0,
            median_us=took[len(took) // 2],
            p99_us=took[min(len(took) - 1, len(took) * 99 // 100)],
            max_us=took[-1],
            age_us=now_us - kept[-1][0],
        )
