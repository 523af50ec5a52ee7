"""What the single remote commands do, and what they refuse."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis, Point
from robot_master import Master

FORMAT_ERROR = (0x4000, 0x0004, 0x0002)
FAR = Point((100000, 200000, 0, 0, 0, 0))


def _mover(**config: Any) -> Master:
    master = Master(**{"points": {19: FAR}, **config})
    master.servo_on()
    return master


@pytest.mark.parametrize(
    "data",
    [
        pytest.param((0x0008, 0, 0, 19), id="flag bit 3 is fixed 0"),
        pytest.param((0x0010, 0, 0, 19), id="flag bit 4 is fixed 0"),
        pytest.param((0x0080, 0, 0, 19), id="flag bit 7 is fixed 0"),
        pytest.param((0x2000, 0, 0, 19), id="flag bit 13 is fixed 0"),
        pytest.param((0x0006, 0, 50, 19), id="speed flag 11 has no meaning"),
        pytest.param((0x0004, 0, 0, 19), id="speed 0 %"),
        pytest.param((0x0004, 0, 101, 19), id="speed 101 %"),
        pytest.param((0x0002, 0, 0, 19), id="direct speed 0"),
        pytest.param((0x0002, 0, 10001, 19), id="direct speed 100.01 %"),
        pytest.param((0x0001, 0, 0, 19), id="axis flag without an axis"),
        pytest.param((0x0001, 0x0041, 0, 19), id="axis bit 6 is fixed 0"),
        pytest.param((0, 0, 0, 30000), id="point 30000"),
        pytest.param((0, 0, 0, 19, 1), id="n+10 is not used"),
        pytest.param((0, 0, 0, 19, 0, 0, 0, 0, 0, 0, 0, 1), id="n+24 is not used"),
        pytest.param((0x0020, 0, 0, 19), id="acceleration 0"),
        pytest.param((0x0020, 0, 0, 19, 0, 0, 0, 0, 0, 101), id="acceleration 101 %"),
        pytest.param((0x0040, 0, 0, 19, 0, 0, 0, 0, 0, 0, 101), id="deceleration 101 %"),
        pytest.param((0xC000, 0, 0, 19), id="both position outputs"),
    ],
)
def test_move_with_a_wrong_telegram_ends_in_input_format_error(data: tuple[int, ...]) -> None:
    """Rule: format, both-outputs.

    Source: remote command guide 4.2.1, PTP designation
    """
    master = _mover()
    assert master.execute(0x0001, *data)[:3] == FORMAT_ERROR
    assert master.robot.positions == [0, 0, 0, 0]


@pytest.mark.parametrize(
    "data",
    [
        pytest.param((0x0004, 0, 1, 19), id="speed 1 %"),
        pytest.param((0x0004, 0, 100, 19), id="speed 100 %"),
        pytest.param((0x0002, 0, 10000, 19), id="direct speed 100 %"),
        pytest.param((0, 0, 0, 0), id="point 0"),
        pytest.param((0, 0, 0, 29999), id="point 29999"),
        pytest.param((0x0060, 0, 0, 19, 0, 0, 0, 0, 0, 1, 100), id="acceleration 1 and 100 %"),
    ],
)
def test_move_takes_the_limits_of_every_range(data: tuple[int, ...]) -> None:
    """Source: remote command guide 4.2.1, PTP designation."""
    near = Point((10, 0, 0, 0, 0, 0))
    master = _mover(points={0: near, 19: near, 29999: near})
    assert master.execute(0x0001, *data)[0] == 0x0200
    assert master.robot.positions == [10, 0, 0, 0]


def test_unused_words_may_be_tolerated() -> None:
    """Fixed bits are still checked.

    Rule: format.
    """
    master = _mover(strict_unused_words=False)
    assert master.execute(0x0501, 0xFFFF)[0] == 0x0200
    assert master.execute(0x0001, 0x0008, 0, 0, 19)[:3] == FORMAT_ERROR


def test_the_format_alarm_is_a_knob() -> None:
    """Rule: format."""
    master = _mover(format_alarm="4.99")
    assert master.execute(0x0501, 1)[:3] == (0x4000, 4, 99)


def test_move_only_the_designated_axes() -> None:
    """Source: remote command guide 4.2.1, a and tt."""
    master = _mover()
    assert master.execute(0x0001, 0x0001, 0x0002, 0, 19)[0] == 0x0200
    assert master.robot.positions == [0, 200000, 0, 0]


def test_an_axis_that_is_not_there_cannot_be_moved() -> None:
    """Rule: other-alarms."""
    master = _mover(no_axis_alarm="6.4")
    assert master.execute(0x0001, 0x0001, 0x0010, 0, 19)[:3] == (0x4000, 6, 4)


def test_each_robot_has_its_own_axes() -> None:
    """Source: remote command guide 4.2.1, R."""
    axes = (Axis(), Axis(robot=2), Axis(robot=2))
    master = _mover(axes=axes)
    assert master.execute(0x2001, 0x4000, 0, 0, 19)[4:8] == (0x86A0, 0x0001, 0x0D40, 0x0003)
    assert master.robot.positions == [0, 100000, 200000]


def test_move_to_a_point_in_millimetres() -> None:
    """10.000 mm at 2000 pulses/mm are 20000 pulses; the answer is in millimetres.

    Rule: millimetres.
    """
    axes = (Axis(pulses_per_mm=2000), Axis())
    master = _mover(axes=axes, points={19: Point((10000, -1, 0, 0, 0, 0), mm=True)})
    answer = master.execute(0x0001, 0x8000, 0, 0, 19)
    assert master.robot.positions == [20000, -1]
    assert answer[4:8] == (0x2710, 0x0000, 0xFFFF, 0xFFFF)


def test_a_position_that_does_not_fit_into_32_bits_is_cut_off() -> None:
    """Rule: millimetres."""
    master = Master(axes=(Axis(pulses_per_mm=0.0001), Axis(pulses_per_mm=0.0001)))
    master.power_up()
    master.robot.positions[:] = [1000, -1000]
    assert master.execute(0x0506)[4:8] == (0xFFFF, 0x7FFF, 0x0000, 0x8000)


def test_positions_are_0_where_they_were_not_asked_for() -> None:
    """Rule: unasked-positions."""
    assert _mover().execute(0x0001, 0, 0, 0, 19)[4] == 0
    shown = _mover(unasked_positions_zero=False).execute(0x0001, 0, 0, 0, 19)
    assert shown[4:6] == (0x86A0, 0x0001)


def test_a_target_beyond_the_soft_limit_ends_in_2_334() -> None:
    """Nothing moves.

    Rule: soft-limit.
    Source: remote command guide chapter 1, 1.1, example 0x0002 / 0x014E
    """
    master = _mover(axes=(Axis(), Axis(soft_high=199999)))
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 0x0002, 0x014E)
    assert master.robot.positions == [0, 0]


def test_an_emergency_stop_interrupts_a_movement_with_12_600() -> None:
    """The axes stand where they were.

    Rule: stop-in-motion, halt.
    Source: remote command guide chapter 1, 1.2, code 0x4000
    """
    master = _mover()
    master.send(0x0001, 0x0004, 0, 10, 19)
    master.run(200)
    master.turn_and_wait("SI00", False, 5)
    assert master.words == (0x4000, 0x000C, 0x0258) + (0,) * 13
    stopped_at = list(master.robot.positions)
    assert 0 < stopped_at[0] < 100000
    master.run(500)
    assert master.robot.positions == stopped_at


def test_the_stop_input_interrupts_a_movement_with_12_400() -> None:
    """Rule: stop-alarm, halt.

    Source: manual chapter 4, 4
    """
    master = _mover()
    master.send(0x0001, 0x0004, 0, 10, 19)
    master.run(200)
    master.turn_and_wait("SI06", False, 5)
    assert master.words[:3] == (0x4000, 0x000C, 0x0190)
    assert not master.on("SO03")
    assert master.on("SO02")


def test_a_movement_attempted_in_the_stop_status_ends_in_12_400() -> None:
    """Rule: stop-alarm.

    Source: manual chapter 4, 4
    """
    master = _mover()
    master.turn_and_wait("SI06", False)
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 0x000C, 0x0190)


def test_a_movement_attempted_in_emergency_stop_ends_in_12_600() -> None:
    """Source: manual chapter 4, 4."""
    master = _mover()
    master.turn_and_wait("SI00", False)
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 0x000C, 0x0258)


@pytest.mark.parametrize(
    ("config", "point", "expected"),
    [
        ({"undefined_point_alarm": "6.5"}, 20, (0x4000, 6, 5)),
        ({}, 20, (0x4000, 6, 204)),
    ],
)
def test_a_point_that_is_not_defined(
    config: dict[str, Any], point: int, expected: tuple[int, ...]
) -> None:
    """Rule: other-alarms."""
    master = _mover(**config)
    assert master.execute(0x0001, 0, 0, 0, point)[:3] == expected
    assert master.execute(0x0101, 0, point)[:3] == expected


def test_a_movement_with_the_servos_off() -> None:
    """Rule: other-alarms."""
    master = Master(points={19: FAR}, servo_off_alarm="6.6")
    master.power_up()
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 6, 6)


def test_a_movement_beside_the_program_or_a_return_to_origin() -> None:
    """Rule: movement-beside."""
    master = _mover()
    master.pulse("SI12")
    assert master.execute(0x0001, 0, 0, 0, 19)[0] == 0x0200
    master = _mover(motion_during_program=False, busy_alarm="6.7")
    master.pulse("SI12")
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 6, 7)
    master = _mover(moving_alarm="6.8")
    master.turn_and_wait("SI14", True, 100)
    assert master.execute(0x0001, 0, 0, 0, 19)[:3] == (0x4000, 6, 8)


@pytest.mark.parametrize(("knob", "alarm"), [(False, False), (True, True)])
def test_an_alarm_that_ends_a_command_goes_into_the_history(knob: bool, alarm: bool) -> None:
    """Rule: command-alarms."""
    master = _mover(command_alarm_is_serious=knob)
    master.execute(0x0001, 0xC000, 0, 0, 19)
    assert master.on("SO03") is alarm
    assert [one.number for one in master.robot.alarms.history] == ["4.2"]


def test_a_point_keeps_unit_hand_and_arm_rotation() -> None:
    """Left-handed, arm 1 = -1, arm 2 = 1, in millimetres: flag 1 + 2*2 + 15*8 + 1*128.

    Source: remote command guide 4.3.1
    """
    master = Master()
    master.power_up()
    flag = 0x0001 | 0x0004 | 0x0078 | 0x0080
    assert master.execute(0x0100, flag, 5, 0, 0x0001, 0x0000, 0xFFFF, 0xFFFF)[0] == 0x0200
    expected = Point((1, -1, 0, 0, 0, 0), mm=True, hand=2, arm1=-1, arm2=1)
    assert master.robot.points[5] == expected
    assert master.execute(0x0101, 0, 5)[:8] == (0x0200, 0, 5, flag, 1, 0, 0xFFFF, 0xFFFF)


def test_other_hands_and_rotations_mean_none_and_in_pulses_they_do_not_count() -> None:
    """Source: remote command guide 4.3.1, tt, xr and yr."""
    master = Master()
    master.power_up()
    master.execute(0x0100, 0x0001 | 0x0006 | 2 << 3 | 14 << 7, 5)
    assert master.robot.points[5] == Point(mm=True)
    master.execute(0x0100, 0x0002 | 1 << 3 | 1 << 7, 6)
    assert master.robot.points[6] == Point()


@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0x0100, 0x0800, 1), id="flag bit 11 is fixed 0"),
        pytest.param((0x0100, 0, 30000), id="point 30000"),
        pytest.param((0x0100, 0, 1, 1), id="n+6 is not used"),
        pytest.param((0x0101, 1, 1), id="n+2 is not used"),
        pytest.param((0x0101, 0, 30000), id="reference of point 30000"),
        pytest.param((0x0501, 0, 1), id="version: n+4 is not used"),
        pytest.param((0x0505, 2), id="position: flag bit 1 is not used"),
        pytest.param((0x0506, 0, 1), id="position: n+4 is not used"),
        pytest.param((0x0604, 1), id="alarm reset: n+2 is not used"),
    ],
)
def test_a_telegram_with_more_than_its_fields_ends_in_input_format_error(
    words: tuple[int, ...],
) -> None:
    """Rule: format."""
    master = Master()
    master.power_up()
    assert master.execute(*words)[:3] == FORMAT_ERROR


def test_bit_0_of_the_point_flag_is_a_knob() -> None:
    """Rule: flag-bit-0."""
    master = Master(position_flag_bit0=False)
    master.power_up()
    assert master.execute(0x0506)[3] == 0


def test_versions_show_0_for_drivers_that_are_not_there() -> None:
    """Rule: versions."""
    master = Master(axes=(Axis(), Axis()), driver_version=0x0203)
    master.power_up()
    assert master.execute(0x0501)[5:9] == (0x0203, 0x0203, 0, 0)


def test_versions_have_four_drivers_however_many_axes_there_are() -> None:
    """Words m+10 to m+16; from m+18 on nothing is used.

    Source: remote command guide 4.7.1
    """
    master = Master(axes=(Axis(), Axis(), Axis(), Axis(), Axis()))
    master.power_up()
    assert master.execute(0x0501)[5:] == (0x0101, 0x0101, 0x0101, 0x0101, *(0,) * 7)


def test_the_alarm_reset_command_clears_the_alarm() -> None:
    """Source: remote command guide 4.8.3."""
    master = _mover()
    master.turn_and_wait("SI00", False)
    master.turn_and_wait("SI00", True)
    assert master.on("SO03")
    assert master.execute(0x0604)[0] == 0x0200
    assert not master.on("SO03")


def test_the_alarm_reset_command_names_an_alarm_that_stays() -> None:
    """Rule: reset-command."""
    master = _mover()
    master.turn_and_wait("SI00", False)
    assert master.execute(0x0604)[:3] == (0x4000, 0x000C, 0x0258)
    assert master.on("SO03")
