"""The motor power command switches the motor power, and also the servos with ON and OFF."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, powered_up

OFF, ON, PWR = 0x0041, 0x0042, 0x0043
TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2))


def _states(master: Master) -> list[int]:
    return master.robot.machine.servos.states


def test_on_turns_the_motor_power_and_all_system_servos_on() -> None:
    """The printed example switches the axes of every robot.

    Rule: motor-power, servo-output.
    Source: remote command guide 4.2.20
    """
    master = powered_up(axes=TWO_ROBOTS)
    assert not master.on("SO02")
    assert master.execute(ON) == NORMAL_END
    assert _states(master) == [1, 1, 1]
    assert master.on("SO02")


def test_off_turns_the_motor_power_and_all_system_servos_off() -> None:
    """The servos turn OFF, and the brakes lock every axis, including an axis that was free.

    Rule: motor-power, servo-output.
    Source: remote command guide 4.2.20
    """
    master = powered_up(axes=TWO_ROBOTS)
    master.execute(ON)
    master.execute(0x0036, 0, 0x0001)
    assert _states(master) == [2, 1, 1]
    assert master.execute(OFF) == NORMAL_END
    assert _states(master) == [0, 0, 0]
    assert not master.on("SO02")


def test_pwr_turns_only_the_motor_power_on() -> None:
    """PWR switches only the motor power. The servos keep their states.

    A servo can be switched ON once the motor power is ON.

    Rule: motor-power, servo-output.
    Source: remote command guide 4.2.20
    """
    master = powered_up()
    assert master.execute(PWR) == NORMAL_END
    assert _states(master) == [0, 0, 0, 0]
    assert master.on("SO02")
    assert master.execute(0x0034, 0, 0x0004) == NORMAL_END
    assert master.execute(PWR) == NORMAL_END
    assert _states(master) == [0, 0, 1, 0]


def test_the_servo_on_input_switches_the_servos_on_after_pwr() -> None:
    """Source: manual chapter 5, 2, SI(01)."""
    master = powered_up()
    master.execute(PWR)
    master.pulse("SI01")
    assert _states(master) == [1, 1, 1, 1]


def test_with_the_motor_power_alone_nothing_moves() -> None:
    """Source: remote command guide 4.2.20."""
    master = powered_up(servo_off_alarm="1.5")
    master.execute(PWR)
    assert master.execute(0x0001, 0, 0, 0, 19) == abnormal_end("1.5")
    master.execute(ON)
    assert master.execute(0x0001, 0, 0, 0, 19)[0] == 0x0200


@pytest.mark.parametrize("code", [ON, PWR])
def test_the_motor_power_does_not_come_on_in_emergency_stop(code: int) -> None:
    """Rule: servo-on-command."""
    master = Master()
    master.run(300)
    assert master.execute(code) == abnormal_end("12.600")
    assert master.execute(OFF) == NORMAL_END


def test_the_motor_power_takes_its_time() -> None:
    """The answer takes 50 ms and the cycle that accepts the command. Rule: servo-on-command."""
    master = powered_up(servo_on_delay=50)
    master.send(ON)
    master.run(50)
    assert (master.status, master.on("SO02")) == (0x0100, False)
    master.run(5)
    assert (master.status, master.on("SO02")) == (0x0200, True)


def test_off_stops_a_robot_program_and_a_return_to_origin() -> None:
    """Rule: servo-off-command."""
    master = powered_up(origin_time=400)
    master.execute(ON)
    master.pulse("SI15")
    master.pulse("SI12")
    assert master.on("SO13")
    master.turn_and_wait("SI14", True)
    master.execute(OFF)
    assert not master.on("SO13")
    assert not master.robot.machine.origin_running
    assert master.robot.alarms.history == []
