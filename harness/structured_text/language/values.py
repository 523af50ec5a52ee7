"""Conversion of Python values to values of variables and back, the same for every engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from ctypes import c_float
from datetime import date, datetime, time, timedelta
from typing import Any

from structured_text.errors import InputError
from structured_text.language.scalars import (
    ANY_CHARS,
    ANY_REAL,
    ANY_STRING,
    INT_RANGE,
    NANOSECONDS_PER_DAY,
    LiteralError,
    Scalar,
    string_length,
    typed_literal,
    within_real,
)
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    members,
)

__all__ = [
    "array_length",
    "describe",
    "from_python",
    "indices_at",
    "nest",
    "scalar_to_python",
]

_EPOCH = datetime(1970, 1, 1)
_TIME_LIMIT = timedelta(microseconds=(1 << 63) // 1000)


def describe(kind: Type) -> str:
    """Return the name of a type as messages show it."""
    if isinstance(kind, ArrayType) and kind.open:
        return f"ARRAY [{', '.join('*' for _ in kind.bounds)}] OF {describe(kind.element)}"
    if isinstance(kind, ArrayType) and not kind.name:
        bounds = ", ".join(f"{low}..{high}" for low, high in kind.bounds)
        return f"ARRAY [{bounds}] OF {describe(kind.element)}"
    if isinstance(kind, ElementaryType) and kind.length is not None:
        return f"{kind.name}[{kind.length}]"
    return kind.name


def array_length(kind: ArrayType) -> int:
    """Return the number of elements over all dimensions."""
    return math.prod(high - low + 1 for low, high in kind.bounds)


def indices_at(kind: ArrayType, position: int) -> tuple[int, ...]:
    """Return the indices of the element at a row-major position, counted from 0."""
    indices = []
    for low, high in reversed(kind.bounds):
        position, offset = divmod(position, high - low + 1)
        indices.append(low + offset)
    return tuple(reversed(indices))


def scalar_to_python(kind: Type, value: Scalar) -> Any:
    """Return the Python value of a scalar, as `Program.read` does (see `Scalar`)."""
    if isinstance(kind, EnumType):
        member = kind.member_of(int(value))
        return int(value) if member is None else member
    if not isinstance(kind, ElementaryType):
        raise TypeError(f"{kind.name} is not a scalar")
    if kind.name == "BOOL":
        return bool(value)
    name = _short(kind)
    if name == "TIME":
        return timedelta(microseconds=_microseconds(value))
    if name == "DATE":
        return (_EPOCH + timedelta(microseconds=_microseconds(value))).date()
    if name == "TOD":
        day = int(value) % NANOSECONDS_PER_DAY
        return (_EPOCH + timedelta(microseconds=_microseconds(day))).time()
    if name == "DT":
        return _EPOCH + timedelta(microseconds=_microseconds(value))
    return value


def _short(kind: ElementaryType) -> str:
    """Return the short form of a long type, such as TIME for LTIME; empty for other types."""
    name = kind.name.removeprefix("L")
    return name if name in _MOMENTS else ""


def _microseconds(nanoseconds: Scalar) -> int:
    """Return whole microseconds, rounded towards zero."""
    value = int(nanoseconds)
    return value // 1000 if value >= 0 else -(-value // 1000)


def nest(kind: ArrayType, flat: Sequence[Any]) -> list[Any]:
    """Return elements in row-major order as nested lists, one level per dimension."""
    items = list(flat)
    for low, high in reversed(kind.bounds[1:]):
        size = high - low + 1
        items = [items[start : start + size] for start in range(0, len(items), size)]
    return items


def from_python(kind: Type, value: Any, path: str) -> Any:
    """Check an external value and convert it to the form that engines hold.

    A dict for a structure may leave fields out.

    Returns:
        A `Scalar`; for an array the flat list of its elements in row-major order; for a
        structure or block a dict of the given fields by declared name.

    Raises:
        InputError: The value does not fit the type. Values are never wrapped or cut.
    """
    if isinstance(kind, EnumType):
        return _enumeration(kind, value, path)
    if isinstance(kind, ElementaryType):
        return _elementary(kind, value, path)
    if isinstance(kind, (ReferenceType, InterfaceType)):
        hint = "set it in the program"
        raise InputError(f"{path} is a {describe(kind)} and cannot be set", hint=hint)
    if isinstance(kind, ArrayType):
        return _array(kind, kind.bounds, value, path)
    return _fields(kind, value, path)


def _mismatch(path: str, kind: Type, value: Any, hint: str = "") -> InputError:
    return InputError(f"{path} is of type {describe(kind)} and cannot be {value!r}", hint=hint)


def _enumeration(kind: EnumType, value: Any, path: str) -> int:
    names = [member.upper() for member in kind.members]
    if isinstance(value, str):
        prefix, _, member = value.upper().replace(".", "#").rpartition("#")
        if member in names and prefix in ("", kind.name.upper()):
            return kind.value_of(member)
    raise _mismatch(path, kind, value, f"use one of {', '.join(kind.members)}")


def _elementary(kind: ElementaryType, value: Any, path: str) -> Scalar:
    name = kind.name
    if name == "BOOL":
        if isinstance(value, bool):
            return value
        raise _mismatch(path, kind, value, "use true or false")
    if name in INT_RANGE:
        low, high = INT_RANGE[name]
        if isinstance(value, int) and not isinstance(value, bool) and low <= value <= high:
            return value
        raise _mismatch(path, kind, value, f"use a whole number from {low} to {high}")
    if name in ANY_REAL:
        if isinstance(value, (int, float)) and not isinstance(value, bool):
            if name == "LREAL":
                return float(value)
            if not math.isfinite(value) or within_real(value) is not None:
                return c_float(value).value
        raise _mismatch(path, kind, value, "use a number")
    if name in ANY_CHARS:
        return _characters(kind, value, path)
    return _moment(kind, value, path)


def _characters(kind: ElementaryType, value: Any, path: str) -> str:
    most, texts = string_length(kind), kind.name in ANY_STRING
    largest, held = (0xFFFF, "16-bit") if kind.name.startswith("W") else (0xFF, "single-byte")
    fits = isinstance(value, str) and len(value) <= most and (texts or len(value) == 1)
    if fits and all(ord(character) <= largest for character in value):
        return str(value)
    number = f"up to {most} {held} characters" if texts else f"one {held} character"
    raise _mismatch(path, kind, value, f"use {number}")


def _moment(kind: ElementaryType, value: Any, path: str) -> int:
    """Return a duration or date [ns] from a Python value or a Structured Text literal."""
    name = _short(kind)
    if isinstance(value, str):
        try:
            literal_type, number = typed_literal(value)
        except (KeyError, LiteralError):
            raise _mismatch(path, kind, value) from None
        if literal_type.name in (kind.name, name):
            return int(number)
    elif name == "TIME" and isinstance(value, timedelta) and abs(value) < _TIME_LIMIT:
        return value // timedelta(microseconds=1) * 1000
    elif name == "DT" and isinstance(value, datetime) and value.tzinfo is None:
        return (value - _EPOCH) // timedelta(microseconds=1) * 1000
    elif name == "DATE" and isinstance(value, date) and not isinstance(value, datetime):
        return (value - _EPOCH.date()).days * NANOSECONDS_PER_DAY
    elif name == "TOD" and isinstance(value, time) and value.tzinfo is None:
        return (datetime.combine(_EPOCH, value) - _EPOCH) // timedelta(microseconds=1) * 1000
    raise _mismatch(path, kind, value, _MOMENTS[name])


_MOMENTS = {
    "TIME": "use a timedelta or a literal such as T#1500ms",
    "DATE": "use a datetime.date or a literal such as D#2024-12-31",
    "TOD": "use a datetime.time or a literal such as TOD#13:30:00",
    "DT": "use a datetime without time zone or a literal such as DT#2024-12-31-13:30:00",
}


def _array(
    kind: ArrayType, bounds: tuple[tuple[int, int], ...], value: Any, path: str
) -> list[Any]:
    if not bounds:
        return [from_python(kind.element, value, path)]
    low, high = bounds[0]
    if not isinstance(value, (list, tuple)) or len(value) != high - low + 1:
        size = len(value) if isinstance(value, (list, tuple)) else repr(value)
        raise InputError(
            f"{path} is of type {describe(kind)} and cannot take {size} elements",
            hint=f"give a list of {high - low + 1}",
        )
    return [
        element
        for offset, item in enumerate(value)
        for element in _array(kind, bounds[1:], item, f"{path}[{low + offset}]")
    ]


def _fields(kind: StructType | BlockType, value: Any, path: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise _mismatch(path, kind, value, "give a dict of its fields")
    fields = members(kind)
    known = {name.upper(): (name, field_type) for name, field_type in fields}
    result = {}
    for key, item in value.items():
        if str(key).upper() not in known:
            raise InputError(
                f"{path} of type {describe(kind)} has no field {key}",
                hint=f"use {', '.join(name for name, _ in fields)}",
            )
        name, field_type = known[str(key).upper()]
        result[name] = from_python(field_type, item, f"{path}.{name}")
    return result
