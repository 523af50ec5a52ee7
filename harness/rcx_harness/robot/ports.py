"""The ports that a robot program reads and writes (manual chapter 3, 2)."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

from rcx_harness.errors import InputError

__all__ = ["Port", "Ports", "port"]

_BITS_AT = 32
_LAST_PORT = 0o15  # the language has ports up to 27, this board takes them up to 15
_FIRST_FREE = 2  # ports 0 and 1 are dedicated, as are words 0 and 1
_WORDS = range(_FIRST_FREE, 16)
_EXTENDED = range(24, 128)

_NAME = re.compile(r"S([IO])(?:([WD])\(?(\d+)\)?|(1?[0-7])\(\)|\(?(1?[0-7])([0-7])\)?)")


@dataclass(frozen=True)
class Port:
    """Where a port lies: `size` bytes at `at`; one bit of the byte if `bit` is not None."""

    name: str
    output: bool
    at: int
    size: int
    bit: int | None = None

    @property
    def signed(self) -> bool:
        """SID and SOD are signed, all others are not (manual chapter 1, 4.1)."""
        return self.size == 4

    def check(self, size: int) -> None:
        """Refuse a word that an area of `size` bytes does not have (InputError)."""
        if self.at + self.size > size:
            raise InputError(f"{self.name} needs the extended area", hint="set size = 256")


@cache
def port(name: str) -> Port:
    """The port with a name of the robot language: `SO(20)`, `SO2()`, `SOW(2)` or `SOD(2)`.

    Raises:
        InputError: no such port, or one that is not general-purpose.
    """
    text = name.replace(" ", "").upper()
    match = _NAME.fullmatch(text)
    if not match:
        raise InputError(f"{name} is no port", hint="write SO(20), SO2(), SOW(2) or SOD(2)")
    output = match[1] == "O"
    if match[2]:
        return _word(text, output, double=match[2] == "D", number=int(match[3]))
    number = int(match[4] or match[5], 8)  # SO7() is followed by SO10()
    if number > _LAST_PORT or (output and number < _FIRST_FREE):
        hint = "SO2() to SO7() and SO10() to SO15() can be written, SI0() to SI15() be read"
        raise InputError(f"{name} is no port of this board", hint=hint)
    return Port(text, output, _BITS_AT + number, 1, int(match[6]) if match[6] else None)


def _word(text: str, output: bool, *, double: bool, number: int) -> Port:
    last = number + 1 if double else number
    free = any(number in part and last in part for part in (_WORDS, _EXTENDED))
    if not free or (double and number % 2):
        hint = "words 2 to 15 are free, 24 to 127 in the extended area; double words are even"
        raise InputError(f"{text} is no general-purpose word", hint=hint)
    return Port(text, output, 2 * number, 4 if double else 2)


class Ports:
    """The general-purpose part of both areas.

    Attributes:
        inputs: The area as the master sent it last.
        outputs: What the robot programs wrote, as an area.
    """

    def __init__(self, size: int) -> None:
        self.inputs = bytes(size)
        self.outputs = bytearray(size)

    def forget_inputs(self) -> None:
        """There is no connection: all inputs are OFF or 0."""
        self.inputs = bytes(len(self.inputs))

    def clear_outputs(self) -> None:
        """All outputs OFF or 0."""
        self.outputs = bytearray(len(self.outputs))

    def read(self, place: Port) -> int:
        """The value of an input or output."""
        self._check(place)
        area = self.outputs if place.output else self.inputs
        value = int.from_bytes(
            area[place.at : place.at + place.size], "little", signed=place.signed
        )
        return value if place.bit is None else value >> place.bit & 1

    def write(self, place: Port, value: int) -> None:
        """Set an output; of a value that is too long the lower bits count.

        Raises:
            InputError: an input, or a word beyond the area.
        """
        if not place.output:
            raise InputError(f"{place.name} is an input of the robot", hint="outputs can be set")
        self._check(place)
        if place.bit is None:
            raw = (value & (1 << 8 * place.size) - 1).to_bytes(place.size, "little")
            self.outputs[place.at : place.at + place.size] = raw
        elif value & 1:
            self.outputs[place.at] |= 1 << place.bit
        else:
            self.outputs[place.at] &= ~(1 << place.bit)

    def _check(self, place: Port) -> None:
        place.check(len(self.inputs))
