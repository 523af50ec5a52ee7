"""PUSH moves an axis to a target, and pushes a workpiece that it meets on the way."""

from __future__ import annotations

from typing import Any

import pytest

from movements import ABNORMAL, MM, NORMAL, PULSES, mover
from rcx_harness.robot import Axis, Point
from robot_master import Master

ONE, FORCE, TIME = 0x0001, 0x0080, 0x0100  # flags
AXIS_3 = 0x0004
EVERY = [0x004B, 0x004C, 0x004D]


def _mover(workpiece: int | None = 4_500, **config: Any) -> Master:
    """Return a robot with 500 pulses/mm on axis 3, and a workpiece at 4500 pulses = 9.000 mm."""
    axes = (Axis(start=1), Axis(start=2), Axis(pulses_per_mm=500, workpiece=workpiece), Axis())
    point = Point((7, 7, 10_000, 7, 0, 0), mm=True)
    return mover(**{"axes": axes, "points": {19: point}, **config})


def _words(code: int, flags: int = 0, force: int = 0, time: int = 0) -> tuple[int, ...]:
    """Return the words that push axis 3 to 5000 pulses = 10.000 mm at 50 %."""
    target = {0x004B: (19, 0), 0x004C: (10_000, 0), 0x004D: (5_000, 0)}[code]
    return (code, flags | ONE | 0x0004, AXIS_3, 50, *target, 0, 0, force & 0xFFFF, time)


def _pushes_for(master: Master, *words: int) -> int:
    """Return the time from reaching 4500 pulses to the end status [ms]."""
    master.send(*words)
    touched = 0
    for _ in range(7_000):
        master.run(5)
        if master.robot.positions[2] == 4_500 and not touched:
            touched = master.now_us
        if master.status in (NORMAL, ABNORMAL):
            break
    assert master.status == NORMAL
    return (master.now_us - touched) // 1000


@pytest.mark.parametrize("code", EVERY)
def test_a_push_against_a_workpiece_ends_after_the_push_time(code: int) -> None:
    """Bit 0 of m+6 is 1 at the end.

    The axis stays at the workpiece, even if the workpiece is removed after the end.

    Rule: push.
    Source: remote command guide 4.2.23, p
    """
    master = _mover()
    assert _pushes_for(master, *_words(code, MM | FORCE | TIME, 100, 100)) == 100
    assert master.words == (NORMAL, 0, 0, 1, 1, 0, 2, 0, 9_000, *(0,) * 7)
    master.robot.workpieces.clear()
    master.run(500)
    assert master.robot.positions == [1, 2, 4_500, 0]


@pytest.mark.parametrize("code", EVERY)
def test_a_push_without_a_workpiece_reaches_its_target(code: int) -> None:
    """Without a workpiece the axis reaches its target, and bit 0 of m+6 is 0.

    Rule: push.
    Source: remote command guide 4.2.23, p
    """
    master = _mover(workpiece=None)
    answer = master.execute(*_words(code, PULSES | FORCE | TIME, 100, 100))
    assert answer == (NORMAL, 0, 0, 0, 1, 0, 2, 0, 5_000, *(0,) * 7)
    assert master.robot.positions == [1, 2, 5_000, 0]


@pytest.mark.parametrize("time", [1, 250, 32767])
def test_a_push_lasts_for_the_push_time_period(time: int) -> None:
    """The push time is counted in cycles of 5 ms. Source: remote command guide 4.2.23, jjjj."""
    pushed = _pushes_for(_mover(workpiece=4_500), *_words(0x004D, TIME, time=time))
    assert time <= pushed < time + 10 if time > 5 else pushed <= 10


def test_without_a_push_time_period_the_parameter_counts() -> None:
    """The parameter PSHTIME of the axis gives the time. Rule: push-parameters."""
    master = _mover(parameters={"PSHTIME": (10, 10, 300, 10)})
    assert _pushes_for(master, *_words(0x004D)) == 300


def test_a_workpiece_that_gives_way_restarts_the_time() -> None:
    """The workpiece is removed after 100 of 200 ms, and the axis continues to its target.

    Rule: push-model.
    """
    master = _mover()
    master.send(*_words(0x004D, TIME, time=200))
    master.run(250)
    assert master.robot.positions[2] == 4_500
    assert master.status == 0x0100
    master.robot.workpieces.clear()
    assert master.finish()[3] == 0
    assert master.robot.positions[2] == 5_000


def test_a_push_does_not_reach_a_workpiece_beyond_its_target() -> None:
    """Rule: push-model."""
    assert _mover(workpiece=5_001).execute(*_words(0x004D))[:4] == (NORMAL, 0, 0, 0)


def test_other_movements_do_not_stop_at_a_workpiece() -> None:
    """Rule: push-model."""
    master = _mover()
    assert master.execute(0x0013, ONE, AXIS_3, 0, 5_000)[0] == NORMAL
    assert master.robot.positions[2] == 5_000


def test_the_push_speed_ratio_reduces_the_speed() -> None:
    """5000 pulses at 50 % of 1 000 000/s take 0.063 s, without a constant phase.

    At 1 % of that speed the movement takes 1.001 s.

    Rule: push-parameters.
    """
    master = _mover(workpiece=None, parameters={"PSHSPD": 1})
    master.send(*_words(0x004D))
    master.run(1000)
    assert master.status == 0x0100
    assert master.finish(30)[0] == NORMAL


def test_the_stop_input_ends_a_push_with_12_400() -> None:
    """Rule: stop-alarm. Source: manual chapter 4, 4."""
    master = _mover()
    master.send(*_words(0x004D, TIME, time=10_000))
    master.run(500)
    master.turn_and_wait("SI06", False, 5)
    assert master.words[:4] == (ABNORMAL, 0x000C, 0x0190, 0)
    assert master.robot.positions[2] == 4_500


@pytest.mark.parametrize(("start", "sign"), [(0, 1), (0, -1), (700, -1), (-700, 1)])
def test_a_push_to_the_position_of_the_workpiece_reaches_its_target(start: int, sign: int) -> None:
    """The target is the workpiece's position.

    From either side, the axis stops there and does not push.

    Rule: push-model.
    Source: remote command guide 4.2.23, p
    """
    place = sign * 5_000
    axes = (Axis(), Axis(), Axis(pulses_per_mm=500, workpiece=place, start=start), Axis())
    master = mover(axes=axes)
    low, high = place & 0xFFFF, place >> 16 & 0xFFFF
    answer = master.execute(0x004D, TIME | ONE | 0x0004, AXIS_3, 50, low, high, 0, 0, 0, 200)
    assert answer[:4] == (NORMAL, 0, 0, 0)
    assert master.robot.positions[2] == place
