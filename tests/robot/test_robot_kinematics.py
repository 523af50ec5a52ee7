"""Forward and inverse kinematics of SCARA robots agree with values calculated by hand.

Arm lengths are those of the data sheets: 225 and 175 mm for the YK400XE, 600 and 600 mm for the
YK1200XG. Lengths are in 0.001 mm, angles in 0.001 degree.
"""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcx_harness.robot.geometry import Frame
from rcx_harness.robot.kinematics import CARTESIAN, Scara, UnreachableError

YK400, YK1200 = Scara(225_000, 175_000), Scara(600_000, 600_000)
LEFT = Scara(225_000, 175_000, left=True)
RIGHT_ANGLE, TURN = 90_000, 360_000


@pytest.mark.parametrize(
    ("joints", "place"),
    [
        ((0, 0, 0, 0), (0, 400, 0, 90)),
        ((90, 0, 10, 0), (-400, 0, 10, 180)),
        ((-90, 0, 10, 90), (400, 0, 10, 90)),
        ((0, 90, 150, 0), (-175, 225, 150, 180)),
        ((0, -90, 0, 0), (175, 225, 0, 0)),
        ((90, -90, 0, -90), (-225, 175, 0, 0)),
        ((-60, 120, 0, 30), (337.5 * math.sqrt(1 / 3) - 87.5, 200, 0, 180)),
    ],
)
def test_forward_kinematics_gives_the_position_of_the_hand(
    joints: tuple[float, ...], place: tuple[float, ...]
) -> None:
    """At 0 degrees the arms lie along Y.

    Positive angles turn to -X. R is the sum of the angles plus 90 degrees.

    With -60 and 120 degrees, arm 1 points 30 degrees above X (194.86, 112.5 mm) and arm 2 points at
    150 degrees (-151.55, 87.5 mm).

    Rule: robot-coordinates, robot-arm.
    Source: public driver of the YK400XE, joints.xacro and README
    """
    found = YK400.forward([1000 * joint for joint in joints])
    if joints[0] == -60:
        place = (194.856 - 151.554, *place[1:])
    assert found == pytest.approx([1000 * one for one in place], abs=1)


@pytest.mark.parametrize(("arm", "sign"), [(YK400, 1), (LEFT, -1)])
def test_both_arms_reach_the_same_place(arm: Scara, sign: int) -> None:
    """The point is at x = 0 and y = 285.044 mm, where axis 2 is at +-90 degrees.

    Axis 1 is -+atan(175 / 225) = 37.875 degrees. The elbow of the right arm is at the right.

    Rule: robot-arm.
    """
    joints = arm.inverse([0, 285_044, 0, 90_000])
    assert joints == pytest.approx([sign * -37_875, sign * 90_000, 0, sign * -52_125], abs=1)
    elbow_x = -math.sin(math.radians(joints[0] / 1000))
    assert elbow_x * sign > 0
    assert arm.bend(joints) == pytest.approx(sign * 90, abs=0.001)


@pytest.mark.parametrize("place", [(0, 400_010), (0, 49_990), (0, 0), (-300_000, 300_000)])
def test_a_position_that_the_arms_do_not_reach_is_refused(place: tuple[int, int]) -> None:
    """The arms reach from 225 - 175 to 225 + 175 mm. Rule: robot-limits."""
    with pytest.raises(UnreachableError):
        YK400.inverse([*place, 0, 0])


def test_positions_on_the_border_of_the_range_are_reached() -> None:
    assert YK400.inverse([0, 400_000, 0, 90_000])[:2] == pytest.approx([0, 0], abs=1)
    assert YK400.inverse([0, 50_000, 0, 0])[1] == pytest.approx(180_000, abs=1)


def _angles(limit: int) -> st.SearchStrategy[float]:
    return st.floats(-limit, limit, allow_nan=False)


@given(
    first=_angles(132_000),
    second=_angles(150_000),
    z=_angles(150_000),
    r=_angles(TURN),
    turned=st.one_of(st.just(0.0), _angles(TURN)),
)
def test_forward_then_inverse_gives_the_same_joints(
    first: float, second: float, z: float, r: float, turned: float
) -> None:
    """The test calculates the position of random joints, and the joints of this position.

    Nearly stretched and folded poses are left out, because their joints are less exact.
    """
    joints = [first, second, z, r]
    arm = Scara(225_000, 175_000, turned)
    bend = arm.bend(joints)
    assert bend is not None
    back = Scara(225_000, 175_000, turned, left=bend < 0).inverse(arm.forward(joints))
    near = 1.0 if 1 < abs(bend) < 179 else 60.0
    assert back == pytest.approx(joints, abs=near)


@pytest.mark.parametrize(
    ("second", "turned"), [(110, 80), (-110, -80), (150, 180), (-150, -180), (150, 350)]
)
def test_axis_2_stays_within_half_a_turn_with_a_turned_hand(second: int, turned: int) -> None:
    """With a hand turned by 80 degrees and axis 2 at 110 degrees, the arm is bent by -170 degrees.

    R makes no whole turn.

    Rule: robot-hand.
    """
    line = math.radians(second + turned)
    x, y = -175_000 * math.sin(line), 225_000 + 175_000 * math.cos(line)
    arm = Scara(225_000, 175_000, 1000 * turned, left=math.sin(line) < 0)
    found = arm.inverse([x, y, 0, 1000 * second + RIGHT_ANGLE])
    assert found == pytest.approx([0, 1000 * second, 0, 0], abs=1)


@given(
    x=st.floats(-1_150_000, 1_150_000),
    y=st.floats(-1_150_000, 1_150_000),
    r=_angles(TURN),
    left=st.booleans(),
)
def test_inverse_then_forward_gives_the_same_position(
    x: float, y: float, r: float, left: bool
) -> None:
    arm = Scara(600_000, 600_000, left=left)
    if not 1_000 < math.hypot(x, y) < 1_199_999:
        return
    joints = arm.inverse([x, y, 5, r])
    assert -180_000 <= joints[0] <= 180_000
    assert arm.forward(joints) == pytest.approx([x, y, 5, r], abs=0.01)


@given(
    pulses=st.tuples(*[st.integers(-380_000, 380_000)] * 2, st.integers(0, 250_000),
                     st.integers(-245_000, 245_000)),
    shift=st.tuples(*[st.integers(-50_000, 50_000)] * 4),
    tool=st.tuples(*[st.integers(-50_000, 50_000)] * 3),
    on_r=st.booleans(),
)  # fmt: skip
def test_tool_and_shift_are_taken_back_exactly(
    pulses: tuple[int, ...], shift: tuple[int, ...], tool: tuple[int, ...], on_r: bool
) -> None:
    """Pulses, converted to millimetres and back, do not change, with every hand and shift."""
    frame = Frame(
        (2901.75, 2923.9, 1678.05, 682.67),
        shift=shift,
        hand=tool if on_r else (0, 0, tool[2]),
        on_r=on_r,
        zeros=(-2476, 613, -1707, 0),
        kinematics=Scara(225_000, 175_000, left=pulses[1] < 613),
    )
    if abs(frame.bend(pulses) or 0.0) < 1:
        return
    assert [round(one) for one in frame.to_pulses(frame.to_mm(pulses))] == list(pulses)


def test_a_hand_beside_the_r_axis_changes_length_and_angle_of_arm_2() -> None:
    """The hand adds 10 degrees and 25 mm.

    With all axes at 0, the hand is at X -200 sin 10 and Y 225 + 200 cos 10.

    Rule: robot-hand.
    """
    arm = Scara(225_000, 200_000, offset=10_000)
    place = arm.forward([0, 0, 0, 0])
    across, along = 200_000 * math.sin(math.radians(10)), 200_000 * math.cos(math.radians(10))
    assert place == pytest.approx([-across, 225_000 + along, 0, RIGHT_ANGLE])
    assert arm.inverse(place) == pytest.approx([0, 0, 0, 0], abs=0.01)


def test_the_axes_of_a_cartesian_robot_are_its_coordinates() -> None:
    assert CARTESIAN.forward((1, 2, 3, 4)) == CARTESIAN.inverse((1, 2, 3, 4)) == [1, 2, 3, 4]
    assert CARTESIAN.bend((1, 2, 3, 4)) is None
    assert CARTESIAN.straight
    assert not YK1200.straight
