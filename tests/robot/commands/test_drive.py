"""DRIVE moves a single axis to a position, DRIVEI moves it by a distance."""

from __future__ import annotations

from typing import Any

import pytest

from movements import ABNORMAL, MM, NORMAL, PULSES, low_high, mover
from rcx_harness.robot import Axis, Point
from robot_master import Master

ONE = 0x0001  # bit 0 of the flags is always 1
AXIS_3 = 0x0004
EVERY = [0x0010, 0x0012, 0x0013, 0x0014, 0x0016, 0x0017]
POINT = Point((11_000, 12_000, 13_000, 14_000, 0, 0))


def _mover(**config: Any) -> Master:
    axes = (Axis(start=1), Axis(start=2), Axis(start=1_000, pulses_per_mm=500), Axis(start=4))
    return mover(**{"axes": axes, "points": {19: POINT}, **config})


@pytest.mark.parametrize(
    ("code", "data", "ends"),
    [
        pytest.param(0x0010, (19,), 13_000, id="DRIVE to a point"),
        pytest.param(0x0012, low_high(-5_000), -2_500, id="DRIVE in mm"),
        pytest.param(0x0013, low_high(-5_000), -5_000, id="DRIVE in pulses"),
        pytest.param(0x0014, (19,), 14_000, id="DRIVEI by a point"),
        pytest.param(0x0016, low_high(-5_000), -1_500, id="DRIVEI in mm"),
        pytest.param(0x0017, low_high(-5_000), -4_000, id="DRIVEI in pulses"),
    ],
)
def test_the_specified_axis_moves_and_no_other(code: int, data: tuple[int, ...], ends: int) -> None:
    """Axis 3 starts at 1000 pulses and has 500 pulses/mm. The answer is in pulses.

    Source: remote command guide 4.2.3 and 4.2.4
    """
    master = _mover()
    answer = master.execute(code, ONE | PULSES | 0x0004, AXIS_3, 50, *data)
    assert master.robot.positions == [1, 2, ends, 4]
    assert answer[:10] == (NORMAL, 0, 0, 0, 1, 0, 2, 0, *low_high(ends))


@pytest.mark.parametrize(
    ("code", "data"),
    [(0x0010, 17), (0x0012, 2_000), (0x0013, 1_000), (0x0014, 18), (0x0016, 0), (0x0017, 0)],
)
def test_drive_answers_with_the_position_of_all_axes_in_millimetres(code: int, data: int) -> None:
    """The answer has the positions of all axes in mm.

    Axis 3 stays at 1000 pulses, which are 2.000 mm.

    Source: remote command guide 4.2.3 and 4.2.4, bbbbbbbb
    """
    master = _mover(points={17: Point((7, 7, 1_000, 7, 0, 0)), 18: Point((7, 7, 0, 7, 0, 0))})
    answer = master.execute(code, ONE | MM, AXIS_3, 0, data)
    assert answer[:12] == (NORMAL, 0, 0, 0, 1, 0, 2, 0, 2_000, 0, 4, 0)


@pytest.mark.parametrize("code", [0x0010, 0x0014])
def test_drive_reaches_a_point_in_millimetres(code: int) -> None:
    """A target of 13.000 mm at 500 pulses/mm is 6500 pulses.

    Source: remote command guide 4.2.3 and 4.2.4, point designation
    """
    master = _mover(points={19: Point(POINT.data, mm=True)})
    assert master.execute(code, ONE, AXIS_3, 0, 19)[0] == NORMAL
    assert master.robot.positions == [1, 2, 6_500 if code == 0x0010 else 7_500, 4]


def test_only_the_soft_limits_of_the_moving_axis_are_checked() -> None:
    """The point lies beyond the soft limit of axis 1, but only another axis moves.

    Source: remote command guide 4.2.3, point designation.
    """
    master = _mover(axes=(Axis(soft_high=100), Axis(), Axis(), Axis()))
    assert master.execute(0x0010, ONE, AXIS_3, 0, 19)[0] == NORMAL
    assert master.robot.positions == [0, 0, 13_000, 0]


RELATIVE = [
    pytest.param((0x0014, ONE | 4, AXIS_3, 10, 19), id="by a point"),
    pytest.param((0x0016, ONE | 4, AXIS_3, 10, *low_high(26_000)), id="in mm"),
    pytest.param((0x0017, ONE | 4, AXIS_3, 10, *low_high(13_000)), id="in pulses"),
]


@pytest.mark.parametrize("words", RELATIVE)
@pytest.mark.parametrize("start_position", ["keep", "reset"])
def test_drivei_after_a_stop_continues_or_starts_anew(
    words: tuple[int, ...], start_position: str
) -> None:
    """After a stop, DRIVEI continues to the first target or starts anew, as configured.

    The distance of 13 000 pulses at 100 000 pulses/s takes 0.15 s. The stop comes after 50 ms.

    Rule: movei-keep.
    Source: remote command guide 4.2.4, notes
    """
    master = _mover(movei_start_position=start_position)
    master.send(*words)
    master.run(50)
    master.turn_and_wait("SI06", False)
    assert master.words[:3] == (ABNORMAL, 0x000C, 0x0190)
    master.send()
    master.turn_and_wait("SI06", True)
    stands = master.robot.positions[2]
    assert 1_000 < stands < 14_000
    assert master.execute(*words)[0] == NORMAL
    ends = 14_000 if start_position == "keep" else stands + 13_000
    assert master.robot.positions == [1, 2, ends, 4]
