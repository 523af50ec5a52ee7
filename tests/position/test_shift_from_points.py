"""FB_ShiftFromPoints calculates a shift from a point at its origin and a point along its X."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES
from for_each import for_each
from rcx_harness.robot.geometry import Frame

_ORIGIN = [100.0, 200.0, 50.0, 30.0]


@cache
def _block(engine: str) -> Alone:
    return Alone("FB_ShiftFromPoints", {}, engine)


def _six(place: Sequence[float]) -> list[float]:
    return [*place, *[0.0] * (6 - len(place))]


def _shift(
    origin: Sequence[float], along_x: Sequence[float], engine: str = "auto", **pins: Any
) -> tuple[list[float], int, float]:
    """Return the outputs ShiftMm, ErrorID and Distance after one scan."""
    block = _block(engine)
    block.restart()
    for pin, value in {"Origin": _six(origin), "AlongX": _six(along_x), **pins}.items():
        block[f"Block.{pin}"] = value
    return _scan(block)


def _scan(block: Alone) -> tuple[list[float], int, float]:
    block.scan(0)
    assert block["Block.Valid"] is (not block["Block.Error"])
    assert block["Block.Error"] is (block["Block.ErrorID"] != 0)
    return block["Block.ShiftMm"], block["Block.ErrorID"], block["Block.Distance"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("way", "turn", "far"),
    [
        ((80, 0), 0, 80),
        ((0, 25), 90, 25),
        ((-40, 0), 180, 40),
        ((0, -30), -90, 30),
        ((30, 40), 53.1301, 50),
        ((-30, 40), 126.8699, 50),
        ((-40, -30), -143.1301, 50),
        ((60, -80), -53.1301, 100),
    ],
)
def test_the_first_point_is_the_origin_and_the_second_the_direction_of_x(
    engine: str, way: tuple[float, float], turn: float, far: float
) -> None:
    """The first point is the origin of the shift; the second point gives the direction of X.

    The angle with the tangent 4 / 3 is 53.1301 degrees. R goes from X to Y.

    Source: remote command guide 4.3.4: axes 1 to 4 are X, Y, Z and R
    """
    there = [_ORIGIN[0] + way[0], _ORIGIN[1] + way[1], -400.0, 70.0, 5.0, 6.0]
    shift, error, distance = _shift(_ORIGIN, there, engine)
    assert error == 0
    assert shift == pytest.approx([100, 200, 50, turn], abs=1e-4)
    assert distance == pytest.approx(far, abs=1e-4)


def test_with_the_shift_the_points_are_at_zero_and_on_x() -> None:
    """With the calculated shift, the first point is at zero and the second point is on the X axis.

    The test has 200 random pairs of points, checked by the model of the controller.

    Source: harness/rcx_harness/robot/geometry.py
    """
    chance = random.Random(4)
    for _ in range(200):
        origin, there = ([chance.uniform(-1000, 1000) for _ in range(4)] for _ in range(2))
        shift, error, far = _shift(origin, there)
        assert error == 0
        frame = Frame((1000.0,) * 4, shift=tuple(round(1000 * one) for one in shift))
        seen = [frame.to_mm([round(1000 * one) for one in place]) for place in (origin, there)]
        assert seen[0][:3] == pytest.approx([0, 0, 0], abs=2)
        assert seen[1][:2] == pytest.approx([1000 * far, 0], abs=30), "0.03 mm on 2800 mm"


@pytest.mark.parametrize("way", [(10, 0), (0, -10), (6, 8)])
def test_points_nearer_than_the_least_distance_are_refused(way: tuple[float, float]) -> None:
    """Points nearer than LeastDistance are refused: by default 10 mm, in X and Y only.

    Source: comment of LeastDistance; docs/reference/errors.md, 16#8062
    """
    there = [_ORIGIN[k] + one for k, one in enumerate(way)]
    assert _shift(_ORIGIN, [*there, 50.0])[1] == 0
    nearer = [_ORIGIN[k] + 0.999 * one for k, one in enumerate(way)]
    shift, error, far = _shift(_ORIGIN, [*nearer, 900.0])
    assert (shift, error, far) == ([0] * 4, 0x8062, 0)
    assert _shift(_ORIGIN, nearer, LeastDistance=9.98)[1] == 0
    assert _shift(_ORIGIN, there, LeastDistance=10.1)[1] == 0x8062


def test_one_place_has_no_direction() -> None:
    assert _shift(_ORIGIN, _ORIGIN, LeastDistance=0.1) == ([0] * 4, 0x8062, 0)


@pytest.mark.parametrize(
    ("value", "wrong"),
    [
        (0.1, False),
        (0.0999, True),
        (0.0, True),
        (8191.9985, False),
        (8192.5, True),
        (-1.0, True),
        (math.nan, True),
    ],
)
def test_the_least_distance_is_a_distance(value: float, wrong: bool) -> None:
    shift, error, far = _shift([-4500, -4500, 50], [4500, 4500, 50], LeastDistance=value)
    assert (error == 0x8045) is wrong
    assert (shift == [0] * 4) is wrong
    assert (far == 0) is wrong


def test_what_is_wrong_with_an_input_is_said_before_what_is_wrong_with_the_points() -> None:
    assert _shift(_ORIGIN, _ORIGIN, LeastDistance=9000.0)[1] == 0x8045
    assert _shift([9000.0], [9000.0])[1] == 0x8047


@for_each("pin", ["Origin", "AlongX"])
@for_each("k", range(6))
@for_each(
    "value, wrong",
    [(8191.9985, False), (-8191.9985, False), (8192.5, True), (-8192.5, True), (math.nan, True)],
)
def test_illegal_coordinates_are_refused(pin: str, k: int, value: float, wrong: bool) -> None:
    """An illegal value of X, Y or Z is refused. Other coordinates are not checked."""
    place = _six(_ORIGIN)
    place[k] = value
    given = {"origin": _ORIGIN, "along_x": [150.0, 200.0]}
    given["origin" if pin == "Origin" else "along_x"] = place
    if pin == "AlongX" and k > 0:
        place[0] = 150.0
    shift, error, far = _shift(given["origin"], given["along_x"])
    if wrong and k < 3:
        assert (shift, error, far) == ([0] * 4, 0x8047, 0)
    else:
        assert error == 0


@pytest.mark.parametrize(
    ("pin", "wrong", "error"),
    [("LeastDistance", 0.0, 0x8045), ("Origin", [9000.0], 0x8047), ("AlongX", _ORIGIN, 0x8062)],
)
def test_an_error_shows_no_shift_of_before_and_goes_with_its_cause(
    pin: str, wrong: Any, error: int
) -> None:
    good = _shift(_ORIGIN, [100.0, 240.0])
    assert good[0] == pytest.approx([100, 200, 50, 90], abs=1e-4)
    assert good[1:] == (0, 40)
    block = _block("auto")
    right = block[f"Block.{pin}"]
    block[f"Block.{pin}"] = _six(wrong) if isinstance(wrong, list) else wrong
    assert _scan(block) == ([0] * 4, error, 0)
    block[f"Block.{pin}"] = right
    assert _scan(block) == good
