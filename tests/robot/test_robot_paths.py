"""Profiles, curves, paths and coordinates have values that were calculated by hand."""

from __future__ import annotations

import math

import pytest

from rcx_harness.robot.geometry import Arc, Frame, Line
from rcx_harness.robot.motion import Motion, Movement
from rcx_harness.robot.paths import ArchPath, AxisMove, CurvePath, Profile, PtpPath


def test_a_profile_accelerates_moves_and_brakes() -> None:
    """A distance of 100 at 50/s, with 100/s^2 up and 50/s^2 down, takes 0.5 s, 1.25 s and 1 s.

    The three phases are 12.5, 62.5 and 25 long.

    Rule: profile.
    """
    profile = Profile.over(100, 50, 100, 50)
    assert profile == Profile(0.5, 1.25, 1.0)
    assert profile.seconds == 2.75
    assert profile.share(0.25) == pytest.approx(0.03125)
    assert profile.share(0.5) == pytest.approx(0.125)
    assert profile.share(1.75) == pytest.approx(0.75)
    assert profile.share(2.25) == pytest.approx(0.9375)
    assert profile.share(9) == 1


def test_a_short_distance_has_no_phase_of_constant_speed() -> None:
    """For a distance of 100 with 200/s^2 up and down, half of the distance takes 0.7071 s.

    Rule: profile.
    """
    profile = Profile.over(100, 1000, 200, 200)
    assert profile.even == pytest.approx(0)
    assert profile.up == profile.down == pytest.approx(math.sqrt(0.5))
    assert Profile.over(0, 1000, 200, 200) == Profile()


@pytest.mark.parametrize(
    ("share", "seconds"),
    [(0, 0), (0.03125, 0.25), (0.125, 0.5), (0.5, 1.25), (0.75, 1.75), (0.9375, 2.25), (1, 2.75)],
)
def test_a_profile_gives_the_time_of_each_part_of_its_distance(
    share: float, seconds: float
) -> None:
    """The profile returns the time at which a given distance is done. Rule: profile."""
    assert Profile.over(100, 50, 100, 50).when(share) == pytest.approx(seconds)


def test_on_a_line_all_axes_are_in_proportion() -> None:
    """The length of a line is that of X, Y and Z.

    If other axes turn farther, their angle is the length.

    Rule: path-speed.
    """
    line = Line((0, 0, 0, 10), (300, 400, 0, -90))
    assert line.length == 500
    assert line.at(0.25) == [75, 100, 0, -15]
    assert Line((0, 0, 0, 0), (3, 4, 0, 90)).length == 90


def test_an_arc_goes_from_the_first_through_the_second_to_the_third_point() -> None:
    """The radius is 5 about (5, 0).

    The arc goes over the top, three quarters of the circle, to (5, -5).

    Rule: arc.
    """
    arc = Arc((0, 0, 7, 0), (5, 5, 7, 10), (5, -5, 7, 90))
    assert arc.length == pytest.approx(1.5 * math.pi * 5)
    assert arc.at(0) == pytest.approx([0, 0, 7, 0])
    assert arc.at(1 / 6) == pytest.approx([5 - 5 * math.sqrt(0.5), 5 * math.sqrt(0.5), 7, 5])
    assert arc.at(1 / 3) == pytest.approx([5, 5, 7, 10])
    assert arc.at(2 / 3) == pytest.approx([10, 0, 7, 50])
    assert arc.at(1) == pytest.approx([5, -5, 7, 90])


def test_an_arc_takes_the_other_way_round_if_the_first_point_lies_there() -> None:
    """Rule: arc."""
    arc = Arc((0, 0), (5, -5), (10, 0))
    assert arc.length == pytest.approx(5 * math.pi)
    assert arc.at(0.5) == pytest.approx([5, -5])


def test_an_arc_may_lie_anywhere_in_space() -> None:
    """The arc is in the plane of Y and Z. Rule: arc."""
    arc = Arc((2, 0, 0), (2, 5, 5), (2, 10, 0))
    assert arc.at(0.25) == pytest.approx([2, 5 - 5 * math.sqrt(0.5), 5 * math.sqrt(0.5)])


@pytest.mark.parametrize(
    "points",
    [
        pytest.param([(0, 0, 0), (1, 1, 1), (3, 3, 3)], id="on a line"),
        pytest.param([(0, 0, 0), (3, 3, 3), (1, 1, 1)], id="on a line, back"),
        pytest.param([(0, 0, 0), (0, 0, 0), (1, 2, 3)], id="the first is where the robot is"),
        pytest.param([(0, 0, 0), (1, 2, 3), (1, 2, 3)], id="first and second point are equal"),
        pytest.param([(0, 0, 0), (1, 2, 3), (0, 0, 0)], id="the second is where the robot is"),
        pytest.param([(0, 0, 0, 0), (0, 0, 0, 5), (0, 0, 0, 9)], id="X, Y and Z stand still"),
        pytest.param([(1,), (2,), (5,)], id="a robot with one axis"),
    ],
)
def test_no_circle_goes_through_points_on_a_line(points: list[tuple[float, ...]]) -> None:
    """Rule: arc."""
    with pytest.raises(ValueError, match="no circle"):
        Arc(*points)


def _move(start: int, target: int, axis: int = 2) -> AxisMove:
    """Return a movement at 100 pulses/s from the start: 100 pulses take a little more than 1 s."""
    return AxisMove(axis, start, target, 100, 1e9, 1e9)


def test_the_arch_axis_goes_first_and_comes_down_last() -> None:
    """The arch axis rises by 200 in 2 s.

    The other axes (300 in 3 s) start when it has risen by 50, at 0.5 s, and arrive at 3.5 s. At 3.5
    s the arch axis must have 60 of its 150 down left, so it has moved 90 in 0.9 s. It therefore
    leaves at 2.6 s and arrives at 4.1 s.

    Rule: arch-motion.
    Source: remote command guide 4.2.1, arch designation, steps 1 to 4
    """
    others = PtpPath([_move(0, 300, 0)])
    path = ArchPath(_move(0, 200), _move(200, 50), others, 50, 60)
    assert path.seconds == pytest.approx(4.1, abs=1e-5)
    assert path.target == {0: 300, 2: 50}
    for t, other, arch in [
        (0.4, 0, 40), (0.5, 0, 50), (1.5, 100, 150), (2.0, 150, 200), (2.6, 210, 200),
        (3.5, 300, 110), (4.0, 300, 60),
    ]:  # fmt: skip
        assert path.at(t)[0] == pytest.approx(other, abs=1e-3)
        assert path.at(t)[2] == pytest.approx(arch, abs=1e-3)


@pytest.mark.parametrize(
    ("distance1", "distance2", "others_start", "arch_leaves"),
    [
        pytest.param(500, 60, 2.0, 4.1, id="distance 1 is longer than the rise"),
        pytest.param(200, 500, 2.0, 5.0, id="distance 2 is longer than the descent"),
        pytest.param(0, 0, 0.0, 2.0, id="no distances: it leaves the arch position at once"),
    ],
)
def test_arch_distances_may_be_longer_than_rise_and_descent(
    distance1: int, distance2: int, others_start: float, arch_leaves: float
) -> None:
    """Distance 2 never makes the arch axis leave before it has reached the arch position.

    Rule: arch-motion.
    """
    others = PtpPath([_move(0, 300, 0)])
    path = ArchPath(_move(0, 200), _move(200, 50), others, distance1, distance2)
    assert path.at(others_start)[0] == pytest.approx(0, abs=1e-3)
    assert path.at(others_start + 0.1)[0] == pytest.approx(10, abs=1e-3)
    assert path.at(arch_leaves)[2] == pytest.approx(200, abs=1e-3)
    assert path.at(arch_leaves + 0.1)[2] == pytest.approx(190, abs=1e-3)


def test_an_arch_movement_of_length_0_ends_at_once() -> None:
    """Rule: arch-motion."""
    path = ArchPath(_move(5, 5), _move(5, 5), PtpPath([]), 10, 10)
    assert path.seconds == 0
    assert path.target == {2: 5}


def test_a_path_on_a_curve_moves_the_axes_that_take_part() -> None:
    """The path takes half a second at 1 mm/s along (3, 4). The second axis has 2000 pulses/mm.

    Rule: path-speed.
    """
    curve = Line((0, 0), (3_000, 4_000))
    profile = Profile(0, 5, 0)
    path = CurvePath(curve, profile, Frame((1000, 2000)), {1: 7}, {7: 8_000})
    assert path.at(0.5) == pytest.approx({7: 800})
    assert path.seconds == 5


# Coordinates

SHIFTED = Frame((1000, 500, 100, 1000, 10), shift=(1_000, 2_000, 3_000, 90_000))


def test_each_axis_has_its_own_factor_from_pulses_to_millimetres() -> None:
    """Rule: coordinates."""
    frame = Frame((1000, 2000))
    assert frame.to_mm((1_500, -3_000)) == (1_500, -1_500)
    assert frame.to_pulses((1_500, -1_500, 9, 9, 9, 9)) == (1_500, -3_000)


def test_a_shift_moves_and_turns_the_coordinates() -> None:
    """The axes are at X 1, Y 12, Z 5 mm. In the shifted coordinates, this is X 10 mm and Z 2 mm.

    Rule: coordinates.
    """
    pulses = (1_000, 6_000, 500, 120_000, 7)
    assert SHIFTED.to_mm(pulses) == pytest.approx((10_000, 0, 2_000, 30_000, 700))
    assert SHIFTED.to_pulses((10_000, 0, 2_000, 30_000, 700)) == pytest.approx(pulses)


@pytest.mark.parametrize(
    ("on_r", "mm"),
    [
        pytest.param(False, (10_000, -2_000, 5_000, 90_000), id="beside the R axis"),
        pytest.param(True, (2_000, 10_000, 5_000, 90_000), id="on the R axis, at 90 degrees"),
    ],
)
def test_the_tool_is_at_the_end_of_the_hand(on_r: bool, mm: tuple[int, ...]) -> None:
    """The hand of the guide's example is 10.000, -2.000 and 5.000 mm long in X, Y and Z.

    Rule: coordinates.
    """
    frame = Frame((1000,) * 4, hand=(10_000, -2_000, 5_000), on_r=on_r)
    assert frame.to_mm((0, 0, 0, 90_000)) == pytest.approx(mm)
    assert frame.to_pulses(mm) == pytest.approx((0, 0, 0, 90_000), abs=1e-6)


@pytest.mark.parametrize("axes", range(1, 7))
@pytest.mark.parametrize("on_r", [False, True])
def test_pulses_come_back_from_millimetres(axes: int, on_r: bool) -> None:
    """Pulses, converted to millimetres and back, do not change, for any number of axes.

    Rule: coordinates.
    """
    frame = Frame(
        (1000.0, 700.0, 300.0, 100.0, 50.0, 1.5)[:axes],
        shift=(1_000, -2_000, 3_000, 33_000),
        hand=(4_000, 5_000, -6_000),
        on_r=on_r,
    )
    pulses = (12_345, -6_789, 1_111, 2_222, 3_333, -4_444)[:axes]
    assert frame.to_pulses(frame.to_mm(pulses)) == pytest.approx(pulses)


def test_a_distance_in_tool_coordinates_turns_with_a_hand_on_the_r_axis() -> None:
    """In the shifted coordinates R is 30 degrees, so (10, 0) mm of the tool is (8.660, 5) mm.

    Rule: coordinates.
    """
    mm, way = (0, 0, 0, 30_000), (10_000, 0, 1_000, 500)
    on_r = Frame((1000,) * 4, hand=(5_000, 0, 0), on_r=True)
    assert on_r.tool_to_mm(mm, way) == pytest.approx((8_660.25, 5_000, 1_000, 30_500))
    assert Frame((1000,) * 4).tool_to_mm(mm, way) == (10_000, 0, 1_000, 30_500)


# Movements


def test_a_path_that_passes_its_target_on_the_way_is_not_done_there() -> None:
    """A path does not end when it passes its target on the way.

    Examples are an arc that begins beside its end, and an arch axis that rises past its target.

    Rule: arrival.
    """
    frame = Frame((1000, 1000))
    arc = Arc((0, 0), (200, 0), (0, 1))
    motion, positions = Motion(), [0, 0, 0]
    round_trip = CurvePath(arc, Profile(0, 10, 0), frame, {0: 0, 1: 1}, {0: 0, 1: 1})
    motion.start(1, Movement(round_trip, 0, tolerance={0: 10, 1: 10}))
    arch = ArchPath(_move(0, 200), _move(200, 50), PtpPath([]), 0, 0)
    motion.start(2, Movement(arch, 0, tolerance={2: 10}))
    motion.advance(5_000, positions)
    assert motion.moving(1)
    motion.advance(500_000, positions)
    assert positions[2] == 50
    assert motion.moving(2)
    motion.advance(3_450_000, positions)
    assert positions[2] == 55
    assert not motion.moving(2)
    motion.advance(9_950_000, positions)
    assert not motion.moving(1)
