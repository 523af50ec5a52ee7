"""Controllers for tests of stored data, and functions that convert values into words."""

from __future__ import annotations

import struct
from typing import Any

from robot_master import Master


def ready(**config: Any) -> Master:
    """Return a master whose controller is ready for commands. By default it has no points."""
    master = Master(**{"points": {}, **config})
    master.power_up()
    return master


def long_words(*values: int) -> tuple[int, ...]:
    """Return signed 32 bit numbers as words, the lower word first."""
    return struct.unpack(f"<{2 * len(values)}H", struct.pack(f"<{len(values)}i", *values))


def real_words(value: float) -> tuple[int, ...]:
    """Return a single-precision number as two words, the lower word first."""
    return struct.unpack("<2H", struct.pack("<f", value))


def text_words(text: str, filler: str) -> tuple[int, ...]:
    """Return sixteen characters as words, the first character in the lower byte."""
    return struct.unpack("<8H", text.ljust(16, filler).encode("latin-1"))


def power_cycle(master: Master) -> None:
    """Switch the controller off and on, and let it boot."""
    master.robot.inject("power_cycle")
    master.run(1000)
    master.power_up()
