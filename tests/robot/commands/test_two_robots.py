"""Two robots of a controller move independently, but only one remote command runs at a time.

The default axis has 1000 pulses/mm, 1 000 000 pulses/s and 5 000 000 pulses/s^2.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis, Point
from rcx_harness.robot.paths import AxisMove, PtpPath
from robot_master import Master, abnormal_end, servos_on

PULSE_OUTPUT = 0x4000
#: Configuration: robot 1 has axes 0 and 1, robot 2 has axes 2 and 3. SI(14) returns axis 3 to its
#: origin.
AXES = (Axis(), Axis(), Axis(robot=2), Axis(robot=2, start=700, type="incremental"))
POINTS = {19: Point((100_000, 50_000, 0, 0, 0, 0)), 20: Point((-30_000, 40_000, 0, 0, 0, 0))}


def _mover(**config: Any) -> Master:
    return servos_on(**{"axes": AXES, "points": POINTS, **config})


def test_a_command_for_robot_2_is_not_executed_while_robot_1_moves() -> None:
    """The status is 0x0100: the second command counts as a change of the first, which continues.

    Source: remote command guide 1.1
    """
    master = _mover()
    master.send(0x1001, 0x0004, 0, 10, 19)
    master.run(100)
    master.send(0x2001, 0x0004, 0, 10, 20)
    master.run(3000)
    assert master.robot.positions == [100_000, 50_000, 0, 700]
    assert master.status == 0
    master.send()
    master.run(50)
    assert master.execute(0x2001, 0, 0, 0, 20)[0] == 0x0200
    assert master.robot.positions == [100_000, 50_000, -30_000, 40_000]


@pytest.mark.parametrize(
    ("robot", "expected"),
    [(0, [100_000, 50_000, 0, 700]), (1, [100_000, 50_000, 0, 700]), (2, [0, 0, 100_000, 50_000])],
)
@pytest.mark.parametrize("code", [0x001, 0x003])
def test_a_movement_moves_the_axes_of_its_robot(code: int, robot: int, expected: list[int]) -> None:
    """The answer has the positions of the designated robot, beginning with its axis 1.

    Source: remote command guide 4.2.1, R.
    """
    master = _mover()
    answer = master.execute(robot << 12 | code, PULSE_OUTPUT, 0, 0, 19)
    assert master.robot.positions == expected
    assert answer[4:10] == (0x86A0, 0x0001, 0xC350, 0x0000, 0, 0)


def test_a_robot_moves_while_the_other_one_returns_to_its_origin() -> None:
    """A robot refuses a movement while one of its axes returns to its origin.

    Rule: robots-move, movement-beside.
    """
    master = _mover(origin_time=1000, moving_alarm="6.7")
    master.turn_and_wait("SI14", True, 50)
    assert not master.on("SO11")
    assert master.execute(0x2001, 0, 0, 0, 20) == abnormal_end("6.7")
    assert master.execute(0x1001, 0, 0, 0, 19)[0] == 0x0200
    assert master.robot.positions == [100_000, 50_000, 0, 700]
    assert not master.on("SO11")
    master.run(1000)
    assert master.on("SO11")
    assert master.robot.positions == [100_000, 50_000, 0, 0]


def test_a_robot_that_moves_takes_no_other_movement() -> None:
    """The test starts the first movement without a remote command.

    Rule: robots-move.
    """
    master = _mover(moving_alarm="6.7")
    path = PtpPath([AxisMove(0, 0, 100_000, 50_000, 5e6, 5e6)])
    master.robot.machine.move(1, path)
    assert master.execute(0x1001, 0, 0, 0, 19) == abnormal_end("6.7")
    assert master.execute(0x2001, 0, 0, 0, 20)[0] == 0x0200
    master.run(2000)
    assert master.robot.positions == [100_000, 0, -30_000, 40_000]


def test_no_return_to_origin_starts_while_a_robot_moves() -> None:
    """Rule: movement-beside."""
    master = _mover()
    master.send(0x1001, 0x0004, 0, 1, 19)
    master.run(50)
    master.turn_and_wait("SI14", True, 1000)
    assert master.status == 0x0100
    assert master.robot.positions[3] == 700


def test_the_stop_input_stops_all_robots() -> None:
    """The stop ends both the movement and the return-to-origin of the other robot.

    Rule: robots-move.
    """
    master = _mover(origin_time=1000)
    master.turn_and_wait("SI14", True, 150)
    master.send(0x1001, 0x0004, 0, 1, 19)
    master.run(100)
    master.turn_and_wait("SI06", False, 5)
    assert master.words == abnormal_end("12.400")
    stopped_at = list(master.robot.positions)
    master.run(2000)
    assert master.robot.positions == stopped_at
    assert master.robot.origins == [True, True, True, False]


def test_servo_off_of_one_robot_leaves_the_other_one_moving() -> None:
    """The test stops axes by a direct call, as servo off does.

    The network allows only one remote command at a time.

    Rule: robots-move.
    """
    master = _mover()
    master.send(0x1001, 0x0004, 0, 10, 19)
    master.run(100)
    machine = master.robot.machine
    machine.halt_axes((2, 3), "6.6")
    assert machine.motion.moving(1)
    machine.halt_axes((1,), "6.6")
    assert master.finish() == abnormal_end("6.6")
    assert 0 < master.robot.positions[0] < 100_000
