"""Single remote commands have their effects, and illegal ones are refused."""

from __future__ import annotations

from typing import Any

import pytest

from movements import low_high
from rcx_harness.robot import Axis, Pallet, Point
from robot_master import Master, abnormal_end, powered_up, servos_on

FORMAT_ERROR = (0x4000, 0x0004, 0x0002)
FAR = Point((100000, 200000, 0, 0, 0, 0))


def _mover(**config: Any) -> Master:
    return servos_on(**{"points": {19: FAR}, **config})


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
    """If unused words are tolerated, fixed bits are still checked. Rule: format."""
    master = _mover(strict_unused_words=False)
    assert master.execute(0x0501, 0xFFFF)[0] == 0x0200
    assert master.execute(0x0001, 0x0008, 0, 0, 19)[:3] == FORMAT_ERROR


def test_a_key_sets_the_format_alarm() -> None:
    """Rule: format."""
    master = _mover(format_alarm="4.99")
    assert master.execute(0x0501, 1)[:3] == (0x4000, 4, 99)


def test_move_moves_only_the_designated_axes() -> None:
    """Source: remote command guide 4.2.1, a and tt."""
    master = _mover()
    assert master.execute(0x0001, 0x0001, 0x0002, 0, 19)[0] == 0x0200
    assert master.robot.positions == [0, 200000, 0, 0]


def test_move_reaches_a_point_in_millimetres() -> None:
    """10.000 mm at 2000 pulses/mm are 20000 pulses. The answer is in millimetres.

    Rule: millimetres.
    """
    axes = (Axis(pulses_per_mm=2000), Axis())
    master = _mover(axes=axes, points={19: Point((10000, -1, 0, 0, 0, 0), mm=True)})
    answer = master.execute(0x0001, 0x8000, 0, 0, 19)
    assert master.robot.positions == [20000, -1]
    assert answer[4:8] == (0x2710, 0x0000, 0xFFFF, 0xFFFF)


def test_a_position_beyond_32_bits_is_shown_as_the_limit() -> None:
    """Rule: millimetres."""
    master = powered_up(axes=(Axis(pulses_per_mm=0.0001), Axis(pulses_per_mm=0.0001)))
    master.robot.positions[:] = [1000, -1000]
    assert master.execute(0x0506)[4:8] == (0xFFFF, 0x7FFF, 0x0000, 0x8000)


def test_a_key_decides_whether_positions_that_were_not_requested_are_0() -> None:
    """Rule: unasked-positions."""
    assert _mover().execute(0x0001, 0, 0, 0, 19)[4] == 0
    shown = _mover(unasked_positions_zero=False).execute(0x0001, 0, 0, 0, 19)
    assert shown[4:6] == (0x86A0, 0x0001)


_BEYOND = low_high(1_000_001)


@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0x0001, 0, 0, 0, 21), id="MOVE"),
        pytest.param((0x0002, 0, 0x0400, 0, 20, 0, 0, 0, *_BEYOND), id="arch position"),
        pytest.param((0x0009, 0, 0, 0, 21), id="MOVEI"),
        pytest.param((0x0013, 1, 0x0004, 0, *_BEYOND), id="DRIVE"),
        pytest.param((0x0017, 1, 0x0004, 0, *_BEYOND), id="DRIVEI"),
        pytest.param((0x0018, 0, 0, 0, 7, 2), id="pallet"),
        pytest.param((0x0044, 0, 0, 0, 21), id="MOVET, PTP"),
        pytest.param((0x0045, 0, 0, 0, 21), id="MOVET, linear"),
        pytest.param((0x004D, 1, 0x0004, 0, *_BEYOND), id="PUSH"),
    ],
)
def test_a_target_beyond_the_soft_limit_ends_in_2_334(words: tuple[int, ...]) -> None:
    """The robot does not move.

    Rule: soft-limit.
    Source: remote command guide chapter 1, 1.1, example 0x0002 / 0x014E
    """
    points = {number: Point((0, 10, 0, 0, 0, 0)) for number in (20, 22, 23, 24, 25, 26)}
    points[21] = points[23] = Point((0, 1_000_001, 0, 0, 0, 0), mm=False)
    master = _mover(points=points, pallets={7: Pallet(2, 1, 1, first=22)})
    assert master.execute(*words) == (0x4000, 0x0002, 0x014E, *(0,) * 13)
    assert master.robot.positions == [0, 0, 0, 0]


@pytest.mark.parametrize(
    ("what", "alarm"), [("SI06", "12.400"), ("SI00", "12.600"), ("servos off", "6.6")]
)
@pytest.mark.parametrize(
    "words",
    [
        pytest.param((0x0001, 0, 0, 0, 19), id="MOVE"),
        pytest.param((0x0020, 0x4000, 0x0001), id="jog in pulses"),
        pytest.param((0x0021, 0x4000, 0x0001), id="Cartesian jog"),
        pytest.param((0x0022, 0x4000, 0x0001), id="tool jog"),
    ],
)
def test_a_movement_does_not_start_in_a_stop_or_with_the_servos_off(
    words: tuple[int, ...], what: str, alarm: str
) -> None:
    """The commands end in an alarm.

    The answer contains no position, because no movement was in progress.

    Rule: stop-alarm, other-alarms, jog-refused.
    Source: manual chapter 4, 4
    """
    master = _mover(servo_off_alarm="6.6")
    if what == "servos off":
        master.execute(0x0035)
    else:
        master.turn_and_wait(what, False)
    assert master.execute(*words) == abnormal_end(alarm)
    assert master.robot.positions == [0, 0, 0, 0]


@pytest.mark.parametrize(
    ("config", "alarm"), [({"undefined_point_alarm": "6.5"}, "6.5"), ({}, "6.204")]
)
@pytest.mark.parametrize("code", [0x001, 0x009, 0x00A, 0x010, 0x014, 0x044, 0x045, 0x04B, 0x101])
def test_a_movement_to_a_point_that_is_not_defined_is_refused(
    code: int, config: dict[str, Any], alarm: str
) -> None:
    """MOVE, MOVEI, DRIVE, DRIVEI, MOVET, PUSH and the point reference refuse an undefined point.

    Rule: other-alarms.
    """
    one_axis = (1, 0x0004) if code in (0x010, 0x014, 0x04B) else (0, 0)
    words = (0, 20) if code == 0x101 else (*one_axis, 0, 20)
    assert _mover(**config).execute(code, *words) == abnormal_end(alarm)


def test_a_movement_during_a_program_or_a_return_to_origin_is_accepted_or_refused() -> None:
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


def test_a_key_decides_bit_0_of_the_point_flag() -> None:
    """Rule: flag-bit-0."""
    master = powered_up(position_flag_bit0=False)
    assert master.execute(0x0506)[3] == 0


def test_versions_show_0_for_drivers_that_are_not_there() -> None:
    """Rule: versions."""
    master = powered_up(axes=(Axis(), Axis()), driver_version=0x0203)
    assert master.execute(0x0501)[5:9] == (0x0203, 0x0203, 0, 0)


def test_versions_have_four_drivers_however_many_axes_there_are() -> None:
    """The answer has the versions of four drivers in words m+10 to m+16.

    The words from m+18 on are not used.

    Source: remote command guide 4.7.1.
    """
    master = powered_up(axes=(Axis(), Axis(), Axis(), Axis(), Axis()))
    assert master.execute(0x0501)[5:] == (0x0101, 0x0101, 0x0101, 0x0101, *(0,) * 7)
