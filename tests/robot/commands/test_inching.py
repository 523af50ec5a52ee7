"""Inching moves an axis by the inching movement amount, in each coordinate system.

The coordinates are pulses, Cartesian or tool coordinates. The default axis has 1000 pulses/mm,
1 000 000 pulses/s, 5 000 000 pulses/s^2 and soft limits of +-1 000 000.
"""

from __future__ import annotations

from typing import Any

import pytest

from rcx_harness.robot import Axis
from rcx_harness.robot.stored import Hand
from robot_master import Master, abnormal_end, servos_on

PULSES, CARTESIAN, TOOL = 0x0024, 0x0025, 0x0026
FRAMES = [PULSES, CARTESIAN, TOOL]
PULSE_OUTPUT, MM_OUTPUT = 0x4000, 0x8000
MINUS = 0x0080


def _incher(amount: int, **config: Any) -> Master:
    """Return a master with the servos on and the inching amount of robot 1 set by command."""
    master = servos_on(**config)
    assert master.execute(0x0027, 0, amount)[0] == 0x0200
    return master


@pytest.mark.parametrize(
    ("code", "pulses"),
    [
        pytest.param(PULSES, 100, id="100 pulses"),
        pytest.param(CARTESIAN, 50, id="0.1 mm at 500 pulses/mm"),
        pytest.param(TOOL, 50, id="0.1 mm in tool coordinates"),
    ],
)
@pytest.mark.parametrize("place", range(4))
@pytest.mark.parametrize(("direction", "sign"), [(0, 1), (MINUS, -1)])
def test_an_amount_of_100_is_100_pulses_or_0_1_mm(
    code: int, pulses: int, place: int, direction: int, sign: int
) -> None:
    """The movement is 100 pulses or 0.1 mm. Without a position output, m+2 to m+30 are 0.

    Rule: inching, jog-frames.
    Source: remote command guide 4.2.7, tt and d
    """
    master = _incher(100, axes=(Axis(pulses_per_mm=500),) * 4)
    answer = master.execute(code, 0, 1 << place | direction)
    assert answer == (0x0200, *(0,) * 15)
    expected = [0, 0, 0, 0]
    expected[place] = sign * pulses
    assert master.robot.positions == expected


@pytest.mark.parametrize("amount", [1, 10_000])
@pytest.mark.parametrize("code", FRAMES)
def test_inching_moves_by_the_smallest_and_the_largest_amount(code: int, amount: int) -> None:
    """An inching by the smallest or largest amount moves the axis by this amount.

    Source: remote command guide 4.2.8, dddd.
    """
    master = _incher(amount)
    assert master.execute(code, 0, 0x0001)[0] == 0x0200
    assert master.robot.positions == [amount, 0, 0, 0]


@pytest.mark.parametrize("code", FRAMES)
def test_inching_is_done_with_the_manual_movement_speed(code: int) -> None:
    """10 000 pulses at 10 000 pulses/s take 998 ms, and 2 ms each to accelerate and brake.

    These are 201 cycles. One more cycle accepts the command.

    Rule: inching-speed.
    """
    master = _incher(10_000, manual_speed=1)
    master.send(code, 0, 0x0001)
    start = master.now_us
    master.finish()
    assert master.now_us - start == 1_010_000


@pytest.mark.parametrize("code", FRAMES)
@pytest.mark.parametrize(("direction", "start"), [(0, 499_901), (MINUS, -599_901)])
def test_inching_beyond_a_soft_limit_does_not_start(code: int, direction: int, start: int) -> None:
    """A movement one pulse beyond the limit ends in alarm 2.334.

    A movement exactly to the limit is legal.

    Rule: soft-limit.
    """
    axes = (Axis(), Axis(start=start, soft_low=-600_000, soft_high=500_000))
    master = _incher(100, axes=axes)
    assert master.execute(code, PULSE_OUTPUT, 0x0002 | direction) == abnormal_end("2.334")
    assert master.robot.positions == [0, start]
    master.execute(0x0027, 0, 99)
    assert master.execute(code, 0, 0x0002 | direction)[0] == 0x0200


@pytest.mark.parametrize("code", FRAMES)
def test_inching_that_the_stop_input_stops_shows_no_position(code: int) -> None:
    """Only a stopped jog answers with a position.

    Source: remote command guide 4.2.7, abnormal end.
    """
    master = _incher(10_000, manual_speed=1)
    master.send(code, PULSE_OUTPUT, 0x0001)
    master.run(500)
    master.turn_and_wait("SI06", False, 5)
    assert master.words == abnormal_end("12.400")
    # 10 pulses in the first 2 ms, then 10 pulses/ms for 498 ms
    assert master.robot.positions[0] == 4_990


@pytest.mark.parametrize(("code", "expected"), [(CARTESIAN, [71, 71]), (TOOL, [0, 100])])
def test_inching_moves_along_turned_coordinates(code: int, expected: list[int]) -> None:
    """The shift turns by 45 degrees, and the hand by 90 degrees.

    100 pulses along a coordinate turned by 45 degrees are 100 / sqrt(2) = 70.7 pulses of each axis.

    Rule: coordinates.
    """
    master = _incher(
        100,
        axes=(Axis(), Axis(), Axis(), Axis(start=90_000)),
        shifts={1: (0, 0, 0, 45_000)},
        hands={(1, 1): Hand((10_000, 0, 0, 1))},
    )
    master.execute(0x003B, 0, 1)
    master.execute(0x003C, 0, 1)
    assert master.execute(code, 0, 0x0001)[0] == 0x0200
    assert master.robot.positions == [*expected, 0, 90_000]


def test_each_robot_has_its_own_amount() -> None:
    """Source: remote command guide 4.2.8, R."""
    master = _incher(100, axes=(Axis(), Axis(robot=2)))
    master.execute(0x2027, 0, 7)
    assert master.execute(0x2024, 0, 0x0001)[0] == 0x0200
    assert master.execute(0x0024, 0, 0x0001)[0] == 0x0200
    assert master.robot.positions == [100, 7]
