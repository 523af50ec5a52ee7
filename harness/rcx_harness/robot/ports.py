"""The ports that a robot program reads and writes (manual chapter 3, 2; guide, 4.5.1)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

from rcx_harness.spec.wire import DEDICATED_AT
from structured_text.errors import InputError

__all__ = ["Access", "Port", "Ports", "port", "port_of", "value_in"]

#: Greatest number of recorded accesses. The checker of properties reads and clears them once per
#: scan.
_MOST_ACCESSES = 10_000
_LAST_PORT = 0o15  # the language has ports 0 to 27 (octal), but the EtherNet/IP board only 0 to 15
_FIRST_FREE = 2  # ports 0 and 1 and words 0 and 1 are dedicated
_WORDS = range(_FIRST_FREE, 16)
_EXTENDED = range(24, 128)

#: Number of ports of each kind that is not part of the areas. SI and SO begin at 16().
_BANKS = {"DI": 24, "DO": 24, "MO": 24, "LO": 2, "TO": 1, "SI": 24, "SO": 24}
#: Kinds of internal outputs, which are memory of the controller.
_INTERNAL = ("MO", "LO", "TO")

_NAME = re.compile(r"S([IO])(?:([WD])\(?(\d+)\)?|(1?[0-7])\(\)|\(?(1?[0-7])([0-7])\)?)")
_OTHER = re.compile(r"(D[IO]|MO|LO|TO)(?:([0-2]?[0-7])\(\)|\(([0-2]?[0-7])([0-7])\))")


@dataclass(frozen=True)
class Port:
    """A port: `size` bytes at offset `at`, or the bit `bit` of the byte at offset `at`.

    If the port is not part of the areas, `bank` is the kind of the port, and `at` is an offset in
    the bytes of this kind. Otherwise `bank` is empty.
    """

    name: str
    output: bool
    at: int
    size: int
    bit: int | None = None
    bank: str = ""

    @property
    def signed(self) -> bool:
        """Return whether the value is signed.

        Only SID and SOD are signed (manual chapter 1, 4.1).
        """
        return self.size == 4

    def check(self, size: int) -> None:
        """Raise InputError if an area of `size` bytes does not contain the port."""
        if not self.bank and self.at + self.size > size:
            raise InputError(f"{self.name} needs the extended area", hint="set size = 256")


@cache
def port(name: str) -> Port:
    """Return the port of a name such as `SO(20)`, `SO2()`, `SOW(2)`, `SOD(2)` or `MO(20)`."""
    text = name.replace(" ", "").upper()
    if other := _OTHER.fullmatch(text):
        number = int(other[2] or other[3], 8)
        return _other(text, other[1], number, int(other[4]) if other[4] else None)
    match = _NAME.fullmatch(text)
    if not match:
        raise InputError(f"{name} is not a port", hint="write SO(20), SO2(), SOW(2) or SOD(2)")
    output = match[1] == "O"
    if match[2]:
        return _word(text, output, double=match[2] == "D", number=int(match[3]))
    number = int(match[4] or match[5], 8)  # numbers are octal: SO7() is followed by SO10()
    if number > _LAST_PORT or (output and number < _FIRST_FREE):
        hint = "write SO2() to SO7() and SO10() to SO15(), read SI0() to SI15()"
        raise InputError(f"{name} is not a port of this board", hint=hint)
    return Port(text, output, DEDICATED_AT + number, 1, int(match[6]) if match[6] else None)


def port_of(kind: str, number: int, bit: int | None = None) -> Port:
    """Return a port of the robot language by its kind, such as `DO`.

    Port names have octal numbers, so port 10() has the index 8. `bit` selects one bit; None: all
    eight.
    """
    name = f"{kind}{number:o}()" if bit is None else f"{kind}({number:o}{bit})"
    if kind in ("SI", "SO") and number <= _LAST_PORT:
        return Port(name, kind == "SO", DEDICATED_AT + number, 1, bit)
    return Port(name, kind[1] == "O", number, 1, bit, bank=kind)


def _other(text: str, kind: str, number: int, bit: int | None) -> Port:
    first = _FIRST_FREE if kind in ("DO", "MO") else 0
    if not first <= number < _BANKS[kind]:
        hint = "use ports 2 to 27 of DO and MO, 0 and 1 of LO, 0 of TO, 0 to 27 of DI"
        raise InputError(f"{text} is not a port", hint=hint)
    return port_of(kind, number, bit)


def _word(text: str, output: bool, *, double: bool, number: int) -> Port:
    free = number in _WORDS or number in _EXTENDED  # words begin at even numbers
    if not free or (double and number % 2):
        hint = "words 2 to 15 are free, 24 to 127 in the extended area; double words are even"
        raise InputError(f"{text} is not a general-purpose word", hint=hint)
    return Port(text, output, 2 * number, 4 if double else 2)


def value_in(place: Port, area: bytes | bytearray) -> int:
    """Return the value of a port in the area that contains it."""
    raw = area[place.at : place.at + place.size]
    value = int.from_bytes(raw, "little", signed=place.signed)
    return value if place.bit is None else value >> place.bit & 1


class Access(NamedTuple):
    """An access of a robot program to a port: a statement has read or changed the port.

    Attributes:
        program: Name of the program.
        line: Line of the statement.
        place: The port.
        changed: Whether the statement has changed the port; otherwise it has read the port.
        inputs: The input area from the master at the time of the access.
        outputs: The output area before the statement.
    """

    program: str
    line: int
    place: Port
    changed: bool
    inputs: bytes
    outputs: bytes


class Ports:
    """The general-purpose part of both areas, and the ports outside of the areas.

    Attributes:
        inputs: The last area that the master sent.
        outputs: The output area with the outputs of the robot programs.
        banks: All other ports by kind: one byte each.
        accesses: The ports that statements of robot programs have read and changed. The caller
            empties this list after reading. None: nothing is recorded.
        statement: Program and line of the statement that is executed, while accesses are recorded.
    """

    def __init__(self, size: int) -> None:
        self.banks = {kind: bytearray(count) for kind, count in _BANKS.items()}
        self.inputs = bytes(size)
        self.outputs = bytearray(size)
        self.accesses: list[Access] | None = None
        self.statement: tuple[str, int] | None = None

    def lose_power(self, *, clears_internal: bool) -> None:
        """Set the ports that lose their values with the power to OFF or 0.

        Internal outputs keep their values unless `clears_internal` is set. The inputs of the
        parallel I/O board always keep their values, because they come from outside.
        """
        self.forget_inputs()
        self.outputs = bytearray(len(self.outputs))
        for kind, bank in self.banks.items():
            if kind != "DI" and (clears_internal or kind not in _INTERNAL):
                bank[:] = bytes(len(bank))

    def forget_inputs(self) -> None:
        """Set all inputs to OFF or 0, because there is no connection."""
        self.inputs = bytes(len(self.inputs))

    def clear_outputs(self) -> None:
        """Set all outputs to OFF or 0."""
        self.outputs = bytearray(len(self.outputs))
        for kind, bank in self.banks.items():
            if kind[1] == "O":
                bank[:] = bytes(len(bank))

    def read(self, place: Port) -> int:
        """Return the value of an input or output."""
        self._check(place)
        if self.statement is not None:
            self._record(place, changed=False)
        return self._value(place)

    def _value(self, place: Port) -> int:
        area: bytes | bytearray = self.outputs if place.output else self.inputs
        if place.bank:
            area = self.banks[place.bank]
        return value_in(place, area)

    def write(self, place: Port, value: int) -> None:
        """Set an output; if the value is too long, its lower bits are written."""
        if not place.output:
            raise InputError(f"{place.name} is an input of the robot", hint="name an output")
        self._check(place)
        area = self.banks[place.bank] if place.bank else self.outputs
        if self.statement is None:
            self._store(area, place, value)
            return
        before, outputs = self._value(place), bytes(self.outputs)
        self._store(area, place, value)
        if self._value(place) != before:
            self._record(place, changed=True, outputs=outputs)

    def set_input(self, place: Port, value: int) -> None:
        """Set an input that does not come from the master: `DI(20)` or `DI2()`."""
        if place.output or not place.bank:
            raise InputError(f"{place.name} is not an input of the parallel I/O board")
        self._store(self.banks[place.bank], place, value)

    def _store(self, area: bytearray, place: Port, value: int) -> None:
        if place.bit is None:
            raw = (value & (1 << 8 * place.size) - 1).to_bytes(place.size, "little")
            area[place.at : place.at + place.size] = raw
        elif value & 1:
            area[place.at] |= 1 << place.bit
        else:
            area[place.at] &= ~(1 << place.bit)

    def _record(self, place: Port, *, changed: bool, outputs: bytes | None = None) -> None:
        assert self.statement is not None
        if self.accesses is not None and len(self.accesses) < _MOST_ACCESSES:
            before = bytes(self.outputs) if outputs is None else outputs
            self.accesses.append(Access(*self.statement, place, changed, self.inputs, before))

    def _check(self, place: Port) -> None:
        place.check(len(self.inputs))
