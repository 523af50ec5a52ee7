"""The second reading of the command blocks' pins: tests/spec/second_reading/pins.

The head of blocks.toml in that folder gives the grammar. This module uses neither spec/ nor the
generator. It makes words from the tables alone, to compare them with a block's words on the wire.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from rcx_harness.spec.telegram import WORDS
from second_reading import FOLDER, Place, place
from structured_text.engines.base import Value
from structured_text.output.toml_files import load_toml

Given = Mapping[str, Value]
_FORMS = ("number", "bit", "pattern", "bcd", "bool", "text", "real", "rotation")
_SCALE = re.compile(r"x(1|100|1000)")


@dataclass(frozen=True)
class Member:
    """A member of an enumeration; `value` is None if the member chooses a command."""

    name: str
    value: int | None
    words: str


@dataclass(frozen=True)
class PinRow:
    """A row of the table: a pin and its places in the telegram.

    A pin may have a row for each condition.
    """

    pin: str
    default: str
    places: tuple[Place, ...]
    how: str
    flag: Place | None = None
    where: tuple[str, str] | None = None

    def __str__(self) -> str:
        return f"{self.pin} at {' / '.join(dict.fromkeys(map(str, self.places)))}"

    @property
    def members(self) -> tuple[Member, ...]:
        """Return the members of the pin's enumeration, or an empty tuple for other types."""
        return every_enumeration().get(self.how, ())

    @property
    def scale(self) -> int:
        """Return the factor from a REAL pin to its number in the telegram, or 0 without one."""
        found = _SCALE.fullmatch(self.how)
        return int(found[1]) if found else 0

    @property
    def initial(self) -> Value:
        """Return the pin's default in the table, converted from its text to a value."""
        text = self.default
        value: Value = text
        if self.how == "text":
            return text.strip("'")
        if self.how == "bool":
            value = text == "TRUE"
        elif self.scale or self.how == "real":
            value = float(text)
        elif not self.members:
            value = int(text.removeprefix("16#"), 16 if text.startswith("16#") else 10)
        flags = bool(self.members)
        return value if flags or len(self.places) == 1 else [value] * len(self.places)

    def counts(self, given: Given, words: Sequence[int] = ()) -> bool:
        """Return whether the row's condition holds with these pin values and this answer."""
        if self.where is None:
            return True
        name, wanted = self.where
        if name.startswith(("n+", "m+")):
            low, _, high = wanted.partition("..")
            return int(low) <= place(name)[0].read(words) <= int(high or low)
        return str(given[name]).upper() == wanted

    def write(self, words: list[int], value: Value) -> None:
        """Write the pin's value to its places in the telegram."""
        if self.flag:
            self.flag.write(words, int(value != 0))
        if self.members and len(self.places) > 1 and self.places[0].width == 1:
            number = next(one.value for one in self.members if one.name == value)
            if number:
                self.places[number - 1].write(words, 1)
            return
        if self.how == "text":
            values: list[Value] = [*str(value).ljust(len(self.places)).encode("ascii")]
        else:
            values = value if isinstance(value, list) else [value] * len(self.places)
        for part, one in zip(self.places, values, strict=True):
            number = self._coded(one) & ((1 << part.width) - 1)
            part.write(words, number - (1 << part.width) * (number > part.limits[1]))

    def shown(self, words: Sequence[int]) -> Value:
        """Return the value that the output pin has after this answer."""
        numbers = [part.read(words) for part in self.places]
        if self.how == "text":
            return bytes(numbers).decode("ascii").rstrip("\0 ")
        values = [self._meant(number) for number in numbers]
        return values if len(values) > 1 else values[0]

    def _coded(self, value: Value) -> int:
        number: int | None
        if self.members:
            number = next(one.value for one in self.members if one.name == value)
            assert number is not None, f"{self}: {value} is not a number"
            return number
        if self.how == "bit":
            return 1 << value - 1 if value else 0
        if self.how == "bcd":
            return int(str(value), 16)
        if self.how == "real":
            return int(struct.unpack("<i", struct.pack("<f", value))[0])
        number = round(value * (self.scale or 1))
        return number

    def _meant(self, number: int) -> Value:
        if self.members:
            return next(one.name for one in self.members if one.value == number)
        if self.how == "bcd":
            return int(f"{number:x}")
        if self.how == "bool":
            return number != 0
        if self.how == "rotation":
            return {1: 1, 15: -1}.get(number, 0)
        if self.how == "real":
            return float(struct.unpack("<f", struct.pack("<i", number))[0])
        return number / self.scale if self.scale else number


@dataclass(frozen=True)
class Pins:
    """The pins of a block and their places in its telegrams.

    `codes` maps the value of the selector pin to a code. Without a selector its only key is ''.
    """

    name: str
    section: str
    codes: Mapping[str, int]
    robot: bool
    select: tuple[str, str]
    fixed: tuple[Place, ...]
    inputs: tuple[PinRow, ...]
    outputs: tuple[PinRow, ...]
    base: Given
    beside: Mapping[str, Given]
    limit: int
    level: bool

    def __str__(self) -> str:
        return f"{self.name} ({self.section})"

    @property
    def defaults(self) -> dict[str, str]:
        """Return the defaults of all inputs, including the selector, as they are written in ST."""
        chosen = {self.select[0]: self.select[1]} if self.select[0] else {}
        return chosen | {entry.pin: entry.default for entry in self.inputs}

    def given(self, **pins: Value) -> dict[str, Value]:
        """Return a value for every input: from `given`, else from `base`, else the default."""
        chosen: dict[str, Value] = {self.select[0]: self.select[1]} if self.select[0] else {}
        for entry in self.inputs:
            chosen[entry.pin] = self.base.get(entry.pin, entry.initial)
        beside = self.beside.get(str(next(iter(pins.values()), "")), {})
        return chosen | {name: one for name, one in beside.items() if name in chosen} | pins

    @property
    def enumerated(self) -> Iterator[tuple[str, str]]:
        """Return every pin with each of its members or BOOL values; the selector comes first."""
        yield from ((self.select[0], member) for member in self.codes if member)
        for entry in self.inputs:
            names = [one.name for one in entry.members]
            yield from (
                (entry.pin, name) for name in names or ["FALSE", "TRUE"][: 2 * _bool(entry)]
            )

    def code(self, given: Given) -> int:
        """Return word n, the command code, without the robot number."""
        chosen = self.select[0]
        return self.codes[str(given[chosen]) if chosen else ""]

    def telegram(self, given: Given, robot: int = 0) -> list[int]:
        """Return the 16 words, with a value for every input."""
        words = [0] * WORDS
        for part in self.fixed:
            part.write(words, 1)
        for entry in self.inputs:
            if entry.counts(given):
                entry.write(words, given[entry.pin])
        words[0] = self.code(given) | robot << 12
        return words


def hexadecimal(words: Sequence[int]) -> str:
    """Return words as text such as `n=16#1001 n+6=16#0064`, without words of 0."""
    shown = (f"n+{2 * k}=16#{word:04X}" for k, word in enumerate(words) if word)
    return " ".join(shown).replace("n+0", "n", 1) or "all 0"


@cache
def refused_with(pin: str) -> int:
    """Return the ErrorID of a command block for an illegal value of this input."""
    pins = load_toml(FOLDER / "pins/texts.toml")["pins"]
    return next((int(number, 16) for number, names in pins.items() if pin in names), 0x8045)


@cache
def every_enumeration() -> Mapping[str, tuple[Member, ...]]:
    """Return the enumerations: each type's name with its members."""
    tables = load_toml(FOLDER / "pins/members.toml")
    return {name: tuple(map(_member, one["members"])) for name, one in tables.items()}


@cache
def every_block() -> Mapping[str, Pins]:
    """Return the pins of all command blocks by the name of the block."""
    tables = load_toml(FOLDER / "pins/blocks.toml")
    return {name: _block(name, tables, **one) for name, one in tables["block"].items()}


def _block(name: str, tables: Mapping[str, Any], section: str, **entry: Any) -> Pins:
    codes = entry.get("codes") or {"": entry["code"]}
    pin, _, default = entry.get("select", "").partition(" = ")
    return Pins(
        name=name,
        section=section,
        codes={member: int(text.removeprefix("R"), 16) for member, text in codes.items()},
        robot=all(text.startswith("R") for text in codes.values()),
        select=(pin, default),
        fixed=tuple(part for text in entry.get("fixed", ()) for part in place(text)),
        inputs=tuple(map(_input, _rows(tables, "inputs", entry.get("inputs", ())))),
        outputs=tuple(map(_output, _rows(tables, "outputs", entry.get("outputs", ())))),
        base={**tables["base"], **entry.get("base", {})},
        beside=tables["beside"],
        limit=entry.get("limit", 5),
        level=entry.get("level", False),
    )


def _rows(tables: Mapping[str, Any], side: str, rows: Sequence[str]) -> Iterator[str]:
    for text in rows:
        if text.startswith("+"):
            yield from _rows(tables, side, tables["group"][text[1:]][side])
        else:
            yield text


def _input(text: str) -> PinRow:
    name, separator, rest = text.partition(" = ")
    default, *parts = rest.split(" | ")
    if not separator:
        raise ValueError(f"not the text of an input: {text!r}")
    return _row(text, name, default, parts)


def _output(text: str) -> PinRow:
    name, *parts = text.split(" | ")
    return _row(text, name, "", parts)


def _row(text: str, name: str, default: str, parts: Sequence[str]) -> PinRow:
    where, how, *extra = parts
    known = how in _FORMS or how in every_enumeration() or _SCALE.fullmatch(how)
    if not known or len(extra) > 1:
        raise ValueError(f"not the text of a row: {text!r}")
    places = tuple(part for one in where.split(" / ") for part in place(one))
    kind, _, condition = extra[0].partition(" ") if extra else ("", "", "")
    left, _, right = condition.partition(" = ")
    return PinRow(
        name,
        default,
        places,
        how,
        flag=place(condition)[0] if kind == "flag" else None,
        where=(left, right) if kind == "where" else None,
    )


def _member(text: str) -> Member:
    name, value, words = re.split(" = | \\| ", text, maxsplit=2)
    return Member(name, None if value == "-" else int(value), words)


def _bool(entry: PinRow) -> bool:
    return entry.how == "bool"
