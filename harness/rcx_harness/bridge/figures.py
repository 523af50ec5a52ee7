"""Rates, round trips and ages of the bridge, and their texts."""

from __future__ import annotations

import threading
from collections import deque
from dataclasses import dataclass

from rcx_harness.bridge.core import State
from rcx_harness.enip.originator.scanner import ScannerStatistics

__all__ = ["Figures", "Rate", "figures_text", "plc_text", "robot_text", "state_text"]

_KEPT = 1000


@dataclass(frozen=True)
class Rate:
    """The statistics of the last exchanges, 1,000 at most.

    Attributes:
        per_second: Exchanges per second; 0 if there are fewer than two.
        median_us: Median of the round trips (read and write), in microseconds; 0: no exchange yet.
        p99_us: 99 % of the round trips took at most this long.
        max_us: The longest round trip.
        age_us: Time since the last answer; None before the first answer.
    """

    per_second: float
    median_us: int
    p99_us: int
    max_us: int
    age_us: int | None


class Figures:
    """The times of the last exchanges; one thread may add a time while another thread reads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._kept: deque[tuple[int, int]] = deque(maxlen=_KEPT)

    def add(self, ended_us: int, took_us: int) -> None:
        """Add an exchange that ended at `ended_us` and took `took_us`."""
        with self._lock:
            self._kept.append((ended_us, took_us))

    def look(self, now_us: int) -> Rate:
        """Return the statistics at `now_us`; the clock is the clock of `ended_us`."""
        with self._lock:
            kept = list(self._kept)
        if not kept:
            return Rate(0.0, 0, 0, 0, None)
        took = sorted(one for _, one in kept)
        span_us = kept[-1][0] - kept[0][0]
        return Rate(
            per_second=(len(kept) - 1) * 1e6 / span_us if span_us else 0.0,
            median_us=took[len(took) // 2],
            p99_us=took[min(len(took) - 1, len(took) * 99 // 100)],
            max_us=took[-1],
            age_us=now_us - kept[-1][0],
        )


_LONG_US = 1_000_000
"""After this time without exchanges, the rates are outdated and are not shown [us]."""


def state_text(state: State, reason: str) -> str:
    """Return state and reason as text, such as `no PLC: 127.0.0.1:502: no answer within 100 ms`."""
    return f"{state.value}: {reason}" if reason else state.value


def plc_text(rate: Rate) -> str:
    """Return a text of the PLC's side: exchanges per second, round trip times, age of the data."""
    if rate.age_us is None:
        return "PLC: no exchange yet"
    if rate.age_us > _LONG_US:
        return f"PLC: no exchange for {rate.age_us / 1e6:.1f} s"
    return (
        f"PLC {rate.per_second:.1f} exchanges/s, round trip {_ms(rate.median_us)} median "
        f"{_ms(rate.p99_us)} p99 {_ms(rate.max_us)} longest, data {_ms(rate.age_us)} old"
    )


def robot_text(look: tuple[ScannerStatistics, int | None] | None) -> str:
    """Return a text of the robot's side: packets per second, intervals, age of the data."""
    seen, age_us = look or (None, None)
    if seen is None or age_us is None:
        return "robot: no packet yet"
    if age_us > _LONG_US:
        return f"robot: no packet for {age_us / 1e6:.1f} s"
    rate = 1e6 / seen.gap_median_us if seen.gap_median_us else 0.0
    return (
        f"robot {rate:.1f} packets/s, one every {_ms(seen.gap_median_us)} median "
        f"{_ms(seen.gap_p99_us)} p99 {_ms(seen.gap_max_us)} longest, {seen.missing} missing, "
        f"data {_ms(age_us)} old"
    )


def figures_text(rate: Rate, look: tuple[ScannerStatistics, int | None] | None) -> str:
    """Return the texts of both sides in one line."""
    return f"{plc_text(rate)}; {robot_text(look)}"


def _ms(time_us: int) -> str:
    return f"{time_us / 1e3:.1f} ms"
