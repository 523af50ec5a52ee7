"""The absolute reset and the return-to-origin commands."""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis
from robot_master import NORMAL_END, Master, abnormal_end, servos_on

MOVE, RESET, ROBOT, AXIS = 0x0030, 0x0031, 0x0032, 0x0033
#: Axis data with which a quarter rotation of the motor is 1000 pulses.
MARK = Axis(origin_method="mark", motor_rotation=4000, start=1300)
ABSOLUTE, INCREMENTAL = Axis(start=700), Axis(start=700, type="incremental")
SEMI = Axis(start=700, type="semi_absolute")


def _master(*axes: Axis, **config: Any) -> Master:
    """Return a master with servos on. A return-to-origin takes 200 ms for each group of axes."""
    return servos_on(axes=axes, origin_time=200, **config)


# Tests of the absolute reset movement


@pytest.mark.parametrize(
    ("start", "direction", "end"),
    [
        (1300, "+", 2000),
        (1300, "-", 1000),
        (-1300, "+", -1000),
        (-1300, "-", -2000),
        (3000, "+", 3000),
        (3000, "-", 3000),
        (0, "-", 0),
    ],
)
def test_the_axis_moves_to_the_nearest_position_where_absolute_reset_can_be_executed(
    start: int, direction: str, end: int
) -> None:
    """Positions are at every 1/4 rotation of the motor.

    An axis at such a position does not move.

    Rule: absolute-reset, absolute-reset-model.
    Source: remote command guide 4.2.10
    """
    master = _master(ABSOLUTE, MARK)
    master.robot.positions[1] = start
    axis_2 = 0x0082 if direction == "-" else 0x0002
    assert master.execute(MOVE, 0, axis_2) == NORMAL_END
    assert master.robot.positions == [700, end]


def test_a_motor_has_16384_pulses_per_rotation_unless_the_robot_file_says_otherwise() -> None:
    """A quarter of a rotation is 4096 pulses. Rule: absolute-reset-model."""
    master = _master(Axis(origin_method="mark", start=1))
    assert master.execute(MOVE, 0, 0x0001) == NORMAL_END
    assert master.robot.positions == [4096]


def test_the_movement_is_made_at_manual_speed() -> None:
    """The axis moves from 4999 to 0 pulses at 50 % of 10 000 pulses/s, with 500 000 pulses/s^2.

    Acceleration and braking take 10 ms and 25 pulses each. The other 4949 pulses take 989.8 ms at
    5000 pulses/s. The movement ends in the cycle at 1010 ms; one more cycle accepts the command.

    Rule: absolute-reset-model.
    """
    axis = Axis(
        origin_method="mark",
        motor_rotation=20_000,
        max_speed=10_000.0,
        max_acceleration=500_000.0,
        start=4999,
    )
    master = _master(axis, manual_speed=50)
    master.send(MOVE, 0, 0x0081)
    start = master.now_us
    assert master.finish() == NORMAL_END
    assert master.now_us - start == 1_015_000
    assert master.robot.positions == [0]


# Tests of the absolute reset


def test_the_printed_example_resets_axis_2_of_robot_1() -> None:
    """The absolute reset of the printed example works after the movement of the previous example.

    Rule: absolute-reset, absolute-reset-model.
    Source: remote command guide 4.2.11
    """
    master = _master(ABSOLUTE, MARK, origin_complete=False)
    assert master.execute(MOVE, 0, 0x0082) == NORMAL_END
    assert master.execute(RESET, 0, 0x0002) == NORMAL_END
    assert master.robot.origins == [False, True]
    assert master.robot.positions == [700, 0]


def test_the_axis_must_be_at_a_position_where_absolute_reset_is_possible() -> None:
    """Rule: absolute-reset, absolute-reset-model. Source: remote command guide 4.2.11."""
    master = _master(MARK, origin_complete=False, absolute_reset_alarm="1.1")
    assert master.execute(RESET, 0, 0x0001) == abnormal_end("1.1")
    assert master.robot.origins == [False]
    assert master.robot.positions == [1300]


@pytest.mark.parametrize("code", [MOVE, RESET])
def test_absolute_reset_and_its_movement_are_for_mark_type_axes_only(code: int) -> None:
    """Rule: absolute-reset-model. Source: remote command guide 4.2.10, 4.2.11."""
    master = _master(ABSOLUTE, origin_complete=False, origin_method_alarm="1.3")
    assert master.execute(code, 0, 0x0001) == abnormal_end("1.3")
    assert (master.robot.origins, master.robot.positions) == ([False], [700])


@pytest.mark.parametrize("code", [MOVE, RESET, AXIS])
def test_the_axis_is_one_of_the_designated_robot(code: int) -> None:
    """Source: remote command guide 4.2.10 to 4.2.12, R and tt."""
    master = _master(MARK, MARK, Axis(robot=2), no_axis_alarm="1.6", origin_method_alarm="1.3")
    assert master.execute(code, 0, 0x0004) == abnormal_end("1.6")
    assert master.execute(code | 0x2000, 0, 0x0002) == abnormal_end("1.6")
    if code != AXIS:
        assert master.execute(code | 0x2000, 0, 0x0001) == abnormal_end("1.3")


# Tests of the return-to-origin in robot units


@pytest.mark.parametrize(
    ("flags", "positions", "complete"),
    [
        pytest.param(0x0000, [0, 0, 700], [True, True, True], id="all axes"),
        pytest.param(0x0002, [700, 0, 700], [False, True, True], id="incremental type axes"),
        pytest.param(0x0004, [0, 700, 700], [True, False, False], id="absolute type axes"),
    ],
)
def test_a_return_to_origin_in_robot_units_moves_the_axes_of_the_selected_types(
    flags: int, positions: list[int], complete: list[bool]
) -> None:
    """A semi-absolute axis searches its origin near its position, with the incremental axes.

    Rule: origin-command, origin-command-axes.
    Source: remote command guide 4.2.12, robot units
    """
    master = _master(ABSOLUTE, INCREMENTAL, SEMI, origin_complete=False)
    assert master.execute(ROBOT, flags) == NORMAL_END
    assert master.robot.positions == positions
    assert master.robot.origins == complete


def test_semi_absolute_axes_belong_to_neither_type_if_the_robot_file_says_so() -> None:
    """Rule: origin-command-axes."""
    master = _master(INCREMENTAL, SEMI, origin_complete=False, semi_absolute_is_incremental=False)
    assert master.execute(ROBOT, 0x0002) == NORMAL_END
    assert master.robot.origins == [True, False]


def test_the_incomplete_flag_moves_only_the_axes_without_origin() -> None:
    """Rule: origin-command. Source: remote command guide 4.2.12, robot units, c."""
    master = _master(ABSOLUTE, ABSOLUTE, INCREMENTAL, INCREMENTAL)
    master.robot.origins[:] = [True, False, False, True]
    assert master.execute(ROBOT, 0x0008) == NORMAL_END
    assert master.robot.positions == [700, 0, 0, 700]
    assert master.robot.origins == [True, True, True, True]


@pytest.mark.parametrize(
    ("code", "positions"),
    [(0x0032, [0, 0, 0]), (0x1032, [0, 700, 700]), (0x2032, [700, 0, 700])],
)
def test_robot_0_returns_all_robots_to_their_origin(code: int, positions: list[int]) -> None:
    """Rule: origin-command. Source: remote command guide 4.2.12, robot units, R."""
    axes = [Axis(start=700, robot=robot) for robot in (1, 2, 3)]
    master = _master(*axes)
    assert master.execute(code) == NORMAL_END
    assert master.robot.positions == positions


def test_absolute_axes_return_first_then_the_others() -> None:
    """The absolute axes take 200 ms, then the other axes take 200 ms.

    One more cycle accepts the command.

    Rule: origin-command-axes.
    """
    master = _master(INCREMENTAL, ABSOLUTE)
    master.send(ROBOT)
    master.run(205)
    assert (master.status, master.robot.positions) == (0x0100, [700, 0])
    master.run(200)
    assert (master.status, master.robot.positions) == (0x0200, [0, 0])


def test_with_no_axis_to_move_the_command_ends_normally() -> None:
    """Rule: origin-command-axes."""
    master = _master(ABSOLUTE)
    assert master.execute(ROBOT, 0x0002) == NORMAL_END
    assert master.execute(ROBOT, 0x0008) == NORMAL_END
    assert master.robot.positions == [700]


def test_mark_method_axes_do_not_take_part_in_a_return_to_origin() -> None:
    """If the origin of a mark method axis is incomplete, the command is refused.

    Rule: origin-command-mark.
    Source: manual chapter 5, 2, SI(17)
    """
    master = _master(ABSOLUTE, MARK, origin_method_alarm="1.3")
    assert master.execute(ROBOT) == NORMAL_END
    assert master.robot.positions == [0, 1300]
    master.robot.positions[0] = 700
    master.robot.origins[1] = False
    assert master.execute(ROBOT) == abnormal_end("1.3")
    assert master.execute(AXIS, 0, 0x0002) == abnormal_end("1.3")
    assert master.robot.positions == [700, 1300]
    assert master.execute(AXIS, 0, 0x0001) == NORMAL_END


# Tests of the return-to-origin in axis units


def test_a_return_to_origin_of_one_axis_is_performed_at_robot_1_if_no_robot_is_specified() -> None:
    """Rule: origin-command. Source: remote command guide 4.2.12, axis units, R."""
    axes = (ABSOLUTE, ABSOLUTE, Axis(start=700, robot=2), Axis(start=700, robot=2))
    master = _master(*axes, origin_complete=False)
    assert master.execute(AXIS, 0, 0x0001) == NORMAL_END
    assert master.robot.positions == [0, 700, 700, 700]
    assert master.robot.origins == [True, False, False, False]
    assert master.execute(AXIS | 0x2000, 0, 0x0002) == NORMAL_END
    assert master.robot.positions == [0, 700, 700, 0]


# Tests of the conditions of both commands, and of events that end them


@pytest.mark.parametrize(
    ("axis", "words"),
    [
        pytest.param(MARK, (MOVE, 0, 0x0001), id="absolute reset movement"),
        pytest.param(ABSOLUTE, (ROBOT,), id="all axes"),
        pytest.param(ABSOLUTE, (AXIS, 0, 0x0001), id="one axis"),
    ],
)
def test_origin_commands_need_servo_on_and_no_stop(axis: Axis, words: tuple[int, ...]) -> None:
    """Rule: origin-command-needs. Source: remote command guide 1.2."""
    master = _master(axis, servo_off_alarm="1.5")
    master.execute(0x0035)
    assert master.execute(*words) == abnormal_end("1.5")
    master.execute(0x0034)
    master.turn_and_wait("SI06", False)
    assert master.execute(*words) == abnormal_end("12.400")
    master.turn_and_wait("SI06", True)
    master.turn_and_wait("SI00", False)
    assert master.execute(*words) == abnormal_end("12.600")
    assert master.robot.positions == [axis.start]


@pytest.mark.parametrize(("name", "number"), [("SI06", "12.400"), ("SI00", "12.600")])
def test_a_stop_ends_a_return_to_origin_by_command(name: str, number: str) -> None:
    """The moving axis loses its origin. The axis of the second step keeps its origin.

    Rule: origin-command-needs.
    Source: remote command guide 1.2
    """
    master = _master(ABSOLUTE, INCREMENTAL)
    master.send(ROBOT)
    master.run(100)
    master.turn(name, on=False)
    assert master.finish() == abnormal_end(number)
    assert master.robot.origins == [False, True]
    assert master.robot.positions[1] == 700


@pytest.mark.parametrize("robot", [1, 2])
def test_a_return_to_origin_is_refused_while_another_one_is_under_way(robot: int) -> None:
    """SI(14) returns the axis of robot 1 to its origin.

    Meanwhile, an origin command for robot 2 is refused.

    Rule: origin-command-needs.
    """
    master = _master(INCREMENTAL, Axis(start=700, robot=2), moving_alarm="1.0")
    master.turn_and_wait("SI14", True, 100)
    assert master.execute(AXIS | robot << 12, 0, 0x0001) == abnormal_end("1.0")
    master.run(200)
    assert master.robot.positions == [0, 700]
