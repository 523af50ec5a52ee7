"""FB_HandFromPoints calculates X and Y of a hand on the R axis from two touches of a place."""

from __future__ import annotations

import dataclasses
import math
import random
from collections.abc import Sequence
from functools import cache
from typing import Any

import pytest

from alone import Alone
from both_engines import ENGINES
from for_each import for_each
from rcx_harness.robot.kinematics import UnreachableError
from scara_poses import Pose

_RIGHT: tuple[list[float], list[float]] = ([140.0, 170.0, 5.0, 90.0], [130.0, 240.0, 5.0, 180.0])


@cache
def _block(engine: str) -> Alone:
    return Alone("FB_HandFromPoints", {}, engine)


def _six(place: Sequence[float]) -> list[float]:
    return [*place, *[0.0] * (6 - len(place))]


def _hand(
    point1: Sequence[float], point2: Sequence[float], engine: str = "auto", **pins: Any
) -> tuple[float, float, float, int]:
    """Return the outputs Data1, Data2, Growth and ErrorID after one scan."""
    block = _block(engine)
    block.restart()
    for pin, value in {"Point1": _six(point1), "Point2": _six(point2), **pins}.items():
        block[f"Block.{pin}"] = value
    return _scan(block)


def _scan(block: Alone) -> tuple[float, float, float, int]:
    block.scan(0)
    assert block["Block.Valid"] is (not block["Block.Error"])
    assert block["Block.Error"] is (block["Block.ErrorID"] != 0)
    data1, data2, growth = (block[f"Block.{pin}"] for pin in ("Data1", "Data2", "Growth"))
    return data1, data2, growth, block["Block.ErrorID"]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize(
    ("first", "second", "data", "growth"),
    [
        ((70, 200, 0, 0), (130, 200, 0, 180), (30, 0), 0.5),
        ((100, 170, 0, 90), (100, 230, 0, -90), (30, 0), 0.5),
        ((100, 240, 0, 0), (100, 160, 0, 180), (0, -40), 0.5),
        ((70, 160, 0, 0), (140, 170, 0, 90), (30, 40), 0.7071),
        ((140, 170, 0, 90), (130, 240, 0, 180), (30, 40), 0.7071),
        ((80, 200, 0, 0), (82.6795, 190, 0, 30), (20, 0), 1.9319),
        ((82.6795, 190, 0, 30), (80, 200, 0, 0), (20, 0), 1.9319),
        ((80, 200, 0, 360), (90, 217.3205, 0, -60), (20, 0), 1.0),
        ((80, 200, 0, 720), (120, 200, 0, 180), (20, 0), 0.5),
    ],
)
def test_two_touches_of_one_place_give_the_hand(
    engine: str,
    first: Sequence[float],
    second: Sequence[float],
    data: tuple[float, float],
    growth: float,
) -> None:
    """Two touches of the same place, at (100, 200) mm, give the data of the hand.

    The tool is at the place minus the hand turned by R. At 90 degrees, a hand of (30, 40) mm is
    (-40, 30) mm. A hand of 20 mm along X is (17.3205, 10)
    mm at 30 degrees, and (10, -17.3205) mm at -60 degrees. Growth is 1 / (2 sin(turn / 2)). The
    half turns are 90, 45, 15 and 30 degrees.

    Source: remote command guide 4.3.5
    """
    data1, data2, grown, error = _hand(first, second, engine)
    assert error == 0
    assert (data1, data2) == pytest.approx(data, abs=0.001)
    assert grown == pytest.approx(growth, abs=1e-4)


def _touch(model: str, hand: Sequence[int], place: Sequence[int], left: bool) -> list[float]:
    """Return the position, with a hand of zeros, while the tip is at a place [0.001 mm]."""
    pose = Pose(model, (hand[0], hand[1], hand[2]), True, (0, 0, 0, 0), ())
    pulses = pose.frame(left=left).to_pulses(place)
    bare = dataclasses.replace(pose, hand=(0, 0, 0), shift=(40_000, -70_000, 9_000, 33_000))
    return [round(one) / 1000 for one in bare.frame().to_mm([round(one) for one in pulses])]


def test_the_result_is_the_hand_of_the_model_of_the_controller() -> None:
    """For 200 hands of a YK400XE, the result agrees with the model of the controller to 0.05 mm.

    The tolerance covers whole pulses of three turning axes, with Growth up to 2. The positions are
    read with a shift that is not zero.

    Source: harness/rcx_harness/robot/kinematics.py
    """
    chance = random.Random(7)
    found = 0
    while found < 200:
        hand = [chance.randint(-100_000, 100_000) for _ in range(3)]
        x, y = chance.randint(-150_000, 150_000), chance.randint(150_000, 300_000)
        turn = chance.randint(-180_000, 180_000)
        other = turn + chance.choice([-1, 1]) * chance.randint(30_000, 330_000)
        left = chance.random() < 0.5
        try:
            points = [_touch("YK400XE", hand, (x, y, 60_000, r), left) for r in (turn, other)]
        except UnreachableError:
            continue
        data1, data2, growth, error = _hand(points[0], points[1], MaxGrowth=2.1)
        assert error == 0
        assert growth <= 1.94
        assert (data1, data2) == pytest.approx((hand[0] / 1000, hand[1] / 1000), abs=0.05)
        found += 1


@pytest.mark.parametrize(
    ("turn", "wider"),
    [(28, 29.5), (-28, -29.5), (331.5, 330), (-332, -330.5), (388, 389.5), (28.9, 29.0)],
)
def test_a_turn_that_is_too_small_is_refused(turn: float, wider: float) -> None:
    """A turn with a Growth above 2 is refused: 28 degrees have 2.067, 29.5 degrees have 1.964.

    Whole turns have no effect. The limit is a turn of 28.955 degrees, because the sine of 14.4775
    degrees is 0.25.

    Source: comment of MaxGrowth; docs/reference/errors.md, 16#8063
    """
    first = [100, 200, 0, 40]
    assert _hand(first, [120, 200, 0, 40 + turn]) == (0, 0, 0, 0x8063)
    assert _hand(first, [120, 200, 0, 40 + turn], MaxGrowth=2.1)[3] == 0
    assert _hand(first, [120, 200, 0, 40 + wider])[3] == 0


@pytest.mark.parametrize(("turn", "growth"), [(2, 28.65), (0.6, 95.49), (359.4, 95.49)])
def test_a_small_turn_is_accepted_with_a_larger_max_growth(turn: float, growth: float) -> None:
    """A small turn is accepted if MaxGrowth allows its Growth.

    Growth is 1 / (2 sin) of 1 and 0.3 degrees. The sines are 0.017452 and 0.005236.
    """
    first, second = [100, 200, 0, 0], [100, 200, 0, turn]
    data1, data2, grown, error = _hand(first, second, MaxGrowth=100.0)
    assert error == 0
    assert (data1, data2) == pytest.approx((0, 0), abs=1e-4)
    assert grown == pytest.approx(growth, abs=0.01)
    assert _hand(first, second, MaxGrowth=growth - 1)[3] == 0x8063


@pytest.mark.parametrize("turn", [0, 360, -360, 720])
def test_whole_turns_tell_nothing(turn: float) -> None:
    found = _hand([100, 200, 0, 40], [120, 200, 0, 40 + turn], MaxGrowth=100.0)
    assert found == (0, 0, 0, 0x8063)


@pytest.mark.parametrize(
    ("value", "wrong"),
    [
        (0.5, False),
        (0.4999, True),
        (0.0, True),
        (-1.0, True),
        (100.0, False),
        (100.01, True),
        (math.nan, True),
    ],
)
def test_growth_is_half_at_best_and_100_at_worst(value: float, wrong: bool) -> None:
    data1, data2, growth, error = _hand([70, 200, 0, 0], [130, 200, 0, 180], MaxGrowth=value)
    assert (error == 0x8045) is wrong
    assert (growth == 0) is wrong
    assert (data1, data2) == pytest.approx((0 if wrong else 30, 0), abs=1e-4)


@for_each("pin", [0, 1])
@for_each("k", range(6))
@for_each(
    "value, wrong",
    [(8191.9985, False), (-8191.9985, False), (8192.5, True), (-8192.5, True), (math.nan, True)],
)
def test_illegal_coordinates_are_refused(pin: int, k: int, value: float, wrong: bool) -> None:
    """An illegal value of X, Y or R is refused. Other coordinates are not checked."""
    points = [_six([0.0, 0.0, 0.0, 0.0]), _six([0.0, 0.0, 0.0, 120.0])]
    points[pin][k] = value
    data1, data2, growth, error = _hand(points[0], points[1], MaxGrowth=100.0)
    if wrong and k in (0, 1, 3):
        assert (data1, data2, growth, error) == (0, 0, 0, 0x8047)
    else:
        assert error == 0


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize(("way", "error"), [(8191.99, 0), (8192.5, 0x8047)])
def test_a_hand_that_is_too_long_for_a_telegram_is_refused(
    axis: int, sign: int, way: float, error: int
) -> None:
    """A hand that is longer than 8192 mm is refused.

    With R at -30 and 30 degrees, the hand is as long as the distance of the two points, and at a
    right angle to it.

    Source: docs/reference/errors.md, 16#8047
    """
    points = [[0.0, 0.0, 0.0, -30.0], [0.0, 0.0, 0.0, 30.0]]
    points[0][axis], points[1][axis] = sign * way / 2, -sign * way / 2
    expected = [0.0, 0.0]
    if not error:
        expected[1 - axis] = sign * way if axis == 1 else -sign * way
    *data, growth, found = _hand(points[0], points[1])
    assert found == error
    assert data == pytest.approx(expected, abs=0.005)
    assert growth == pytest.approx(0 if error else 1, abs=1e-5)


@pytest.mark.parametrize(
    ("pin", "wrong", "error"),
    [("MaxGrowth", 0.0, 0x8045), ("Point1", [9000.0], 0x8047), ("Point2", _RIGHT[0], 0x8063)],
)
def test_an_error_shows_no_hand_of_before_and_goes_with_its_cause(
    pin: str, wrong: Any, error: int
) -> None:
    good = _hand(*_RIGHT)
    assert good[3] == 0
    block = _block("auto")
    right = block[f"Block.{pin}"]
    block[f"Block.{pin}"] = _six(wrong) if isinstance(wrong, list) else wrong
    assert _scan(block) == (0, 0, 0, error)
    block[f"Block.{pin}"] = right
    assert _scan(block) == good
