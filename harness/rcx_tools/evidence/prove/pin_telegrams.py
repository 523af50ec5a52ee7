"""The telegram that belongs to the pins of a command block, as terms over the pins.

The mapping from pins to words does not come from the tables of the library. It comes from
tests/spec/second_reading/pins, a second and independent interpretation of the guide.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Protocol

import z3

from rcx_tools.evidence.prove.legality import CODE_BITS
from rcx_tools.evidence.results import ROOT
from structured_text.prove import reals
from structured_text.prove.logic import UnsupportedError
from structured_text.prove.machine import Machine
from structured_text.prove.reals import Real
from structured_text.prove.texts import Text

if TYPE_CHECKING:
    from pin_reading import PinRow, Pins
    from second_reading import Place

__all__ = [
    "ROUNDED",
    "WORDS",
    "Expected",
    "bounds",
    "char_code",
    "nearest",
    "pattern_of",
    "reading_of",
    "times",
]

#: Words n+2 to n+30.
WORDS = range(15)
_SPACE = 0x20
#: Conditions in which tests/spec/second_reading/pins has one number, with the range of values that
#: the number means (guide 4.4.1).
_SPANS = {("Variable1", "0"): (0, 31), ("Variable1", "256"): (256, 287)}
#: Rows of factor, lowest and highest REAL, and greatest result. If the lowest REAL is None, the
#: limits apply to both signs.
ROUNDED = (
    (1000, None, 8191.999, 8_191_999),
    (100, 0.009, 100.0, 10_000),
    (1, 1.0, 100.0, 100),
    (1, 1.0, 1000.0, 1000),
)


class _Call(Protocol):
    """The protocol of a block call: its methods give the values of pins."""

    def pin(self, name: str, place: int = 0) -> Any:
        """Return the value of a pin, or of an element of the pin: a term, or a text."""

    def member(self, name: str, member: str) -> Any:
        """Return the claim that a pin equals a given member of its enumeration."""


def reading_of(block: str) -> Pins:
    """Return the meaning of a block's pins in the second interpretation.

    `block` is in upper case.
    """
    folder = str(ROOT / "tests/support")
    if folder not in sys.path:
        sys.path.append(folder)
    from pin_reading import every_block

    return {name.upper(): pins for name, pins in every_block().items()}[block]


# --- REAL ---


def times(pattern: Any, factor: int) -> Real:
    """Return the product of a REAL and a factor, as the engines compute it."""
    number = Real(pattern)
    if factor == 1:
        return number
    return reals.arithmetic("*", number, reals.constant(float(factor), "REAL", wide=True), "REAL")


def nearest(pattern: Any, factor: int) -> Any:
    """Return the whole number nearest to the REAL product. Halves are rounded to even numbers."""
    return reals.to_integer(reals.settled(times(pattern, factor), "REAL"), 32, signed=True)


def pattern_of(number: float) -> int:
    """Return the 32 bits of the nearest REAL."""
    return int(struct.unpack("<I", struct.pack("<f", number))[0])


def bounds(pattern: Any, number: Any, factor: int) -> Iterator[tuple[str, Any, Any]]:
    """Yield limits of a REAL, and the limits of the number that result from them.

    Each row is (name, premise, conclusion).
    """
    for scale, low, high, most in ROUNDED:
        if scale != factor:
            continue
        if low is None:
            inside = z3.ULE(pattern & 0x7FFF_FFFF, pattern_of(high))
            found = z3.And(number >= -most, number <= most)
        else:
            inside = z3.And(z3.UGE(pattern, pattern_of(low)), z3.ULE(pattern, pattern_of(high)))
            found = z3.And(number >= 1, number <= most)
        yield f"{low or -high} to {high}, times {scale}, rounded", inside, found


def _bits(pattern: Any) -> Any:
    """Return the bit pattern of a REAL that is sent. -0.0 is sent as 0.0."""
    return z3.If(pattern == 0x8000_0000, z3.BitVecVal(0, 32), pattern)


# --- texts ---


def _character(text: Text, place: int) -> Any:
    """Return the character at a position from 0 on, or a space after the end of the text."""
    within = z3.UGT(text.size, place)
    return z3.If(within, text.char(place), z3.BitVecVal(_SPACE, 8))


def char_code(machine: Machine, arguments: list[Any]) -> Any:
    """Return FC_RcxCharCode for one of the first sixteen characters.

    It is 0 for an illegal character.
    """
    text, position = arguments
    if not 1 <= position <= 16:
        raise UnsupportedError(f"FC_RcxCharCode at place {position}")
    code = _character(text, position - 1)
    carried = z3.And(z3.UGE(code, 0x20), z3.ULE(code, 0x7E))
    return z3.ZeroExt(8, z3.If(carried, code, z3.BitVecVal(0, 8)))


@dataclass(frozen=True)
class Expected:
    """The telegram that the pins of a call describe according to the second interpretation."""

    call: _Call
    reading: Pins

    def code(self) -> Any:
        """Return word n of the expected telegram: code and robot number."""
        code = z3.BitVecVal(0, 16)
        chosen = self.reading.select[0]
        for member, number in self.reading.codes.items():
            here = self.call.member(chosen, member) if chosen else z3.BoolVal(True)
            code = z3.If(here, z3.BitVecVal(number, 16), code)
        if self.reading.robot:
            code |= self.call.pin("RobotNumber") << CODE_BITS
        return code

    def data(self) -> list[Any]:
        """Return the words n+2 to n+30 of the expected telegram."""
        words: list[Any] = [z3.BitVecVal(0, 16) for _ in WORDS]
        for part in self.reading.fixed:
            _write(words, part, z3.BitVecVal(1, part.width), z3.BoolVal(True))
        for row in self.reading.inputs:
            counts = self.counts(row)
            for number, part in enumerate(row.places):
                _write(words, part, self._value(row, number), counts)
            if row.flag:
                _write(words, row.flag, z3.BitVecVal(1, 1), z3.And(counts, self._pin(row) != 0))
        return words

    def counts(self, row: PinRow) -> Any:
        """Return the condition under which a row of the interpretation has an effect."""
        if row.where is None:
            return z3.BoolVal(True)
        name, wanted = row.where
        if row.where in _SPANS:
            low, high = _SPANS[row.where]
            return z3.And(self.call.pin(name) >= low, self.call.pin(name) <= high)
        if wanted in ("TRUE", "FALSE"):
            return self.call.pin(name) == (wanted == "TRUE")
        return self.call.member(name, wanted)

    def scaled(self) -> Iterator[tuple[PinRow, Any]]:
        """Yield the REAL pins that are multiplied by a factor, with the pattern of each element."""
        for row in self.reading.inputs:
            if row.scale:
                for number in range(len(row.places)):
                    yield row, self._pin(row, number)

    def fits(self) -> Iterator[Any]:
        """Yield the claims that every used REAL is within its limits and no text is too long."""
        for row, pattern in self.scaled():
            limits = bounds(pattern, nearest(pattern, row.scale), row.scale)
            yield z3.Implies(self.counts(row), z3.Or([inside for _, inside, _ in limits]))
        for row in self.reading.inputs:
            if row.how == "real":
                finite = self._pin(row) & 0x7F80_0000 != 0x7F80_0000
                yield z3.Implies(self.counts(row), finite)
            if row.how == "text":
                yield z3.Implies(self.counts(row), z3.ULE(self._pin(row).size, len(row.places)))

    def keys(self) -> Iterator[Any]:
        """Yield the values that a telegram must contain: command, robot, and each used pin."""
        if self.reading.select[0]:
            yield self.call.pin(self.reading.select[0])
        if self.reading.robot:
            yield self.call.pin("RobotNumber")
        for row in self.reading.inputs:
            flags = bool(row.members) and len(row.places) > 1
            for number in range(1 if flags else len(row.places)):
                raw = row.scale or row.how in ("real", "text")
                key = self._value(row, number) if raw else self._pin(row, number)
                key = z3.If(key, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1)) if z3.is_bool(key) else key
                yield z3.If(self.counts(row), key, z3.BitVecVal(0, key.size()))

    def _pin(self, row: PinRow, number: int = 0) -> Any:
        return self.call.pin(row.pin, number)

    def _value(self, row: PinRow, number: int) -> Any:
        """Return the value that a row of the interpretation writes to one position."""
        width, pin = row.places[number].width, self._pin(row, number)
        if row.members:
            value = z3.BitVecVal(0, width)
            flags = len(row.places) > 1
            for one in row.members:
                wire = int(one.value == number + 1) if flags else one.value
                value = z3.If(self.call.member(row.pin, one.name), z3.BitVecVal(wire, width), value)
            return value
        if row.how == "text":
            return _character(pin, number)
        if row.how == "bool":
            return z3.If(pin, z3.BitVecVal(1, width), z3.BitVecVal(0, width))
        if row.how == "real":
            return _bits(pin)
        if row.scale:
            return _cut(nearest(pin, row.scale), width)
        if row.how == "bit":
            return _table(pin, {k: 1 << k - 1 for k in range(1, width + 1)}, width)
        if row.how == "bcd":
            return _table(pin, {k: int(str(k), 16) for k in range(100)}, width)
        return _cut(pin, width)


def _cut(term: Any, width: int) -> Any:
    size = term.size()
    return z3.SignExt(width - size, term) if size < width else z3.Extract(width - 1, 0, term)


def _table(term: Any, rows: dict[int, int], width: int) -> Any:
    value = z3.BitVecVal(0, width)
    for number, one in rows.items():
        value = z3.If(term == number, z3.BitVecVal(one, width), value)
    return value


def _write(words: list[Any], part: Place, value: Any, counts: Any) -> None:
    """Write a value to its position in the words. The position must have been 0 before."""
    first = part.at // 2 - 1
    value = z3.If(counts, value, z3.BitVecVal(0, part.width))
    for number in range(first, first + (part.width + 15) // 16):
        if part.width > 16:
            low = 16 * (number - first)
            words[number] |= z3.Extract(low + 15, low, value)
        else:
            words[number] |= z3.ZeroExt(16 - part.width, value) << part.low
