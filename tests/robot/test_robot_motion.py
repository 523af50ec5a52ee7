"""PTP movements have the profile that follows from distance, speed and acceleration.

Expected times are calculated by hand. The default axis has 1 000 000 pulses/s and 5 000 000
pulses/s^2.
"""

from __future__ import annotations

import math
from typing import Any

import pytest

from rcx_harness.robot import Axis, Point
from rcx_harness.robot.motion import Movement
from rcx_harness.robot.paths import AxisMove, PtpPath
from rcx_harness.robot.stored import Hand
from robot_master import servos_on

WAY = Point((100000, -50000, 0, 0, 0, 0))


def _seconds(data: tuple[int, ...], **config: Any) -> float:
    """Return the time from accepting a command to the end of its first end status [s]."""
    master = servos_on(points={19: WAY}, **config)
    master.send(0x0001, *data)
    start = master.now_us
    master.finish()
    return (master.now_us - start) / 1e6


@pytest.mark.parametrize(
    ("data", "config", "seconds"),
    [
        # 0.1 s acceleration, 0.1 s at 500 000 pulses/s, 0.1 s deceleration
        pytest.param((0x0004, 0, 50, 19), {}, 0.300, id="50 %"),
        # no phase of constant speed: 2 * sqrt(100 000 / 5 000 000) = 0.2828 s
        pytest.param((0x0004, 0, 100, 19), {}, 0.285, id="100 %, triangle"),
        # 0.02 s acceleration, 0.98 s at 100 000 pulses/s, 0.02 s deceleration
        pytest.param((0x0002, 0, 1000, 19), {}, 1.020, id="direct 10.00 %"),
        # the speed is 50 % of the automatic speed of 20 %
        pytest.param((0x0004, 0, 50, 19), {"auto_speed": 20}, 1.020, id="automatic speed 20 %"),
        pytest.param((0x0002, 0, 5000, 19), {"auto_speed": 20}, 0.300, id="direct is direct"),
        pytest.param((0, 0, 0, 19), {"program_speed": 50}, 0.300, id="program speed 50 %"),
        # 0.2 s acceleration and 0.1 s deceleration leave 25 000 pulses at 500 000 pulses/s: 0.05 s
        pytest.param((0x0024, 0, 50, 19, 0, 0, 0, 0, 0, 50), {}, 0.350, id="acceleration 50 %"),
        pytest.param((0x0044, 0, 50, 19, 0, 0, 0, 0, 0, 0, 50), {}, 0.350, id="deceleration 50 %"),
        pytest.param((0x0004, 0, 50, 19), {"parameters": {"ACCEL": 50}}, 0.350, id="ACCEL 50 %"),
        pytest.param((0x0004, 0, 50, 19), {"parameters": {"DECEL": 50}}, 0.350, id="DECEL 50 %"),
    ],
)
def test_a_movement_takes_the_calculated_time(
    data: tuple[int, ...], config: dict[str, Any], seconds: float
) -> None:
    """Rule: profile."""
    assert _seconds(data, **config) == pytest.approx(seconds + 0.005)


def test_all_axes_start_and_end_together() -> None:
    """With a symmetric profile, every axis has moved half of its distance after half the time.

    Rule: profile.
    """
    ways = [(0, 100000), (1, -50000)]
    path = PtpPath([AxisMove(k, 0, end, 500000, 5e6, 5e6) for k, end in ways])
    movement = Movement(path, start_us=0)
    positions = [0, 0, 7]
    assert movement.duration_us == 300000
    movement.advance(150000, positions, {})
    assert positions == [50000, -25000, 7]
    movement.advance(50000, positions, {})  # distance in 0.05 s: 5 000 000 / 2 * 0.05^2
    assert positions == [6250, -3125, 7]
    movement.advance(250000, positions, {})
    assert positions == [93750, -46875, 7]
    movement.advance(100000, positions, {})
    assert positions == [25000, -12500, 7]
    assert not movement.done
    movement.advance(300000, positions, {})
    assert positions == [100000, -50000, 7]
    assert movement.done


def test_a_movement_never_overshoots_and_never_turns_back() -> None:
    """Rule: profile."""
    movement = Movement(PtpPath([AxisMove(0, -3, 99997, 1e6, 5e6, 1e6)]), start_us=0)
    positions, before = [-3], -3
    for now in range(0, movement.duration_us + 5000, 1000):
        movement.advance(now, positions, {})
        assert before <= positions[0] <= 99997
        before = positions[0]
    assert before == 99997


def test_a_movement_of_length_0_ends_at_once() -> None:
    """Rule: profile."""
    movement = Movement(PtpPath([AxisMove(0, 5, 5, 1e6, 5e6, 5e6)]), start_us=10)
    positions = [5]
    movement.advance(10, positions, {})
    assert movement.done
    assert positions == [5]


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("code", [0x0001, 0x0003])
def test_an_axis_beyond_its_soft_limit_can_come_back(code: int, sign: int) -> None:
    """An axis beyond its soft limit can move back, but cannot stay there or move farther.

    Rule: limits-on-the-way.
    """
    axes = (Axis(start=sign * 1_000_100), Axis())
    points = {
        19: Point((sign * 999_000, 500, 0, 0, 0, 0)),
        20: Point((sign * 1_000_100, 500, 0, 0, 0, 0)),
        21: Point((sign * 1_000_101, 500, 0, 0, 0, 0)),
    }
    master = servos_on(axes=axes, points=points)
    assert master.execute(code, 0, 0, 0, 20)[:3] == (0x4000, 2, 334)
    assert master.execute(code, 0, 0, 0, 21)[:3] == (0x4000, 2, 334)
    assert master.execute(code, 0, 0, 0, 19)[0] == 0x0200
    assert master.robot.positions == [sign * 999_000, 500]


@pytest.mark.parametrize(
    ("flags", "speed", "step"),
    [
        pytest.param(0x0004, 100, 500, id="100 %"),
        pytest.param(0x0004, 50, 250, id="50 %: half of the speed that the slow axis allows"),
        pytest.param(0x0006, 90, 450, id="90 mm/s"),
        pytest.param(0x0006, 200, 500, id="200 mm/s"),
    ],
)
def test_the_slowest_axis_limits_the_speed_of_the_tool(flags: int, speed: int, step: int) -> None:
    """On a line at 60 degrees, the first axis moves half of the distance.

    It can move at 50 mm/s, so the tool moves at most at 100 mm/s, which is 0.5 mm in 5 ms.

    Rule: path-speed.
    """
    axes = (Axis(max_speed=50_000), Axis())
    master = servos_on(axes=axes, points={19: Point((50_000, 86_603, 0, 0, 0, 0))})
    master.send(0x0003, flags, 0, speed, 19)
    master.run(500)
    before = list(master.robot.positions)
    master.run(5)
    assert math.dist(before, master.robot.positions) == pytest.approx(step, abs=1)


def test_the_axes_that_carry_a_turning_hand_stay_within_their_limits() -> None:
    """The tool is 10 mm from R and stays where it is while R turns by 180 degrees.

    On the way, at 90 degrees, axis 2 has to be at -10 mm.

    Rule: limits-on-the-way, coordinates.
    """
    for low, status in ((-9_999, 0x4000), (-10_000, 0x0200)):
        axes = (Axis(), Axis(soft_low=low), Axis(), Axis())
        there = Point((10_000, 0, 0, 180_000, 0, 0), mm=True)
        hands = {(1, 0): Hand((10_000, 0, 0, 1))}
        master = servos_on(axes=axes, points={19: there}, hands=hands)
        assert master.execute(0x0003, 0, 0, 0, 19)[0] == status
        assert master.robot.positions == ([0] * 4 if status == 0x4000 else [20_000, 0, 0, 180_000])


def test_a_movement_goes_on_without_anything_new_from_the_master() -> None:
    """A movement continues to its target without a change of the master's data. Rule: arrival."""
    parameters = {"TOLE": 16_384}
    master = servos_on(points={19: WAY}, end_in_tolerance=True, parameters=parameters)
    master.send(0x0001, 0x0004, 0, 10, 19)
    assert master.finish()[0] == 0x0200
    assert 83_000 < master.robot.positions[0] < 90_000
    for _ in range(100):
        master.robot.cycle(master.now_us, bytes(master.si))
        master.now_us += 5_000
    assert master.robot.positions == [100_000, -50_000, 0, 0]
