"""Hand data: definition and reference, per robot."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis, Hand
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, power_cycle, ready

WRITE, READ = 0x0110, 0x0111
#: 10.000, -2.000, 5.000 and 0 as printed.
PRINTED = (0x2710, 0x0000, 0xF830, 0xFFFF, 0x1388, 0x0000, 0x0000, 0x0000)
TWO_ROBOTS = (Axis(), Axis(robot=2))


def test_the_defined_hand_is_read_back_with_the_number_of_the_robot() -> None:
    """Robot 0 is robot 1, as printed.

    Source: remote command guide 4.3.5
    """
    master = ready()
    assert master.execute(WRITE, 0, 1, 0, *PRINTED) == NORMAL_END
    for code in (READ, 0x1000 | READ):
        assert master.execute(code, 0, 1) == (0x0200, 0, 1, 1, *PRINTED) + (0,) * 4
    assert master.robot.machine.memory.hand(0, 1) == Hand((10_000, -2_000, 5_000, 0))


def test_each_robot_has_its_own_hands() -> None:
    """Rule: hand-robot.

    Source: remote command guide 4.3.5
    """
    master = ready(axes=TWO_ROBOTS)
    first, second = long_words(1, 2, 3, 0), long_words(4, 5, 6, 1)
    assert master.execute(0x1000 | WRITE, 0, 31, 0, *first) == NORMAL_END
    assert master.execute(0x2000 | WRITE, 0, 31, 0, *second) == NORMAL_END
    assert master.execute(0x1000 | READ, 0, 31)[2:12] == (31, 1, *first)
    assert master.execute(0x2000 | READ, 0, 31)[2:12] == (31, 2, *second)


@pytest.mark.parametrize("scara", [(), (1,)])
@pytest.mark.parametrize("on_r_axis", [0, 1])
def test_hand_data_are_kept_as_they_are(scara: tuple[int, ...], on_r_axis: int) -> None:
    """Rule: hand-data.

    Source: remote command guide 4.3.5
    """
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


@pytest.mark.parametrize(
    "words",
    [
        pytest.param((WRITE, 1, 5), id="definition: n+2"),
        pytest.param((WRITE, 0, 32), id="definition: hand 32"),
        pytest.param((WRITE, 0, 5, 1), id="definition: n+6"),
        pytest.param((WRITE, 0, 5, 0, 0, 0, 0, 0, 0, 0, 2), id="definition: data 4 is 2"),
        pytest.param((WRITE, 0, 5, 0, *long_words(0, 0, 0, -1)), id="definition: data 4 is -1"),
        pytest.param((WRITE, 0, 5, 0, *PRINTED, 1), id="definition: n+24"),
        pytest.param((READ, 1, 5), id="reference: n+2"),
        pytest.param((READ, 0, 32), id="reference: hand 32"),
        pytest.param((READ, 0, 5, 1), id="reference: n+6"),
    ],
)
def test_a_wrong_telegram_on_hands_changes_nothing(words: tuple[int, ...]) -> None:
    """Rule: hand-data.

    Source: remote command guide 4.3.5
    """
    master = ready(hands={(1, 5): Hand((1, 2, 3, 0))})
    assert master.execute(*words) == abnormal_end("4.2")
    assert master.robot.machine.memory.hands == {(1, 5): Hand((1, 2, 3, 0))}


@pytest.mark.parametrize("code", [0x2000 | WRITE, 0x5000 | WRITE, 0x2000 | READ])
def test_a_robot_that_is_not_there_has_no_hands(code: int) -> None:
    """Rule: alarm-names.

    Source: remote command guide 4.3.5
    """
    master = ready(hands={(1, 5): Hand((1, 2, 3, 0))})
    assert master.execute(code, 0, 5) == abnormal_end("4.204")
    assert master.robot.machine.memory.hands == {(1, 5): Hand((1, 2, 3, 0))}


def test_hands_survive_a_power_cycle() -> None:
    """Rule: stored.

    Source: remote command guide 4.3.5
    """
    master = ready()
    master.execute(WRITE, 0, 1, 0, *PRINTED)
    power_cycle(master)
    assert master.execute(READ, 0, 1)[4:12] == PRINTED
