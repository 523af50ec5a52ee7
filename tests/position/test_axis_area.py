"""FB_AxisArea reports whether axes are inside or outside of limits.

It uses positions with an age.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from area_blocks import AxisArea
from both_engines import ENGINES

_MOST = 1_000_000_000
_LIMITS: dict[str, Any] = {"Low": [1000, -5000, 0, -900], "High": [3000, -1000, 8000, 900]}
_MIDDLE = (2000, -3000, 4000, 0)


def _area(engine: str = "auto", **inputs: Any) -> AxisArea:
    """Return an FB_AxisArea with limits for four axes."""
    return AxisArea(engine, **{**_LIMITS, **inputs})


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("pulses", "depth"),
    [
        (_MIDDLE, 900),
        ((1300, -3000, 4000, 0), 300),
        ((2750, -3000, 4000, 0), 250),
        ((2000, -4800, 4000, 0), 200),
        ((2000, -1150, 4000, 0), 150),
        ((2000, -3000, 110, 0), 110),
        ((2000, -3000, 7880, 0), 120),
        ((2000, -3000, 4000, -770), 130),
        ((2000, -3000, 4000, 760), 140),
        ((2000, -3000, 4000, 1000), -100),
        ((800, -3000, 4000, 0), -200),
        ((2000, -900, 4000, 0), -100),
        ((500, -10_000, 4000, 0), -5000),
    ],
)
def test_the_distance_to_the_nearest_limit_of_any_axis_decides(
    engine: str, pulses: Sequence[int], depth: int
) -> None:
    """The distance to the nearest limit of any axis decides.

    The limits are 1000 to 3000, -5000 to -1000, 0 to 8000, -900 to 900. Axes 5 and 6 are not used.
    """
    area = _area(engine)
    assert area.at(*pulses, 77, -77) == ("inside" if depth > 0 else "outside")
    assert area["Depth"] == depth
    assert area["Valid"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("axis", range(6))
def test_only_the_selected_axes_are_checked(engine: str, axis: int) -> None:
    """Only the axes selected by Axes are checked. Bit 0 is axis 1.

    Errors of other axes have no effect.

    Source: comment of Axes.
    """
    low, high, pulses = [5] * 6, [-5] * 6, [2 * _MOST] * 6
    low[axis], high[axis], pulses[axis] = -1000, 1000, 700
    area = _area(engine, Axes=1 << axis, Low=low, High=high)
    assert area.at(*pulses) == "inside"
    assert area["Depth"] == 300
    area["Axes"] = 0x3F ^ (1 << axis)
    assert area.at(*pulses) == "-"
    assert area["ErrorID"] == 0x8045


def test_all_six_may_count() -> None:
    area = _area(Axes=0x3F, Low=[-1000] * 6, High=[1000] * 6)
    assert area.at(*[0] * 6) == "inside"
    for k in range(6):
        assert area.at(*[0] * k, 1100, *[0] * (5 - k)) == "outside"


@pytest.mark.parametrize("axes", [0, 0x40, 0x8000, 0xFFCF])
def test_no_axis_or_an_axis_above_six_is_refused(axes: int) -> None:
    """Source: docs/reference/errors.md, 16#8041."""
    area = _area()
    assert area.at(*_MIDDLE) == "inside"
    area["Axes"] = axes
    assert area.at(*_MIDDLE) == "-"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (0x8041, False, 0)


def test_the_dead_band_is_100_pulses_and_may_be_none() -> None:
    area = _area()
    told = [area.at(one, *_MIDDLE[1:]) for one in (1099, 1100, 999, 901, 900)]
    assert told == ["-", "inside", "-", "-", "outside"]
    area["DeadBand"] = 0
    assert [area.at(one, *_MIDDLE[1:]) for one in (1000, 999)] == ["inside", "outside"]


@pytest.mark.parametrize(
    ("value", "wrong"), [(0, False), (-1, True), (_MOST, False), (_MOST + 1, True)]
)
def test_the_dead_band_is_not_below_0(value: int, wrong: bool) -> None:
    area = _area(DeadBand=value)
    area.at(*_MIDDLE)
    assert (area["ErrorID"] == 0x8045) is wrong
    assert area["Valid"] is (not wrong)
    assert area["Depth"] == (0 if wrong else 900)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize(
    ("low", "high", "pulses", "depth"),
    [
        (-_MOST, _MOST, 0, 900),
        (-_MOST, -_MOST, _MOST, -2 * _MOST),
        (_MOST, _MOST, -_MOST, -2 * _MOST),
        (-_MOST - 1, _MOST, 0, None),
        (-_MOST, _MOST + 1, 0, None),
        (-_MOST, _MOST, -_MOST - 1, None),
        (-_MOST, _MOST, _MOST + 1, None),
        (-(2**31), 2**31 - 1, 0, None),
        (7, 7, 7, 0),
        (8, 7, 7, None),
    ],
)
def test_limits_in_the_wrong_order_or_range_are_refused(
    engine: str, k: int, low: int, high: int, pulses: int, depth: int | None
) -> None:
    """Limits in the wrong order or out of range are refused.

    Differences of 2,000,000,000 pulses are exact.
    """
    area = _area(engine)
    area.at(*_MIDDLE)
    now = list(_MIDDLE)
    lows, highs = [*_LIMITS["Low"]], [*_LIMITS["High"]]
    lows[k], highs[k], now[k] = low, high, pulses
    if k == 3 and depth == 900:
        depth = 1000
    area["Low"], area["High"] = lows, highs
    told = area.at(*now)
    if depth is None:
        assert (told, area["ErrorID"], area["Valid"], area["Depth"]) == ("-", 0x8045, False, 0)
    else:
        assert (area["ErrorID"], area["Depth"]) == (0, depth)
        assert told == ("inside" if depth >= 0 else "outside"), "the axis was inside before"
