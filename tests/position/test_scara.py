"""FB_ScaraForward and FB_ScaraInverse agree with poses calculated by hand and with the model.

The poses have both hand systems, hands and shifts. The arms have 225 and 175 mm unless a test says
otherwise.
"""

from __future__ import annotations

import math
import random
from typing import Any

import pytest

from scara_bench import ON_BOTH, UNIT, forward, inverse, scara, with_arm
from scara_poses import LIMITS, Pose, compare, poses


@ON_BOTH
@pytest.mark.parametrize(
    ("joints", "place", "hand"),
    [
        ((0, 0, 0, 0), (0, 400, 0, 90), "HAND_RIGHT"),
        ((90, 0, 10, 0), (-400, 0, 10, 180), "HAND_RIGHT"),
        ((-90, 0, 10, 90), (400, 0, 10, 90), "HAND_RIGHT"),
        ((0, 90, 150, 0), (-175, 225, 150, 180), "HAND_RIGHT"),
        ((0, -90, 0, 0), (175, 225, 0, 0), "HAND_LEFT"),
        ((90, -90, 0, -90), (-225, 175, 0, 0), "HAND_LEFT"),
        ((-60, 120, 0, 30), (194.856 - 151.554, 112.5 + 87.5, 0, 180), "HAND_RIGHT"),
        ((0, 179, 0, -360), (-3.054, 50.027, 0, -91), "HAND_RIGHT"),
    ],
)
def test_the_position_of_the_tool_follows_from_the_axes(
    engine: str, joints: tuple[float, ...], place: tuple[float, ...], hand: str
) -> None:
    """The position follows from the axes. At 0 degrees the arms lie along Y.

    Positive angles turn to -X. R is the sum of the angles plus 90. With -60 and 120 degrees, arm 1
    points 30 degrees above X (194.856, 112.5 mm) and arm 2 points
    at 150 degrees (-151.554, 87.5 mm). With axis 2 at 179 degrees, X is -175 sin 179 and Y is 225 +
    175 cos 179.

    Rule: robot-coordinates, robot-arm.
    Source: public driver of the YK400XE, joints.xacro and README
    """
    position, shown, error = forward(joints, engine)
    assert error == 0
    assert position == pytest.approx([*place, 0, 0], abs=0.001)
    assert shown == hand


@ON_BOTH
@pytest.mark.parametrize(("hand", "sign"), [("HAND_RIGHT", 1), ("HAND_LEFT", -1)])
def test_both_arms_reach_the_same_place(engine: str, hand: str, sign: int) -> None:
    """Right-handed and left-handed poses reach the same position.

    At x = 0 and y = 285.044 mm (diagonal of a right angle), axis 2 is +-90 degrees. Axis 1 is
    -+atan(175 / 225) = 37.875 degrees. The elbow of the right arm is at the right. R is
    90 degrees: for the right arm 90 - 37.875 + 90 - 52.125, for the left arm 90 + 37.875 - 90 +
    52.125.

    Rule: robot-arm.
    """
    joints, error = inverse([0, 285.044, 5, 90], hand, engine)
    assert error == 0
    expected = [sign * -37.875, sign * 90, 5, sign * -52.125, 0, 0]
    assert joints == pytest.approx(expected, abs=0.002)


@ON_BOTH
@pytest.mark.parametrize(
    ("place", "joints"),
    [
        ((0, 400, 0, 90), (0, 0, 0, 0)),
        ((-400, 0, 10, 180), (90, 0, 10, 0)),
        ((400, 0, 10, 90), (-90, 0, 10, 90)),
        ((-175, 225, 150, 180), (0, 90, 150, 0)),
        ((0, -400, 0, 90), (-180, 0, 0, 180)),
        ((0, 50, 0, 0), (0, 180, 0, -270)),
        ((0, -50, 0, 0), (-180, 180, 0, -90)),
        ((0, 400.009, 0, 90), (0, 0, 0, 0)),
        ((0, 49.991, 0, 0), (0, 180, 0, -270)),
    ],
)
def test_the_axes_of_a_right_handed_pose(
    engine: str, place: tuple[float, ...], joints: tuple[float, ...]
) -> None:
    """The axes of right-handed poses are correct: arms stretched, folded or at a right angle.

    Behind the base, axis 1 is at -180 degrees. A position 0.01 mm beyond the reach is accepted as a
    result of rounding.

    Rule: robot-arm.
    """
    found, error = inverse(place, "HAND_RIGHT", engine)
    assert error == 0
    assert found == pytest.approx([*joints, 0, 0], abs=0.002)


@pytest.mark.parametrize(
    "place", [(0, 400.011), (0, 49.989), (0, 0), (-300, 300), (0, -49.989), (283, -283)]
)
@pytest.mark.parametrize("hand", ["HAND_RIGHT", "HAND_LEFT"])
def test_a_position_out_of_reach_is_refused(place: tuple[float, float], hand: str) -> None:
    """A position outside of the reach, 225 - 175 to 225 + 175 mm, is refused.

    The point 283, 283 mm is 400.2 mm away.

    Rule: robot-limits.
    """
    assert inverse(place, hand) == ([0] * 6, 0x8060)


@ON_BOTH
@pytest.mark.parametrize(("far", "bend"), [(399.999, 0.258), (50.005, 179.796)])
def test_near_the_stretched_or_folded_pose_axis_2_is_exact(
    engine: str, far: float, bend: float
) -> None:
    """Near the stretched or folded pose, axis 2 has the exact angle of the bend.

    The law of cosines gives cos = (far^2 - 225^2 - 175^2) / (2 * 225 * 175).
    For 399.999 mm that is 1 - 1.0159E-5, and for 50.005 mm 6.349E-6 - 1.

    Rule: robot-arm.
    """
    joints, error = inverse([0, far, 0, 90], "HAND_RIGHT", engine)
    assert error == 0
    assert joints[1] == pytest.approx(bend, abs=0.01)


@pytest.mark.parametrize(("far", "error"), [(0.007, 0x8060), (0.011, 0), (0.05, 0)])
def test_equal_arms_reach_to_a_hundredth_of_a_millimetre_from_the_base(
    far: float, error: int
) -> None:
    """Equal arms reach to 0.01 mm from the base. Axis 2 is then at 179.985 to 180 degrees.

    Rule: robot-limits.
    """
    joints, found = inverse([0, far, 0, 90], "HAND_RIGHT", Arm1=200.0, Arm2=200.0)
    assert found == error
    assert joints[1] == pytest.approx(0 if error else 180, abs=0.02)


@pytest.mark.parametrize("arms", [(200.0, 200.0), (150.0, 250.0)])
def test_arms_of_other_lengths(arms: tuple[float, float]) -> None:
    """Arms of other lengths are calculated correctly, with a right angle between the arms.

    Arms of equal length would reach the base itself, where the direction is undefined: this is
    refused. If arm 2 is longer, it extends beyond the base when it is folded.
    """
    own: dict[str, Any] = {"Arm1": arms[0], "Arm2": arms[1]}
    joints, error = inverse([-arms[1], arms[0], 0, 180], "HAND_RIGHT", **own)
    assert error == 0
    assert joints == pytest.approx([0, 90, 0, 0, 0, 0], abs=0.002)
    beyond = arms[0] - arms[1]
    joints, error = inverse([0, beyond, 0, 270], "HAND_RIGHT", **own)
    if beyond:
        assert joints == pytest.approx([0, 180, 0, 0, 0, 0], abs=0.002)
    else:
        assert error == 0x8060


@ON_BOTH
@pytest.mark.parametrize(
    ("data", "place"), [((100, 0, 20), (0, 500, 20, 90)), ((0, 100, 0), (-100, 400, 0, 90))]
)
def test_a_hand_on_the_r_axis_turns_with_it(
    engine: str, data: tuple[float, ...], place: tuple[float, ...]
) -> None:
    """A hand on the R axis turns with R. With all axes at 0, R is 90 degrees.

    X of the hand then lies along Y, and Y of the hand along -X.

    Rule: robot-hand.
    Source: remote command guide 4.3.5
    """
    hand: dict[str, Any] = {f"HandData{k}": float(one) for k, one in enumerate(data, 1)}
    hand |= {"HandMount": "HAND_ON_R_AXIS"}
    assert forward([0] * 4, engine, **hand)[0] == pytest.approx([*place, 0, 0], abs=0.001)
    joints, _ = inverse([place[0] - 175, place[1] - 175, place[2], 90], "HAND_RIGHT", **hand)
    assert joints[:2] == pytest.approx([0, 90], abs=0.002), "the flange is 175 mm left and back"
    assert joints[3] == pytest.approx(-90, abs=0.002)


@ON_BOTH
def test_a_hand_beside_the_r_axis_acts_as_another_arm_2(engine: str) -> None:
    """A hand beside the R axis acts as another arm 2: here with 10 degrees and 25 mm more.

    With all axes at 0, the hand is at -200 sin 10, 225 + 200 cos 10. The pose is right-handed: the
    elbow is at the right of the line to the hand.

    Rule: robot-hand.
    Source: remote command guide 4.3.5: data 1 is an integer, data 2 and 3 are in 0.001 mm
    """
    hand: dict[str, Any] = {"HandData1Integer": 10 * UNIT, "HandData2": 25.0, "HandData3": 7.0}
    position, shown, _ = forward([0] * 4, engine, **hand)
    assert position == pytest.approx([-34.730, 421.962, 7, 90, 0, 0], abs=0.001)
    assert shown == "HAND_RIGHT"
    joints, _ = inverse(position, shown, engine, **hand)
    assert joints == pytest.approx([0] * 6, abs=0.002)
    assert forward([0, -5, 0, 0], **hand)[1] == "HAND_RIGHT"
    assert forward([0, -11, 0, 0], **hand)[1] == "HAND_LEFT"


@ON_BOTH
@pytest.mark.parametrize("turn", [-360, -180, -80, 80, 100, 180, 350])
@pytest.mark.parametrize("axis2", [-150, -110, -10, 10, 110, 150])
def test_axis_2_is_within_half_a_turn_for_any_turn_of_the_hand(
    engine: str, turn: int, axis2: int
) -> None:
    """Axis 2 is always within half a turn, however far the hand is turned.

    Arm 1 lies along Y. With a hand turned by 80 degrees and axis 2 at 110, the line to the hand is
    at 190 degrees, which is -170. Axis 2 is then at 110 degrees, not at -250, and axis 4 makes no
    turn.

    Rule: robot-hand.
    Source: remote command guide 4.3.5: data 1 is an integer; head of FB_ScaraInverse
    """
    line = math.radians(axis2 + turn)
    place = [-175 * math.sin(line), 225 + 175 * math.cos(line), 0, axis2 + 90]
    hand = "HAND_RIGHT" if math.sin(line) > 0 else "HAND_LEFT"
    joints, error = inverse(place, hand, engine, HandData1Integer=turn * UNIT)
    assert error == 0
    assert joints == pytest.approx([0, axis2, 0, 0, 0, 0], abs=0.004)


@ON_BOTH
def test_a_shift_moves_and_turns_the_coordinates(engine: str) -> None:
    """A shift moves and turns the coordinates: (0, 400) becomes (380, 10).

    The flange is at (0, 400, 0, 90). The shift is (10, 20, 5), turned by 90 degrees.

    Rule: shift-and-hand.
    Source: remote command guide 4.3.4
    """
    shift: dict[str, Any] = {"Shift": [10.0, 20.0, 5.0, 90.0]}
    position, _, _ = forward([0] * 4, engine, **shift)
    assert position == pytest.approx([380, 10, -5, 0, 0, 0], abs=0.001)
    joints, _ = inverse([380 - 175, 10 + 175, -5, 0], "HAND_RIGHT", engine, **shift)
    assert joints == pytest.approx([0, 90, 0, -90, 0, 0], abs=0.002)


@ON_BOTH
def test_the_base_transforms_into_the_users_coordinates(engine: str) -> None:
    """The base transforms positions into the user's coordinates.

    With the base at (1000, 2000, 100), turned by 90 degrees, the stretched arms lie along -X.
    """
    base: dict[str, Any] = {"Base": [1000.0, 2000.0, 100.0, 90.0]}
    position, _, _ = forward([0, 0, 3, 0], engine, **base)
    assert position == pytest.approx([600, 2000, 103, 180, 0, 0], abs=0.001)
    joints, _ = inverse([775, 1825, 103, 0], "HAND_RIGHT", engine, **base)
    assert joints == pytest.approx([0, 90, 3, -270, 0, 0], abs=0.002)


@pytest.mark.parametrize(
    ("base", "place", "axis1"),
    [
        (180.0, (0, -400), 0),
        (180.0, (0, 400), -180),
        (-180.0, (0, 400), -180),
        (170.0, (200, 346.4102), 160),
        (-170.0, (-200, 346.4102), -160),
        (170.0, (72.8942, 393.302), 179.5),
        (-170.0, (-72.8942, 393.302), -179.5),
    ],
)
def test_axis_1_is_within_half_a_turn(
    base: float, place: tuple[float, float], axis1: float
) -> None:
    """Axis 1 is always within half a turn.

    The directions are 180, 0, 0, -30, 30, -10.5 and 10.5 degrees from Y, minus the angle of the
    base. Beyond half a turn, a whole turn is added or subtracted.
    """
    joints, error = inverse([*place, 0, 0], "HAND_RIGHT", Base=[0.0, 0.0, 0.0, base])
    assert error == 0
    assert joints[:2] == pytest.approx([axis1, 0], abs=0.5), (
        "nearly stretched: compared in degrees only"
    )


def test_the_zeros_are_what_the_axes_count_from() -> None:
    zero: dict[str, Any] = {"Zero": [-2476, 613, -1707, 40, 0, 0]}
    position, _, _ = forward([-2.476, 0.613, -1.707, 0.040], **zero)
    assert position == pytest.approx([0, 400, 0, 90, 0, 0], abs=0.001)
    joints, _ = inverse([-175, 225, 10, 180], "HAND_RIGHT", **zero)
    expected = [-2.476, 90.613, 8.293, 0.040, 0, 0]
    assert joints == pytest.approx(expected, abs=0.002)


@ON_BOTH
@pytest.mark.parametrize("zero", [20_000_001, -200_000_003, 999_000_007])
def test_large_zero_positions_do_not_reduce_the_accuracy(engine: str, zero: int) -> None:
    """Zero positions with many pulses do not reduce the accuracy.

    A REAL holds whole numbers up to 16,777,216. The angles are -60 and 120 degrees.

    Source: heads of FB_ScaraForward and FB_ScaraInverse; comment of Zero
    """
    far: dict[str, Any] = {"Zero": [zero] * 4 + [0] * 2}
    turned = [zero / UNIT + joint for joint in (-60.0, 120.0, 12.345, 30.0)]
    position, _, error = forward(turned, engine, **far)
    assert error == 0
    assert position == pytest.approx([43.301, 200, 12.345, 180, 0, 0], abs=0.001)
    joints, error = inverse([43.3013, 200, 12.345, 180], "HAND_RIGHT", engine, **far)
    assert error == 0
    assert joints[:4] == pytest.approx(turned, abs=0.002)


@ON_BOTH
@pytest.mark.parametrize("turns", [-22, -10, 1, 22])
def test_whole_turns_of_the_shift_change_nothing_but_r(engine: str, turns: int) -> None:
    """Whole turns of the shift change only R. The shift is (10, 20, 5), 30 degrees and 22 turns.

    The flange at (0, 1200) is (-10, 1180) from the shift's origin, turned by -30 degrees.

    Source: head of FB_ScaraForward; remote command guide 4.3.4
    """
    own: dict[str, Any] = {
        "Arm1": 600.0,
        "Arm2": 600.0,
        "Shift": [10.0, 20.0, 5.0, 30.0 + 360 * turns],
    }
    position, _, error = forward([0] * 4, engine, **own)
    assert error == 0
    x, y = -10 * math.cos(math.radians(30)) + 590, 1180 * math.cos(math.radians(30)) + 5
    assert position[:3] == pytest.approx([x, y, -5], abs=0.001)
    assert position[3] == pytest.approx(60 - 360 * turns, abs=0.001)
    own["Shift"][:2] = [
        10.0 - 600.0,
        20.0 - 600.0,
    ]  # position of the flange with axis 2 at 90 degrees
    joints, error = inverse([x, y, -5, 150 - 360 * turns], "HAND_RIGHT", engine, **own)
    assert error == 0
    assert joints == pytest.approx([0, 90, 0, 0, 0, 0], abs=0.002)


@ON_BOTH
@pytest.mark.parametrize("turns", [-10, -1, 2, 10])
def test_whole_turns_of_the_r_axis_change_nothing_but_r(engine: str, turns: int) -> None:
    """Whole turns of the R axis change only R.

    A hand of 300 mm along X of R lies along Y if R is 90 degrees plus whole turns.

    Source: head of FB_ScaraForward
    """
    hand: dict[str, Any] = {"HandMount": "HAND_ON_R_AXIS", "HandData1": 300.0}
    position, _, error = forward([0, 0, 0, 360 * turns], engine, **hand)
    assert error == 0
    assert position[:3] == pytest.approx([0, 700, 0], abs=0.001)
    assert position[3] == pytest.approx(90 + 360 * turns, abs=0.001)
    joints, error = inverse([-175, 525, 0, 90 + 360 * turns], "HAND_RIGHT", engine, **hand)
    assert error == 0
    assert joints == pytest.approx([0, 90, 0, 360 * turns - 90, 0, 0], abs=0.002)


def test_an_axis_may_count_the_other_way() -> None:
    other: dict[str, Any] = {"PulsesPerUnit": [-1000.0, 1000.0, -1000.0, 1000.0, 0.0, 0.0]}
    position, _, _ = forward([-90, 0, -10, 0], **other)
    assert position == pytest.approx([-400, 0, 10, 180, 0, 0], abs=0.001)
    joints, _ = inverse([-400, 0, 10, 180], "HAND_RIGHT", **other)
    assert joints == pytest.approx([-90, 0, -10, 0, 0, 0], abs=0.002)


def test_an_error_clears_the_pulses_and_ends_with_its_cause() -> None:
    """Source: comments of the outputs; docs/reference/errors.md, 16#8060 and 16#8061."""
    assert inverse([-175, 225, 10, 180], "HAND_RIGHT", Zero=[500] * 4 + [0] * 2)[1] == 0
    block = scara("Inverse", "auto")
    shown = ("ErrorID", "Valid", "Pulses")
    good = [block[f"Block.{pin}"] for pin in shown]
    assert good == [
        0,
        True,
        [pytest.approx(500 + one, abs=2) for one in (0, 90_000, 10_000, 0)] + [0] * 2,
    ]
    wrong: list[tuple[str, Any, Any, int]] = [
        ("PositionMm", [0.0, 500.0, 10.0, 180.0, 0.0, 0.0], block["Block.PositionMm"], 0x8060),
        ("Arm.Arm1", 0.5, 225.0, 0x8061),
        ("Arm.HandData3", 9000.0, 0.0, 0x8061),
    ]
    for pin, bad, right, error in wrong:
        block[f"Block.{pin}"] = bad
        block.scan(0)
        assert [block[f"Block.{pin}"] for pin in shown] == [error, False, [0] * 6]
        block[f"Block.{pin}"] = right
        block.scan(0)
        assert [block[f"Block.{pin}"] for pin in shown] == good


def test_the_arm_is_right_handed_by_default() -> None:
    """Without a value for HandSystem, the pose is right-handed. Source: comment of HandSystem."""
    block = scara("Inverse", "auto")
    with_arm(block, {})
    block["Block.PositionMm"] = [0.0, 285.044, 5.0, 90.0, 0.0, 0.0]
    block.scan(0)
    assert block["Block.Pulses"][1] == pytest.approx(90 * UNIT, abs=2)


def test_axes_5_and_6_are_ignored() -> None:
    """Axes 5 and 6 of the position and of the arm have no effect.

    Source: comments of RCX_SCARA and of PositionMm.
    """
    much = [0, 0, 0, 0, 2_100_000_000, -2_100_000_000]
    joints, error = inverse([-175, 225, 10, 180, 9000.0, -9000.0], "HAND_RIGHT", Zero=much)
    assert error == 0
    assert joints == pytest.approx([0, 90, 10, 0, 0, 0], abs=0.002)
    assert forward([0, 0, 0, 0, 9000, -9000], Zero=much)[2] == 0


@pytest.mark.parametrize(
    ("axis2", "hand"),
    [
        (20, "HAND_RIGHT"),
        (170, "HAND_RIGHT"),
        (200, "HAND_LEFT"),
        (350, "HAND_LEFT"),
        (-170, "HAND_LEFT"),
        (-200, "HAND_RIGHT"),
    ],
)
def test_the_hand_system_follows_from_the_bend_of_axis_2(axis2: float, hand: str) -> None:
    """HandSystem follows from the bend of axis 2: at 200 degrees the arm is as at -160.

    Rule: robot-arm.
    """
    assert forward([0, axis2, 0, 0])[1] == hand


def test_an_error_clears_the_position_and_ends_with_its_cause() -> None:
    """Source: comments of the outputs; docs/reference/errors.md, 16#8047."""
    assert forward([30, 40, 50, 60])[2] == 0
    block = scara("Forward", "auto")
    good = block["Block.Pulses"]
    shown = ("ErrorID", "Valid", "PositionMm", "HandSystem")
    place = [block[f"Block.{pin}"] for pin in shown]
    block["Block.Pulses"] = [8_192_500, 0, 0, 0, 0, 0]
    block.scan(0)
    assert [block[f"Block.{pin}"] for pin in shown] == [0x8047, False, [0] * 6, "HAND_NONE"]
    block["Block.Pulses"] = good
    block.scan(0)
    assert [block[f"Block.{pin}"] for pin in shown] == place


def test_a_place_without_a_hand_system_has_two_answers_and_so_none() -> None:
    assert inverse([0, 300, 0, 0], "HAND_NONE") == ([0] * 6, 0x8045)
    assert inverse([0, 300, 0, 8193], "HAND_NONE")[1] == 0x8047, "no pose may be wrong"
    assert inverse([0, 300, 0, 0], "HAND_NONE", Arm1=0.0)[1] == 0x8061
    assert inverse([0, 300, 0, 8193], "HAND_RIGHT", Arm1=0.0)[1] == 0x8061


@ON_BOTH
def test_both_agree_with_the_model_of_the_controller(engine: str) -> None:
    """Both blocks agree with the model of the controller, within the bounds of their heads.

    Source: heads of FB_ScaraForward and FB_ScaraInverse; harness/rcx_harness/robot/kinematics.py
    """
    some: list[Pose] = list(poses(random.Random(22), 100))
    worst = compare(some, engine)
    assert worst.poses == len(some)
    for name, limit in LIMITS.items():
        assert 0 < getattr(worst, name) <= limit, name
