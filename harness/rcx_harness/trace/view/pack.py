"""The encoding of the changes of a lane: small in a file, and read fast by the page (page/data.js).

A change consists of the time since the previous change and the new value. A whole number has seven
bits in each byte, the lowest first. Bytes of 128 or more are followed by another byte. Signed
numbers 0, -1, 1, -2 ... are encoded as 0, 1, 2, 3 ...
"""

from __future__ import annotations

import struct

__all__ = ["Bits", "Numbers", "Packed", "Reals", "Texts", "put_whole"]

_REAL = struct.Struct("<d")


def put_whole(data: bytearray, number: int) -> None:
    """Append a whole number (0 or more) in the encoding of the page."""
    while number > 127:
        data.append(number & 127 | 128)
        number >>= 7
    data.append(number)


class Packed:
    """The encoded changes of one lane.

    This class is for two values in turn, so values are not stored.

    Attributes:
        first: The value before the first change; None until a value is recorded.
    """

    #: Name of the encoding in the page.
    form = "bit"

    def __init__(self) -> None:
        self.data = bytearray()
        self.count = 0
        self.first: float | None = None
        self._last: float = 0
        self._t_us = 0

    def note(self, t_us: int, value: float) -> bool:
        """Record the value from the time `t_us` [us] on. Return whether it is a change.

        The first value is not a change: it counts as the value from the beginning.
        """
        if self.first is None:
            self.first = self._last = value
            return False
        if value == self._last or (value != value and self._last != self._last):
            return False
        self.add(t_us, value)
        return True

    def add(self, t_us: int, value: float) -> None:
        """Record a change, even if the value stays the same.

        The time is not before the previous time.
        """
        t_us = max(t_us, self._t_us)
        put_whole(self.data, t_us - self._t_us)
        self._put(value)
        self._t_us, self._last = t_us, value
        self.count += 1

    def _put(self, value: float) -> None:
        """Append the value of a change. Here nothing is appended, because two values alternate."""


class Bits(Packed):
    """The encoded changes of a signal that is ON or OFF."""


class Texts(Packed):
    """The encoded changes of a text, stored as its number in the table of all texts."""

    form = "text"

    def _put(self, value: float) -> None:
        put_whole(self.data, int(value))


class Numbers(Packed):
    """The encoded changes of a whole number up to 2^53, stored as differences."""

    form = "whole"

    def _put(self, value: float) -> None:
        by = int(value) - int(self._last)
        put_whole(self.data, 2 * by if by >= 0 else -2 * by - 1)


class Reals(Packed):
    """The encoded changes of a number with a fraction, stored in 64 bits."""

    form = "real"

    def _put(self, value: float) -> None:
        self.data += _REAL.pack(value)
