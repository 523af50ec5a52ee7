"""Conditions under which arithmetic leaves its type.

PLCs differ in the result of such arithmetic, and it is seldom intended.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import z3

from structured_text.language import tree as t
from structured_text.language.scalars import ANY_BIT, ANY_DATE, INT_RANGE
from structured_text.language.types import Type, type_name
from structured_text.prove import values
from structured_text.prove.logic import Bool, both, either, is_known
from structured_text.prove.values import Value

__all__ = [
    "NANOSECONDS",
    "Operation",
    "Span",
    "arithmetic",
    "beyond_bits",
    "conversion",
    "negation",
    "outside",
    "resized",
]

Span = tuple[int, int]
#: The range of a duration with 64 bits.
NANOSECONDS: Span = (-(1 << 63), (1 << 63) - 1)


@dataclass(frozen=True)
class Operation:
    """An arithmetic operation that was run, with its position in the source.

    Attributes:
        pou: The POU with the operation.
        line: First line of the statement with the operation.
        reached: The condition under which the operation is run.
        leaves: A function that takes the range of TIME and returns the condition under which the
            result leaves its type. The term is created only on request.
    """

    node: t.Expression
    pou: str
    file: str
    line: int
    reached: tuple[Bool, ...]
    leaves: Callable[[Span], Bool]

    def when(self, time: Span = NANOSECONDS) -> Bool:
        """Return the condition under which the operation is run and its result leaves the type."""
        leaves = self.leaves(time)
        return False if leaves is False else both(*self.reached, leaves)


def _span(kind: Type, time: Span = NANOSECONDS) -> Span | None:
    """Return the lowest and the highest number of a type; None if the type is not numeric."""
    if type_name(kind) in ANY_DATE:
        return NANOSECONDS
    return time if values.is_duration(kind) else INT_RANGE.get(type_name(kind))


def resized(value: Value, kind: Type, width: int) -> Value:
    """Return an integer with another width: extended by sign or zeros, or truncated."""
    if is_known(value) or value.size() == width:
        return value
    if value.size() > width:
        return z3.Extract(width - 1, 0, value)
    extend = z3.SignExt if values.is_signed(kind) else z3.ZeroExt
    return extend(width - value.size(), value)


def _outside(value: Value, low: int, high: int, kind: Type) -> Bool:
    """Return the condition that a value is below `low` or above `high`.

    The limits may exceed the range of the value's own type; such a limit needs no comparison.
    """
    if is_known(value):
        return not low <= value <= high
    least, most = (0, (1 << value.size()) - 1)
    if values.is_signed(kind):
        least, most = -(1 << value.size() - 1), (1 << value.size() - 1) - 1
    return either(
        values.compare("<", value, low, kind) if low > least else False,
        values.compare(">", value, high, kind) if high < most else False,
    )


def outside(value: Value, kind: Type, time: Span) -> Bool:
    """Return the condition that a value computed with spare bits does not fit its type."""
    limits = _span(kind, time)
    return False if limits is None else _outside(value, *limits, kind)


def arithmetic(op: str, left: Value, right: Value, kind: Type, time: Span) -> Bool:
    """Return the condition that the result of an operation leaves the type.

    The operation is a sum, difference, product, quotient or remainder. Both operands have the width
    of the type. The remainder of the lowest number by -1 counts as well, because many processors
    divide to compute it.
    """
    limits = _span(kind, time)
    if limits is None:
        return False
    low, high = limits
    if op in ("/", "MOD"):
        if not values.is_signed(kind):
            return False
        return both(values.compare("=", left, low, kind), values.compare("=", right, -1, kind))
    if is_known(left) and is_known(right):
        exact = {"+": left + right, "-": left - right, "*": left * right}[op]
        return not low <= exact <= high
    if op in "+*" and is_known(left):
        left, right = right, left
    if is_known(right):
        return _with_known(op, left, right, low, high, kind)
    if op == "*":
        return _product(left, right, low, high, kind)
    width = values.bits(kind) + 2
    a, b = (resized(values.scalar(kind, one), kind, width) for one in (left, right))
    exact = a + b if op == "+" else a - b
    return z3.Or(exact < low, exact > high)


def _with_known(op: str, left: Value, number: int, low: int, high: int, kind: Type) -> Bool:
    """Return the condition that an operation with a constant leaves its type.

    The condition has at most two comparisons.
    """
    if op in "+-":
        by = number if op == "+" else -number
        return _outside(left, low - by if by < 0 else low, high - by if by > 0 else high, kind)
    if number == 0:
        return False
    first, last = (low, high) if number > 0 else (high, low)
    return _outside(left, -(-first // number), last // number, kind)


def _product(left: Value, right: Value, low: int, high: int, kind: Type) -> Bool:
    signed = values.is_signed(kind)
    inside = [z3.BVMulNoOverflow(left, right, signed)]
    if signed:
        inside.append(z3.BVMulNoUnderflow(left, right))
    fits = z3.And(*inside)
    return either(z3.Not(fits), _outside(left * right, low, high, kind))


def beyond_bits(op: str, left: Value, right: Value, kind: Type) -> Bool:
    """Return the condition that the result of a signed +, - or * does not fit its bit-vector."""
    a, b = values.scalar(kind, left), values.scalar(kind, right)
    if op == "*":
        fits = z3.And(z3.BVMulNoOverflow(a, b, True), z3.BVMulNoUnderflow(a, b))
    elif op == "+":
        fits = z3.And(z3.BVAddNoOverflow(a, b, True), z3.BVAddNoUnderflow(a, b))
    else:
        fits = z3.And(z3.BVSubNoOverflow(a, b), z3.BVSubNoUnderflow(a, b, True))
    return z3.Not(fits)


def negation(value: Value, kind: Type, time: Span) -> Bool:
    """Return the condition that -value, or the absolute value, leaves the type."""
    return arithmetic("-", 0, value, kind, time)


def conversion(value: Value, source: Type, target: Type) -> Bool:
    """Return the condition that a number does not fit the target type, or that bits are lost.

    A bit string and a number of the same width exchange the bit pattern unchanged.
    """
    bits = [one for one in (source, target) if type_name(one) in ANY_BIT]
    limits = INT_RANGE.get(type_name(target))
    if limits is None or _span(source) is None:
        return False
    low, high = limits
    if bits:
        width = values.bits(target)
        if width >= values.bits(source):
            return False
        low, high = -(1 << width - 1) if values.is_signed(source) else 0, (1 << width) - 1
    return _outside(value, low, high, source)
