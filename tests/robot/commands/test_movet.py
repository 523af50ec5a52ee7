"""MOVET moves to a position in tool coordinates.

A hand on the R axis turns with axis 4: at 90 degrees the tool's X is the robot's Y.
"""

from __future__ import annotations

from typing import Any

import pytest

from movements import MM, NORMAL, mover, way_of
from rcx_harness.robot import Axis, Point
from rcx_harness.robot.stored import Hand
from robot_master import Master

POINT = Point((10_000, 0, -3_000, 0, 0, 0), mm=True)
ON_R = Hand((0, 0, 0, 1))


def _mover(**config: Any) -> Master:
    axes = (Axis(start=1_000), Axis(pulses_per_mm=500), Axis(), Axis(start=90_000))
    return mover(**{"axes": axes, "points": {19: POINT}, **config})


@pytest.mark.parametrize("code", [0x0044, 0x0045])
def test_without_a_hand_on_the_r_axis_tool_and_robot_coordinates_are_parallel(code: int) -> None:
    """The robot moves 10 mm along its X axis and -3 mm along its Z axis.

    Rule: movet.
    Source: remote command guide 4.2.21
    """
    master = _mover()
    answer = master.execute(code, MM, 0, 0, 19)
    assert master.robot.positions == [11_000, 0, -3_000, 90_000]
    assert answer[4:10] == (11_000, 0, 0, 0, 0xF448, 0xFFFF)


@pytest.mark.parametrize("code", [0x0044, 0x0045])
def test_a_hand_on_the_r_axis_turns_the_tool(code: int) -> None:
    """R is at 90 degrees: X of the tool is Y of the robot, where 1 mm is 500 pulses.

    Rule: movet.
    Source: remote command guide 4.2.21
    """
    master = _mover(hands={(1, 0): ON_R})
    assert master.execute(code, 0, 0, 0, 19)[0] == NORMAL
    assert master.robot.positions == [1_000, 5_000, -3_000, 90_000]


@pytest.mark.parametrize("code", [0x0044, 0x0045])
def test_the_specified_axes_of_movet_are_axes_of_the_tool(code: int) -> None:
    """If axis 1 alone is specified, the robot's Y moves and its Z does not.

    Rule: movet.
    Source: remote command guide 4.2.21, a and tt
    """
    master = _mover(hands={(1, 0): ON_R})
    assert master.execute(code, 1, 0x0001, 0, 19)[0] == NORMAL
    assert master.robot.positions == [1_000, 5_000, 0, 90_000]


def test_a_point_in_pulses_is_a_distance_for_each_axis() -> None:
    """A distance of 500 pulses of axis 2 is 1 mm. Rule: movet."""
    master = _mover(points={19: Point((2_000, 500, 0, 0, 0, 0))})
    assert master.execute(0x0044, 0, 0, 0, 19)[0] == NORMAL
    assert master.robot.positions == [3_000, 500, 0, 90_000]


def test_the_line_of_the_tool_is_straight() -> None:
    """X and Y of a tool that is turned by 45 degrees add up to a movement along the robot's Y.

    Source: remote command guide 4.2.21, linear interpolation
    """
    axes = (Axis(), Axis(), Axis(), Axis(start=45_000))
    there = Point((30_000, 30_000, 0, 0, 0, 0), mm=True)
    master = _mover(axes=axes, hands={(1, 0): ON_R}, points={19: there})
    seen = set(way_of(master, 0x0045, 0x0006, 0, 100, 19))
    assert len(seen) > 50
    assert all(at[0] == 0 for at in seen)
    assert master.robot.positions == [0, 42_426, 0, 45_000]  # 30 000 times the square root of 2
