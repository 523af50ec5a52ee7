"""Where the areas lie in the PLC's holding registers, and how their words are ordered."""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from rcx_harness.errors import InputError
from rcx_harness.spec.wire import check_size

__all__ = ["Registers", "area_of", "words_of"]

_LAST = 0xFFFF
_AT_ONCE = 120
"""Registers of one request: Modbus allows 125 to be read and 123 to be written. Even, so that no
double word of the area is cut in two."""


def words_of(area: bytes) -> tuple[int, ...]:
    """The words of an area: byte 2k is the low half of word k (manual chapter 1, 4.1)."""
    return struct.unpack(f"<{len(area) // 2}H", area)


def area_of(words: Sequence[int]) -> bytes:
    """The bytes of an area, twice as many as words; each word is 0 to 65535."""
    return struct.pack(f"<{len(words)}H", *words)


@dataclass(frozen=True)
class Registers:
    """The PLC's registers that the bridge reads and writes.

    Each area is followed by one more register: the PLC's heartbeat behind what is read, the
    bridge's life word behind what is written.

    Attributes:
        read: First register of the area to the robot; OpenPLC: %QW0 is 0.
        write: First register of the area from the robot; OpenPLC: %MW0 is 1024.
        size: Bytes of each area, 48 or 256.

    Raises:
        InputError: a size that no area has, registers that do not exist or that overlap.
    """

    read: int = 0
    write: int = 1024
    size: int = 48

    def __post_init__(self) -> None:
        """Check them."""
        check_size(self.size)
        for name, first in (("--read", self.read), ("--write", self.write)):
            if not 0 <= first <= _LAST - self.words:
                raise InputError(
                    f"{name} {first}: there are no registers {first} to {first + self.words}",
                    hint=f"with {self.size} bytes it can be 0 to {_LAST - self.words}",
                )
        if abs(self.read - self.write) <= self.words:
            raise InputError(
                f"the registers {self.text(self.read)} and {self.text(self.write)} overlap",
                hint=f"leave {self.words + 1} registers between --read and --write",
            )

    @property
    def words(self) -> int:
        """Words of an area, without the one behind it."""
        return self.size // 2

    def text(self, first: int) -> str:
        """`0 to 24`: the registers of an area and the one behind it."""
        return f"{first} to {first + self.words}"

    def parts(self, first: int) -> Iterator[tuple[int, int]]:
        """The requests that an area and the word behind it take: first register and number.

        With 48 bytes it is one, so that all words are of one scan of the PLC. With 256 bytes all
        but the last few words are in the first one.
        """
        end = first + self.words + 1
        for start in range(first, end, _AT_ONCE):
            yield start, min(_AT_ONCE, end - start)
