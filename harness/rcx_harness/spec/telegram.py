"""The telegram of a remote command: fields, words, and checks of their values.

A telegram has 16 words: word k is at byte 2k of the area, and word 0 is the code or status.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from typing import Any, cast

from structured_text.errors import InputError, did_you_mean
from structured_text.output.units import format_word

__all__ = ["WORDS", "Command", "Field", "FieldValue", "Product", "intervals"]

#: A number, a tuple of numbers (at most the field's count), or a text.
FieldValue = int | float | str | tuple[int, ...] | tuple[float, ...]

WORDS = 16
_FORMATS = {"u16": "<H", "s16": "<h", "u32": "<I", "s32": "<i", "f32": "<f"}
#: The largest finite number of 32 bits (IEEE 754).
_REAL = (2 - 2**-23) * 2.0**127
_LIMITS: dict[str, tuple[float, float]] = {
    "u16": (0, 0xFFFF),
    "s16": (-0x8000, 0x7FFF),
    "u32": (0, 0xFFFFFFFF),
    "s32": (-0x80000000, 0x7FFFFFFF),
    "f32": (-_REAL, _REAL),
}


@dataclass(frozen=True)
class Field:
    """One field of a telegram; see the head of remote_commands.toml for its keys."""

    name: str
    at: int
    type: str = "bits"
    bits: tuple[int, int] = (0, 15)
    count: int = 1
    length: int = 0
    range: tuple[int, ...] | None = None
    values: Mapping[int, str] = field(default_factory=dict)
    by: str = ""
    ranges: Mapping[int, tuple[int, ...]] = field(default_factory=dict)
    one_bit: bool = False
    unit: str = ""
    meaning: str = ""

    @property
    def fixed(self) -> int | None:
        """Return the only possible value of the field; None if several values are possible."""
        return next(iter(self.values)) if len(self.values) == 1 else None

    @property
    def mask(self) -> int:
        """Return a mask of the bits that the field covers in its first word."""
        if self.type != "bits":
            return 0xFFFF
        low, high = self.bits
        return ((1 << (high - low + 1)) - 1) << low

    @property
    def words(self) -> Sequence[int]:
        """Return the indices of the words of the telegram that the field covers."""
        if self.type == "bits":
            size = 2
        elif self.type == "text":
            size = self.length + self.length % 2
        else:
            size = struct.calcsize(_FORMATS[self.type]) * self.count
        return range(self.at // 2, (self.at + size) // 2)

    def units_by(self, names: Collection[str]) -> tuple[str, dict[int, str]]:
        """Return the field that selects the unit, and the unit for each of its values."""
        units = re.split(r", | or ", self.unit)
        if len(units) > 1 and self.by:
            return self.by, dict(zip(self.ranges, units, strict=True))
        by = next((one for one in ("unit", "arch_unit") if one in names), "")
        return (by, dict(enumerate(units))) if len(units) > 1 and by else ("", {})

    def unit_among(self, values: Mapping[str, FieldValue]) -> str:
        """Return the field's unit in a telegram with these `values`; empty if it is undecided."""
        by, units = self.units_by(values)
        return units.get(cast(int, values[by]), "") if by else self.unit

    def read(self, words: Sequence[int]) -> FieldValue:
        """Return the field's value in a telegram; numbers are not scaled to units."""
        if self.type == "bits":
            return (words[self.at // 2] & self.mask) >> self.bits[0]
        raw = b"".join(words[k].to_bytes(2, "little") for k in self.words)
        if self.type == "text":
            text = raw[: self.length].decode("latin-1")
            # texts are padded with spaces or with NUL characters
            return text.rstrip("\0" if text.endswith("\0") else " ")
        every = tuple(part[0] for part in struct.iter_unpack(_FORMATS[self.type], raw))
        return every if self.count > 1 else every[0]

    def write(self, words: list[int], value: FieldValue) -> None:
        """Write `value` into a telegram."""
        wrong = self.kind_problem(value) or self._limit_problem(value)
        if wrong:
            raise InputError(wrong)
        if self.type == "bits":
            shifted = cast(int, value) << self.bits[0]
            words[self.at // 2] = words[self.at // 2] & ~self.mask | shifted
            return
        if self.type == "text":
            raw = str(value).encode("ascii").ljust(2 * len(self.words))
        else:
            parts = _parts(value)
            parts += (0,) * (self.count - len(parts))
            raw = b"".join(struct.pack(_FORMATS[self.type], part) for part in parts)
        for k in self.words:
            start = 2 * (k - self.at // 2)
            words[k] = int.from_bytes(raw[start : start + 2], "little")

    def kind_problem(self, value: FieldValue) -> str:
        """Return the error of a value with the wrong type or length; empty if there is none."""
        if self.type == "text":
            if len(str(value)) > self.length:
                return f"{self.name} has no room for {value!r}; it takes {self.length} characters"
            return ""
        parts = _parts(value)
        count = 1 if self.type == "bits" else self.count
        if len(parts) > count:
            return f"{self.name} has no room for {value!r}; it takes {count} number(s)"
        real = self.type == "f32"
        for part in parts:
            if not isinstance(part, (int, float) if real else int):
                return f"{self.name} is {part!r}, not a {'' if real else 'whole '}number"
        return ""

    def _limit_problem(self, value: FieldValue) -> str:
        """Return the error of a value that the wire cannot represent; empty if there is none."""
        if self.type == "text":
            foreign = [c for c in str(value) if not c.isascii()]
            return f"{self.name} has the character {foreign[0]!r}, not ASCII" if foreign else ""
        low, high = (0, self.mask >> self.bits[0]) if self.type == "bits" else _LIMITS[self.type]
        for part in cast("tuple[float, ...]", _parts(value)):
            if isinstance(part, float) and not math.isfinite(part):
                continue  # the wire can carry infinities and NaN
            if not low <= part <= high:
                return f"{self.name} is {part}, not {_shown(self.range or (low, high))}"
        return ""

    def problem(self, values: Mapping[str, FieldValue]) -> str:
        """Return the error of the field in a telegram with these `values`, or an empty text."""
        value = values[self.name]
        each = value if isinstance(value, tuple) else (value,)
        if self.values and any(part not in self.values for part in each):
            return f"{self.name} is {value}, which has no meaning"
        allowed = self.range
        if self.by:
            selector = values[self.by]
            allowed = self.ranges.get(selector) if isinstance(selector, int) else None
            if allowed is None:
                return ""
        if isinstance(value, str):
            legal = intervals(allowed or (0x20, 0x7E))
            wrong = [c for c in value if not any(low <= ord(c) <= high for low, high in legal)]
            shown = ", ".join(f"16#{low:02X} to 16#{high:02X}" for low, high in legal)
            if "\0" in value:
                return f"{self.name} has 16#00 before its end; fill it up with one character only"
            return f"{self.name} has the character {wrong[0]!r}, not {shown}" if wrong else ""
        if allowed is None:
            return ""
        for part in value if isinstance(value, tuple) else (value,):
            if not any(low <= part <= high for low, high in intervals(allowed)):
                return f"{self.name} is {part}, not {_shown(allowed)}"
        if self.one_bit and value and isinstance(value, int) and value & (value - 1):
            return f"{self.name} is {value:#b}, not exactly one bit"
        return ""


@dataclass(frozen=True)
class Product:
    """The limits for the product of the values of several fields."""

    fields: tuple[str, ...]
    range: tuple[int, int]


@dataclass(frozen=True)
class Command:
    """One remote command: its code, and the fields of its telegrams."""

    code: int
    name: str
    title: str
    category: int
    section: str
    robot: bool
    pendant: bool
    request: tuple[Field, ...] = ()
    response: tuple[Field, ...] = ()
    exclusive: tuple[tuple[str, str], ...] = ()
    product: Product | None = None
    robot_zero: str = "robot 1"

    @property
    def shown(self) -> str:
        """Return the code as the manual writes it, `0xR001` or `0x0100`."""
        return f"0xR{self.code:03X}" if self.robot else f"0x{self.code:04X}"

    @property
    def iec(self) -> str:
        """Return the code for messages, `16#R001` (R is the robot's number) or `16#0100`."""
        return f"16#{self.shown[2:]}"

    def decode(self, words: Sequence[int]) -> dict[str, FieldValue]:
        """Return the request's fields by name, without any check."""
        return {part.name: part.read(words) for part in self.request}

    def encode(self, values: Mapping[str, FieldValue], robot: int = 0) -> tuple[int, ...]:
        """Return the 16 words of a request; fields without a value are 0."""
        if robot and not (self.robot and 0 < robot <= 4):
            raise InputError(f"{self.iec} {self.name} cannot designate robot {robot}")
        preset = {part.name: part.fixed for part in self.request if part.fixed is not None}
        given = {**preset, **values}
        problem = self._given_problem(given)
        if problem:
            raise InputError(f"{self.iec} {self.name}: {problem}")
        words = self._fill(self.request, given)
        problem = self.problem(words)
        if problem:
            raise InputError(f"{self.iec} {self.name}: {problem}")
        words[0] = self.code | robot << 12
        return tuple(words)

    def respond(self, values: Mapping[str, FieldValue]) -> tuple[int, ...]:
        """Return the 15 response words of a normal end; fields without a value are 0."""
        return tuple(self._fill(self.response, values)[1:])

    def read_response(self, words: Sequence[int]) -> dict[str, FieldValue]:
        """Return the response's fields by name, from the 16 words that the controller sends."""
        return {part.name: part.read(words) for part in self.response}

    def problem(self, words: Sequence[int], *, unused_words: bool = True) -> str:
        """Return the error in a request's data words; empty if there is none.

        Word 0 is ignored. With `unused_words`, words without any field must be 0 as well.
        """
        covered = [0] * WORDS
        for part in self.request:
            for k in part.words:
                covered[k] |= part.mask
        for k in range(1, WORDS):
            stray = words[k] & ~covered[k]
            if stray and (covered[k] or unused_words):
                kind = "fixed 0" if covered[k] else "not used"
                return f"n+{2 * k} has bits {format_word(stray)} set, which are {kind}"
        values = self.decode(words)
        for part in self.request:
            problem = part.problem(values)
            if problem:
                return problem
        for first, second in self.exclusive:
            if values[first] and values[second]:
                return f"{first} and {second} cannot both be 1"
        if self.product:
            result = math.prod(cast(int, values[name]) for name in self.product.fields)
            low, high = self.product.range
            if not low <= result <= high:
                return f"{' * '.join(self.product.fields)} is {result}, not {low} to {high}"
        return ""

    def _fill(self, fields: Sequence[Field], values: Mapping[str, FieldValue]) -> list[int]:
        by_name = {part.name: part for part in fields}
        words = [0] * WORDS
        for name, value in values.items():
            if name not in by_name:
                meant = did_you_mean(get_close_matches(name, by_name))
                hint = meant or f"its fields are: {', '.join(by_name) or 'none'}"
                raise InputError(f"{self.iec} {self.name} has no field {name!r}", hint=hint)
            try:
                by_name[name].write(words, value)
            except InputError as error:
                raise InputError(f"{self.iec} {self.name}: {error}") from None
        return words

    def _given_problem(self, given: Mapping[str, FieldValue]) -> str:
        """Return the error in the values for a request, before they are packed into words."""
        parts = [part for part in self.request if part.name in given]
        for part in parts:
            problem = part.kind_problem(given[part.name])
            if problem:
                return problem
        values: dict[str, FieldValue] = dict.fromkeys((part.name for part in self.request), 0)
        for part in parts:
            value = given[part.name]
            values[part.name] = tuple(value) if isinstance(value, list) else value
            if part.type == "text":
                values[part.name] = str(value).rstrip(" ")  # trailing spaces are padding
        return next(filter(None, (part.problem(values) for part in parts)), "")


def _parts(value: FieldValue) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, (tuple, list)) else (value,)


def _shown(limits: Sequence[float]) -> str:
    pairs = zip(limits[::2], limits[1::2], strict=True)
    return " or ".join(f"{low} to {high}" for low, high in pairs)


def intervals(limits: Sequence[int]) -> list[tuple[int, int]]:
    """Return the (lowest, highest) pairs of a range that may have gaps: `(0, 31, 256, 287)`."""
    return list(zip(limits[::2], limits[1::2], strict=True))
