"""The max. torque command value."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end

TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _master(**config: Any) -> Master:
    master = Master(**config)
    master.servo_on()
    return master


def test_the_max_torque_of_axis_1_becomes_50_percent_and_that_of_no_other_axis() -> None:
    """The printed example.

    Rule: torque-limit.
    Source: remote command guide 4.2.22
    """
    master = _master()
    assert master.execute(0x0048, 0, 1, 50) == NORMAL_END
    assert master.robot.machine.settings.torque == [50, 100, 100, 100]


def test_the_torque_becomes_effective_at_the_next_movement_command() -> None:
    """On the axes that move: the axis that is not designated keeps what it had.

    Rule: torque-limit.
    Source: remote command guide 4.2.22
    """
    master = _master()
    settings = master.robot.machine.settings
    master.execute(0x0048, 0, 1, 50)
    master.execute(0x0048, 0, 2, 60)
    assert settings.torque_in_effect == [100, 100, 100, 100]
    assert master.execute(0x0001, 0x0001, 0x0001, 0, 19)[0] == 0x0200
    assert settings.torque_in_effect == [50, 100, 100, 100]
    assert master.execute(0x0001, 0, 0, 0, 19)[0] == 0x0200
    assert settings.torque_in_effect == [50, 60, 100, 100]


@pytest.mark.parametrize("torque", [1, 100])
def test_the_torque_is_1_to_100_percent(torque: int) -> None:
    """Source: remote command guide 4.2.22."""
    master = _master()
    assert master.execute(0x0048, 0, 8, torque) == NORMAL_END
    assert master.robot.machine.settings.torque == [100, 100, 100, torque]


@pytest.mark.parametrize(
    "data",
    [
        pytest.param((0, 1, 0), id="torque 0"),
        pytest.param((0, 1, 101), id="torque 101 %"),
        pytest.param((0, 0, 50), id="no axis"),
        pytest.param((0, 3, 50), id="two axes"),
        pytest.param((0, 0x41, 50), id="axis bit 6 is fixed 0"),
        pytest.param((0, 0x8001, 50), id="axis bit 15 is fixed 0"),
        pytest.param((1, 1, 50), id="n+2 is not used"),
        pytest.param((0, 1, 50, 1), id="n+8 is not used"),
    ],
)
def test_a_wrong_torque_telegram_changes_nothing(data: tuple[int, ...]) -> None:
    """Source: remote command guide 4.2.22."""
    master = _master()
    assert master.execute(0x0048, *data) == abnormal_end("4.2")
    assert master.robot.machine.settings.torque == [100, 100, 100, 100]


def test_the_axis_is_one_of_the_designated_robot() -> None:
    """Source: remote command guide 4.2.22, R and tt."""
    master = _master(axes=TWO_ROBOTS, no_axis_alarm="1.6")
    assert master.execute(0x2048, 0, 1, 50) == NORMAL_END
    assert master.robot.machine.settings.torque == [100, 100, 50]
    assert master.execute(0x2048, 0, 2, 50) == abnormal_end("1.6")
    assert master.execute(0x0048, 0, 4, 50) == abnormal_end("1.6")
    assert master.robot.machine.settings.torque == [100, 100, 50]


def test_the_parameter_counts_again_after_a_power_cycle() -> None:
    """The command does not change the parameter.

    Rule: settings-power, first-settings.
    Source: remote command guide 4.2.22
    """
    master = _master()
    master.execute(0x0048, 0, 1, 50)
    master.execute(0x0001, 0, 0, 0, 19)
    master.robot.inject("power_cycle")
    master.run(300)
    settings = master.robot.machine.settings
    assert settings.torque == settings.torque_in_effect == [100, 100, 100, 100]
