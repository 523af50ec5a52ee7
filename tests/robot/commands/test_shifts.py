"""Shift data: definition and reference."""

from __future__ import annotations

import pytest

from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, power_cycle, ready

WRITE, READ = 0x010C, 0x010D
#: 10.000, -20.000, 5.000, -18.000 as printed.
PRINTED = (0x2710, 0x0000, 0xB1E0, 0xFFFF, 0x1388, 0x0000, 0xB9B0, 0xFFFF)


def test_the_defined_shift_is_read_back() -> None:
    """Source: remote command guide 4.3.4."""
    master = ready()
    assert master.execute(WRITE, 0, 5, 0, *PRINTED) == NORMAL_END
    assert master.execute(READ, 0, 5) == (0x0200, 0, 5, 0, *PRINTED) + (0,) * 4
    assert master.robot.machine.memory.shift(5) == (10_000, -20_000, 5_000, -18_000)


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


@pytest.mark.parametrize(
    "words",
    [
        pytest.param((WRITE, 1, 5), id="definition: n+2"),
        pytest.param((WRITE, 0, 40), id="definition: shift 40"),
        pytest.param((WRITE, 0, 5, 1), id="definition: n+6"),
        pytest.param((WRITE, 0, 5, 0, *PRINTED, 1), id="definition: n+24"),
        pytest.param((READ, 1, 5), id="reference: n+2"),
        pytest.param((READ, 0, 40), id="reference: shift 40"),
        pytest.param((READ, 0, 5, 1), id="reference: n+6"),
    ],
)
def test_a_wrong_telegram_on_shifts_changes_nothing(words: tuple[int, ...]) -> None:
    """Source: remote command guide 4.3.4."""
    master = ready(shifts={5: (1, 2, 3, 4)})
    assert master.execute(*words) == abnormal_end("4.2")
    assert master.robot.machine.memory.shifts == {5: (1, 2, 3, 4)}


def test_shifts_survive_a_power_cycle() -> None:
    """Rule: stored.

    Source: remote command guide 4.3.4
    """
    master = ready()
    master.execute(WRITE, 0, 5, 0, *PRINTED)
    power_cycle(master)
    assert master.execute(READ, 0, 5)[4:12] == PRINTED
