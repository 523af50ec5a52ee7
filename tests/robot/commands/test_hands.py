"""Hand data: definition and reference, per robot."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, ready

WRITE, READ = 0x0110, 0x0111
TWO_ROBOTS = (Axis(), Axis(robot=2))


def test_each_robot_has_its_own_hands() -> None:
    """Rule: hand-robot. Source: remote command guide 4.3.5."""
    master = ready(axes=TWO_ROBOTS)
    first, second = long_words(1, 2, 3, 0), long_words(4, 5, 6, 1)
    assert master.execute(0x1000 | WRITE, 0, 31, 0, *first) == NORMAL_END
    assert master.execute(0x2000 | WRITE, 0, 31, 0, *second) == NORMAL_END
    assert master.execute(0x1000 | READ, 0, 31)[2:12] == (31, 1, *first)
    assert master.execute(0x2000 | READ, 0, 31)[2:12] == (31, 2, *second)


@pytest.mark.parametrize("scara", [(), (1,)])
@pytest.mark.parametrize("on_r_axis", [0, 1])
def test_hand_data_are_kept_as_they_are(scara: tuple[int, ...], on_r_axis: int) -> None:
    """Rule: hand-data. Source: remote command guide 4.3.5."""
    master = ready(scara_robots=scara)
    data = long_words(-(2**31), 2**31 - 1, -1, on_r_axis)
    assert master.execute(WRITE, 0, 0, 0, *data) == NORMAL_END
    assert master.execute(READ, 0, 0)[4:12] == data
    assert master.robot.machine.memory.hand(1, 0).on_r_axis is bool(on_r_axis)


def test_a_hand_that_was_never_defined_is_0() -> None:
    """Or its reference is an alarm, unless it is hand 0.

    Rule: undefined-data.
    Source: remote command guide 4.3.5
    """
    master = ready(axes=TWO_ROBOTS)
    assert master.execute(0x2000 | READ, 0, 7) == (0x0200, 0, 7, 2) + (0,) * 12
    master = ready(undefined_data_alarm="6.5")
    assert master.execute(READ, 0, 7) == abnormal_end("6.5")
    assert master.execute(READ, 0, 0) == (0x0200, 0, 0, 1) + (0,) * 12
