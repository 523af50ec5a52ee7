"""Pallets are defined by points, and their work positions lie between these points."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Pallet, Point
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, ready

WRITE, READ, ASSIGN, READ_POINT = 0x0108, 0x0109, 0x0238, 0x0101


def _mm(*data: int) -> Point:
    return Point(data + (0,) * (6 - len(data)), mm=True)


#: A pallet of 3 x 2 x 3 positions, 10 mm apart in X, 20 mm in Y, 5 mm in Z, from (100, -50, 7) mm.
BOX = {
    200: _mm(100_000, -50_000, 7_000),
    201: _mm(120_000, -50_000, 7_000),
    202: _mm(100_000, -30_000, 7_000),
    203: _mm(120_000, -30_000, 7_000),
    204: _mm(100_000, -50_000, 17_000),
}
BOX_PALLET = {3: Pallet(3, 2, 3, 200)}


@pytest.mark.parametrize(
    ("counts", "allowed"),
    [
        ((32767, 1, 1), True),
        ((31, 7, 151), True),  # 32767
        ((32, 32, 32), False),  # 32768
        ((256, 256, 1), False),  # 65536 positions, which are 0 in 16 bits
        ((2, 1, 16384), False),
        ((0, 1, 1), False),
        ((1, 0, 1), False),
        ((1, 1, 0), False),
        ((32768, 1, 1), False),
        ((32767, 32767, 32767), False),
    ],
)
def test_a_pallet_has_1_to_32767_positions(counts: tuple[int, ...], allowed: bool) -> None:
    """Rule: pallet-size. Source: remote command guide 4.3.3."""
    master = ready()
    assert master.execute(WRITE, 0, 1, *counts, 0) == (
        NORMAL_END if allowed else abnormal_end("4.2")
    )
    assert (1 in master.robot.machine.memory.pallets) is allowed


@pytest.mark.parametrize("work", range(1, 19))
def test_work_positions_count_in_x_then_y_then_z(work: int) -> None:
    """The test visits each of the 3 * 2 * 3 positions once.

    Rule: work-positions.
    Source: remote command guide 4.4.3, 4.3.3
    """
    x_places, y_places, z_places = (100, 110, 120), (-50, -30), (7, 12, 17)
    places = [(1000 * x, 1000 * y, 1000 * z) for z in z_places for y in y_places for x in x_places]
    master = ready(points=BOX, pallets=BOX_PALLET)
    assert master.execute(ASSIGN, 0, 100, 3, work) == NORMAL_END
    answer = master.execute(READ_POINT, 0, 100)
    assert answer == (0x0200, 0, 100, 1, *long_words(*places[work - 1], 0, 0, 0))


@pytest.mark.parametrize(
    ("work", "expected"),
    [
        (1, (0, 0)),
        (2, (10_000, 2_000)),
        (3, (20_000, 4_000)),
        (5, (12_500, 13_500)),
        (7, (0, 20_000)),
        (8, (15_000, 25_000)),
        (9, (30_000, 30_000)),
    ],
)
def test_a_pallet_need_not_be_a_rectangle(work: int, expected: tuple[int, int]) -> None:
    """Position 5 of 3 * 3 is the mean of the four corners.

    These are (0+20+0+30)/4 in X and (0+4+20+30)/4 in Y.

    Rule: work-positions.
    Source: remote command guide 4.4.3
    """
    corners = {0: _mm(0, 0), 1: _mm(20_000, 4_000), 2: _mm(0, 20_000), 3: _mm(30_000, 30_000)}
    master = ready(points=corners, pallets={0: Pallet(3, 3, 1, 0)})
    master.execute(ASSIGN, 0, 100, 0, work)
    assert master.robot.points[100].data[:2] == expected


def test_all_axes_are_interpolated_and_rounded_in_the_unit_of_the_points() -> None:
    """A third of the distance is rounded: 1 -> 0, 2 -> 1, 5 -> 2, -5 -> -2, 100 -> 33.

    At half of the distance, .5 is rounded away from 0.

    Rule: work-positions.
    Source: remote command guide 4.4.3
    """
    ends = {0: Point(), 1: Point((1, 2, 5, -5, 100, -100))}
    master = ready(points=ends, pallets={0: Pallet(4, 1, 1, 0), 1: Pallet(3, 1, 1, 0)})
    master.execute(ASSIGN, 0, 50, 0, 2)
    assert master.robot.points[50] == Point((0, 1, 2, -2, 33, -33))
    master.execute(ASSIGN, 0, 50, 1, 2)
    assert master.robot.points[50] == Point((1, 1, 3, -3, 50, -50))


def test_a_pallet_point_takes_hand_and_arm_rotation_from_the_first_point() -> None:
    """Rule: point-units. Source: remote command guide 4.4.3."""
    first = Point((0,) * 6, mm=True, hand=2, arm1=1, arm2=-1)
    master = ready(points={0: first, 1: _mm(10)}, pallets={0: Pallet(2, 1, 1, 0)})
    master.execute(ASSIGN, 0, 50, 0, 2)
    assert master.robot.points[50] == Point(_mm(10).data, mm=True, hand=2, arm1=1, arm2=-1)


def test_points_of_a_direction_with_one_position_need_not_be_defined() -> None:
    """Rule: work-positions. Source: remote command guide 4.4.3."""
    master = ready(
        points={0: _mm(1), 2: _mm(3)},
        pallets={0: Pallet(1, 2, 1, 0), 1: Pallet(2, 1, 1, 0)},
        undefined_point_alarm="6.5",
    )
    assert master.execute(ASSIGN, 0, 50, 0, 2) == NORMAL_END
    assert master.robot.points[50] == _mm(3)
    assert master.execute(ASSIGN, 0, 50, 1, 2) == abnormal_end("6.5")
    assert master.robot.points[50] == _mm(3)


def test_the_points_of_a_pallet_have_the_same_unit() -> None:
    """Rule: point-units. Source: remote command guide 4.4.3."""
    master = ready(
        points={0: _mm(), 1: Point()}, pallets={0: Pallet(2, 1, 1, 0)}, point_unit_alarm="6.1"
    )
    assert master.execute(ASSIGN, 0, 50, 0, 2) == abnormal_end("6.1")
    assert 50 not in master.robot.points


def test_a_position_beyond_32_bits_is_refused() -> None:
    """At the last position in Z and X the coordinate would be 2^31, so the command is refused.

    Rule: overflow.
    Source: remote command guide 4.4.3
    """
    master = ready(
        points={0: _mm(), 1: _mm(2**31 - 1), 4: _mm(1)},
        pallets={0: Pallet(2, 1, 2, 0)},
        overflow_alarm="6.2",
    )
    assert master.execute(ASSIGN, 0, 50, 0, 4) == abnormal_end("6.2")
    assert master.execute(ASSIGN, 0, 50, 0, 2) == NORMAL_END


def test_the_target_pallet_must_be_defined_and_its_definition_ends_the_work_positions() -> None:
    """Positions from 19 on are refused, since the pallet has 3 * 2 * 3 = 18 positions.

    Rule: pallet-point, undefined-pallet.
    Source: remote command guide 4.4.3
    """
    master = ready(
        points=BOX, pallets=BOX_PALLET, undefined_pallet_alarm="6.3", work_position_alarm="6.4"
    )
    assert master.execute(ASSIGN, 0, 50, 4, 1) == abnormal_end("6.3")
    assert master.execute(READ, 0, 4) == abnormal_end("6.3")
    assert master.execute(ASSIGN, 0, 50, 3, 19) == abnormal_end("6.4")
    assert master.execute(ASSIGN, 0, 50, 3, 18) == NORMAL_END
