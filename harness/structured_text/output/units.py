"""Durations (`10ms`, `T#1s500ms`) and words (`16#8011`): parsing and formatting."""

from __future__ import annotations

import re
from datetime import timedelta
from fractions import Fraction

from structured_text.errors import InputError

__all__ = ["format_us", "format_word", "parse_us", "whole", "within_us"]

_UNITS = {"d": 86_400_000_000, "h": 3_600_000_000, "m": 60_000_000, "s": 1_000_000}
_UNITS |= {"ms": 1_000, "us": 1}
_PART = re.compile(r"([0-9]+(?:\.[0-9]+)?)(ms|us|d|h|m|s)")
#: Greatest number of digits of a number, greatest number of shown characters of an input, and the
#: longest duration. No run and no timer of a PLC takes longer.
_DIGITS, _SHOWN = 20, 40
_LONGEST_US = 365 * _UNITS["d"]


def parse_us(text: str | int | timedelta) -> int:
    """Parse a duration.

    Args:
        text: `"10ms"`, `"1.5s"`, `"T#1s500ms"`, a timedelta, or an int of microseconds.

    Returns:
        Microseconds, at least 0.

    Raises:
        InputError: The text is not a duration, or the duration is negative, longer than a year, or
            finer than a microsecond.
    """
    if isinstance(text, bool) or not isinstance(text, (str, int, timedelta)):
        hint = 'write it as "10ms", "1.5s", or an int of microseconds'
        raise InputError(f"{text!r:.{_SHOWN}} is not a duration", hint=hint)
    if isinstance(text, timedelta):
        text = text // timedelta(microseconds=1)
    if isinstance(text, int):
        if text < 0:
            raise InputError(f"a duration cannot be negative: {text} us")
        if text > _LONGEST_US:
            raise InputError("a duration is too long", hint="use 0s to 365d")
        return text
    plain = re.sub(r"^(t|time)#", "", text.strip().lower()).replace("_", "")
    total, end = 0, 0
    for part in _PART.finditer(plain):
        if part.start() != end:
            break
        if len(part[1]) > _DIGITS:
            raise InputError(f"{text[:_SHOWN]}... is not a duration", hint="use 0s to 365d")
        exact = Fraction(part[1]) * _UNITS[part[2]]
        if exact.denominator != 1:
            raise InputError(f"a duration in whole microseconds is expected, not {text!r}")
        total, end = total + int(exact), part.end()
    if not plain or end != len(plain):
        shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."
        raise InputError(f"{shown!r} is not a duration", hint="write it as 10ms, 1.5s or 1m30s")
    if total > _LONGEST_US:
        raise InputError(f"{text!r} is too long for a duration", hint="use 0s to 365d")
    return total


def within_us(what: str, value: str | int | timedelta, low: int, high: int) -> int:
    """Parse a duration from `low` to `high`; raise InputError if it is invalid or out of range."""
    try:
        given = parse_us(value)
    except InputError as error:
        span = f"{what} can be {format_us(low)} to {format_us(high)}"
        raise InputError(f"{what}: {error.message}", hint=span) from None
    if not low <= given <= high:
        raise InputError(
            f"{what} is {format_us(given)}; it must be {format_us(low)} to {format_us(high)}"
        )
    return given


def whole(what: str, value: object, low: int, high: int) -> int:
    """Return a whole number from `low` to `high`, or raise InputError."""
    if isinstance(value, bool) or not isinstance(value, int) or not low <= value <= high:
        shown = "a number of so many digits" if _is_huge(value) else f"{value!r:.{_SHOWN}}"
        raise InputError(
            f"{what} cannot be {shown}", hint=f"use a whole number from {low} to {high}"
        )
    return value


def _is_huge(value: object) -> bool:
    return isinstance(value, int) and abs(value) >= 10**_SHOWN


def format_us(time_us: int) -> str:
    """Format microseconds as milliseconds, `12.345 ms`, without trailing zeros."""
    return f"{time_us / 1000:.3f}".rstrip("0").rstrip(".") + " ms"


def format_word(value: int) -> str:
    """Format a word in hexadecimal, as IEC 61131-3 and this library's pages do: `16#8011`."""
    return f"16#{value:04X}"
