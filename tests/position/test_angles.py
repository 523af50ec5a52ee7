"""FC_RcxAngle and FC_RcxHalfTurn give values that were calculated by hand, on both engines."""

from __future__ import annotations

import math

import pytest

from plc_bench import compiled
from scara_bench import ON_BOTH

_ANGLE = """PROGRAM Angles
  VAR
    Along, Across, Angle : REAL;
  END_VAR
  Angle := FC_RcxAngle(Along := Along, Across := Across);
END_PROGRAM
"""


@ON_BOTH
def test_the_angle_of_a_vector_in_all_quarters_and_on_the_axes(engine: str) -> None:
    """FC_RcxAngle is correct in all quarters and on the axes; a zero vector has the angle 0.

    The tangent of 30 degrees is 0.57735.

    Source: head of FC_RcxAngle
    """
    program = compiled(_ANGLE, engine)
    for along, across, angle in (
        (0.0, 0.0, 0.0),
        (2.0, 0.0, 0.0),
        (0.0, 2.0, 90.0),
        (-2.0, 0.0, 180.0),
        (0.0, -2.0, -90.0),
        (1.0, 0.57735, 30.0),
        (0.57735, 1.0, 60.0),
        (-0.57735, 1.0, 120.0),
        (-1.0, 0.57735, 150.0),
        (-1.0, -0.57735, -150.0),
        (-0.57735, -1.0, -120.0),
        (0.57735, -1.0, -60.0),
        (1.0, -0.57735, -30.0),
        (0.0, 0.5, 90.0),
        (3.0, 3.0, 45.0),
        (-3.0, 3.0, 135.0),
        (-3.0, -3.0, -135.0),
    ):
        program.write("Main.Along", along)
        program.write("Main.Across", across)
        program.scan(0)
        assert program.read("Main.Angle") == pytest.approx(angle, abs=1e-4), (along, across)


_HALF_TURNS = """PROGRAM HalfTurns
  VAR
    Angle, Rest : REAL;
  END_VAR
  Rest := FC_RcxHalfTurn(Angle := Angle);
END_PROGRAM
"""


@ON_BOTH
def test_whole_turns_are_removed_from_an_angle_exactly(engine: str) -> None:
    """FC_RcxHalfTurn removes whole turns without an error.

    With whole turns, half a turn becomes 180 degrees.

    Half a turn alone, 180 or -180 degrees, does not change.

    Source: head of FC_RcxHalfTurn
    """
    program = compiled(_HALF_TURNS, engine)
    for angle, rest in (
        (0.0, 0.0),
        (180.0, 180.0),
        (-180.0, -180.0),
        (180.5, -179.5),
        (-180.5, 179.5),
        (270.0, -90.0),
        (-270.0, 90.0),
        (269.5, -90.5),
        (-269.5, 90.5),
        (360.0, 0.0),
        (-360.0, 0.0),
        (539.5, 179.5),
        (-539.5, -179.5),
        (540.5, -179.5),
        (-540.5, 179.5),
        (630.0, -90.0),
        (-630.0, 90.0),
        (8191.5, -88.5),
        (-8191.5, 88.5),
        (16380.25, -179.75),
        (720_000.0625, 0.0625),
        (-999_999.9375, 80.0625),
    ):
        program.write("Main.Angle", angle)
        program.scan(0)
        assert program.read("Main.Rest") == rest, angle
    for turns in (*range(-40, -1), *range(40)):
        program.write("Main.Angle", 180.0 + 360.0 * turns)
        program.scan(0)
        assert program.read("Main.Rest") == 180, turns
    for angle in (3.7e7, -3.7e7, math.inf, -math.inf):  # 100,000 turns and more
        program.write("Main.Angle", angle)
        program.scan(0)
        assert program.read("Main.Rest") == angle
    program.write("Main.Angle", math.nan)
    program.scan(0)
    assert math.isnan(program.read("Main.Rest"))
