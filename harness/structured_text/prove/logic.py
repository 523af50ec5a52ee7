"""Truth values: a Python `bool` if known, else a term of the solver.

The functions simplify known operands, so that terms stay small.
"""

from __future__ import annotations

from typing import Any

import z3

__all__ = [
    "PROVED",
    "REFUTED",
    "UNKNOWN",
    "Bool",
    "UnsupportedError",
    "both",
    "either",
    "equal",
    "is_known",
    "logical",
    "negated",
    "truth",
]

#: Verdicts: the claim holds for all values, fails for some values, or is undecided.
PROVED, REFUTED, UNKNOWN = "proved", "refuted", "unknown"

#: `bool` or `z3.BoolRef`.
Bool = Any


class UnsupportedError(Exception):
    """The error for a construct that is not translated; the message names it."""


def is_known(value: Any) -> bool:
    """Return whether a value is a Python number or truth value."""
    return isinstance(value, (bool, int))


def truth(term: Any) -> Bool:
    """Return a Boolean term as `bool` if it is constant, else the term."""
    if isinstance(term, bool):
        return term
    if z3.is_true(term):
        return True
    return False if z3.is_false(term) else term


def negated(value: Bool) -> Bool:
    """Return NOT of a value."""
    if isinstance(value, bool):
        return not value
    return value.arg(0) if z3.is_not(value) else z3.Not(value)


def both(*values: Bool) -> Bool:
    """Return the conjunction of all values."""
    rest = [value for value in values if value is not True]
    if any(value is False for value in rest):
        return False
    if not rest:
        return True
    return rest[0] if len(rest) == 1 else z3.And(*rest)


def either(*values: Bool) -> Bool:
    """Return the disjunction of all values."""
    rest = [value for value in values if value is not False]
    if any(value is True for value in rest):
        return True
    if not rest:
        return False
    return rest[0] if len(rest) == 1 else z3.Or(*rest)


def logical(op: str, left: Bool, right: Bool) -> Bool:
    """Return AND, OR or XOR of two values."""
    if op == "AND":
        return both(left, right)
    if op == "OR":
        return either(left, right)
    if isinstance(left, bool):
        return negated(right) if left else right
    if isinstance(right, bool):
        return negated(left) if right else left
    return z3.Xor(left, right)


def equal(left: Any, right: Any) -> Bool:
    """Return the condition that two terms of the same sort are equal."""
    if left.eq(right):
        return True
    return truth(left == right) if z3.is_const(left) or z3.is_const(right) else left == right
