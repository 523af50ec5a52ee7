"""Remote commands move a robot with the arms of a YK400XE: 225 and 175 mm.

Most tests use the point x = 150, y = 240 mm, which is 283.02 mm from the base.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest

from movements import ABNORMAL, NORMAL, mover, way_of
from rcx_harness.robot import Hand, Point, RobotConfig
from rcx_harness.spec import alarms, command, public_alarms
from robot_master import Master, abnormal_end

PTP, LINE, ARC, ARM, ARM_STATUS, POSITION = 0x1001, 0x1003, 0x1004, 0x103D, 0x150C, 0x1506
X, Y, Z, R = 1, 2, 4, 8
#: Positions to the right of the robot, in front of it, and out of reach of the arms.
RIGHT, FRONT, FAR = (150_000, 240_000), (0, 285_044), (300_000, 300_000)
LEFT_HANDED = 2


def _words(name: str, **values: Any) -> tuple[int, ...]:
    """Return the words of a command to robot 1, by the names of its fields."""
    return command(name).encode(values, 1)


_DRIVE_X = _words("DriveDirectMm", axes=X, target=10_000)


def _point(place: tuple[int, int], z: int = 50_000, r: int = 0, hand: int = 0) -> Point:
    return Point((*place, z, r, 0, 0), mm=True, hand=hand)


def _robot(at: int = 0, **config: Any) -> Master:
    """Return the robot with its servos on, at point number `at`, or at 0 pulses if `at` is 0."""
    points = {
        1: _point(RIGHT),
        2: _point((-150_000, 240_000)),
        3: _point(RIGHT, hand=LEFT_HANDED),
        4: _point(FAR),
        5: _point((0, 399_900)),
        8: _point((0, 399_000)),
        6: _point(FRONT, z=20_000),
        7: _point((0, 300_000), hand=1),
    }
    master = mover(**{"robot": "YK400XE", "points": points, **config})
    if at:
        master.execute(PTP, 0, 0, 0, at)
    return master


def _at(master: Master) -> tuple[float, ...]:
    """Return the position of the tool from the position reference [mm, degree]."""
    low_words = master.execute(POSITION)[4:12]
    pairs = zip(low_words[::2], low_words[1::2], strict=True)
    values = [low | high << 16 for low, high in pairs]
    return tuple((value - (value >> 31 << 32)) / 1000 for value in values)


def _mm(master: Master, pulses: tuple[int, ...]) -> tuple[float, ...]:
    return tuple(one / 1000 for one in master.robot.machine.arm(1).frame.to_mm(pulses))


def test_a_point_in_millimetres_is_reached_with_the_designated_arm() -> None:
    """Axis 2 is at acos((283.02^2 - 225^2 - 175^2) / (2 * 225 * 175)) = 88.83 degrees.

    The angle of the right-handed arm is positive. The coordinate R is 0.

    Rule: robot-arm.
    """
    master = _robot()
    assert master.execute(PTP, 0, 0, 0, 1)[0] == NORMAL
    assert _at(master) == pytest.approx((150, 240, 50, 0), abs=0.01)
    cosine = (150**2 + 240**2 - 225**2 - 175**2) / (2 * 225 * 175)
    pulses = 613 + math.degrees(math.acos(cosine)) * 2923.9
    assert master.robot.positions[1] == pytest.approx(pulses, abs=2)
    assert master.execute(ARM_STATUS)[4 - 2] == 0


def test_a_point_with_a_hand_system_is_reached_with_that_arm() -> None:
    """With the other hand system, axis 2 bends to the other side for the same position.

    The arm status command shows the present hand system.

    Rule: robot-arm.
    Source: remote command guide 4.2.1, 4.7.10
    """
    master = _robot(at=1)
    right = master.robot.positions[1] - 613
    assert master.execute(PTP, 0, 0, 0, 3)[0] == NORMAL
    assert _at(master) == pytest.approx((150, 240, 50, 0), abs=0.01)
    assert master.robot.positions[1] - 613 == pytest.approx(-right, abs=2)
    assert master.execute(ARM_STATUS)[2] == 1


def test_a_changed_arm_designation_decides_for_points_without_a_hand_system() -> None:
    """Rule: robot-arm. Source: remote command guide 4.2.19."""
    master = _robot()
    assert master.execute(ARM, 0, 1)[0] == NORMAL
    master.execute(PTP, 0, 0, 0, 1)
    assert master.robot.positions[1] < 0


def test_with_ptp_the_joints_turn_evenly_and_the_tool_moves_on_a_curve() -> None:
    """In front of the robot, the curve's middle is farther from the base than a straight line."""
    master = _robot(at=1)
    way = way_of(master, PTP, 0, 0, 0, 2)
    first, last = way[0], way[-1]
    for at in way:
        share = (at[0] - first[0]) / (last[0] - first[0])
        assert at[1] == pytest.approx(first[1] + (last[1] - first[1]) * share, abs=2)
    middle = _mm(master, way[len(way) // 2])
    assert math.hypot(*middle[:2]) == pytest.approx(math.hypot(150, 240), abs=0.1)
    assert middle[1] > 270


def test_a_line_is_straight_in_millimetres() -> None:
    """Y stays at 240 mm, except for rounding to pulses (0.0024 mm for each axis).

    The hand system and R do not change.
    """
    master = _robot(at=1)
    way = way_of(master, LINE, 0, 0, 0, 2)
    assert len(way) > 20
    places = [_mm(master, at) for at in way]
    assert all(place[1] == pytest.approx(240, abs=0.005) for place in places)
    assert all(place[2:] == pytest.approx((50, 0), abs=0.003) for place in places)
    assert [place[0] for place in places] == sorted((p[0] for p in places), reverse=True)
    assert places[-1][0] == pytest.approx(-150, abs=0.005)
    assert all(at[1] > 613 for at in way)


def test_a_line_respects_the_speed_and_acceleration_of_each_axis() -> None:
    """In each cycle of 5 ms, each axis respects its speed and its acceleration.

    One pulse is allowed for rounding.
    """
    master = _robot(at=1)
    way = way_of(master, *_words("MoveLinear", speed_mode=3, speed=1000, point=2))
    for place, axis in enumerate(master.robot.config.axes):
        steps = [b[place] - a[place] for a, b in pairwise(way)]
        assert max(map(abs, steps)) <= axis.max_speed * 0.005 + 1
        changes = [b - a for a, b in pairwise(steps)]
        assert max(map(abs, changes)) <= axis.max_acceleration * 0.005**2 + 2


def test_an_arc_is_round_in_millimetres() -> None:
    """The arc goes from (150, 240) through (0, 300) to (-150, 240) mm.

    The radius is 217.5 mm, and the centre is (0, 82.5) mm.
    """
    master = _robot(at=1)
    way = way_of(master, ARC, 0, 0, 0, 7, 2)
    for at in way:
        x, y = _mm(master, at)[:2]
        assert math.hypot(x, y - 82.5) == pytest.approx(217.5, abs=0.02)
    assert max(_mm(master, at)[1] for at in way) == pytest.approx(300, abs=0.05)


@pytest.mark.parametrize(
    ("words", "alarm"),
    [
        pytest.param((LINE, 0, 0, 0, 4), "2.335", id="line out of reach"),
        pytest.param(
            _words("MoveDirectMm", targets=(*RIGHT, 151_000, 0, 0, 0)), "2.334", id="z too deep"
        ),
        pytest.param(
            _words("DriveIDirectMm", axes=Y, distance=1_000), "2.337", id="drivei y in mm"
        ),
        pytest.param(
            _words("MoveArch", point=2, arch_unit=1, arch_axis=X), "2.337", id="arch along x in mm"
        ),
    ],
)
def test_a_movement_beyond_the_arms_ends_in_an_alarm(words: tuple[int, ...], alarm: str) -> None:
    """Rule: robot-limits, alarm-names.

    Source: names of the public list; 2.334: remote command guide 1.1
    """
    master = _robot(at=1)
    before = list(master.robot.positions)
    assert master.execute(*words) == abnormal_end(alarm)
    assert master.robot.positions == before


@pytest.mark.parametrize(
    ("knob", "default", "at", "words"),
    [
        ("out_of_reach_alarm", "2.335", 1, (PTP, 0, 0, 0, 4)),
        ("outer_range_alarm", "2.352", 1, (LINE, 0, 0, 0, 5)),
        ("to_left_alarm", "2.319", 1, (LINE, 0, 0, 0, 3)),
        ("to_right_alarm", "2.320", 3, (LINE, 0, 0, 0, 7)),
        ("drive_xy_alarm", "2.337", 1, _DRIVE_X),
    ],
)
def test_a_key_sets_each_alarm_of_a_limit_of_the_arms(
    knob: str, default: str, at: int, words: tuple[int, ...]
) -> None:
    """Rule: robot-limits."""
    assert _robot(at=at).execute(*words) == abnormal_end(default)
    assert _robot(at=at, **{knob: "9.9"}).execute(*words) == abnormal_end("9.9")


def test_a_key_sets_the_angle_of_the_outer_range() -> None:
    """The key sets the smallest angle of axis 2 on a line. The default is 3 degrees.

    At y = 399 mm axis 2 is at 8.2 degrees: cos = (399^2 - 225^2 - 175^2) / (2 * 225 * 175). With a
    limit of 8.5 degrees, the line to this point is refused.

    Rule: robot-limits.
    """
    assert math.degrees(math.acos((399**2 - 225**2 - 175**2) / 78_750)) == pytest.approx(
        8.2, abs=0.1
    )
    for angle, alarm in ((8.0, None), (8.5, "2.352")):
        master = _robot(at=1, outer_angle=angle)
        answer = master.execute(LINE, 0, 0, 0, 8)
        assert answer == abnormal_end(alarm) if alarm else answer[0] == NORMAL


def test_a_stretched_arm_refuses_a_line_and_accepts_ptp() -> None:
    """At power-on all axes are at 0, so the arm is stretched. Rule: robot-limits."""
    master = _robot()
    assert master.execute(LINE, 0, 0, 0, 1) == abnormal_end("2.352")
    assert master.execute(PTP, 0, 0, 0, 1)[0] == NORMAL


def test_a_relative_movement_in_millimetres_moves_the_tool_by_that_distance() -> None:
    """The tool moves 100 mm to the left and 20 mm down; the hand system stays the same."""
    master = _robot(at=3)
    distances = (-100_000, 0, 20_000, 0, 0, 0)
    words = _words("MoveIDirectMm", axis_designation=1, axes=X | Z, distances=distances)
    assert master.execute(*words)[0] == NORMAL
    assert _at(master) == pytest.approx((50, 240, 70, 0), abs=0.01)
    assert master.execute(ARM_STATUS)[2] == 1


def test_z_alone_is_driven_in_millimetres_downwards() -> None:
    """0 mm are -1707 pulses and 150 mm are 250 000 pulses, so 75 mm are 124 146.5 pulses."""
    master = _robot()
    assert master.execute(*_words("DriveDirectMm", axes=Z, target=75_000))[0] == NORMAL
    assert master.robot.positions[2] in (124_146, 124_147)


def test_r_alone_is_driven_to_its_angle_in_the_coordinates() -> None:
    """Axes 1 and 2 do not move."""
    master = _robot(at=1)
    before = master.robot.positions[:3]
    assert master.execute(*_words("DriveDirectMm", axes=R, target=45_000))[0] == NORMAL
    assert master.robot.positions[:3] == before
    assert _at(master)[3] == pytest.approx(45, abs=0.01)


def test_a_jog_along_x_goes_straight_until_an_axis_or_the_outer_range() -> None:
    """Y stays at 240 mm.

    At x = sqrt(399.86^2 - 240^2) = 319.8 mm, axis 2 has reached the limit of 3 degrees.
    """
    master = _robot(at=1)
    answer = master.execute(*_words("JogCartesian", axes=X))
    assert answer[:3] == (ABNORMAL, 2, 334)
    x, y, *_ = _at(master)
    assert y == pytest.approx(240, abs=0.01)
    assert x == pytest.approx(319.8, abs=0.2)


def test_the_tool_at_the_end_of_a_hand_on_r_goes_to_the_point() -> None:
    """The flange is 30 mm before the point if the hand is 30 mm long and R is 0."""
    master = _robot(hands={(1, 3): Hand((30_000, 0, 10_000, 1))})
    assert master.execute(*_words("SelectHand", hand_number=3))[0] == NORMAL
    master.execute(PTP, 0, 0, 0, 1)
    assert _at(master) == pytest.approx((150, 240, 50, 0), abs=0.01)
    assert master.execute(*_words("SelectHand", hand_number=0))[0] == NORMAL
    assert _at(master) == pytest.approx((120, 240, 40, 0), abs=0.01)


def test_the_public_list_has_every_alarm_that_a_knob_takes_from_it() -> None:
    """The list has all alarms that the manual names. It lists 4.2 as 4.202.

    Alarms 5.997 to 5.999 are additions of this project.

    Rule: alarm-list, alarm-names.
    """
    config = RobotConfig()
    keys = [key for key in vars(config) if key.endswith("_alarm")]
    ours = {value for key in keys if isinstance(value := getattr(config, key), str)}
    assert ours - {"", "4.2", "5.997", "5.998", "5.999"} <= set(public_alarms())
    named = {alarm.number: alarm.name for alarm in alarms().values() if alarm.section}
    assert named.pop("4.2") == public_alarms()["4.202"]
    assert named.items() <= public_alarms().items()
    assert "4.2" not in public_alarms()
    assert public_alarms()["4.202"] == "Input format error"
    assert public_alarms()[config.servo_off_alarm] == "Servo off"
    assert public_alarms()[config.undefined_code_alarm] == "Illegal remote command"


def test_a_line_without_a_hand_system_keeps_the_present_hand_system() -> None:
    """The robot stays left-handed although the arm designation is right-handed. Rule: robot-arm."""
    master = _robot(at=3)
    assert master.execute(LINE, 0, 0, 0, 2)[0] == NORMAL
    assert _at(master) == pytest.approx((-150, 240, 50, 0), abs=0.01)
    assert master.execute(ARM_STATUS)[2] == 1


def test_near_the_base_a_line_respects_the_acceleration_of_each_axis() -> None:
    """On the line y = 120 mm the arms fold and unfold near the base.

    Each axis respects its acceleration; the test allows 2 pulses for rounding.
    """
    points = {1: _point((150_000, 120_000)), 2: _point((-150_000, 120_000))}
    master = _robot(at=1, points=points)
    way = way_of(master, *_words("MoveLinear", speed_mode=3, speed=1000, point=2))
    for place, axis in enumerate(master.robot.config.axes):
        steps = [b[place] - a[place] for a, b in pairwise(way)]
        changes = [abs(b - a) for a, b in pairwise(steps)]
        assert max(changes) <= axis.max_acceleration * 0.005**2 + 2


def test_r_alone_is_driven_with_a_hand_on_it_too() -> None:
    """Axes 1 and 2 stay while the hand of 30 mm turns about the flange at x = 120 mm.

    At 45 degrees the hand's end is at 120 + 21.21 and 240 + 21.21 mm.
    """
    master = _robot(hands={(1, 3): Hand((30_000, 0, 10_000, 1))})
    master.execute(*_words("SelectHand", hand_number=3))
    master.execute(PTP, 0, 0, 0, 1)
    before = master.robot.positions[:3]
    assert master.execute(*_words("DriveDirectMm", axes=R, target=45_000))[0] == NORMAL
    assert master.robot.positions[:3] == before
    assert _at(master) == pytest.approx((141.213, 261.213, 50, 45), abs=0.02)


def test_a_hand_beside_r_changes_arm_2_in_the_commands() -> None:
    """A hand beside the R axis changes the length and angle of arm 2 for commands, too.

    All axes are at 0 degrees. The hand turns arm 2 by 10 degrees (29 239 pulses) and makes it 25 mm
    longer. The end is 200 mm * sin 10 to the left and 225 + 200 * cos 10 mm in front.

    Rule: robot-hand.
    """
    plain = RobotConfig(robot=("YK400XE",)).axes
    axes = tuple(replace(axis, start=axis.zero) for axis in plain)
    master = _robot(axes=axes, hands={(1, 3): Hand((29_239, 25_000, 5_000, 0))})
    master.execute(*_words("SelectHand", hand_number=3))
    assert _at(master) == pytest.approx((-34.730, 421.962, 5, 90), abs=0.01)
    assert master.execute(PTP, 0, 0, 0, 1)[0] == NORMAL
    assert _at(master) == pytest.approx((150, 240, 50, 0), abs=0.01)


def test_a_movet_by_a_point_in_pulses_moves_each_axis_by_its_value() -> None:
    points = {1: _point(RIGHT), 9: Point((-5_000, 7_000, 900, -300, 0, 0))}
    master = _robot(at=1, points=points)
    before = list(master.robot.positions)
    assert master.execute(*_words("MoveTPtp", point=9))[0] == NORMAL
    ways = (-5_000, 7_000, 900, -300)
    assert master.robot.positions == [at + way for at, way in zip(before, ways, strict=True)]


def test_a_movement_along_the_tool_takes_the_hand_system_of_its_point() -> None:
    """The robot moves 10 mm along X of the tool and ends left-handed."""
    points = {1: _point(RIGHT), 9: Point((10_000, 0, 0, 0, 0, 0), mm=True, hand=LEFT_HANDED)}
    master = _robot(at=1, points=points)
    assert master.execute(*_words("MoveTPtp", point=9))[0] == NORMAL
    assert _at(master) == pytest.approx((160, 240, 50, 0), abs=0.01)
    assert master.execute(ARM_STATUS)[2] == 1
