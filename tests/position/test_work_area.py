"""FB_WorkArea: inside or outside of a box or a cylinder, by positions of a certain age."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES

_ON_BOTH = pytest.mark.parametrize("engine", ENGINES)
_BOX: dict[str, Any] = {"Corner1": [100.0, 200.0, 300.0], "Corner2": [200.0, 400.0, 600.0]}
_TUBE: dict[str, Any] = {
    "Shape": "AREA_CYLINDER",
    "Corner1": [100.0, 200.0, 50.0],
    "Corner2": [999.0, 999.0, 150.0],
    "Radius": 50.0,
}


@cache
def _block(engine: str) -> Alone:
    return Alone("FB_WorkArea", {}, engine)


class _Area:
    """A work area, and a tool whose position is valid and new."""

    def __init__(self, engine: str = "auto", **inputs: Any) -> None:
        self._block = _block(engine)
        self._block.restart()
        for name, value in {"PositionValid": True, "Age": "T#0ms", **inputs}.items():
            self[name] = value

    def __setitem__(self, pin: str, value: Any) -> None:
        long = [*value, *[0.0] * (6 - len(value))] if isinstance(value, list) else value
        self._block[f"Block.{pin}"] = long

    def __getitem__(self, pin: str) -> Any:
        return self._block[f"Block.{pin}"]

    def at(self, *place: float) -> str:
        """One scan with the tool there: what the bits say."""
        self["PositionMm"] = list(place)
        self._block.scan(0)
        assert not (self["Inside"] and self["Outside"])
        assert self["Error"] is (self["ErrorID"] != 0)
        return "inside" if self["Inside"] else "outside" if self["Outside"] else "-"


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
    """From (100, 200, 300) to (200, 400, 600): the nearest side counts."""
    corners = {"Corner1": _BOX["Corner2"], "Corner2": _BOX["Corner1"]} if swapped else _BOX
    area = _Area(engine, **corners)
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
def test_a_cylinder_stands_on_the_middle_of_its_end(
    engine: str, place: Sequence[float], depth: float
) -> None:
    """Radius 50 about (100, 200), Z from 50 to 150; X and Y of the second corner do not count.

    30 and 40 mm off are 50 mm, 24 and 32 mm 40 mm, 60 and 80 mm 100 mm.
    """
    area = _Area(engine, **_TUBE)
    area.at(*place)
    assert area["Depth"] == pytest.approx(depth, abs=1e-4)


def test_a_bit_falls_at_the_border_and_rises_beyond_the_dead_band() -> None:
    """5 mm: inside from 105 on until below 100, outside from 95 on until 100."""
    area = _Area(**_BOX, DeadBand=5.0)
    told = [area.at(x, 300, 450) for x in (104.5, 105, 100, 99.5, 95.5, 95, 99.5, 100, 104.5)]
    assert told == ["-", "inside", "inside", "-", "-", "outside", "outside", "-", "-"]


def test_the_dead_band_is_a_millimetre_and_may_be_none() -> None:
    area = _Area(**_BOX)
    assert [area.at(x, 300, 450) for x in (100.5, 101, 99.5, 99)] == ["-", "inside", "-", "outside"]
    area["DeadBand"] = 0.0
    assert [area.at(x, 300, 450) for x in (100, 99.5)] == ["inside", "outside"]


@pytest.mark.parametrize("inside", [True, False])
def test_nothing_is_sure_without_valid_data(inside: bool) -> None:
    area = _Area(**_BOX)
    where = (150 if inside else 50, 300, 450)
    told = "inside" if inside else "outside"
    assert area.at(*where) == told
    area["PositionValid"] = False
    assert area.at(*where) == "-"
    assert not area["Valid"]
    assert not area["Error"]
    area["PositionValid"] = True
    assert area.at(*where) == told


@pytest.mark.parametrize("inside", [True, False])
def test_nothing_is_sure_by_data_older_than_max_age(inside: bool) -> None:
    """A second; it is no error, a movement may take longer."""
    area = _Area(**_BOX, Age="T#1000ms")
    where = (150 if inside else 50, 300, 450)
    assert area.at(*where) == ("inside" if inside else "outside")
    area["Age"] = "T#1001ms"
    assert area.at(*where) == "-"
    assert not area["Valid"]
    assert not area["Error"]
    area["MaxAge"] = "T#1001ms"
    assert area.at(*where) == ("inside" if inside else "outside")


def test_after_a_gap_the_dead_band_counts_again() -> None:
    area = _Area(**_BOX, DeadBand=5.0)
    assert [area.at(x, 300, 450) for x in (110, 102)] == ["inside", "inside"]
    area["PositionValid"] = False
    area.at(102, 300, 450)
    area["PositionValid"] = True
    assert area.at(102, 300, 450) == "-"
    assert area.at(95, 300, 450) == "outside"
    area["Age"] = "T#1h"
    area.at(99, 300, 450)
    area["Age"] = "T#0s"
    assert area.at(99, 300, 450) == "-"


_EDGE = 8191.9985


@pytest.mark.parametrize("pin", ["Radius", "DeadBand"])
@pytest.mark.parametrize(
    ("value", "wrong"),
    [(0.0, False), (_EDGE, False), (-0.001, True), (8192.5, True), (math.nan, True)],
)
def test_sizes_are_not_below_0(pin: str, value: float, wrong: bool) -> None:
    area = _Area(**_TUBE)
    area[pin] = value
    area.at(100, 200, 100)
    assert (area["ErrorID"] == 0x8045) is wrong
    assert area["Valid"] is (not wrong)


@pytest.mark.parametrize("pin", ["PositionMm", "Corner1", "Corner2"])
@pytest.mark.parametrize("k", range(4))
@pytest.mark.parametrize(
    ("value", "wrong"),
    [(_EDGE, False), (-_EDGE, False), (8192.5, True), (-8192.5, True), (math.nan, True)],
)
def test_coordinates_that_are_none_are_refused(pin: str, k: int, value: float, wrong: bool) -> None:
    """X, Y and Z; the others do not count."""
    area = _Area(**_BOX)
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


@pytest.mark.parametrize(
    ("pin", "wrong", "right", "error"),
    [("DeadBand", -1.0, 1.0, 0x8045), ("Corner1", [0.0, 9000.0], _BOX["Corner1"], 0x8047)],
)
def test_an_error_goes_with_its_cause(pin: str, wrong: Any, right: Any, error: int) -> None:
    area = _Area(**_BOX)
    place = (150, 300, 450)
    assert area.at(*place) == "inside"
    area[pin] = wrong
    assert area.at(*place) == "-"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (error, False, 0)
    area[pin] = right
    assert area.at(*place) == "inside"
    assert (area["ErrorID"], area["Valid"], area["Depth"]) == (0, True, 50)


def test_the_radius_is_a_millimetre_unless_it_is_given() -> None:
    """0.6 and 0.8 mm are 1 mm from the line of the cylinder."""
    area = _Area(Shape="AREA_CYLINDER", Corner2=[0.0, 0.0, 10.0])
    area.at(0, 0, 5)
    assert area["Depth"] == 1
    area.at(0.6, 0.8, 5)
    assert area["Depth"] == pytest.approx(0, abs=1e-6)
