"""The possible signs of floating-point terms, found without their arithmetic."""

from __future__ import annotations

from typing import Any

import z3

__all__ = ["by_sign"]

_INFINITE = 0x7F80_0000
_JOINS = (z3.Z3_OP_FPA_MUL, z3.Z3_OP_FPA_ADD)


def by_sign(term: Any) -> Any:
    """Replace each sum or product in a term by an arbitrary number.

    The arbitrary number has only signs that the sum or product can have.
    """
    if isinstance(term, bool):
        return z3.BoolVal(term)
    swaps, seen, waiting = [], set(), [term]
    while waiting:
        node = waiting.pop()
        if node.get_id() in seen:
            continue
        seen.add(node.get_id())
        if z3.is_app_of(node, z3.Z3_OP_FPA_TO_IEEE_BV) and node.size() == 32:
            swaps.append((node, _signed(node)))
        else:
            waiting += node.children()
    return z3.substitute(term, swaps) if swaps else term


def _signed(rounded: Any) -> Any:
    """Return an arbitrary bit pattern.

    If the term cannot be below 0, the pattern is not below 0.
    """
    pattern = z3.FreshConst(rounded.sort(), "signed")
    never = z3.And(_is_negative(pattern), z3.Not(_below_zero(rounded.arg(0))))
    return z3.If(never, z3.BitVecVal(0, 32), pattern)


def _below_zero(term: Any) -> Any:
    """Return a condition that covers all cases in which a floating-point term is below 0.

    NaN is not below 0. A square is not negative. Sums and products of non-negative numbers are not
    negative, and rounding keeps a sign.
    """
    kind, arguments = term.decl().kind(), term.children()
    if kind == z3.Z3_OP_FPA_MUL and arguments[1].eq(arguments[2]):
        return z3.BoolVal(False)
    if kind in _JOINS:
        return z3.Or(_below_zero(arguments[1]), _below_zero(arguments[2]))
    if kind == z3.Z3_OP_FPA_TO_FP and len(arguments) == 2 and z3.is_fp(arguments[1]):
        return _below_zero(arguments[1])
    if kind == z3.Z3_OP_FPA_TO_FP and term.sort() == z3.Float32() and z3.is_bv(arguments[-1]):
        return _pattern_below_zero(arguments[-1])
    return z3.fpLT(term, z3.FPVal(0.0, term.sort()))


def _pattern_below_zero(pattern: Any) -> Any:
    """Return the condition of `_below_zero` for a REAL that is given as a bit pattern."""
    if z3.is_app_of(pattern, z3.Z3_OP_FPA_TO_IEEE_BV):
        return z3.And(_is_negative(pattern), _below_zero(pattern.arg(0)))
    if z3.is_app_of(pattern, z3.Z3_OP_ITE):
        condition, yes, no = pattern.children()
        parts = z3.If(condition, _pattern_below_zero(yes), _pattern_below_zero(no))
        return z3.And(_is_negative(pattern), parts)
    return _is_negative(pattern)


def _is_negative(pattern: Any) -> Any:
    """Return the claim that the number with this pattern is below 0."""
    size = pattern & 0x7FFF_FFFF
    return z3.And(pattern != size, size != 0, z3.ULE(size, _INFINITE))
