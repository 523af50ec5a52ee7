"""The servo command switches servos on, off or free."""

from __future__ import annotations

import pytest

from movements import mover
from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, powered_up

ON, OFF, FREE = 0x034, 0x035, 0x036
#: Values of a servo's state in the answer of the servo status command (guide, 4.7.3).
STATE = {ON: 1, OFF: 0, FREE: 2}
TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2), Axis(robot=2))


def _states(master: Master) -> list[int]:
    return master.robot.machine.servos.states


@pytest.mark.parametrize("code", [OFF, FREE])
def test_one_axis_goes_off_or_free_and_comes_back_on(code: int) -> None:
    """The motor power stays ON, and so does SO(02).

    Rule: servo-command, servo-output.
    Source: remote command guide 4.2.13
    """
    master = mover()
    assert master.execute(code, 0, 0x0002) == NORMAL_END
    assert _states(master) == [1, STATE[code], 1, 1]
    assert master.on("SO02")
    assert master.execute(ON, 0, 0x0002) == NORMAL_END
    assert _states(master) == [1, 1, 1, 1]


@pytest.mark.parametrize("robot", [0, 1])
def test_all_the_robot_servos_are_switched_if_no_axis_is_specified(robot: int) -> None:
    """The command switches all axes of the robot. R = 0 means robot 1; robot 2 stays as it is.

    Rule: servo-command.
    Source: remote command guide 4.2.13
    """
    master = mover(axes=TWO_ROBOTS)
    for code in (FREE, OFF, ON):
        assert master.execute(code | robot << 12) == NORMAL_END
        assert _states(master) == [STATE[code], STATE[code], 1, 1]


def test_all_the_servos_of_the_designated_robot_are_switched() -> None:
    """Source: remote command guide 4.2.13, R."""
    master = mover(axes=TWO_ROBOTS)
    assert master.execute(OFF | 0x2000) == NORMAL_END
    assert _states(master) == [1, 1, 0, 0]
    assert master.execute(ON | 0x2000, 0, 0x0002) == NORMAL_END
    assert _states(master) == [1, 1, 0, 1]


@pytest.mark.parametrize("code", [OFF, FREE])
def test_an_axis_moves_only_with_its_servo_on(code: int) -> None:
    """With axis 2 off or free, axis 1 can move alone. A movement of all axes is refused.

    Source: remote command guide 4.2.13
    """
    master = mover(servo_off_alarm="1.5")
    master.execute(code, 0, 0x0002)
    assert master.execute(0x0001, 0, 0, 0, 19) == abnormal_end("1.5")
    assert master.execute(0x0001, 0x0001, 0x0001, 0, 19)[0] == 0x0200
    assert master.robot.positions == [120_000, 0, 0, 0]
    master.execute(ON, 0, 0x0002)
    assert master.execute(0x0001, 0, 0, 0, 19)[0] == 0x0200
    assert master.robot.positions == [120_000, -45_000, 30_000, 0]


def test_the_servo_on_input_brings_back_what_a_command_switched_off() -> None:
    """SI(01) switches a servo ON that a command has switched OFF.

    Source: manual chapter 5, 2, SI(01).
    """
    master = mover()
    master.execute(OFF, 0, 0x0001)
    master.execute(FREE, 0, 0x0002)
    master.pulse("SI01")
    assert _states(master) == [1, 1, 1, 1]


def test_an_emergency_stop_switches_the_servos_off_with_their_brakes() -> None:
    """The brakes also lock an axis that was free. Source: manual chapter 5, 3.1."""
    master = mover()
    master.execute(FREE, 0, 0x0001)
    master.turn_and_wait("SI00", False)
    assert _states(master) == [0, 0, 0, 0]
    assert not master.on("SO02")


def test_servo_on_takes_its_time() -> None:
    """The answer takes 50 ms and the cycle that accepts the command. Rule: servo-on-command."""
    master = mover(servo_on_delay=50)
    master.execute(OFF)
    master.send(ON)
    master.run(50)
    assert (master.status, _states(master)) == (0x0100, [0, 0, 0, 0])
    master.run(5)
    assert (master.status, _states(master)) == (0x0200, [1, 1, 1, 1])


def test_servo_on_goes_on_in_a_copy_of_the_state() -> None:
    """A copy is restored from a snapshot while a servo on is in progress.

    The servo on ends in the copy as in the original.

    Rule: servo-on-command.
    """
    master = mover(servo_on_delay=50)
    master.execute(OFF)
    master.send(ON)
    master.run(20)
    half = master.robot.snapshot()
    first = master.robot.machine
    master.robot.restore(half)
    master.run(50)
    assert _states(master) == [1, 1, 1, 1]
    assert first.servos.states == [0, 0, 0, 0]


def test_servo_on_in_emergency_stop_ends_with_12_600() -> None:
    """Rule: servo-on-command."""
    master = Master()
    master.run(300)
    assert master.execute(ON) == abnormal_end("12.600")


def test_an_emergency_stop_ends_servo_on_with_12_600() -> None:
    """Rule: servo-on-command. Source: remote command guide 1.2."""
    master = mover(servo_on_delay=200)
    master.execute(OFF)
    master.send(ON)
    master.run(50)
    master.turn("SI00", on=False)
    assert master.finish() == abnormal_end("12.600")
    assert _states(master) == [0, 0, 0, 0]


def test_servo_on_needs_motor_power() -> None:
    """Without motor power, servo on is refused.

    With another setting it switches the motor power ON itself.

    Rule: servo-on-command.
    """
    master = powered_up(motor_power_alarm="1.4")
    assert master.execute(ON, 0, 0x0001) == abnormal_end("1.4")
    assert not master.on("SO02")

    master = powered_up(servo_needs_motor_power=False)
    assert master.execute(ON, 0, 0x0001) == NORMAL_END
    assert master.on("SO02")
    assert _states(master) == [1, 0, 0, 0]


@pytest.mark.parametrize("code", [OFF, FREE])
def test_off_and_free_are_possible_in_emergency_stop(code: int) -> None:
    """Rule: servo-off-command."""
    master = Master()
    master.run(300)
    assert master.execute(code, 0, 0x0001) == NORMAL_END
    assert _states(master) == [STATE[code], 0, 0, 0]


@pytest.mark.parametrize("code", [OFF, FREE])
def test_off_and_free_end_a_return_to_origin_of_the_axis(code: int) -> None:
    """SI(14) returns axes 3 and 4 together to their origins.

    A servo command ends this for its axis. Rule: servo-off-command.
    """
    master = mover(origin_time=400)
    master.turn_and_wait("SI14", True)
    assert master.robot.machine.origin_running
    master.execute(code, 0, 0x0001)
    assert master.robot.machine.origin_running
    master.execute(code, 0, 0x0004)
    assert not master.robot.machine.origin_running
    master.run(500)
    assert master.robot.origins == [True, True, False, False]


@pytest.mark.parametrize("code", [ON, 0x0042])
@pytest.mark.parametrize(
    ("event", "args", "alarm"),
    [("alarm", {"group": 17, "category": 4}, "17.4"), ("main_power_off", {}, "1.4")],
)
def test_servo_on_and_motor_power_on_are_refused_at_an_alarm_and_without_main_power(
    event: str, args: dict[str, int], alarm: str, code: int
) -> None:
    """Rule: servo-on-command."""
    master = mover(motor_power_alarm="1.4")
    master.robot.inject(event, **args)
    master.run(50)
    assert master.execute(code) == abnormal_end(alarm)
