"""The point teaching command stores the current position as a point."""

from __future__ import annotations

from typing import Any

from rcx_harness.robot import Axis, Point
from robot_master import NORMAL_END, Master, powered_up

#: Axis data: axis 1 has 500 pulses per millimetre.
AXES = (Axis(pulses_per_mm=500.0), Axis(), Axis(robot=2, pulses_per_mm=2000.0))


def _master(**config: Any) -> Master:
    """Return a master with robot 1 at 1234 and -2001 pulses, and robot 2 at 3 pulses."""
    master = powered_up(**{"axes": AXES, **config})
    master.robot.positions[:] = [1234, -2001, 3]
    return master


def test_the_current_position_becomes_a_point_in_millimetres() -> None:
    """1234 pulses at 500 pulses/mm are 2.468 mm; -2001 pulses at 1000 pulses/mm are -2.001 mm.

    Rule: teaching, taught-point.
    Source: remote command guide 4.2.9
    """
    master = _master()
    assert master.execute(0x0028, 0, 0, 1) == NORMAL_END
    assert master.robot.points[0] == Point((2468, -2001, 0, 0, 0, 0), mm=True)


def test_the_position_is_that_of_the_designated_robot() -> None:
    """3 pulses at 2000 pulses/mm are 0.0015 mm, rounded to the even value 0.002 mm.

    Source: remote command guide 4.2.9, R
    """
    master = _master()
    assert master.execute(0x2028, 0, 5, 0) == NORMAL_END
    assert master.execute(0x2028, 0, 6, 1) == NORMAL_END
    assert master.robot.points[5] == Point((3, 0, 0, 0, 0, 0))
    assert master.robot.points[6] == Point((2, 0, 0, 0, 0, 0), mm=True)


def test_a_taught_point_is_read_back_and_moved_to() -> None:
    """Source: remote command guide 4.2.9, 4.3.1, 4.2.1."""
    master = _master()
    master.execute(0x0028, 0, 29999, 0)
    answer = master.execute(0x0101, 0, 29999)
    assert answer[:8] == (0x0200, 0, 29999, 0, 1234, 0, 0x10000 - 2001, 0xFFFF)
    master.robot.positions[:] = [0, 0, 0]
    master.pulse("SI01")
    assert master.execute(0x0001, 0, 0, 0, 29999)[0] == 0x0200
    assert master.robot.positions == [1234, -2001, 0]


def test_a_point_taught_in_a_shift_is_where_the_robot_was() -> None:
    """With shift 1 (1.000 mm in X), 2.468 mm become 1.468 mm, which is the same place.

    Source: remote command guide 4.2.9, 4.2.17
    """
    master = _master()
    assert master.execute(0x010C, 0, 1, 0, 1000) == NORMAL_END
    assert master.execute(0x003B, 0, 1) == NORMAL_END
    assert master.execute(0x0028, 0, 8, 1) == NORMAL_END
    assert master.robot.points[8].data[:2] == (1468, -2001)
    master.robot.positions[:] = [0, 0, 0]
    master.pulse("SI01")
    assert master.execute(0x0001, 0, 0, 0, 8)[0] == 0x0200
    assert master.robot.positions == [1234, -2001, 0]


def test_teaching_replaces_a_point_that_is_there() -> None:
    """Source: remote command guide 4.2.9."""
    master = _master(points={7: Point((9, 9, 9, 9, 9, 9), mm=True, hand=2, arm1=1)})
    master.execute(0x0028, 0, 7, 0)
    assert master.robot.points[7] == Point((1234, -2001, 0, 0, 0, 0))


def test_teaching_is_possible_with_the_servos_off_and_without_origin() -> None:
    """Rule: taught-point."""
    master = _master(origin_complete=False)
    assert not master.on("SO02")
    assert not master.on("SO11")
    assert master.execute(0x0028, 0, 1, 0) == NORMAL_END
