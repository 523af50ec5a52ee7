"""Integer division and remainder by the standard's rules, for constants and running programs."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

__all__ = ["ARITHMETIC", "COMPARISONS", "LOGIC", "quotient", "remainder"]

ARITHMETIC: dict[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": operator.pow,
}
LOGIC: dict[str, Callable[[Any, Any], Any]] = {
    "AND": operator.and_,
    "OR": operator.or_,
    "XOR": operator.xor,
}
COMPARISONS: dict[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def quotient(a: int, b: int) -> int:
    """Divide two integers and truncate towards zero; raise ZeroDivisionError for a divisor of 0."""
    found = abs(a) // abs(b)
    return found if (a < 0) == (b < 0) else -found


def remainder(a: int, b: int) -> int:
    """Return the remainder with the sign of the dividend.

    The remainder is 0 for a divisor of 0, as the standard says.
    """
    rest = abs(a) % abs(b) if b else 0
    return -rest if a < 0 else rest
