"""The max. torque command value limits the torque from the next movement on."""

from __future__ import annotations

from typing import Any

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, servos_on

TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _master(**config: Any) -> Master:
    return servos_on(**config)


def test_the_torque_becomes_effective_at_the_next_movement_command() -> None:
    """The limit applies to the designated axes only. Other axes keep their limits.

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
