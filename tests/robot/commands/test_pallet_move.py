"""A pallet movement goes to a work position between the points that define a pallet.

The pallet has 3 x 2 work positions. Positions 1 to 3 lie along X, and 4 to 6 are the next row in Y.
"""

from __future__ import annotations

from typing import Any

import pytest

from movements import MM, NORMAL, PULSES, low_high, mover, way_of
from rcx_harness.robot import Point
from rcx_harness.robot.stored import Pallet
from robot_master import Master, abnormal_end

POINTS = {
    200: Point((0, 0, 4_000, 8_000, 0, 0)),
    201: Point((20_000, 0, 4_000, 8_000, 0, 0)),
    202: Point((0, 30_000, 4_000, 8_000, 0, 0)),
    203: Point((20_000, 30_000, 4_000, 8_000, 0, 0)),
    204: Point((0, 0, 50_000, 8_000, 0, 0)),
}


def _mover(**config: Any) -> Master:
    pallets = {7: Pallet(nx=3, ny=2, nz=1, first=200)}
    return mover(**{"points": POINTS, "pallets": pallets, **config})


@pytest.mark.parametrize(
    ("work", "expected"),
    [
        (1, [0, 0, 4_000, 8_000]),
        (2, [10_000, 0, 4_000, 8_000]),
        (6, [20_000, 30_000, 4_000, 8_000]),
        (5, [10_000, 30_000, 4_000, 8_000]),
    ],
)
def test_a_ptp_movement_reaches_the_work_position(work: int, expected: list[int]) -> None:
    """All axes move to the work position. Source: remote command guide 4.2.5, PTP designation."""
    master = _mover()
    answer = master.execute(0x0018, PULSES | 0x0004, 0, 70, 7, work)
    assert master.robot.positions == expected
    assert answer == (NORMAL, 0, 0, 0, *low_high(*expected), 0, 0, 0, 0)


def test_an_arch_movement_reaches_the_work_position() -> None:
    """Axis 3 rises to 40.000 mm and comes down to 4.000 mm.

    At 10 % an axis moves at most 500 pulses per cycle. The other axes start when axis 3 is at
    10.000 mm.

    Source: remote command guide 4.2.5, arch designation, steps 1 to 4
    """
    master = _mover()
    arch = (0, 0, *low_high(40_000, 10_000, 5_000))
    way = way_of(master, 0x0019, MM | 0x0014, 0x0400, 10, 7, 6, *arch)
    assert way[-1] == (20_000, 30_000, 4_000, 8_000)
    assert max(at[2] for at in way) == 40_000
    first = next(at for at in way if at[0] > 0)
    assert 10_000 <= first[2] <= 11_000
    assert master.words[4:8] == low_high(20_000, 30_000)


@pytest.mark.parametrize(
    ("code", "axes", "pallet", "work", "alarm"),
    [
        pytest.param(0x0018, 0, 8, 1, "6.1", id="pallet 8 is not defined"),
        pytest.param(0x0018, 0, 7, 7, "6.2", id="the pallet has only six work positions"),
        pytest.param(0x0019, 0x0400, 8, 1, "6.1", id="arch to a pallet that does not exist"),
    ],
)
def test_a_movement_to_an_undefined_work_position_is_refused(
    code: int, axes: int, pallet: int, work: int, alarm: str
) -> None:
    """A movement to an undefined work position is refused.

    Rule: other-alarms.
    Source: remote command guide 4.2.5, pppp and www.
    """
    master = _mover(undefined_pallet_alarm="6.1", work_position_alarm="6.2")
    assert master.execute(code, 0, axes, 0, pallet, work) == abnormal_end(alarm)
    assert master.robot.positions == [0, 0, 0, 0]
