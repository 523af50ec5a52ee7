"""MOVE goes to an absolute position with PTP, in an arch, on a line or arc, or directly.

The default axis has 1000 pulses/mm, 1 000 000 pulses/s, 5 000 000 pulses/s^2 and soft limits of +-1
000 000.
"""

from __future__ import annotations

import math

import pytest

from movements import ABNORMAL, MM, NORMAL, low_high, mover, way_of
from rcx_harness.robot import Axis, Point
from rcx_harness.robot.stored import Pallet
from robot_master import Master


def _seconds(master: Master, *words: int) -> float:
    return (
        len(way_of(master, *words)) - 2
    ) * 0.005  # time without the cycle that accepts the command


def test_the_speed_in_percent_is_of_the_automatic_speed_and_the_direct_one_of_the_maximum() -> None:
    """20 % of 50 % automatic speed is as fast as 10.00 % direct.

    100 000 pulses at 100 000/s
    take 0.02 s for acceleration, 0.98 s at constant speed and 0.02 s for braking.

    Source: remote command guide 4.2.1, bb
    """
    there = {19: Point((100_000, 0, 0, 0, 0, 0))}
    assert _seconds(mover(points=there), 0x0001, 0x0002, 0, 1000, 19) == pytest.approx(1.02)
    half = mover(points=there, auto_speed=50)
    assert _seconds(half, 0x0001, 0x0004, 0, 20, 19) == pytest.approx(1.02)


# Linear interpolation


def test_linear_interpolation_is_a_straight_line_in_millimetres() -> None:
    """Axis 1 moves 30 mm and axis 2 moves 40 mm. On the way y = 4/3 x, for any pulses per mm.

    Source: remote command guide 4.2.1, linear interpolation
    """
    axes = (Axis(), Axis(pulses_per_mm=2000))
    master = mover(axes=axes, points={19: Point((30_000, 40_000, 0, 0, 0, 0), mm=True)})
    way = way_of(master, 0x0003, 0x0006, 0, 100, 19)
    assert way[-1] == (30_000, 80_000)
    assert len(set(way)) > 50
    for x, y in way:
        assert y / 2 == pytest.approx(x * 4 / 3, abs=2)


def test_the_path_speed_is_in_mm_per_second() -> None:
    """In the middle of a path of 50 mm, 100 mm/s are 0.5 mm per cycle of 5 ms.

    Source: remote command guide 4.2.1, linear interpolation, bb
    """
    master = mover(points={19: Point((30_000, 40_000, 0, 0, 0, 0))})
    way = way_of(master, 0x0003, 0x0006, 0, 100, 19)
    middle = len(way) // 2
    step = math.dist(way[middle], way[middle + 1])
    assert step == pytest.approx(500, abs=2)


@pytest.mark.parametrize(
    ("scara", "speed", "expected"),
    [
        pytest.param((1,), 1000, NORMAL, id="SCARA, 1000 mm/s"),
        pytest.param((1,), 1001, ABNORMAL, id="SCARA, 1001 mm/s"),
        pytest.param((), 750, NORMAL, id="another robot, 750 mm/s"),
        pytest.param((), 751, ABNORMAL, id="another robot, 751 mm/s"),
        pytest.param((), 0, ABNORMAL, id="0 mm/s"),
    ],
)
@pytest.mark.parametrize("code", [0x0003, 0x0004])
def test_a_line_is_refused_beyond_the_range_of_mm_per_second(
    code: int, scara: tuple[int, ...], speed: int, expected: int
) -> None:
    """Rule: line-speed.

    Source: remote command guide 4.2.1, linear and circular interpolation, bb
    """
    near = {19: Point((100, 0, 0, 0, 0, 0)), 20: Point((100, 100, 0, 0, 0, 0))}
    master = mover(points=near, scara_robots=scara)
    assert master.execute(code, 0x0006, 0, speed, 19, 20 * (code == 0x0004))[0] == expected


def test_linear_interpolation_moves_only_the_designated_axes() -> None:
    """Rule: linear-axes."""
    master = mover(points={19: Point((30_000, 40_000, 0, 0, 0, 0))})
    assert master.execute(0x0003, 0x0001, 0x0002, 0, 19)[0] == NORMAL
    assert master.robot.positions == [0, 40_000, 0, 0]


def test_a_line_respects_the_given_acceleration_and_deceleration() -> None:
    """A lower acceleration or deceleration makes the movement longer.

    Source: remote command guide 4.2.1, linear interpolation, d and e
    """
    there = {19: Point((30_000, 40_000, 0, 0, 0, 0))}
    plain = _seconds(mover(points=there), 0x0003, 0x0006, 0, 500, 19)
    slow_up = _seconds(mover(points=there), 0x0003, 0x0026, 0, 500, 19, 0, 0, 0, 0, 0, 20)
    slow_down = _seconds(mover(points=there), 0x0003, 0x0046, 0, 500, 19, 0, 0, 0, 0, 0, 0, 20)
    assert slow_up > plain + 0.05
    assert slow_up == pytest.approx(slow_down)


# Circular interpolation


def test_circular_interpolation_goes_through_the_first_point_to_the_second() -> None:
    """The arc goes from (0, 0) through (10, 10) to (20, 0) mm.

    Its centre is (10, 0) mm and its radius is 10 mm.

    Source: remote command guide 4.2.1, circular interpolation
    """
    points = {19: Point((10_000, 10_000, 0, 0, 0, 0)), 20: Point((20_000, 0, 0, 0, 0, 0))}
    master = mover(points=points)
    way = way_of(master, 0x0004, 0x0006, 0, 50, 19, 20)
    assert all(math.dist(at[:2], (10_000, 0)) == pytest.approx(10_000, abs=2) for at in way)
    assert min(math.dist(at[:2], (10_000, 10_000)) for at in way) < 200
    assert way[-1] == (20_000, 0, 0, 0)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        pytest.param((0, 0, 0, 19, 21), (ABNORMAL, 6, 9), id="all three on one line"),
        pytest.param((0, 0, 0, 19, 99), (ABNORMAL, 6, 5), id="second point undefined"),
        pytest.param((0, 0, 0, 99, 19), (ABNORMAL, 6, 5), id="first point undefined"),
        pytest.param((0, 0, 0, 19, 22), (ABNORMAL, 2, 334), id="the arc leaves the soft limits"),
    ],
)
def test_an_impossible_arc_is_refused(words: tuple[int, ...], expected: tuple[int, ...]) -> None:
    """The arc to (0, 200) mm through (10, 10) mm would go up to x = 44.5 mm.

    Its centre is (-90, 100) mm and its radius is 134.5 mm.

    Source: remote command guide 4.2.1, circular interpolation
    """
    points = {
        19: Point((10_000, 10_000, 0, 0, 0, 0)),
        20: Point((20_000, 0, 0, 0, 0, 0)),
        21: Point((20_000, 20_000, 0, 0, 0, 0)),
        22: Point((0, 200_000, 0, 0, 0, 0)),
    }
    axes = (Axis(soft_high=44_000), Axis(), Axis(), Axis())
    master = mover(axes=axes, points=points, no_circle_alarm="6.9", undefined_point_alarm="6.5")
    assert master.execute(0x0004, *words)[:3] == expected
    assert master.robot.positions == [0, 0, 0, 0]


def test_a_deviation_of_0_001_mm_makes_an_arc_only_on_a_short_line() -> None:
    """The middle point lies 0.001 mm beside the line.

    With a distance of 700 mm, this makes an arc; with 1000 mm, all three points count as one line
    and are refused.

    Rule: arc.
    """
    points = {
        19: Point((700_000, 1, 0, 0, 0, 0)),
        20: Point((1_000_000, 1, 0, 0, 0, 0)),
        21: Point((900_000, 0, 0, 0, 0, 0)),
    }
    master = mover(points=points, no_circle_alarm="6.9")
    assert master.execute(0x0004, 4, 0, 100, 20, 21)[:3] == (0x4000, 6, 9)
    assert master.execute(0x0004, 4, 0, 100, 19, 21)[:3] == (NORMAL, 0, 0)


# Direct designation


def test_a_movement_reaches_a_target_given_in_millimetres() -> None:
    """The target is 10.000 and -20.000 mm, and axis 2 has 500 pulses/mm. The answer is in mm.

    Source: remote command guide 4.2.1, direct PTP designation (millimeter units)
    """
    master = mover(axes=(Axis(), Axis(pulses_per_mm=500)))
    data = low_high(10_000, -20_000)
    answer = master.execute(0x0006, MM | 0x0004, 0, 50, *data)
    assert master.robot.positions == [10_000, -10_000]
    assert answer == (NORMAL, 0, 0, 0, *data, *(0,) * 8)


@pytest.mark.parametrize(("scara", "moves_along"), [((1,), True), ((), False)])
def test_scara_axes_1_and_2_move_with_axis_4(scara: tuple[int, ...], moves_along: bool) -> None:
    """Rule: scara-axis-4.

    Source: remote command guide 4.2.1, direct PTP designation (millimeter units), caution
    """
    master = mover(scara_robots=scara)
    data = low_high(1_000, 2_000, 3_000, 4_000)
    assert master.execute(0x0006, 1, 0x0008, 0, *data)[0] == NORMAL
    assert master.robot.positions == ([1_000, 2_000, 0, 4_000] if moves_along else [0, 0, 0, 4_000])


def test_in_pulses_axis_4_moves_alone() -> None:
    """Source: remote command guide 4.2.1, direct PTP designation (pulse units)."""
    master = mover()
    assert master.execute(0x0007, 1, 0x0008, 0, *low_high(1_000, 2_000, 3_000, 4_000))[0] == NORMAL
    assert master.robot.positions == [0, 0, 0, 4_000]


@pytest.mark.parametrize(
    ("scara", "hand", "arm"),
    [
        pytest.param((1,), 1, 0, id="right-handed"),
        pytest.param((1,), 2, 1, id="left-handed"),
        pytest.param((1,), 0, 0, id="no hand system: the designated arm"),
        pytest.param((1,), 3, 0, id="11 also means no hand system"),
        pytest.param((), 2, 0, id="no SCARA robot"),
    ],
)
def test_the_arm_takes_the_hand_system_of_the_target(
    scara: tuple[int, ...], hand: int, arm: int
) -> None:
    """The hand system may come from the command or from the point. Arm rotation has no effect.

    Rule: hand-system.
    Source: remote command guide 4.2.1, direct PTP designation (millimeter units), cc
    """
    master = mover(scara_robots=scara, points={19: Point(mm=True, hand=hand % 3)})
    assert master.execute(0x0006, hand << 3 | 1 << 5 | 15 << 9)[0] == NORMAL
    assert master.robot.machine.settings.of(1).arm_status == arm
    master.robot.machine.settings.of(1).arm_status = 1 - arm
    assert master.execute(0x0001, 0, 0, 0, 19)[0] == NORMAL
    assert master.robot.machine.settings.of(1).arm_status == arm


@pytest.mark.parametrize(
    ("words", "left"),
    [
        pytest.param((0x0001, 0, 0, 0, 19), True, id="MOVE, PTP"),
        pytest.param((0x0002, 0, 0x0400, 0, 19), True, id="MOVE, arch"),
        pytest.param((0x0003, 0, 0, 0, 19), True, id="MOVE, linear"),
        pytest.param((0x0004, 0, 0, 0, 20, 19), True, id="MOVE, circular: the second point"),
        pytest.param((0x0009, 0, 0, 0, 19), True, id="MOVEI, PTP"),
        pytest.param((0x000A, 0, 0, 0, 19), True, id="MOVEI, linear"),
        pytest.param((0x0018, 0, 0, 0, 7, 1), True, id="pallet, PTP"),
        pytest.param((0x0019, 0, 0x0400, 0, 7, 1), True, id="pallet, arch"),
        pytest.param((0x0044, 0, 0, 0, 19), True, id="MOVET, PTP"),
        pytest.param((0x0045, 0, 0, 0, 19), True, id="MOVET, linear"),
        pytest.param((0x0010, 1, 4, 0, 19), False, id="DRIVE: one axis does not change the arm"),
        pytest.param((0x0014, 1, 4, 0, 19), False, id="DRIVEI: one axis does not change the arm"),
        pytest.param((0x004B, 1, 4, 0, 19), False, id="PUSH: one axis does not change the arm"),
    ],
)
def test_each_movement_to_a_point_takes_its_hand(words: tuple[int, ...], left: bool) -> None:
    """Point 19 is left-handed, so each movement to it ends left-handed. Rule: hand-system."""
    points = {
        19: Point((2_000, 0, 0, 0, 0, 0), mm=True, hand=2),
        20: Point((1_000, 1_000) + (0,) * 4),
    }
    master = mover(points=points, pallets={7: Pallet(1, 1, 1, first=19)})
    assert master.execute(*words)[0] == NORMAL
    assert master.robot.machine.settings.of(1).arm_status == left
