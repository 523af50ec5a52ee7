"""The display of watched variables: members and elements, and values as text.

Values have the form that engines read (`engines.base.Value`). Their types give the members and
elements.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from datetime import date, datetime, time, timedelta
from functools import reduce
from itertools import chain, product
from operator import getitem
from typing import Any, NamedTuple

from structured_text.errors import InputError
from structured_text.language.scalars import DIGITS
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    members,
)
from structured_text.language.values import array_length
from structured_text.output.limits import MOST_LEVELS, MOST_WATCHED

__all__ = [
    "LONGEST",
    "Changed",
    "Part",
    "check_watched",
    "count",
    "described",
    "is_long",
    "literal",
    "members",
    "parts",
    "typed",
    "value_text",
]

#: Largest number of array elements that are shown one by one. A longer array is shown as a single
#: value, because so many rows of a chart are unreadable.
LONGEST = 64

#: Significant decimal digits of each real type.
_PRECISION = {"REAL": 7, "LREAL": 15}
#: Number of elements that are shown of an array that is a single value.
_SHOWN = 8
_MILLISECOND = timedelta(milliseconds=1)


class Part(NamedTuple):
    """A scalar inside a variable; `way` has the indices and names that lead to the scalar."""

    path: str
    type: Type
    way: tuple[str | int, ...]

    def of(self, value: Any) -> Any:
        """Return the value of this part from the value of the whole."""
        return reduce(getitem, self.way, value)


def is_long(kind: Type) -> bool:
    """Return whether a type is an array that is shown as a single value."""
    return isinstance(kind, ArrayType) and array_length(kind) > LONGEST


def count(kind: Type) -> int:
    """Return the number of parts that `parts` would yield."""
    if isinstance(kind, (StructType, BlockType)):
        return sum(count(member) for _, member in members(kind))
    if isinstance(kind, ArrayType) and not is_long(kind):
        return array_length(kind) * count(kind.element)
    return 1


def check_watched(watched: Mapping[str, Type]) -> None:
    """Raise InputError if these variables have too many parts to be shown."""
    found = sum(map(count, watched.values()))
    if found > MOST_WATCHED:
        raise InputError(
            f"{found:,} variables are watched, with all members and elements",
            hint=f"watch fewer; the limit is {MOST_WATCHED:,}",
        )


def parts(path: str, kind: Type, way: tuple[str | int, ...] = ()) -> Iterator[Part]:
    """Yield the scalars in a variable; a long array is yielded as a whole."""
    if isinstance(kind, (StructType, BlockType)):
        for name, member in members(kind):
            yield from parts(f"{path}.{name}", member, (*way, name))
    elif isinstance(kind, ArrayType) and not is_long(kind):
        for place in product(*(range(low, high + 1) for low, high in kind.bounds)):
            steps = (index - low for index, (low, _) in zip(place, kind.bounds, strict=True))
            name = f"{path}[{','.join(map(str, place))}]"
            yield from parts(name, kind.element, (*way, *steps))
    else:
        yield Part(path, kind, way)


class Changed:
    """The values of watched variables, compared from scan to scan.

    Raises:
        InputError: The watched variables have too many parts to be shown.
    """

    def __init__(self, watched: Mapping[str, Type]) -> None:
        check_watched(watched)
        self.parts = {path: list(parts(path, kind)) for path, kind in watched.items()}
        """The scalars in each watched variable."""
        self._before: dict[str, Any] = {}

    def take(self, values: Mapping[str, Any]) -> Iterator[tuple[Part, Any]]:
        """Yield the scalars of the watched variables that have changed, with their values.

        The first call yields all scalars.
        """
        for path, within in self.parts.items():
            value = values[path]
            if path in self._before and value == self._before[path]:
                continue
            self._before[path] = value
            yield from ((part, part.of(value)) for part in within)


def value_text(kind: Type, value: Any) -> str:
    """Return a value in Structured Text: `TRUE`, `16#8020`, `T#1500ms`, `'text'`, a member.

    The text of a long array has only the first elements. The text of a pointer or interface is the
    path of its target.
    """
    if isinstance(kind, ArrayType):
        flat = value
        for _ in kind.bounds[1:]:
            flat = list(chain.from_iterable(flat))
        shown = [value_text(kind.element, item) for item in flat[:_SHOWN]]
        return f"[{', '.join([*shown, '...'] if len(flat) > _SHOWN else shown)}]"
    if isinstance(value, dict):
        parts = (f"{name} := {value_text(one, value[name])}" for name, one in members(kind))
        return f"({', '.join(parts)})"
    if value is None:
        return "NULL"
    if not isinstance(kind, ElementaryType):
        return str(value)
    if kind.name == "BOOL":
        return "TRUE" if value else "FALSE"
    if kind.name in DIGITS:
        return f"16#{value:0{DIGITS[kind.name]}X}"
    if kind.name in _PRECISION:
        return f"{value:.{_PRECISION[kind.name]}g}"
    if isinstance(value, str):
        return f"'{''.join(map(_written, _whole(value)))}'"
    return str(literal(value))


def _written(letter: str) -> str:
    """Return a character as a literal has it: `$0A` for a line feed, `$$` for `$`, `$'` for `'`."""
    if letter in "$'":
        return f"${letter}"
    return letter if letter.isprintable() else f"${ord(letter):02X}"


def _whole(text: str) -> str:
    """Return a text without unpaired surrogates, which a WSTRING of 16-bit characters can have."""
    return text.encode("utf-16", "surrogatepass").decode("utf-16", "replace")


def literal(value: Any) -> Any:
    """Return a value in JSON's types.

    A duration or date becomes a literal; NaN and infinity become a word.
    """
    if isinstance(value, str):
        return value if value.isascii() else _whole(value)
    if isinstance(value, timedelta):
        return f"T#{value / _MILLISECOND:.3f}".rstrip("0").rstrip(".") + "ms"
    if isinstance(value, datetime):
        return f"DT#{value:%Y-%m-%d-%H:%M:%S}{_fraction(value)}"
    if isinstance(value, date):
        return f"D#{value:%Y-%m-%d}"
    if isinstance(value, time):
        return f"TOD#{value:%H:%M:%S}{_fraction(value)}"
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    if isinstance(value, list):
        return [literal(item) for item in value]
    if isinstance(value, dict):
        return {name: literal(item) for name, item in value.items()}
    return value


def _fraction(value: datetime | time) -> str:
    return f".{value.microsecond:06}".rstrip("0") if value.microsecond else ""


def described(kind: Type) -> Any:
    """Return the description of a type for the header of a trace.

    An elementary type becomes its name. An enumeration becomes `{"enum", "members"}` with the
    values of the members. An array becomes `{"array", "of"}` with the bounds of each dimension. A
    structure or block becomes `{"struct", "members"}`.
    """
    if isinstance(kind, EnumType):
        values = {member: kind.value_of(member) for member in kind.members}
        return {"enum": kind.name, "members": values}
    if isinstance(kind, ArrayType):
        return {"array": [list(bounds) for bounds in kind.bounds], "of": described(kind.element)}
    if isinstance(kind, (StructType, BlockType)):
        return {
            "struct": kind.name,
            "members": {name: described(member) for name, member in members(kind)},
        }
    return kind.name


def _whole_number(given: Any) -> int:
    """Return a whole number unchanged, or raise ValueError for any other value."""
    if type(given) is not int:
        raise ValueError("no whole number")
    return given


def typed(description: Any, level: int = 0) -> Type:
    """Return the type that `described` has described; a block becomes a structure.

    Raise KeyError, TypeError or ValueError if the argument is not the description of a type.
    """
    if level > MOST_LEVELS:
        raise ValueError("too many levels")
    if isinstance(description, str):
        return ElementaryType(description)
    if "enum" in description:
        given = description["members"]
        return EnumType(
            description["enum"], tuple(given), tuple(map(_whole_number, given.values()))
        )
    level += 1
    if "array" in description:
        bounds = tuple(
            (_whole_number(low), _whole_number(high)) for low, high in description["array"]
        )
        if any(low > high for low, high in bounds):
            raise ValueError("empty bounds")
        return ArrayType("", bounds, typed(description["of"], level))
    fields = tuple((name, typed(member, level)) for name, member in description["members"].items())
    return StructType(description["struct"], fields)
