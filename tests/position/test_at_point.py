"""FB_AtPoint reports whether the tool is at a taught position, within tolerances."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES
from for_each import for_each

_TARGET = [100.0, 200.0, 50.0, -90.0]


@cache
def _block(engine: str) -> Alone:
    return Alone("FB_AtPoint", {}, engine)


class _Point:
    """A target, and a tool with a valid and recent position."""

    def __init__(self, engine: str = "auto", **inputs: Any) -> None:
        self._block = _block(engine)
        self._block.restart()
        first = {"PositionValid": True, "Age": "T#0ms", "TargetMm": _TARGET}
        for name, value in {**first, **inputs}.items():
            self[name] = value

    def __setitem__(self, pin: str, value: Any) -> None:
        long = [*value, *[0.0] * (6 - len(value))] if isinstance(value, list) else value
        self._block[f"Block.{pin}"] = long

    def __getitem__(self, pin: str) -> Any:
        return self._block[f"Block.{pin}"]

    def off(self, *way: float) -> bool:
        """Run one scan with the tool at these distances from the target, and return There."""
        place = [a + b for a, b in zip(_TARGET, [*way, *[0.0] * (4 - len(way))], strict=True)]
        self["PositionMm"] = place
        return self.scan()

    def scan(self) -> bool:
        """Run one scan, and return There."""
        self._block.scan(0)
        assert self["Error"] is (self["ErrorID"] != 0)
        return bool(self["There"])


@pytest.mark.parametrize("engine", ENGINES)
def test_distance_is_a_straight_line_and_turn_has_no_sign(engine: str) -> None:
    """Distance is the length of a straight line, and Turn has no sign.

    2, 3 and 6 mm along X, Y and Z are 7 mm in total.
    """
    point = _Point(engine)
    point.off(2, -3, 6, -4)
    assert (point["Distance"], point["Turn"]) == (pytest.approx(7), pytest.approx(4))
    assert point["Valid"]
    assert not point["There"]


@pytest.mark.parametrize(
    ("way", "there"),
    [
        ((0, 0, 0, 0), True),
        ((1, 0, 0, 0), True),
        ((0, -1.001, 0, 0), False),
        ((0, 0, 1.001, 0), False),
        ((0.7, 0.7, 0.7, 0), False),
        ((0, 0, 0, 1), True),
        ((0, 0, 0, -1.001), False),
        ((0, 0, 0, 360), False),
    ],
)
def test_tolerances_are_a_millimetre_and_a_degree(way: tuple[float, ...], there: bool) -> None:
    """The default tolerances are 1 mm and 1 degree.

    Three distances of 0.7 mm are 1.21 mm in total. With R a whole turn away, There is FALSE.
    """
    assert _Point().off(*way) is there


@pytest.mark.parametrize("k", [0, 1, 2, 3])
def test_there_falls_only_beyond_the_dead_band(k: int) -> None:
    """With tolerance and dead band, There turns TRUE within 2 mm, and FALSE beyond 2.5 mm."""
    point = _Point(Tolerance=2.0, ToleranceDeg=2.0)
    ways = [[0.0] * k + [way] for way in (2.01, 2.0, 2.5, 2.51, 2.01, 1.99)]
    assert [point.off(*way) for way in ways] == [False, True, True, False, False, True]
    point["DeadBand"] = 0.0
    assert point.off(*ways[0]) is False


@pytest.mark.parametrize(("tight", "other"), [("Tolerance", 3), ("ToleranceDeg", 0)])
def test_each_tolerance_is_its_own(tight: str, other: int) -> None:
    point = _Point(Tolerance=5.0, ToleranceDeg=5.0)
    point[tight] = 0.0
    way = [0.0] * 4
    way[other] = 4.0
    assert point.off(*way) is True
    way[3 - other] = 4.0
    assert point.off(*way) is False


def test_without_valid_or_with_old_data_it_is_not_there() -> None:
    point = _Point(Age="T#1000ms")
    assert point.off(0)
    for pin, wrong, right in (("Age", "T#1001ms", "T#0s"), ("PositionValid", False, True)):
        point[pin] = wrong
        assert not point.off(1.4), "within tolerance and dead band"
        assert (point["Valid"], point["Error"]) == (False, False)
        point[pin] = right
        assert not point.off(1.4), "There must turn TRUE again"
        assert point["Valid"]
        assert point.off(0)
    point["Age"], point["MaxAge"] = "T#2s", "T#2s"
    assert point.off(0)


_EDGE = 8191.9985


@pytest.mark.parametrize("pin", ["Tolerance", "ToleranceDeg", "DeadBand"])
@pytest.mark.parametrize(
    ("value", "wrong"),
    [(0.0, False), (_EDGE, False), (-0.001, True), (8192.5, True), (math.nan, True)],
)
def test_tolerances_are_not_below_0(pin: str, value: float, wrong: bool) -> None:
    point = _Point()
    point[pin] = value
    assert point.off(0) is (not wrong)
    assert (point["ErrorID"] == 0x8045) is wrong
    assert point["Valid"] is (not wrong)


@for_each("pin", ["PositionMm", "TargetMm"])
@for_each("k", range(5))
@for_each(
    "value, wrong",
    [(_EDGE, False), (-_EDGE, False), (8192.5, True), (-8192.5, True), (math.nan, True)],
)
def test_illegal_coordinates_are_refused(pin: str, k: int, value: float, wrong: bool) -> None:
    """An illegal value of X, Y, Z or R is refused. Other coordinates are not checked."""
    point = _Point()
    assert point.off(0)
    coordinates = [*_TARGET, 0.0]
    coordinates[k] = value
    point[pin] = coordinates
    point.scan()
    refused = wrong and k < 4
    assert (point["ErrorID"] == 0x8047) is refused
    if refused:
        shown = (point["Valid"], point["There"], point["Distance"], point["Turn"])
        assert shown == (False, False, 0, 0)


def test_an_error_clears_the_outputs_and_ends_with_its_cause() -> None:
    """During an error, There and Distance are reset, and the error ends with its cause.

    Distances of 0.6 and 0.8 mm are 1 mm in total.
    """
    point = _Point(Tolerance=2.0)
    for pin, wrong, right, error in (
        ("DeadBand", -1.0, 0.5, 0x8045),
        ("TargetMm", [0.0, 9000.0], _TARGET, 0x8047),
    ):
        assert point.off(0.6, 0, -0.8, 0.5)
        assert point["Distance"] == pytest.approx(1, abs=1e-4)
        assert point["Turn"] == pytest.approx(0.5)
        point[pin] = wrong
        assert not point.scan()
        assert (point["ErrorID"], point["Distance"], point["Turn"]) == (error, 0, 0)
        point[pin] = right
        assert point.scan()
        assert (point["ErrorID"], point["Valid"]) == (0, True)
        assert point["Distance"] == pytest.approx(1, abs=1e-4)
        assert point["Turn"] == pytest.approx(0.5)
