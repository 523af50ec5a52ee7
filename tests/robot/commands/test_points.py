"""Point data can be defined, read, assigned, added and subtracted."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Point
from robot_master import NORMAL_END, abnormal_end
from stored_data import long_words, power_cycle, ready

WRITE, READ, ASSIGN, ADD, SUBTRACT = 0x0100, 0x0101, 0x0230, 0x0234, 0x0235
#: Words of the point data 10000, -20000, 5000, -18000, as the guide's examples print them.
PRINTED = (0x2710, 0x0000, 0xB1E0, 0xFFFF, 0x1388, 0x0000, 0xB9B0, 0xFFFF, 0, 0, 0, 0)
PULSES = Point((10000, -20000, 5000, -18000, 0, 0))
MM = Point((10000, -20000, 5000, -18000, 0, 0), mm=True)
LEFT = Point((1, 2, 3, 4, 5, 6), mm=True, hand=2, arm1=-1, arm2=1)


def test_point_data_have_32_bits_on_each_of_six_axes() -> None:
    """Source: remote command guide 4.3.1."""
    master = ready()
    extremes = long_words(-(2**31), 2**31 - 1, -1, 1, -(2**31), 2**31 - 1)
    assert master.execute(WRITE, 0, 29999, 0, *extremes) == NORMAL_END
    assert master.execute(READ, 0, 29999) == (0x0200, 0, 29999, 0, *extremes)


@pytest.mark.parametrize(("bits", "hand"), [(0, 0), (1, 1), (2, 2), (3, 0)])
def test_bits_1_and_2_of_the_flags_are_the_hand_system(bits: int, hand: int) -> None:
    """01 is right-handed and 10 left-handed. Any other value means no hand system.

    Rule: point-hand.
    Source: remote command guide 4.3.1
    """
    master = ready()
    master.execute(WRITE, 1 | bits << 1, 7)
    assert master.execute(READ, 0, 7)[3] == 1 | hand << 1


@pytest.mark.parametrize("low", [3, 7])
@pytest.mark.parametrize(
    ("bits", "shown"), [(0b0000, 0), (0b0001, 1), (0b1111, 15), (0b0010, 0), (0b1110, 0)]
)
def test_each_arm_rotation_has_four_bits(low: int, bits: int, shown: int) -> None:
    """0001 means 1, 1111 means -1, and all other values mean 0.

    Arm 1 begins at bit 3, arm 2 at bit 7.

    Rule: point-hand.
    Source: remote command guide 4.3.1
    """
    master = ready()
    master.execute(WRITE, 1 | bits << low, 7)
    assert master.execute(READ, 0, 7)[3] == 1 | shown << low


@pytest.mark.parametrize("unit", [0, 1])
def test_hand_and_arm_rotation_count_only_in_millimetres_with_a_scara_robot(unit: int) -> None:
    """Rule: point-hand. Source: remote command guide 4.3.1."""
    flag = 0b0001_0001_01 << 1 | unit
    for robots in ((), (1,)):
        master = ready(scara_robots=robots)
        master.execute(WRITE, flag, 7)
        assert master.execute(READ, 0, 7)[3] == (flag if unit and robots else unit)


def test_reading_a_point_that_is_not_defined_is_refused() -> None:
    """Source: remote command guide 4.3.1."""
    master = ready(undefined_point_alarm="6.5")
    assert master.execute(READ, 0, 0) == abnormal_end("6.5")


def test_assigning_point_2_to_point_1_copies_units_hand_and_arms() -> None:
    """Point 2 (the source) and the comment of point 1 do not change.

    Source: remote command guide 4.4.3.
    """
    master = ready(points={100: LEFT, 1: PULSES}, comments={1: "ONE", 100: "HUNDRED"})
    assert master.execute(ASSIGN, 0, 1, 100) == NORMAL_END
    assert master.robot.points == {1: LEFT, 100: LEFT}
    assert master.robot.machine.memory.comments == {1: "ONE", 100: "HUNDRED"}


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (ADD, (11000, -20000, 4999, -18000, 0, 7)),
        (SUBTRACT, (9000, -20000, 5001, -18000, 0, -7)),
    ],
)
def test_points_are_added_and_subtracted(code: int, expected: tuple[int, ...]) -> None:
    """Source: remote command guide 4.4.3."""
    second = Point((1000, 0, -1, 0, 0, 7))
    master = ready(points={1: PULSES, 100: second})
    assert master.execute(code, 0, 1, 100) == NORMAL_END
    assert master.robot.points == {1: Point(expected), 100: second}


def test_a_point_can_be_added_to_itself() -> None:
    """Source: remote command guide 4.4.3."""
    master = ready(points={1: LEFT})
    master.execute(ADD, 0, 1, 1)
    assert master.robot.points[1].data == (2, 4, 6, 8, 10, 12)


def test_the_sum_keeps_hand_and_arm_rotation_of_point_1() -> None:
    """Rule: point-units. Source: remote command guide 4.4.3."""
    master = ready(points={1: LEFT, 100: MM})
    master.execute(ADD, 0, 1, 100)
    assert master.robot.points[1] == Point(
        (10001, -19998, 5003, -17996, 5, 6), mm=True, hand=2, arm1=-1, arm2=1
    )


@pytest.mark.parametrize("code", [ADD, SUBTRACT])
def test_points_of_different_units_are_not_added(code: int) -> None:
    """Rule: point-units. Source: remote command guide 4.4.3."""
    master = ready(points={1: PULSES, 100: MM}, point_unit_alarm="6.1")
    assert master.execute(code, 0, 1, 100) == abnormal_end("6.1")
    assert master.execute(code, 0, 100, 1) == abnormal_end("6.1")
    assert master.robot.points == {1: PULSES, 100: MM}


def test_a_sum_beyond_32_bits_changes_nothing() -> None:
    """Rule: overflow. Source: remote command guide 4.4.3."""
    top, least = Point((2**31 - 1, 0, 0, 0, 0, 0)), Point((1, 0, 0, 0, 0, 0))
    master = ready(points={1: top, 2: least}, overflow_alarm="6.2")
    assert master.execute(ADD, 0, 1, 2) == abnormal_end("6.2")
    assert master.robot.points[1] == top
    assert master.execute(SUBTRACT, 0, 1, 2) == NORMAL_END
    assert master.execute(ADD, 0, 1, 2) == NORMAL_END
    assert master.robot.points[1] == top


@pytest.mark.parametrize("code", [ASSIGN, ADD, SUBTRACT])
def test_both_points_must_be_defined(code: int) -> None:
    """Only the destination of an assignment may be undefined.

    Source: remote command guide 4.4.3.
    """
    master = ready(points={1: PULSES}, undefined_point_alarm="6.5")
    assert master.execute(code, 0, 1, 2) == abnormal_end("6.5")
    assert master.robot.points == {1: PULSES}
    ends = NORMAL_END if code == ASSIGN else abnormal_end("6.5")
    assert master.execute(code, 0, 2, 1) == ends


def test_restoring_a_snapshot_restores_the_points() -> None:
    """Restoring a snapshot restores the points that commands wrote, and movements use them.

    Source: remote command guide 4.3.1
    """
    master = ready()
    before = master.robot.snapshot()
    master.execute(WRITE, 0, 100, 0, *PRINTED)
    master.robot.restore(before)
    machine = master.robot.machine
    assert not master.robot.points
    assert machine.points is machine.memory.points


@pytest.mark.parametrize(
    ("write", "read"),
    [
        pytest.param((0x0100, 0, 100, 0, *PRINTED), (0x0101, 0, 100), id="point"),
        pytest.param((0x0104, 0, 100, 0, 0x4157), (0x0105, 0, 100), id="comment"),
        pytest.param((0x0108, 0, 10, 10, 15, 1, 100), (0x0109, 0, 10), id="pallet"),
        pytest.param((0x010C, 0, 5, 0, *PRINTED[:8]), (0x010D, 0, 5), id="shift"),
        pytest.param((0x0110, 0, 1, 0, *PRINTED[:6]), (0x0111, 0, 1), id="hand"),
        pytest.param((0x0200, 0, 1, 0, 7), (0x0214, 0, 1), id="integer variable"),
        pytest.param((0x0200, 0, 257, 0, 0, 0x4020), (0x0214, 0, 257), id="real variable"),
        pytest.param((0x0220, 0, 257, 1, 33), (0x0224, 0, 257, 1), id="axis parameter"),
        pytest.param((0x0220, 0, 1, 0, 5), (0x0224, 0, 1), id="robot parameter"),
    ],
)
def test_stored_data_survive_a_power_cycle(write: tuple[int, ...], read: tuple[int, ...]) -> None:
    """Rule: stored. Source: remote command guide 4.3.1 to 4.3.5, 4.4.1, 4.4.2."""
    master = ready()
    before = master.execute(*read)
    assert master.execute(*write) == NORMAL_END
    written = master.execute(*read)
    assert written != before
    power_cycle(master)
    assert master.execute(*read) == written
