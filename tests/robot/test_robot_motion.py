"""The PTP profile: times by hand from way, speed and acceleration.

Default axis: 1 000 000 pulses/s, 5 000 000 pulses/s^2.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Point
from rcx_harness.robot.motion import AxisMove, Movement
from robot_master import Master

WAY = Point((100000, -50000, 0, 0, 0, 0))


def _seconds(data: tuple[int, ...], **config: Any) -> float:
    """From the cycle that takes the command to the end of the one that shows its end status."""
    master = Master(points={19: WAY}, **config)
    master.servo_on()
    master.send(0x0001, *data)
    start = master.now_us
    master.finish()
    return (master.now_us - start) / 1e6


@pytest.mark.parametrize(
    ("data", "config", "seconds"),
    [
        # 0.1 s up, 0.1 s at 500 000, 0.1 s down
        pytest.param((0x0004, 0, 50, 19), {}, 0.300, id="50 %"),
        # no constant phase: 2 * sqrt(100 000 / 5 000 000) = 0.2828 s
        pytest.param((0x0004, 0, 100, 19), {}, 0.285, id="100 %, triangle"),
        # 0.02 s up, 0.98 s at 100 000, 0.02 s down
        pytest.param((0x0002, 0, 1000, 19), {}, 1.020, id="direct 10.00 %"),
        # 50 % of 20 % automatic speed
        pytest.param((0x0004, 0, 50, 19), {"auto_speed": 20}, 1.020, id="automatic speed 20 %"),
        pytest.param((0x0002, 0, 5000, 19), {"auto_speed": 20}, 0.300, id="direct is direct"),
        pytest.param((0, 0, 0, 19), {"program_speed": 50}, 0.300, id="program speed 50 %"),
        # 0.2 s up and 0.1 s down leave 25 000 at 500 000: 0.05 s
        pytest.param((0x0024, 0, 50, 19, 0, 0, 0, 0, 0, 50), {}, 0.350, id="acceleration 50 %"),
        pytest.param((0x0044, 0, 50, 19, 0, 0, 0, 0, 0, 0, 50), {}, 0.350, id="deceleration 50 %"),
    ],
)
def test_time_of_a_movement(data: tuple[int, ...], config: dict[str, Any], seconds: float) -> None:
    """Rule: profile."""
    assert _seconds(data, **config) == pytest.approx(seconds + 0.005)


def test_all_axes_start_and_end_together() -> None:
    """Half the way after half the time of a symmetric profile, on every axis.

    Rule: profile.
    """
    ways = [(0, 100000), (1, -50000)]
    moves = [AxisMove(k, 0, end, 500000, 5e6, 5e6) for k, end in ways]
    movement = Movement(moves, start_us=0)
    positions = [0, 0, 7]
    assert movement.duration_us == 300000
    movement.advance(150000, positions)
    assert positions == [50000, -25000, 7]
    movement.advance(50000, positions)  # 5 000 000 / 2 * 0.05^2
    assert positions == [6250, -3125, 7]
    movement.advance(250000, positions)
    assert positions == [93750, -46875, 7]
    movement.advance(100000, positions)
    assert positions == [25000, -12500, 7]
    assert not movement.done
    movement.advance(300000, positions)
    assert positions == [100000, -50000, 7]
    assert movement.done


def test_a_movement_never_overshoots_and_never_turns_back() -> None:
    """Rule: profile."""
    moves = [AxisMove(0, -3, 99997, 1e6, 5e6, 1e6)]
    movement = Movement(moves, start_us=0)
    positions, before = [-3], -3
    for now in range(0, movement.duration_us + 5000, 1000):
        movement.advance(now, positions)
        assert before <= positions[0] <= 99997
        before = positions[0]
    assert before == 99997


def test_a_movement_without_a_way_is_done_at_once() -> None:
    """Rule: profile."""
    movement = Movement([AxisMove(0, 5, 5, 1e6, 5e6, 5e6)], start_us=10)
    positions = [5]
    movement.advance(10, positions)
    assert movement.done
    assert positions == [5]
