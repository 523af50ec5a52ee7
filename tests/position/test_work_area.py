"""FB_WorkArea reports whether a position is inside or outside of a box or a cylinder.

If the position is older than MaxAge, Inside and Outside are FALSE.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import pytest

from area_blocks import WorkArea
from both_engines import ENGINES
from for_each import for_each

_ON_BOTH = pytest.mark.parametrize("engine", ENGINES)
_BOX: dict[str, Any] = {"Corner1": [100.0, 200.0, 300.0], "Corner2": [200.0, 400.0, 600.0]}
_TUBE: dict[str, Any] = {
    "Shape": "AREA_CYLINDER",
    "Corner1": [100.0, 200.0, 50.0],
    "Corner2": [999.0, 999.0, 150.0],
    "Radius": 50.0,
}


@_ON_BOTH
@pytest.mark.parametrize(
    ("place", "depth"),
    [
        ((150, 300, 450), 50),
        ((110, 300, 450), 10),
        ((195, 300, 450), 5),
        ((150, 203, 450), 3),
        ((150, 398, 450), 2),
        ((150, 300, 304), 4),
        ((150, 300, 590), 10),
        ((90, 300, 450), -10),
        ((150, 500, 450), -100),
        ((150, 300, 299), -1),
        ((90, 180, 450), -20),
    ],
)
@pytest.mark.parametrize("swapped", [False, True])
def test_a_box_lies_between_two_corners_in_any_order(
    engine: str, place: Sequence[float], depth: float, swapped: bool
) -> None:
    """A box lies between two corners in any order, and the distance to the nearest side decides.

    The box is from (100, 200, 300) to (200, 400, 600).
    """
    corners = {"Corner1": _BOX["Corner2"], "Corner2": _BOX["Corner1"]} if swapped else _BOX
    area = WorkArea(engine, **corners)
    assert area.at(*place) == ("inside" if depth > 0 else "outside")
    assert area["Depth"] == pytest.approx(depth)
    assert area["Valid"]


@_ON_BOTH
@pytest.mark.parametrize(
    ("place", "depth"),
    [
        ((100, 200, 100), 50),
        ((130, 240, 100), 0),
        ((124, 232, 100), 10),
        ((100, 200, 60), 10),
        ((100, 200, 148), 2),
        ((160, 280, 100), -50),
        ((100, 200, 170), -20),
        ((100, 200, 40), -10),
    ],
)
def test_the_first_corner_is_the_center_of_the_end_of_a_cylinder(
    engine: str, place: Sequence[float], depth: float
) -> None:
    """A cylinder has its axis through the first corner, and its height between the two corners.

    Here the radius is 50 about (100, 200), and Z is from 50 to 150. X and Y of the second corner
    are not used. Offsets of 30 and 40 mm are 50 mm in total, 24 and 32
    mm are 40 mm, 60 and 80 mm are 100 mm.
    """
    area = WorkArea(engine, **_TUBE)
    area.at(*place)
    assert area["Depth"] == pytest.approx(depth, abs=1e-4)


def test_the_dead_band_is_a_millimetre_and_may_be_none() -> None:
    area = WorkArea(**_BOX)
    assert [area.at(x, 300, 450) for x in (100.5, 101, 99.5, 99)] == ["-", "inside", "-", "outside"]
    area["DeadBand"] = 0.0
    assert [area.at(x, 300, 450) for x in (100, 99.5)] == ["inside", "outside"]


_EDGE = 8191.9985


@pytest.mark.parametrize("pin", ["Radius", "DeadBand"])
@pytest.mark.parametrize(
    ("value", "wrong"),
    [(0.0, False), (_EDGE, False), (-0.001, True), (8192.5, True), (math.nan, True)],
)
def test_sizes_are_not_below_0(pin: str, value: float, wrong: bool) -> None:
    area = WorkArea(**_TUBE)
    area[pin] = value
    area.at(100, 200, 100)
    assert (area["ErrorID"] == 0x8045) is wrong
    assert area["Valid"] is (not wrong)


@for_each("pin", ["PositionMm", "Corner1", "Corner2"])
@for_each("k", range(4))
@for_each(
    "value, wrong",
    [(_EDGE, False), (-_EDGE, False), (8192.5, True), (-8192.5, True), (math.nan, True)],
)
def test_illegal_coordinates_are_refused(pin: str, k: int, value: float, wrong: bool) -> None:
    """An illegal value of X, Y or Z is refused. Other coordinates are not checked."""
    area = WorkArea(**_BOX)
    assert area.at(150, 300, 450) == "inside"
    coordinates = [150.0, 300.0, 450.0, 0.0]
    coordinates[k] = value
    if pin != "PositionMm":
        area[pin] = coordinates
        coordinates = [150.0, 300.0, 450.0, 0.0]
    told = area.at(*coordinates)
    if wrong and k < 3:
        assert (area["ErrorID"], told, area["Depth"]) == (0x8047, "-", 0)
        assert not area["Valid"]
    else:
        assert area["ErrorID"] == 0


def test_the_default_radius_is_one_millimetre() -> None:
    """Without a value, the radius is 1 mm.

    The position is 0.6 and 0.8 mm, so 1 mm, from the axis.
    """
    area = WorkArea(Shape="AREA_CYLINDER", Corner2=[0.0, 0.0, 10.0])
    area.at(0, 0, 5)
    assert area["Depth"] == 1
    area.at(0.6, 0.8, 5)
    assert area["Depth"] == pytest.approx(0, abs=1e-6)
