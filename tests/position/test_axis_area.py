"""FB_AxisArea: inside or outside of limits of the axes, by positions of a certain age."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES

_MOST = 1_000_000_000
_LIMITS: dict[str, Any] = {"Low": [1000, -5000, 0, -900], "High": [3000, -1000, 8000, 900]}
_MIDDLE = (2000, -3000, 4000, 0)


@cache
def _block(engine: str) -> Alone:
    return Alone("FB_AxisArea", {}, engine)


class _Area:
    """Limits of four axes, and a robot whose position is valid and new."""

    def __init__(self, engine: str = "auto", **inputs: Any) -> None:
        self._block = _block(engine)
        self._block.restart()
        for name, value in {"PositionValid": True, "Age": "T#0ms", **_LIMITS, **inputs}.items():
            self[name] = value

    def __setitem__(self, pin: str, value: Any) -> None:
        long = [*value, *[0] * (6 - len(value))] if isinstance(value, list) else value
        self._block[f"Block.{pin}"] = long

    def __getitem__(self, pin: str) -> Any:
        return self._block[f"Block.{pin}"]

    def at(self, *pulses: int) -> str:
        """One scan with the axes there: what the bits say."""
        self["Pulses"] = list(pulses)
        self._block.scan(0)
        assert not (self["Inside"] and self["Outside"])
        assert self["Error"] is (self["ErrorID"] != 0)
        return "inside" if self["Inside"] else "outside" if self["Outside"] else "-"


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
def test_the_nearest_limit_of_any_axis_counts(
    engine: str, pulses: Sequence[int], depth: int
) -> None:
    """From 1000 to 3000, -5000 to -1000, 0 to 8000 and -900 to 900; axes 5 and 6 do not count."""
    area = _Area(engine)
    assert area.at(*pulses, 77, -77) == ("inside" if depth > 0 else "outside")
    assert area["Depth"] == depth
    assert area["Valid"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("axis", range(6))
def test_only_the_axes_that_are_chosen_count(engine: str, axis: int) -> None:
    """Bit 0 is axis 1; what is wrong with the others does not matter.

    Source: comment of Axes
    """
    low, high, pulses = [5] * 6, [-5] * 6, [2 * _MOST] * 6
    low[axis], high[axis], pulses[axis] = -1000, 1000, 700
    area = _Area(engine, Axes=1 << axis, Low=low, High=high)
    assert area.at(*pulses) == "inside"
    assert area["Depth"] == 300
    area["Axes"] = 0x3F ^ (1 << axis)
    assert area.at(*pulses) == "-"
    assert area["ErrorID"] == 0x8045


def test_all_six_may_count() -> None:
    area = _Area(Axes=0x3F, Low=[-1000] * 6, High=[1000] * 6)
    assert area.at(*[0] * 6) == "inside"
    for k in range(6):
        assert area.at(*[0] * k, 1100, *[0] * (5 - k)) == "outside"


@pytest.mark.parametrize("axes", [0, 0x40, 0x8000, 0xFFCF])
def test_no_axis_or_one_beyond_six_is_refused(axes: int) -> None:
    """Source: docs/reference/errors.md, 16#8041."""
    area = _Area()
    assert area.at(*_MIDDLE) == "inside"
    area["Axes"] = axes
    assert area.at(*_MIDDLE) == "-"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (0x8041, False, 0)


def test_a_bit_falls_at_the_border_and_rises_beyond_the_dead_band() -> None:
    """500 pulses: inside from 1500 on until below 1000, outside from 500 on until 1000."""
    area = _Area(DeadBand=500, High=[3000, -1000, 8000, 900])
    told = [area.at(one, *_MIDDLE[1:]) for one in (1499, 1500, 1000, 999, 501, 500, 999, 1000)]
    assert told == ["-", "inside", "inside", "-", "-", "outside", "outside", "-"]
    assert area.at(1499, *_MIDDLE[1:]) == "-"


def test_the_dead_band_is_100_pulses_and_may_be_none() -> None:
    area = _Area()
    told = [area.at(one, *_MIDDLE[1:]) for one in (1099, 1100, 999, 901, 900)]
    assert told == ["-", "inside", "-", "-", "outside"]
    area["DeadBand"] = 0
    assert [area.at(one, *_MIDDLE[1:]) for one in (1000, 999)] == ["inside", "outside"]


@pytest.mark.parametrize("inside", [True, False])
def test_nothing_is_sure_without_valid_data(inside: bool) -> None:
    area = _Area()
    where = _MIDDLE if inside else (0, *_MIDDLE[1:])
    told = "inside" if inside else "outside"
    assert area.at(*where) == told
    area["PositionValid"] = False
    assert area.at(*where) == "-"
    assert (area["Valid"], area["Error"]) == (False, False)
    area["PositionValid"] = True
    assert area.at(*where) == told


@pytest.mark.parametrize("inside", [True, False])
def test_nothing_is_sure_by_data_older_than_max_age(inside: bool) -> None:
    """A second; it is no error, a movement may take longer."""
    area = _Area(Age="T#1000ms")
    where = _MIDDLE if inside else (0, *_MIDDLE[1:])
    told = "inside" if inside else "outside"
    assert area.at(*where) == told
    area["Age"] = "T#1001ms"
    assert area.at(*where) == "-"
    assert (area["Valid"], area["Error"]) == (False, False)
    area["MaxAge"] = "T#1001ms"
    assert area.at(*where) == told


def test_after_a_gap_the_dead_band_counts_again() -> None:
    area = _Area(DeadBand=500)
    assert [area.at(one, *_MIDDLE[1:]) for one in (1600, 1200)] == ["inside", "inside"]
    area["PositionValid"] = False
    area.at(1200, *_MIDDLE[1:])
    area["PositionValid"] = True
    assert area.at(1200, *_MIDDLE[1:]) == "-"
    assert area.at(500, *_MIDDLE[1:]) == "outside"
    area["Age"] = "T#1h"
    area.at(900, *_MIDDLE[1:])
    area["Age"] = "T#0s"
    assert area.at(900, *_MIDDLE[1:]) == "-"


@pytest.mark.parametrize(
    ("value", "wrong"), [(0, False), (-1, True), (_MOST, False), (_MOST + 1, True)]
)
def test_the_dead_band_is_not_below_0(value: int, wrong: bool) -> None:
    area = _Area(DeadBand=value)
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
def test_limits_are_in_their_order_and_range(
    engine: str, k: int, low: int, high: int, pulses: int, depth: int | None
) -> None:
    """Differences of 2,000,000,000 pulses are exact."""
    area = _Area(engine)
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
        assert told == ("inside" if depth >= 0 else "outside"), "it was inside before"


@pytest.mark.parametrize(
    ("pin", "wrong", "right", "error"),
    [
        ("DeadBand", -1, 100, 0x8045),
        ("Low", [4000], _LIMITS["Low"], 0x8045),
        ("Axes", 0, 15, 0x8041),
    ],
)
def test_an_error_goes_with_its_cause(pin: str, wrong: Any, right: Any, error: int) -> None:
    area = _Area()
    assert area.at(*_MIDDLE) == "inside"
    area[pin] = wrong
    assert area.at(*_MIDDLE) == "-"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (error, False, 0)
    area[pin] = right
    assert area.at(*_MIDDLE) == "inside"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (0, True, 900)
