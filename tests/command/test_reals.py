"""The library converts REAL values to IEEE 754 bit patterns and back without an error."""

from __future__ import annotations

import math
import random
import struct

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, compiled
from structured_text.engines.base import Program

PROGRAM = ROOT / "tests/data/library/Texts.st"

#: Patterns at the limits of the format: the smallest and largest denormal and normal numbers, 1,
#: and their neighbours.
PATTERNS = [
    0x00000000, 0x00000001, 0x00000002, 0x007FFFFF, 0x00800000, 0x00800001, 0x3F7FFFFF,
    0x3F800000, 0x3F800001, 0x4B000000, 0x4AFFFFFF, 0x4B7FFFFF, 0x4B800000, 0x4F000000,
    0x7F7FFFFF, 0x7F000000, 0x42C80000, 0xC2C80000, 0x80000001, 0xFF7FFFFF,
]  # fmt: skip


@pytest.fixture(scope="module", params=ENGINES)
def plc(request: pytest.FixtureRequest) -> Program:
    return compiled(PROGRAM, request.param)


def _real(pattern: int) -> float:
    return float(struct.unpack("<f", struct.pack("<I", pattern))[0])


def _patterns() -> list[int]:
    rng = random.Random(1)
    some = (rng.getrandbits(32) for _ in range(600))
    return PATTERNS + [one for one in some if one >> 23 & 0xFF != 0xFF]


def test_every_real_has_its_pattern_and_is_read_from_it(plc: Program) -> None:
    """Each REAL has the right pattern, and each pattern gives the REAL.

    Source: remote command guide 4.4.1: single-precision real numbers in 32 bits.
    """
    for pattern in _patterns():
        plc.write("Main.Number32", _real(pattern))
        plc.write("Main.Bits", pattern)
        plc.scan(0)
        assert plc.read("Main.Pattern") == pattern, f"{pattern:#010x}"
        assert plc.read("Main.Back") == _real(pattern), f"{pattern:#010x}"


@pytest.mark.parametrize(
    ("pattern", "real"),
    [
        (0x80000000, 0.0),
        (0x7F800000, _real(0x7F7FFFFF)),
        (0xFF800000, -_real(0x7F7FFFFF)),
        (0x7FC00000, 0.0),
    ],
)
def test_infinity_and_nan_give_a_finite_number(plc: Program, pattern: int, real: float) -> None:
    """Infinity becomes the largest REAL and NaN becomes 0 (assumed: the guide is silent)."""
    plc.write("Main.Bits", pattern)
    plc.scan(0)
    assert plc.read("Main.Back") == real


@pytest.mark.parametrize(("number", "pattern"), [("inf", 0x7F800000), ("-inf", 0xFF800000)])
def test_an_overflow_has_the_pattern_of_infinity(plc: Program, number: str, pattern: int) -> None:
    """A number beyond the largest REAL has the pattern of infinity.

    Source: IEEE 754, exponent 255.
    """
    plc.write("Main.Number32", float(number))
    plc.scan(0)
    assert plc.read("Main.Pattern") == pattern


@pytest.mark.parametrize(
    ("number", "outside"),
    [(0.5, False), (-0.5, False), (2.0, False), (2.001, True), (-0.501, True), (math.nan, True)],
)
def test_numbers_outside_of_the_limits_and_nan_are_detected(
    plc: Program, number: float, outside: bool
) -> None:
    """Numbers outside of the limits -0.5 to 2.0, and NaN, are reported as outside."""
    plc.write("Main.Number32", number)
    plc.scan(0)
    assert plc.read("Main.Outside") is outside
