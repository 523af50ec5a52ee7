"""The facts of the wire: sizes, assemblies, cycle and status words.

Controller, adapter and wire monitor judge by independent code and share only these numbers.
tests/spec/test_wire.py repeats the numbers from the manual.
"""

from __future__ import annotations

from structured_text.errors import InputError

__all__ = [
    "ABNORMAL_END",
    "AREA_SIZES",
    "CYCLE_US",
    "DEDICATED_AT",
    "ENDS",
    "EXTENDED_SIZE",
    "NORMAL_END",
    "READY",
    "RESERVED_AT",
    "RUN",
    "SIZE",
    "STATUS_NAMES",
    "TO_MASTER",
    "TO_ROBOT",
    "check_size",
]

SIZE, EXTENDED_SIZE = 48, 256
"""Bytes of each area: by default, and with "SIOW extension" valid (manual chapter 1, 4)."""
AREA_SIZES = (SIZE, EXTENDED_SIZE)

TO_MASTER, TO_ROBOT = 100, 150
"""Instances of the Assembly object that carry the areas (manual chapter 1, 4.3; chapter 5, 4)."""

DEDICATED_AT, RESERVED_AT = 32, 46
"""Offsets of the dedicated bits and of the reserved bytes in an area (chapter 1, 4.1)."""

CYCLE_US = 5_000
"""The controller's I/O update interval in microseconds (manual chapter 5, 4)."""

READY, RUN, NORMAL_END, ABNORMAL_END = 0x0000, 0x0100, 0x0200, 0x4000
"""The values of the remote status (guide chapter 1, 1.2)."""
ENDS = (NORMAL_END, ABNORMAL_END)
STATUS_NAMES = {
    READY: "command ready",
    RUN: "command run",
    NORMAL_END: "normal end",
    ABNORMAL_END: "abnormal end",
}


def check_size(size: int) -> None:
    """Raise InputError for a size that no area has."""
    if not isinstance(size, int) or size not in AREA_SIZES:
        raise InputError(
            f"an area of {size} bytes does not exist",
            hint=f"use {SIZE}, or {EXTENDED_SIZE} with SIOW extension valid",
        )
