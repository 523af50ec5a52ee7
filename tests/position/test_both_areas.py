"""FB_AxisArea and FB_WorkArea have the same rules for validity, age, dead band and errors."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import pytest

from area_blocks import AxisArea, WorkArea


class _Kind(NamedTuple):
    """A kind of area, with the value of its border in the first coordinate and of one unit."""

    make: Callable[..., Any]
    border: float
    unit: float
    rest: tuple[float, ...]
    depth: float

    def at(self, area: Any, units: float) -> str:
        """Return Inside and Outside for a position at this distance beyond the border."""
        first = self.border + units * self.unit
        return str(area.at(int(first) if self.unit == 100 else first, *self.rest))


_AXIS = _Kind(
    partial(AxisArea, Low=[1000, -5000, 0, -900], High=[3000, -1000, 8000, 900]),
    1000, 100, (-3000, 4000, 0), 900,
)  # fmt: skip
_WORK = _Kind(
    partial(WorkArea, Corner1=[100.0, 200.0, 300.0], Corner2=[200.0, 400.0, 600.0]),
    100, 1.0, (300, 450), 50,
)  # fmt: skip
_both = pytest.mark.parametrize("kind", [_AXIS, _WORK], ids=["FB_AxisArea", "FB_WorkArea"])
_on_both_sides = pytest.mark.parametrize(("units", "told"), [(10, "inside"), (-10, "outside")])


def _with_dead_band(kind: _Kind) -> Any:
    return kind.make(DeadBand=500 if kind is _AXIS else 5.0)


@_both
def test_a_bit_falls_at_the_border_and_rises_beyond_the_dead_band(kind: _Kind) -> None:
    """With a dead band of 5, Inside turns TRUE at 5 and FALSE below 0; Outside at -5 and 0."""
    area = _with_dead_band(kind)
    least = 0.01 if kind is _AXIS else 0.5
    places = (5 - least, 5, 0, -least, least - 5, -5, -least, 0, 5 - least)
    told = [kind.at(area, units) for units in places]
    assert told == ["-", "inside", "inside", "-", "-", "outside", "outside", "-", "-"]


@_both
@_on_both_sides
def test_nothing_is_sure_without_valid_data(kind: _Kind, units: float, told: str) -> None:
    area = kind.make()
    assert kind.at(area, units) == told
    area["PositionValid"] = False
    assert kind.at(area, units) == "-"
    assert (area["Valid"], area["Error"]) == (False, False)
    area["PositionValid"] = True
    assert kind.at(area, units) == told


@_both
@_on_both_sides
def test_data_older_than_max_age_are_neither_inside_nor_outside(
    kind: _Kind, units: float, told: str
) -> None:
    """If data are older than MaxAge (one second), Inside and Outside are FALSE.

    This is not an error, since a movement may take longer.
    """
    area = kind.make(Age="T#1000ms")
    assert kind.at(area, units) == told
    area["Age"] = "T#1001ms"
    assert kind.at(area, units) == "-"
    assert (area["Valid"], area["Error"]) == (False, False)
    area["MaxAge"] = "T#1001ms"
    assert kind.at(area, units) == told


@_both
def test_after_a_gap_the_dead_band_counts_again(kind: _Kind) -> None:
    area = _with_dead_band(kind)
    assert [kind.at(area, units) for units in (6, 2)] == ["inside", "inside"]
    area["PositionValid"] = False
    kind.at(area, 2)
    area["PositionValid"] = True
    assert kind.at(area, 2) == "-"
    assert kind.at(area, -5) == "outside"
    area["Age"] = "T#1h"
    kind.at(area, -1)
    area["Age"] = "T#0s"
    assert kind.at(area, -1) == "-"


@pytest.mark.parametrize(
    ("kind", "pin", "wrong", "right", "error"),
    [
        (_AXIS, "DeadBand", -1, 100, 0x8045),
        (_AXIS, "Low", [4000], [1000, -5000, 0, -900], 0x8045),
        (_AXIS, "Axes", 0, 15, 0x8041),
        (_WORK, "DeadBand", -1.0, 1.0, 0x8045),
        (_WORK, "Corner1", [0.0, 9000.0], [100.0, 200.0, 300.0], 0x8047),
    ],
)
def test_an_error_goes_with_its_cause(
    kind: _Kind, pin: str, wrong: Any, right: Any, error: int
) -> None:
    area, middle = kind.make(), 10 if kind is _AXIS else 50
    assert kind.at(area, middle) == "inside"
    area[pin] = wrong
    assert kind.at(area, middle) == "-"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (error, False, 0)
    area[pin] = right
    assert kind.at(area, middle) == "inside"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (0, True, kind.depth)
