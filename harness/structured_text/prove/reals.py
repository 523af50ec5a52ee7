"""REAL and LREAL values as terms of the solver.

A stored REAL is its IEEE 754 pattern of 32 bits. Comparisons, signs and powers of two are
calculated with the pattern, which is exact and fast. All other operations use the solver's floating
point. As in the engines, an untyped literal keeps double precision in REAL arithmetic until the
result is stored or passed (see `wide`).
"""

from __future__ import annotations

import math
import struct
from ctypes import c_float
from dataclasses import dataclass
from typing import Any

import z3

from structured_text.language.arithmetic import ARITHMETIC, COMPARISONS
from structured_text.prove.logic import Bool, UnsupportedError, both, either, negated, truth

__all__ = [
    "Real",
    "absolute",
    "anything",
    "arithmetic",
    "choose",
    "compare",
    "constant",
    "cut",
    "fits",
    "from_integer",
    "identical",
    "in_range",
    "negative",
    "root",
    "settled",
    "to_integer",
    "widened",
]

_SIGN, _MAGNITUDE, _INFINITE = 1 << 31, (1 << 31) - 1, 0x7F80_0000


@dataclass(frozen=True)
class Real:
    """A REAL or LREAL number.

    Attributes:
        value: A Python float if it is known. Otherwise a REAL is its pattern, a bit-vector of 32
            bits; an LREAL, or a REAL with double precision, is a double-precision term.
        double: Whether the number is an LREAL, or a REAL that is not rounded yet.
        halved: +1 if the value is a pattern that is still to be doubled, -1 if it is still to be
            halved, else 0.
    """

    value: Any
    double: bool = False
    halved: int = 0

    @property
    def known(self) -> bool:
        """Return whether the value is a Python number."""
        return isinstance(self.value, float)


def constant(value: float, kind: str, *, wide: bool = False) -> Real:
    """Return the value of a literal."""
    if kind == "REAL" and not wide:
        return Real(c_float(value).value)
    return Real(value, double=True)


def anything(name: str, kind: str) -> Real:
    """Return an arbitrary number, including infinities and NaN."""
    if kind == "REAL":
        return Real(z3.BitVec(name, 32))
    return Real(z3.FP(name, z3.Float64()), double=True)


def _pattern(number: Real) -> Any:
    """Return the bits of a REAL with single precision."""
    if number.known:
        return int(struct.unpack("<I", struct.pack("<f", c_float(number.value).value))[0])
    return number.value


def _bits(number: Real) -> Any:
    pattern = _pattern(number)
    return z3.BitVecVal(pattern, 32) if isinstance(pattern, int) else pattern


def _single(number: Real) -> Any:
    return z3.fpBVToFP(_bits(number), z3.Float32())


def _double(number: Real) -> Any:
    if number.known:
        return z3.FPVal(number.value, z3.Float64())
    if number.halved:
        factor = z3.FPVal(2.0**number.halved, z3.Float64())
        return z3.fpMul(z3.RNE(), _double(Real(number.value)), factor)
    if number.double:
        return number.value
    return z3.fpFPToFP(z3.RNE(), _single(number), z3.Float64())


def _narrow(term: Any) -> Real:
    return Real(z3.fpToIEEEBV(term))


def settled(number: Real, kind: str) -> Real:
    """Return the number as it is stored: a REAL is rounded to single precision."""
    if kind == "LREAL" or not number.double:
        return number
    if number.known:
        return Real(c_float(number.value).value)
    if number.halved:
        return Real(_twice(number.value) if number.halved > 0 else _half(number.value))
    return _narrow(z3.fpFPToFP(z3.RNE(), number.value, z3.Float32()))


def _twice(pattern: Any) -> Any:
    sign, size = pattern & _SIGN, pattern & _MAGNITUDE
    return sign | z3.If(
        z3.UGE(size, _INFINITE),
        size,
        z3.If(
            z3.UGE(size, 0x7F00_0000),
            z3.BitVecVal(_INFINITE, 32),
            z3.If(z3.ULT(size, 0x80_0000), size << 1, size + 0x80_0000),
        ),
    )


def _half(pattern: Any) -> Any:
    sign, size = pattern & _SIGN, pattern & _MAGNITUDE
    down = z3.LShR(size, 1)
    return sign | z3.If(
        z3.UGE(size, _INFINITE),
        size,
        z3.If(z3.ULT(size, 0x100_0000), down + (size & down & 1), size - 0x80_0000),
    )


def choose(condition: Any, yes: Real, no: Real) -> Real:
    """Return `yes` if the condition holds, else `no`."""
    if (
        yes.known
        and no.known
        and yes.double == no.double
        and struct.pack("<d", yes.value) == struct.pack("<d", no.value)
    ):
        return yes
    if yes.double or no.double:
        return Real(z3.If(condition, _double(yes), _double(no)), double=True)
    left, right = _bits(yes), _bits(no)
    return yes if left.eq(right) else Real(z3.If(condition, left, right))


def identical(left: Real, right: Real) -> Bool:
    """Return the condition that two numbers are the same: 0.0 is not -0.0, and NaN is NaN."""
    if left.known and right.known:
        return struct.pack("<d", left.value) == struct.pack("<d", right.value)
    if left.double or right.double:
        a, b = _double(left), _double(right)
    else:
        a, b = _bits(left), _bits(right)
    # The equality of the solver; `==` on floating point terms is that of IEEE 754.
    return True if a.eq(b) else z3.ExprRef.__eq__(a, b)


def _is_nan(number: Real) -> Bool:
    if number.known:
        return math.isnan(number.value)
    return z3.UGT(number.value & _MAGNITUDE, _INFINITE)


def _key(number: Real) -> Any:
    """Return the number as unsigned bits that sort like the REAL numbers.

    +0 and -0 give the same bits.
    """
    pattern = _pattern(number)
    if isinstance(pattern, int):
        pattern = 0 if pattern == _SIGN else pattern
        return z3.BitVecVal(pattern ^ (0xFFFF_FFFF if pattern & _SIGN else _SIGN), 32)
    zero = pattern & _MAGNITUDE == 0
    negative = z3.Extract(31, 31, pattern) == 1
    return z3.If(zero, z3.BitVecVal(_SIGN, 32), z3.If(negative, ~pattern, pattern ^ _SIGN))


_ORDER = {"=": lambda a, b: a == b, "<": z3.ULT, ">": z3.UGT, "<=": z3.ULE, ">=": z3.UGE}
_DOUBLE = {"=": z3.fpEQ, "<": z3.fpLT, ">": z3.fpGT, "<=": z3.fpLEQ, ">=": z3.fpGEQ}
_MIRRORED = {"<": ">", ">": "<", "<=": ">=", ">=": "<=", "=": "=", "<>": "<>"}


def compare(op: str, left: Real, right: Real) -> Bool:
    """Return the result of a comparison; NaN is unequal to every number."""
    if left.known and right.known:
        return bool(COMPARISONS[op](left.value, right.value))
    if op == "<>":
        return negated(compare("=", left, right))
    if left.known:
        return compare(_MIRRORED[op], right, left)
    if right.known and not left.double:
        return _against(op, left, right.value)
    if not left.double and not right.double:
        order = truth(_ORDER[op](_key(left), _key(right)))
        return both(order, negated(either(_is_nan(left), _is_nan(right))))
    return truth(_DOUBLE[op](_double(left), _double(right)))


def _against(op: str, number: Real, limit: float) -> Bool:
    """Return the comparison of a REAL with a double.

    A double lies on a single-precision number or between two of them. The comparison with the
    appropriate neighbour has the same result, and needs no floating-point term.
    """
    if math.isnan(limit):
        return False
    below = c_float(limit).value
    if below > limit:
        below = _neighbour(below, up=False)
    exact = below == limit
    above = limit if exact else _neighbour(below, up=True)
    if op == "=" and not exact:
        return False
    near = {"<": above, ">=": above, ">": below, "<=": below, "=": limit}[op]
    return both(truth(_ORDER[op](_key(number), _key(Real(near)))), negated(_is_nan(number)))


def _neighbour(value: float, *, up: bool) -> float:
    pattern = struct.unpack("<i", struct.pack("<f", value))[0]
    if value == 0:
        return math.ldexp(1.0 if up else -1.0, -149)
    step = 1 if up == (value > 0) else -1
    return float(struct.unpack("<f", struct.pack("<i", pattern + step))[0])


def arithmetic(op: str, left: Real, right: Real, kind: str) -> Real:
    """Return the sum, difference, product or quotient in the precision that the engines use.

    Raises:
        UnsupportedError: The operation is a power.
    """
    if op not in ("+", "-", "*", "/"):
        raise UnsupportedError(f"{op} of REAL is not supported")
    double = kind == "LREAL" or left.double or right.double
    if left.known and right.known and (op != "/" or right.value != 0):
        value = ARITHMETIC[op](left.value, right.value)
        return Real(value if double else c_float(value).value, double)
    power = right.known and right.value == 2.0 and op in "*/"
    if double and power and not (left.double or left.known):
        return Real(left.value, double=True, halved=1 if op == "*" else -1)
    calls = {"+": z3.fpAdd, "-": z3.fpSub, "*": z3.fpMul, "/": z3.fpDiv}
    if double:
        term = calls[op](z3.RNE(), _double(left), _double(right))
        return Real(term, double=True)
    return _narrow(calls[op](z3.RNE(), _single(left), _single(right)))


def negative(number: Real) -> Real:
    """Return -x."""
    if number.known:
        return Real(-number.value, number.double)
    if number.double:
        return Real(z3.fpNeg(_double(number)), double=True)
    return Real(number.value ^ _SIGN)


def absolute(number: Real) -> Real:
    """Return ABS."""
    if number.known:
        return Real(abs(number.value), number.double)
    if number.double:
        return Real(z3.fpAbs(_double(number)), double=True)
    return Real(number.value & _MAGNITUDE)


def from_integer(value: Any, kind: str, *, signed: bool) -> Real:
    """Convert an integer to a REAL or LREAL, rounded to the nearest number."""
    if isinstance(value, int):
        return constant(float(value), kind)
    sort = z3.Float32() if kind == "REAL" else z3.Float64()
    convert = z3.fpSignedToFP if signed else z3.fpUnsignedToFP
    if kind == "REAL" and value.size() > 53:
        # The built-in engine converts the integer to a double first, and then rounds it to REAL.
        return _narrow(z3.fpFPToFP(z3.RNE(), convert(z3.RNE(), value, z3.Float64()), sort))
    term = convert(z3.RNE(), value, sort)
    return _narrow(term) if kind == "REAL" else Real(term, double=True)


def in_range(number: Real, low: int, high: int) -> Bool:
    """Return the condition that the nearest whole number lies within these limits."""
    if number.known:
        return math.isfinite(number.value) and low <= round(number.value) <= high
    rounded = z3.fpRoundToIntegral(z3.RNE(), _double(number))
    return z3.And(z3.fpGEQ(rounded, _float(low)), z3.fpLT(rounded, _float(high + 1)))


def _float(value: int) -> Any:
    return z3.FPVal(float(value), z3.Float64())


def to_integer(number: Real, width: int, *, signed: bool) -> Any:
    """Return the nearest whole number; a half is rounded to the even neighbour.

    A negative number is 0 in an unsigned type.
    """
    if number.known:
        whole = math.isfinite(number.value) and (signed or number.value >= 0)
        value = round(number.value) if whole else 0
        low = -(1 << width - 1) if signed else 0
        return (value - low) % (1 << width) + low
    if signed:
        return z3.fpToSBV(z3.RNE(), _double(number), z3.BitVecSort(width))
    zero = z3.BitVecVal(0, width)
    term = z3.fpToUBV(z3.RNE(), _double(number), z3.BitVecSort(width))
    return z3.If(z3.fpLT(_double(number), _float(0)), zero, term)


def fits(number: Real, width: int, *, signed: bool) -> Bool:
    """Return the condition that the number, truncated towards zero, has at most this many bits."""
    low, high = (-(1 << width - 1), 1 << width - 1) if signed else (0, 1 << width)
    if number.known:
        return math.isfinite(number.value) and low <= math.trunc(number.value) < high
    whole = z3.fpRoundToIntegral(z3.RTZ(), _double(number))
    return z3.And(z3.fpGEQ(whole, _float(low)), z3.fpLT(whole, _float(high)))


def cut(number: Real, width: int, *, signed: bool) -> Any:
    """Return the number truncated towards zero; it must satisfy `fits`."""
    if number.known:
        value = math.trunc(number.value) if math.isfinite(number.value) else 0
        low = -(1 << width - 1) if signed else 0
        return (value - low) % (1 << width) + low
    convert = z3.fpToSBV if signed else z3.fpToUBV
    return convert(z3.RTZ(), _double(number), z3.BitVecSort(width))


def root(number: Real, kind: str) -> Real:
    """Return SQRT.

    Rounding the double result once more gives the single-precision result.
    """
    if kind == "LREAL":
        return Real(z3.fpSqrt(z3.RNE(), _double(number)), double=True)
    return _narrow(z3.fpSqrt(z3.RNE(), _single(number)))


def widened(number: Real) -> Real:
    """Return REAL_TO_LREAL."""
    return Real(number.value if number.known else _double(number), double=True)
