"""Truth values: Python's where they are known, terms of the solver where they are not."""

from __future__ import annotations

from typing import Any

import z3

__all__ = ["Bool", "UnsupportedError", "both", "either", "equal", "is_known", "negated", "truth"]

#: `bool` or `z3.BoolRef`.
Bool = Any


class UnsupportedError(Exception):
    """Something of the program that is not translated; the message names it."""


def is_known(value: Any) -> bool:
    """Whether it is a Python number or truth value."""
    return isinstance(value, (bool, int))


def truth(term: Any) -> Bool:
    """A Boolean term as `bool` where it is one."""
    if isinstance(term, bool):
        return term
    if z3.is_true(term):
        return True
    return False if z3.is_false(term) else term


def negated(value: Bool) -> Bool:
    """NOT."""
    if isinstance(value, bool):
        return not value
    return value.arg(0) if z3.is_not(value) else z3.Not(value)


def both(*values: Bool) -> Bool:
    """All of them hold."""
    rest = [value for value in values if value is not True]
    if any(value is False for value in rest):
        return False
    if not rest:
        return True
    return rest[0] if len(rest) == 1 else z3.And(*rest)


def either(*values: Bool) -> Bool:
    """One of them holds."""
    rest = [value for value in values if value is not False]
    if any(value is True for value in rest):
        return True
    if not rest:
        return False
    return rest[0] if len(rest) == 1 else z3.Or(*rest)


def equal(left: Any, right: Any) -> Bool:
    """Two terms of one sort are equal."""
    if left.eq(right):
        return True
    return truth(left == right) if z3.is_const(left) or z3.is_const(right) else left == right
