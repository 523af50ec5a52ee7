"""The changes of a lane as bytes: small in a file, and read fast by the page (page/data.js).

A change is the time since the one before, then its value. Whole numbers have seven bits in a byte,
the lowest first, and a further byte behind each that is 128 or more; what may be negative goes
0, -1, 1, -2 ... as 0, 1, 2, 3 ...
"""

from __future__ import annotations

import struct

__all__ = ["Bits", "Numbers", "Packed", "Reals", "Texts", "put_whole"]

_REAL = struct.Struct("<d")


def put_whole(data: bytearray, number: int) -> None:
    """Append a whole number that is not negative."""
    while number > 127:
        data.append(number & 127 | 128)
        number >>= 7
    data.append(number)


class Packed:
    """The changes of one lane, without values of their own: each is another of two.

    Attributes:
        data: The changes.
        count: How many there are.
        first: The value before the first of them; None as long as none was noted.
    """

    #: What the page reads it as.
    form = "bit"

    def __init__(self) -> None:
        self.data = bytearray()
        self.count = 0
        self.first: float | None = None
        self._last: float = 0
        self._t_us = 0

    def note(self, t_us: int, value: float) -> bool:
        """The value from `t_us` on [us]; the first one has always been. Is it a change?"""
        if self.first is None:
            self.first = self._last = value
            return False
        if value == self._last or (value != value and self._last != self._last):
            return False
        self.add(t_us, value)
        return True

    def add(self, t_us: int, value: float) -> None:
        """A change, also to the same value; time never goes back."""
        t_us = max(t_us, self._t_us)
        put_whole(self.data, t_us - self._t_us)
        self._put(value)
        self._t_us, self._last = t_us, value
        self.count += 1

    def _put(self, value: float) -> None:
        """The value of a change: nothing is needed."""


class Bits(Packed):
    """What is ON or OFF."""


class Texts(Packed):
    """Texts, by their numbers in the table of all texts."""

    form = "text"

    def _put(self, value: float) -> None:
        put_whole(self.data, int(value))


class Numbers(Packed):
    """Whole numbers, by the difference to the one before; up to 2^53, as the page has them."""

    form = "whole"

    def _put(self, value: float) -> None:
        by = int(value) - int(self._last)
        put_whole(self.data, 2 * by if by >= 0 else -2 * by - 1)


class Reals(Packed):
    """Numbers with a fraction, as 64 bits each."""

    form = "real"

    def _put(self, value: float) -> None:
        self.data += _REAL.pack(value)
