"""MOVEI moves by a distance, and may continue with the rest of it after an interruption."""

from __future__ import annotations

from typing import Any

import pytest

from movements import ABNORMAL, FORMAT_ERROR, MM, NORMAL, PULSES, low_high, mover
from rcx_harness.robot import Axis, Point
from robot_master import Master, servos_on

FAR = Point((100_000, -50_000, 0, 0, 0, 0))


def _mover(**config: Any) -> Master:
    return mover(**{"points": {19: FAR, 20: Point((1_000, 0, 0, 0, 0, 0))}, **config})


def _interrupt(master: Master, *words: int) -> int:
    """Stop a movement after 200 ms, release the stop, and return the position of axis 1."""
    before = master.robot.positions[0]
    master.send(*words)
    master.run(200)
    master.turn_and_wait("SI06", False)
    assert master.words[:3] == (ABNORMAL, 0x000C, 0x0190)
    master.send()
    master.turn_and_wait("SI06", True)
    assert master.status == 0
    stands = master.robot.positions[0]
    assert 0 < abs(stands - before) < 100_000
    return stands


@pytest.mark.parametrize("code", [0x0009, 0x000A])
def test_movei_moves_by_the_distance_of_the_point(code: int) -> None:
    """The movement starts at the robot's position.

    A second movement starts at the end of the first.

    Source: remote command guide 4.2.2, PTP designation and linear interpolation
    """
    master = _mover()
    assert master.execute(code, PULSES, 0, 0, 19)[4:8] == low_high(100_000, -50_000)
    assert master.execute(code, PULSES, 0, 0, 19)[4:8] == low_high(200_000, -100_000)


def test_movei_moves_by_a_point_in_millimetres() -> None:
    """A distance of 10.000 mm at 500 pulses/mm is 5000 pulses.

    Source: remote command guide 4.2.2, PTP designation
    """
    axes = (Axis(pulses_per_mm=500, start=100), Axis())
    master = _mover(axes=axes, points={19: Point((10_000, 7, 0, 0, 0, 0), mm=True)})
    assert master.execute(0x0009, MM, 0, 0, 19)[4:8] == low_high(10_200, 7)
    assert master.robot.positions == [5_100, 7]


def test_movei_moves_only_the_designated_axes() -> None:
    """Source: remote command guide 4.2.2, a and tt."""
    master = _mover()
    assert master.execute(0x0009, 1, 0x0002, 0, 19)[0] == NORMAL
    assert master.robot.positions == [0, -50_000, 0, 0]


def test_movei_moves_by_distances_in_millimetres() -> None:
    """Source: remote command guide 4.2.2, direct PTP designation (millimeter units)."""
    axes = (Axis(pulses_per_mm=500, start=1_000), Axis(start=-7))
    master = _mover(axes=axes)
    answer = master.execute(0x000E, MM | 0x0004, 0, 50, *low_high(10_000, -20_000))
    assert master.robot.positions == [6_000, -20_007]
    assert answer[4:8] == low_high(12_000, -20_007)


def test_movei_moves_by_distances_in_pulses() -> None:
    """Source: remote command guide 4.2.2, direct PTP designation (pulse units)."""
    master = _mover(axes=(Axis(pulses_per_mm=500, start=1_000), Axis(start=-7)))
    answer = master.execute(0x000F, PULSES, 0, 0, *low_high(10_000, -20_000))
    assert master.robot.positions == [11_000, -20_007]
    assert answer[4:8] == low_high(11_000, -20_007)


def test_linear_interpolation_takes_mm_per_second_and_ptp_does_not() -> None:
    """40 mm at 100 mm/s take 0.4 s plus the time for acceleration.

    Source: remote command guide 4.2.2, bb
    """
    master = _mover(points={20: Point((40_000, 0, 0, 0, 0, 0))})
    master.send(0x000A, 0x0006, 0, 100, 20)
    master.run(395)
    assert master.status == 0x0100
    assert master.finish(50)[0] == NORMAL
    master.send()
    master.run(10)
    assert master.execute(0x0009, 0x0006, 0, 100, 20)[:3] == FORMAT_ERROR


COMMANDS = [
    pytest.param((0x0009, 0x0004, 0, 20, 19), id="PTP"),
    pytest.param((0x000A, 0x0004, 0, 20, 19), id="linear"),
    pytest.param((0x000E, 0x0004, 0, 20, *low_high(100_000)), id="direct in mm"),
    pytest.param((0x000F, 0x0004, 0, 20, *low_high(100_000)), id="direct in pulses"),
]


@pytest.mark.parametrize("words", COMMANDS)
def test_an_interrupted_movei_goes_on_to_its_original_target(words: tuple[int, ...]) -> None:
    """By default (Keep) the axis completes the original distance.

    The next MOVEI then moves by a new distance.

    Rule: movei-keep.
    Source: remote command guide 4.2.2, note
    """
    master = _mover()
    _interrupt(master, *words)
    assert master.execute(*words)[0] == NORMAL
    assert master.robot.positions[0] == 100_000
    assert master.execute(*words)[0] == NORMAL
    assert master.robot.positions[0] == 200_000


@pytest.mark.parametrize("words", COMMANDS)
def test_movei_starts_anew_if_its_start_position_is_reset(words: tuple[int, ...]) -> None:
    """Rule: movei-keep, movei-start. Source: remote command guide 4.2.2, note."""
    master = _mover(movei_start_position="reset")
    stands = _interrupt(master, *words)
    assert master.execute(*words)[0] == NORMAL
    assert master.robot.positions[0] == stands + 100_000


def test_an_interrupted_movei_goes_on_at_another_speed_and_after_a_second_interruption() -> None:
    """Rule: movei-start."""
    master = _mover()
    _interrupt(master, 0x0009, 0x0004, 0, 20, 19)
    _interrupt(master, 0x0009, PULSES | 0x0004, 0, 10, 19)
    assert master.execute(0x0009, 0, 0, 0, 19)[0] == NORMAL
    assert master.robot.positions[:2] == [100_000, -50_000]


@pytest.mark.parametrize(
    ("words", "way"),
    [
        pytest.param((0x0009, 0, 0, 0, 20), 1_000, id="another distance"),
        pytest.param((0x000A, 0, 0, 0, 19), 100_000, id="another command"),
        pytest.param((0x0009, 1, 0x0001, 0, 19), 100_000, id="other axes"),
    ],
)
def test_movei_starts_anew_after_another_movement(words: tuple[int, ...], way: int) -> None:
    """Another movement comes between an interrupted MOVEI and its repetition.

    Both then start at the robot's position.

    Rule: movei-start.
    """
    master = _mover()
    stands = _interrupt(master, 0x0009, 0x0004, 0, 20, 19)
    assert master.execute(*words)[0] == NORMAL
    assert master.robot.positions[0] == stands + way
    assert master.execute(0x0009, 0, 0, 0, 19)[0] == NORMAL
    assert master.robot.positions[0] == stands + way + 100_000


def test_movei_changes_to_the_designated_hand_system() -> None:
    """Rule: hand-system.

    Source: remote command guide 4.2.2, direct PTP designation (millimeter units), cc
    """
    master = _mover()
    assert master.execute(0x000E, 2 << 3)[0] == NORMAL
    assert master.robot.machine.settings.of(1).arm_status == 1


@pytest.mark.parametrize("stopped", [False, True])
def test_a_movement_that_ended_within_its_tolerance_does_not_block_the_next(stopped: bool) -> None:
    """The next command is accepted although the axis still moves within its tolerance.

    A stop while the axis still moves does not count as an interruption.

    Rule: arrival, relative-kept, robots-move.
    """
    master = servos_on(end_in_tolerance=True, axes=(Axis(max_acceleration=10_000.0),))
    assert master.execute(0x0100, 0, 1, 0, 1000)[0] == 0x0200
    movei = (0x0009, 0, 0, 0, 1)
    master.send(*movei)
    assert master.finish()[0] == 0x0200
    assert master.robot.positions[0] < 1000
    if stopped:
        master.drop("SI06")
    master.send()
    master.run(5)
    here = master.robot.positions[0]
    assert here < 1000
    assert master.execute(*movei)[0] == 0x0200
    master.run(1000)
    crept = master.robot.positions[0] - 1000 - here  # the axis is within TOLE, 80 pulses
    assert crept == 0 if stopped else 0 < crept <= 80
