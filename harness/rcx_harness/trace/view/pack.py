"""The changes of a lane as bytes: small in a file, and fast to read by the page (page/data.js).

A change is the time since the previous change, then its value. Whole numbers have seven bits per
byte, lowest first; another byte follows a byte of 128 or more. Signed numbers 0, -1, 1, -2 ... are
encoded as 0, 1, 2, 3 ...
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
    """The changes of one lane that alternates between two values, so values are not stored.

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
        """Record the value from `t_us` on [us]; return whether it is a change.

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
        """Record a change, even to the same value; the time is at least the previous time."""
        t_us = max(t_us, self._t_us)
        put_whole(self.data, t_us - self._t_us)
        self._put(value)
        self._t_us, self._last = t_us, value
        self.count += 1

    def _put(self, value: float) -> None:
        """Append the value of a change; here nothing, because the value alternates."""


class Bits(Packed):
    """The changes of a signal that is ON or OFF."""


class Texts(Packed):
    """The changes of a text, as numbers in the table of all texts."""

    form = "text"

    def _put(self, value: float) -> None:
        put_whole(self.data, int(value))


class Numbers(Packed):
    """The changes of a whole number, as differences; up to 2^53, the limit of the page."""

    form = "whole"

    def _put(self, value: float) -> None:
        by = int(value) - int(self._last)
        put_whole(self.data, 2 * by if by >= 0 else -2 * by - 1)


class Reals(Packed):
    """The changes of a number with a fraction, 64 bits each."""

    form = "real"

    def _put(self, value: float) -> None:
        self.data += _REAL.pack(value)
