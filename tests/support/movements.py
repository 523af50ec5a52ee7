"""Helpers for the tests of movements by remote command."""

from __future__ import annotations

from typing import Any

from robot_master import Master

NORMAL, ABNORMAL = 0x0200, 0x4000
FORMAT_ERROR = (ABNORMAL, 4, 2)
#: Flags in a command that select the unit of the position output.
MM, PULSES = 0x8000, 0x4000


def mover(**config: Any) -> Master:
    """Return a master of a robot with its servos on."""
    master = Master(**config)
    master.servo_on()
    return master


def low_high(*values: int) -> tuple[int, ...]:
    """Return signed 32 bit values as words, the lower word first."""
    return tuple(word for value in values for word in (value & 0xFFFF, value >> 16 & 0xFFFF))


def way_of(master: Master, *words: int) -> list[tuple[int, ...]]:
    """Run a movement to its normal end.

    Return the positions of all axes at its start and every 5 ms.
    """
    master.send(*words)
    seen = [tuple(master.robot.positions)]
    while master.status not in (NORMAL, ABNORMAL):
        master.run(5)
        seen.append(tuple(master.robot.positions))
        assert len(seen) < 4_000, "the movement did not end within 20 s"
    assert master.status == NORMAL
    return seen
