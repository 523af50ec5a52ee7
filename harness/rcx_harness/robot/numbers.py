"""Numbers as the controller keeps them: 32 bit integers and single-precision real numbers."""

from __future__ import annotations

import math
import struct
from fractions import Fraction

__all__ = ["fits_integer", "from_bits", "nearest", "single", "to_bits", "toward_zero"]


def fits_integer(value: int) -> bool:
    """It is a signed number of 32 bits."""
    return -(2**31) <= value < 2**31


def nearest(value: Fraction) -> int:
    """The nearest integer; a half goes away from 0."""
    size = math.floor(abs(value) + Fraction(1, 2))
    return size if value >= 0 else -size


def toward_zero(value: Fraction) -> int:
    """The integer without what is behind the point."""
    return math.trunc(value)


def single(value: float) -> float:
    """The nearest single-precision number; infinite where it is too large."""
    try:
        return from_bits(to_bits(value))
    except OverflowError:
        return math.copysign(math.inf, value)


def from_bits(bits: int) -> float:
    """The single-precision number with these 32 bits (signed or not)."""
    value: float = struct.unpack("<f", struct.pack("<I", bits & 0xFFFFFFFF))[0]
    return value


def to_bits(value: float) -> int:
    """The bits of a single-precision number as a signed integer.

    Raises:
        OverflowError: it is too large for single precision.
    """
    bits: int = struct.unpack("<i", struct.pack("<f", value))[0]
    return bits
