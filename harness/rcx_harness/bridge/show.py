"""What the bridge says: a live line in a terminal, else a line for each change and now and then."""

from __future__ import annotations

from rcx_harness.bridge.core import State
from rcx_harness.bridge.figures import Rate
from rcx_harness.enip.originator.scanner import ScannerStatistics

__all__ = ["figures_text", "plc_text", "robot_text", "state_text"]

_LONG_US = 1_000_000
"""After so long without anything new, rates are those of another time."""


def state_text(state: State, reason: str) -> str:
    """`no PLC: 127.0.0.1:502: no answer within 100 ms`."""
    return f"{state.value}: {reason}" if reason else state.value


def plc_text(rate: Rate) -> str:
    """The PLC's side: exchanges a second, round trip, age of its data."""
    if rate.age_us is None:
        return "PLC: no exchange yet"
    if rate.age_us > _LONG_US:
        return f"PLC: no exchange for {rate.age_us / 1e6:.1f} s"
    return (
        f"PLC {rate.per_second:.1f} exchanges/s, round trip {_ms(rate.median_us)} median "
        f"{_ms(rate.p99_us)} p99 {_ms(rate.max_us)} longest, data {_ms(rate.age_us)} old"
    )


def robot_text(look: tuple[ScannerStatistics, int | None] | None) -> str:
    """The robot's side: packets a second, time between two of them, age of its data."""
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
    """Both sides in one line."""
    return f"{plc_text(rate)}; {robot_text(look)}"


def _ms(time_us: int) -> str:
    return f"{time_us / 1e3:.1f} ms"
