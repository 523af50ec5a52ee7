"""In a MOVE with arch designation, the arch axis rises first and the other axes follow.

The default axis has 1000 pulses/mm, 1 000 000 pulses/s, 5 000 000 pulses/s^2 and soft limits of +-1
000 000.
"""

from __future__ import annotations

import pytest

from movements import low_high, mover, way_of
from rcx_harness.robot import Axis, Point

ARCH_POINT = Point((50_000, -25_000, 20_000, 0, 0, 0))


def _arch_words(flags: int, axes: int, position: int, first: int, second: int) -> tuple[int, ...]:
    """Return the words of an arch movement to point 19, with 10 % of the maximum speed."""
    return (0x0002, flags | 4, axes, 10, 19, 0, 0, 0, *low_high(position, first, second))


def test_the_other_axes_start_when_the_arch_axis_has_moved_by_distance_1() -> None:
    """At 10 % an axis moves at most 500 pulses per cycle.

    Axis 3 rises from 0 to 40 000 and comes down to 20 000. The other axes start when axis 3 has
    moved 10 000 pulses. They have arrived when axis 3 has 5 000 pulses left.

    Rule: arch.
    Source: remote command guide 4.2.1, arch designation, steps 1 to 4
    """
    master = mover(points={19: ARCH_POINT})
    way = way_of(master, *_arch_words(0, 0x0400, 40_000, 10_000, 5_000))
    first = next(k for k, at in enumerate(way) if at[0] > 0)
    assert 10_000 <= way[first][2] <= 11_000
    assert max(at[2] for at in way) == 40_000
    arrived = next(k for k, at in enumerate(way) if at[:2] == (50_000, -25_000))
    assert 24_400 <= way[arrived][2] <= 25_100
    assert way[-1] == (50_000, -25_000, 20_000, 0)


def test_arch_data_in_millimetres_are_converted_for_the_arch_axis() -> None:
    """At 500 pulses/mm, 40.000 mm are 20 000 pulses and 10.000 mm are 5000 pulses.

    Source: remote command guide 4.2.1, arch designation, d and qqqqqqqq
    """
    axes = (Axis(), Axis(), Axis(pulses_per_mm=500))
    master = mover(axes=axes, points={19: Point((50_000, 0, 0, 0, 0, 0))})
    way = way_of(master, *_arch_words(0x0010, 0x0400, 40_000, 10_000, 0))
    first = next(k for k, at in enumerate(way) if at[0] > 0)
    assert 5_000 <= way[first][2] <= 6_000
    assert max(at[2] for at in way) == 20_000


def test_an_arch_axis_that_is_not_designated_comes_back() -> None:
    """Rule: arch-axis-alone."""
    master = mover(points={19: ARCH_POINT})
    way = way_of(master, *_arch_words(1, 0x0401, 40_000, 0, 0))
    assert max(at[2] for at in way) == 40_000
    assert way[-1] == (50_000, 0, 0, 0)


@pytest.mark.parametrize(
    ("knob", "distance", "low"), [(False, 0, 0), (True, 0, 8_000), (True, 3_000, 3_000)]
)
def test_an_arch_distance_of_0_is_0_or_the_parameter(knob: bool, distance: int, low: int) -> None:
    """The parameter ARCHP1 of axis 3 is 8000 pulses.

    A key decides whether a distance of 0 means 0 or this parameter.

    Rule: arch-distances.
    """
    parameters = {"ARCHP1": (1, 1, 8_000, 1)}
    master = mover(points={19: ARCH_POINT}, parameters=parameters, arch_zero_is_parameter=knob)
    way = way_of(master, *_arch_words(0, 0x0400, 40_000, distance, 0))
    first = next(at for at in way if at[0] > 0)
    assert low <= first[2] <= low + 1_000
