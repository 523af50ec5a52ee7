"""Commands of category 6 read data of the controller and data that other commands have set."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, abnormal_end, answer_of, powered_up

PULSES, MM, DESIGNATION, ARM = 0x505, 0x506, 0x50B, 0x50C
OF_MAX, OF_RATED, SLOTS = 0x510, 0x516, 0x513
ROBOT_2 = 0x2000
NO_AXIS = 9

TWO_ROBOTS = (Axis(), Axis(), Axis(robot=2, robot_type=5000), Axis(robot=2, robot_type=5001))


def _data(*words: int) -> tuple[int, ...]:
    """Return the response words from m+2 on: 0, the given words, then zeros up to the end."""
    return (0, *words, *(0,) * (14 - len(words)))


# System configuration


def test_each_robot_has_its_own_configuration() -> None:
    """The type of a robot is that of its first axis.

    Rule: robot-type.
    Source: remote command guide 4.7.2
    """
    master = powered_up(axes=TWO_ROBOTS)
    assert answer_of(master, 0x1502) == _data(2000, 0, 2000, 2000)
    assert answer_of(master, 0x2502) == _data(5000, 0, 5000, 5001)


# Servos


# Current position


@pytest.mark.parametrize(("arm", "flag"), [(0, 0b011), (1, 0b101)])
def test_the_position_shows_the_hand_system_if_it_is_configured(arm: int, flag: int) -> None:
    """01 means right-handed, 10 left-handed. Bit 0 is as in the printed example.

    Rule: position-hand.
    Source: remote command guide 4.7.4
    """
    master = powered_up(position_hand=True, scara_robots=(1,), axes=TWO_ROBOTS)
    for robot in (1, 2):
        master.robot.machine.settings.of(robot).arm_status = arm
    assert answer_of(master, 0x1506)[2] == flag
    assert answer_of(master, 0x2506)[2] == 1
    assert answer_of(powered_up(), 0x0506)[2] == 1


@pytest.mark.parametrize("code", [PULSES, MM])
def test_continuous_output_goes_on_in_an_alarm_and_has_no_end_status(code: int) -> None:
    """The position is sent in every cycle with status 0x0100.

    The status reset command leads to 0x0000.

    Rule: continuous, continuous-details.
    Source: remote command guide 4.7.4
    """
    master = powered_up()
    master.send(code, 1)
    master.run(20)
    master.turn("SI00", False)
    seen = []
    for pulses in range(5):
        master.robot.positions[1] = pulses
        master.run(5)
        seen.append((master.status, master.words[6]))
    assert master.on("SO03")
    assert seen == [(0x0100, pulses) for pulses in range(5)]
    master.send()
    master.run(5)
    assert master.words == (0,) * 16


# Speeds, arm designation, inching amount


def test_speeds_are_read_back_as_they_were_set_for_each_robot() -> None:
    """The automatic speed is at m+4, the manual speed at m+6, the program speed at m+8.

    Rule: references.
    Source: remote command guide 4.7.8
    """
    master = powered_up(axes=TWO_ROBOTS, auto_speed=1, manual_speed=2, program_speed=3)
    for code, percent in ((0x039, 11), (0x038, 12), (0x03A, 13)):
        master.execute(ROBOT_2 | code, 0, percent)
    assert answer_of(master, 0x150A) == _data(1, 2, 3)
    assert answer_of(master, 0x250A) == _data(11, 12, 13)


def test_the_examples_show_the_left_handed_system() -> None:
    """The arm status follows with the next movement. Source: remote command guide 4.7.9, 4.7.10."""
    master = powered_up()
    assert answer_of(master, 0x050B) == answer_of(master, 0x050C) == _data(0)
    assert master.execute(0x03D, 0, 1) == NORMAL_END
    assert answer_of(master, 0x050B) == _data(1)
    assert answer_of(master, 0x050C) == _data(0)
    master.pulse("SI01")
    assert master.execute(0x001, 4, 0, 50, 100)[0] == 0x0200
    assert answer_of(master, 0x050C) == _data(1)


@pytest.mark.parametrize("code", [DESIGNATION, ARM])
def test_a_robot_other_than_a_scara_robot_shows_9(code: int) -> None:
    """Source: remote command guide 4.7.9, 4.7.10."""
    master = powered_up(axes=TWO_ROBOTS, scara_robots=(2,))
    assert answer_of(master, code) == _data(9)
    assert answer_of(master, ROBOT_2 | code) == _data(0)


# Origins


def test_the_example_shows_the_origins_of_robot_1() -> None:
    """Motor type 0, and every value without a meaning, select axes of all types.

    Source: remote command guide 4.7.11
    """
    master = powered_up()
    master.robot.origins[2] = False
    assert answer_of(master, 0x150F) == _data(1, 1, 0, 1, NO_AXIS, NO_AXIS)
    for pattern in (0, 3, 4, 5, 6, 7):
        assert answer_of(master, 0x150F, 0, pattern) == _data(1, 1, 0, 1, NO_AXIS, NO_AXIS)


def test_robot_0_is_the_entire_system() -> None:
    """For robot 0, m+4 has a single state for all robots.

    The motor type only has an effect for robots 1 to 4.

    Rule: origin-system.
    Source: remote command guide 4.7.11
    """
    axes = (Axis(), Axis(robot=2, type="incremental"))
    master = powered_up(axes=axes)
    assert answer_of(master, 0x050F) == _data(1)
    master.robot.origins[1] = False
    assert answer_of(master, 0x050F) == _data(0)
    assert answer_of(master, 0x050F, 0, 2) == _data(0)
    assert answer_of(master, 0x150F) == _data(1, *(NO_AXIS,) * 5)
    assert answer_of(master, 0x250F) == _data(0, *(NO_AXIS,) * 5)


def test_the_origin_status_of_axes_of_other_motor_types_is_not_applicable() -> None:
    """Rule: origin-types-read. Source: remote command guide 4.7.11."""
    axes = (Axis(), Axis(type="incremental"), Axis(type="semi_absolute"), Axis())
    master = powered_up(axes=axes)
    master.robot.origins[0] = False
    assert answer_of(master, 0x150F, 0, 1) == _data(9, 1, 1, 9, 9, 9)
    assert answer_of(master, 0x150F, 0, 2) == _data(0, 9, 9, 1, 9, 9)
    assert master.execute(0x150F, 0, 8) == abnormal_end("4.2")


# Torques


def test_the_examples_show_the_torque_of_axis_3_alone() -> None:
    """Axis 3 has 20 % of the maximum, which is 100 % of the rated torque.

    Axes that were not requested show 0.

    Rule: torque-model.
    Source: remote command guide 4.7.12, 4.7.18
    """
    axes = tuple(Axis(holding_torque=20) for _ in range(4))
    master = powered_up(axes=axes)
    assert answer_of(master, 0x0510, 0, 4) == _data(0)
    master.pulse("SI01")
    assert answer_of(master, 0x0510, 0, 4) == _data(0, 0, 0x14)
    assert answer_of(master, 0x0516, 0, 4) == _data(0, 0, 0x64)
    assert answer_of(master, 0x0510) == _data(20, 20, 20, 20)
    assert answer_of(master, 0x0516, 0, 0b1001) == _data(100, 0, 0, 100)


def test_a_moving_axis_needs_torque_in_its_direction() -> None:
    """A moving axis shows its holding torque, plus the moving torque in its direction.

    The moving torque is 10 % of the maximum. Axis 1 holds -5 % and has a rated torque of 10 %, axis
    2 holds 0 % and has a rated torque of 20 %.

    Rule: torque-model.
    Source: remote command guide 4.7.12, 4.7.18
    """
    master = powered_up(axes=(Axis(holding_torque=-5, rated_torque=10), Axis()))
    master.pulse("SI01")
    torques = master.robot.machine.data.torques
    master.send(0x0001, 4, 0, 1, 19)  # to point 19: axis 1 plus, axis 2 minus
    master.run(50)
    assert [torques.of_max(axis) for axis in (0, 1)] == [5, -10]
    assert [torques.of_rated(axis) for axis in (0, 1)] == [50, -50]
    master.turn_and_wait("SI06", False)
    assert [torques.of_max(axis) for axis in (0, 1)] == [-5, 0]


def test_a_negative_torque_is_shown_with_its_sign() -> None:
    """A torque of -5 is shown as 0xFFFB. Source: remote command guide 4.7.12."""
    master = powered_up(axes=(Axis(holding_torque=-5),))
    master.pulse("SI01")
    assert answer_of(master, 0x0510) == _data(0xFFFB)
    assert answer_of(master, 0x0516) == _data(0xFFE7)


def test_the_shown_torque_does_not_exceed_the_max_torque() -> None:
    """The limit applies from the next movement on. Rule: torque-model."""
    master = powered_up(axes=(Axis(holding_torque=90),))
    master.pulse("SI01")
    assert answer_of(master, 0x0510) == _data(90)
    assert master.execute(0x048, 0, 1, 30) == NORMAL_END
    assert answer_of(master, 0x0510) == _data(90)
    master.execute(0x001, 4, 0, 100, 19)
    assert answer_of(master, 0x0510) == _data(30)


@pytest.mark.parametrize("code", [OF_MAX, OF_RATED])
def test_the_torque_is_0_for_axes_that_are_not_connected(code: int) -> None:
    """Source: remote command guide 4.7.12, 4.7.18."""
    master = powered_up(no_axis_alarm="9.7")
    assert answer_of(master, code, 0, 0b10000) == _data(0, 0, 0, 0, 0, 0)


# Option slots


def test_the_example_shows_the_option_slots_of_controller_1() -> None:
    """Slot 1 has the EtherNet/IP unit, slot 2 the DIO unit.

    Rule: option-slots.
    Source: remote command guide 4.7.15
    """
    assert answer_of(powered_up(), 0x0513, 0, 1) == _data(0x0401, 0x0100)
    master = powered_up(option_slots=(0x0300, 0, 0x0900, 0x0401), ivy2_unit=0x0802)
    assert answer_of(master, 0x0513, 0, 1) == _data(0x0300, 0, 0x0900, 0x0401, 0x0802)


def test_controllers_are_numbered_1_to_4_and_there_is_one() -> None:
    """Rule: option-slots. Source: remote command guide 4.7.15."""
    master = powered_up(absent_controller_alarm="9.8")
    for number in (2, 3, 4):
        assert master.execute(SLOTS, 0, number) == abnormal_end("9.8")
    for number in (0, 5):
        assert master.execute(SLOTS, 0, number) == abnormal_end("4.2")
