"""The bytes of the input area and the output area: dedicated bits, words, and forced outputs."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence

from rcx_harness.robot.ports import port
from rcx_harness.spec import Signal, signals
from rcx_harness.spec.wire import DEDICATED_AT
from structured_text.errors import InputError

__all__ = [
    "DEDICATED",
    "INPUTS",
    "OUTPUTS",
    "RESERVED",
    "WORDS_AT_REST",
    "Overlay",
    "build_area",
    "dedicated_word",
    "input_words",
    "mask_of",
    "reserved_bytes_of",
]

_WORDS = struct.Struct("<16H")
_DEDICATED_WORDS = struct.Struct("<2H")

#: The words m to m+30 while the controller is ready for a remote command.
WORDS_AT_REST = (0,) * 16


def mask_of(signal: Signal) -> int:
    """Return the mask of a signal in the dedicated word, which is bytes 32 (low) and 33 (high)."""
    return 1 << (signal.bit + 8 * (signal.byte - DEDICATED_AT))


#: Maps the short name of a dedicated input or output, such as `SI00`, to its mask in the dedicated
#: word.
INPUTS = {signal.short: mask_of(signal) for signal in signals().input}
OUTPUTS = {signal.short: mask_of(signal) for signal in signals().output}
#: The mask of all dedicated inputs, and the mask of the reserved bits, in the dedicated word.
DEDICATED = sum(INPUTS.values())
RESERVED = 0xFFFF & ~DEDICATED


def input_words(area: bytes) -> tuple[int, ...]:
    """Return the words n to n+30 of an input area."""
    return _WORDS.unpack_from(area)


def dedicated_word(area: bytes) -> int:
    """Return bytes 32 (low) and 33 (high) of an area as one word."""
    return area[DEDICATED_AT] | area[DEDICATED_AT + 1] << 8


def reserved_bytes_of(area: bytes) -> bytes:
    """Return those bytes of the input area whose eight bits are all reserved."""
    return bytes(map(area.__getitem__, signals().reserved_bytes))


def build_area(general: bytearray, words: Sequence[int], dedicated: int) -> bytearray:
    """Build the bytes of an output area.

    `words` are the words m to m+30, or only the first two if robot programs write the other words.
    `dedicated` is the word of bytes 32 (low) and 33 (high). All other bytes come from `general`.
    """
    area = bytearray(general)
    (_WORDS if len(words) == len(WORDS_AT_REST) else _DEDICATED_WORDS).pack_into(area, 0, *words)
    area[DEDICATED_AT] = dedicated & 0xFF
    area[DEDICATED_AT + 1] = dedicated >> 8
    return area


class Overlay:
    """The outputs that a test holds or forces. Their bits replace the bits of the output area."""

    def __init__(self, size: int) -> None:
        self._size = size
        self._parts: dict[str, list[tuple[int, int, int]]] = {}

    def set(self, name: str, value: int) -> None:
        """Force an output: a bit such as `SO02` to 0 or 1, a word such as `SOW(2)` to 16 bits."""
        spans = self._locate(name)
        if spans[0][1] != 0xFF:
            if not isinstance(value, int) or value not in (0, 1):
                raise InputError(f"{name} is a bit and cannot be {value}")
            at, mask = spans[0]
            self._parts[name] = [(at, mask, mask * value)]
            return
        if not isinstance(value, int) or not 0 <= value <= 0xFFFF:
            raise InputError(f"{name} is a word and cannot be {value}")
        first = spans[0][0]
        self._parts[name] = [(first, 0xFF, value & 0xFF), (first + 1, 0xFF, value >> 8)]

    def freeze(self, name: str, area: bytes) -> None:
        """Hold an output at its value in `area`; `Status` also holds the response words."""
        self._parts[name] = [(at, mask, area[at] & mask) for at, mask in self._locate(name)]

    def remove(self, name: str) -> None:
        """Release an output; do nothing if it is not held."""
        self._locate(name)
        self._parts.pop(name, None)

    @property
    def names(self) -> list[str]:
        """Return the names of the held or forced outputs."""
        return list(self._parts)

    def apply(self, area: bytearray) -> None:
        """Write the held and forced outputs into `area`."""
        for parts in self._parts.values():
            for at, mask, value in parts:
                area[at] = area[at] & ~mask | value

    def _locate(self, name: str) -> list[tuple[int, int]]:
        if name == "Status":
            return [(at, 0xFF) for at in range(DEDICATED_AT)]
        if not isinstance(name, str):
            raise InputError(f"{name!r:.40} is not an output", hint='write "SO02" or "SOW(2)"')
        word = re.fullmatch(r"SOW\(?(\d{1,4})\)?", name)
        if word and 2 * int(word[1]) + 1 < self._size:
            return [(2 * int(word[1]), 0xFF), (2 * int(word[1]) + 1, 0xFF)]
        if re.fullmatch(r"SO\(?([2-7]|1[0-5])[0-7]\)?", name):
            place = port(name)
            return [(place.at, 1 << (place.bit or 0))]
        signal = signals().find(name)
        if signal not in signals().output:
            raise InputError(f"{name} is an input of the controller", hint="name an output")
        return [(signal.byte, 1 << signal.bit)]
