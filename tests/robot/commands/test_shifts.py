"""Shift data: definition and reference."""

from __future__ import annotations

from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, ready

WRITE, READ = 0x010C, 0x010D


def test_shifts_0_and_39_hold_32_bits_on_four_axes() -> None:
    """Source: remote command guide 4.3.4."""
    master = ready()
    for number in (0, 39):
        extremes = long_words(-(2**31), 2**31 - 1, number, -number)
        assert master.execute(WRITE, 0, number, 0, *extremes) == NORMAL_END
    assert master.execute(READ, 0, 0)[4:12] == long_words(-(2**31), 2**31 - 1, 0, 0)
    assert master.execute(READ, 0, 39)[4:12] == long_words(-(2**31), 2**31 - 1, 39, -39)


def test_a_shift_that_was_never_defined_is_0() -> None:
    """Or its reference is an alarm, unless it is shift 0.

    Rule: undefined-data.
    Source: remote command guide 4.3.4
    """
    assert ready().execute(READ, 0, 7) == (0x0200, 0, 7) + (0,) * 13
    master = ready(undefined_data_alarm="6.5")
    assert master.execute(READ, 0, 7) == abnormal_end("6.5")
    assert master.execute(READ, 0, 0) == (0x0200,) + (0,) * 15
    assert master.execute(WRITE, 0, 7) == NORMAL_END
    assert master.execute(READ, 0, 7) == (0x0200, 0, 7) + (0,) * 13
