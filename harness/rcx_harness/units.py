"""Durations (`10ms`, `T#1s500ms`, in whole microseconds) and words, as people write them."""

from __future__ import annotations

import re
from datetime import timedelta

from rcx_harness.errors import InputError

__all__ = ["format_us", "format_word", "parse_us"]

_UNITS = {"d": 86_400_000_000, "h": 3_600_000_000, "m": 60_000_000, "s": 1_000_000}
_UNITS |= {"ms": 1_000, "us": 1}
_PART = re.compile(r"(\d+(?:\.\d+)?)(ms|us|d|h|m|s)")


def parse_us(text: str | int | timedelta) -> int:
    """Read a duration.

    Args:
        text: `"10ms"`, `"1.5s"`, `"T#1s500ms"`, a timedelta, or an int of microseconds.

    Returns:
        Microseconds, at least 0.

    Raises:
        InputError: not a duration, negative, or finer than a microsecond.
    """
    if isinstance(text, timedelta):
        text = text // timedelta(microseconds=1)
    if isinstance(text, int):
        if text < 0:
            raise InputError(f"a duration cannot be negative: {text} us")
        return text
    plain = re.sub(r"^(t|time)#", "", text.strip().lower()).replace("_", "")
    total, end = 0, 0
    for part in _PART.finditer(plain):
        if part.start() != end:
            break
        exact = float(part[1]) * _UNITS[part[2]]
        if abs(exact - round(exact)) > 1e-6:
            raise InputError(f"a duration in whole microseconds is expected, not {text!r}")
        total, end = total + round(exact), part.end()
    if not plain or end != len(plain):
        raise InputError(f"not a duration: {text!r}", hint="write it as 10ms, 1.5s or 1m30s")
    return total


def format_us(time_us: int) -> str:
    """Write microseconds as milliseconds, `12.345 ms`, without trailing zeros."""
    return f"{time_us / 1000:.3f}".rstrip("0").rstrip(".") + " ms"


def format_word(value: int) -> str:
    """Write a word as IEC 61131-3 and this library's pages do, `16#8011`."""
    return f"16#{value:04X}"
