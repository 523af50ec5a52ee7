"""Implicit conversions between elementary types, and their common types.

`standard` marks the conversions of edition 3 of IEC 61131-3 (its figure of implicit conversions).
`vendor` marks those that CODESYS and similar tools accept in addition, where only one meaning is
possible: bit patterns and numbers of the same width, a change of sign, integers and LREAL where a
REAL is expected.
"""

from __future__ import annotations

from ctypes import c_float

from structured_text.language.scalars import (
    ANY_BIT,
    ANY_INT,
    ANY_REAL,
    ANY_STRING,
    INT_RANGE,
    LONGEST_STRING,
    MOMENTS,
    SIGNED,
    STRING_MAX,
    UNSIGNED,
    WIDTH,
    Scalar,
    string_kind,
    string_length,
)
from structured_text.language.types import ElementaryType, EnumType, Type, integer_name

__all__ = [
    "BITS_OF",
    "common",
    "converted",
    "fitting_integer",
    "joined",
    "number_of",
    "same_number",
    "widening",
    "widens",
]

STANDARD, VENDOR = "standard", "vendor"

_BITS = dict(zip((8, 16, 32, 64), ("BYTE", "WORD", "DWORD", "LWORD"), strict=True))
_UNSIGNED = {WIDTH[name]: name for name in UNSIGNED}
_NEXT_SIGNED = {"USINT": "INT", "UINT": "DINT", "UDINT": "LINT"}

#: The bit string with the width of each integer type.
BITS_OF = {name: _BITS[WIDTH[name]] for name in ANY_INT}


def number_of(name: str) -> str:
    """Return the unsigned integer of a bit string's width; every other type is returned as is."""
    return _UNSIGNED[WIDTH[name]] if name in ANY_BIT and name != "BOOL" else name


def widens(have: Type, want: Type) -> bool:
    """Return whether a value converts implicitly to another elementary type."""
    both = isinstance(have, ElementaryType) and isinstance(want, ElementaryType)
    return both and bool(widening(have.name, want.name))


def same_number(one: Type, other: Type) -> bool:
    """Return whether two types have the same base type, and at least one is an enumeration."""
    either = isinstance(one, EnumType) or isinstance(other, EnumType)
    return either and one != other and integer_name(one) == integer_name(other)


def widening(source: str, target: str) -> str:
    """Return the kind of implicit conversion: `standard`, `vendor`, or empty if there is none."""
    if source == target:
        return ""
    if source in MOMENTS:
        return STANDARD if target == f"L{source}" else ""
    if source in ("CHAR", "WCHAR"):
        return STANDARD if target == ("STRING" if source == "CHAR" else "WSTRING") else ""
    if source in ANY_BIT and target in ANY_BIT:
        return STANDARD if source == "BOOL" or WIDTH[source] < WIDTH.get(target, 0) else ""
    if source == "LREAL":
        return VENDOR if target == "REAL" else ""
    if source == "REAL":
        return STANDARD if target == "LREAL" else ""
    if source not in WIDTH:
        return ""
    if target in ANY_REAL:
        exact = source in ANY_INT and WIDTH[source] < (32 if target == "REAL" else 64)
        return STANDARD if exact else VENDOR
    if target not in WIDTH or WIDTH[source] > WIDTH[target]:
        return ""
    if source in ANY_BIT or target in ANY_BIT or (source in SIGNED and target in UNSIGNED):
        return VENDOR
    return STANDARD if WIDTH[source] < WIDTH[target] else VENDOR


def common(one: str, other: str) -> str:
    """Return the type in which values of two types are calculated and compared, or an empty text.

    If one type widens to the other, the result is the wider type. For a signed and an unsigned
    integer it is the signed type that holds both. A bit string counts as the unsigned integer of
    its width. A REAL and an integer give REAL.
    """
    if one == other:
        return one
    if one in ANY_BIT and other in ANY_BIT:
        return other if widening(one, other) else one
    one, other = number_of(one), number_of(other)
    if one == other:
        return one
    numbers = (*ANY_INT, *ANY_REAL)
    if one not in numbers or other not in numbers:
        return other if widening(one, other) else one if widening(other, one) else ""
    if one in ANY_REAL or other in ANY_REAL:
        return "LREAL" if "LREAL" in (one, other) else "REAL"
    if (one in SIGNED) == (other in SIGNED):
        return one if WIDTH[one] > WIDTH[other] else other
    signed, unsigned = (one, other) if one in SIGNED else (other, one)
    if WIDTH[signed] > WIDTH[unsigned]:
        return signed
    return _NEXT_SIGNED.get(unsigned, "")


def fitting_integer(value: int) -> str:
    """Return the smallest signed type that holds the value, else ULINT; empty if none does."""
    for name in (*SIGNED, "ULINT"):
        low, high = INT_RANGE[name]
        if low <= value <= high:
            return name
    return ""


#: Length of the result of functions that join texts, if an argument is longer than a plain STRING.
_JOINED = 255


def joined(kinds: list[ElementaryType], *, longer: bool) -> ElementaryType:
    """Return the text type that holds each of these types; with `longer`, also two texts joined."""
    length = max(string_length(kind) for kind in kinds)
    if longer and length > STRING_MAX:
        length = min(max(length, _JOINED), LONGEST_STRING)
    name = next((kind.name for kind in kinds if kind.name in ANY_STRING), "STRING")
    return string_kind(name, length)


def converted(value: Scalar, source: str, target: ElementaryType) -> Scalar:
    """Return the value of a constant after conversion to a wider type."""
    if isinstance(value, str):
        return value[: string_length(target)]
    if target.name in ANY_REAL:
        number = c_float(float(value)).value if source == "REAL" else float(value)
        return c_float(number).value if target.name == "REAL" else number
    if target.name in INT_RANGE:
        low, _ = INT_RANGE[target.name]
        return (int(value) - low) % (1 << WIDTH[target.name]) + low
    return value
