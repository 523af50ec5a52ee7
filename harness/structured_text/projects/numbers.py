"""Numbers in project files: strict readers of whole numbers and times.

Python's own conversions also accept `inf`, `nan`, `1_000` and digits of other scripts, and refuse
very long numbers.
"""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.units import parse_us

__all__ = ["interval_text", "interval_us", "milliseconds_us", "priority_of", "whole"]

_DIGITS = re.compile(r"[0-9]{1,18}")
_DECIMAL = re.compile(r"[0-9]{1,18}(?:\.[0-9]{1,18})?")
#: The greatest number of a priority in the standard; no tool has a greater number.
_LOWEST_PRIORITY = 65_535
_SHOWN = 40


def whole(text: str, what: str, low: int, high: int, file: Path, line: int) -> int:
    """Read a whole number, or raise InputError.

    `what` is the meaning of the number for the message, as in `the priority of the task T`.
    """
    plain = text.strip()
    number = int(plain) if _DIGITS.fullmatch(plain) else None
    if number is None or not low <= number <= high:
        hint = f"write a whole number from {low} to {high}"
        raise InputError(f"{what} is {_shown(text)}", file=file, line=line, hint=hint)
    return number


def priority_of(text: str, task: str, file: Path, line: int) -> int | None:
    """Read the priority of a task, or raise InputError; return None if the file has none."""
    what = f"the priority of the task {task}"
    return whole(text, what, 0, _LOWEST_PRIORITY, file, line) if text.strip() else None


def milliseconds_us(text: str, task: str, file: Path, line: int) -> int:
    """Read the interval of a task in milliseconds and return it in whole microseconds [µs].

    Raise InputError if it is not a number, is 0, or longer than a year.
    """
    plain = text.strip()
    exact = Fraction(plain) if _DECIMAL.fullmatch(plain) else Fraction(0)
    return interval_us(exact * 1_000, text, task, file, line)


def interval_us(exact: Fraction, text: str, task: str, file: Path, line: int) -> int:
    """Check the interval of a task and return the nearest whole number of microseconds [µs].

    Raise InputError if it is 0, or longer than a year.
    """
    try:
        found = parse_us(round(exact))
    except InputError:
        found = 0
    if not found:
        hint = "write an interval of 1 us to 365 d, such as T#10ms"
        text = f"the task {task} has the interval {_shown(text)}"
        raise InputError(text, file=file, line=line, hint=hint)
    return found


def interval_text(microseconds: int) -> str:
    """Write a time as a literal of one unit: `T#10ms`, `T#0.5ms`."""
    whole_ms, rest = divmod(microseconds, 1_000)
    return f"T#{whole_ms}.{rest:03}".rstrip("0") + "ms" if rest else f"T#{whole_ms}ms"


def _shown(text: str) -> str:
    return repr(text if len(text) <= _SHOWN else f"{text[:_SHOWN]}...")
