"""Arithmetic that leaves its type is detected for known values and for solver terms."""

from __future__ import annotations

from itertools import product

import pytest
import z3

from structured_text.language.scalars import ELEMENTARY
from structured_text.prove import overflow

_EDGES = {"SINT": (-128, -127, -64, -1, 0, 1, 2, 127), "USINT": (0, 1, 2, 16, 128, 255)}


def _exact(op: str, left: int, right: int) -> int:
    return {"+": left + right, "-": left - right, "*": left * right}[op]


@pytest.mark.parametrize("kind", list(_EDGES))
@pytest.mark.parametrize("op", ["+", "-", "*"])
@pytest.mark.parametrize("known", ["both", "left", "right", "none"])
def test_arithmetic_that_leaves_8_bits_is_found(kind: str, op: str, known: str) -> None:
    """A result outside of the 8-bit type is detected for all operands.

    The test compares with unlimited integers. IEC 61131-3, table 10, has the ranges.
    """
    least, most = (-128, 127) if kind == "SINT" else (0, 255)
    a, b = z3.BitVec("a", 8), z3.BitVec("b", 8)
    for left, right in product(_EDGES[kind], repeat=2):
        first = left if known in ("both", "left") else a
        second = right if known in ("both", "right") else b
        found = overflow.arithmetic(op, first, second, ELEMENTARY[kind], overflow.NANOSECONDS)
        if not isinstance(found, bool):
            pairs = (a, z3.BitVecVal(left, 8)), (b, z3.BitVecVal(right, 8))
            found = z3.is_true(z3.simplify(z3.substitute(found, *pairs)))
        assert found is not (least <= _exact(op, left, right) <= most), (left, right)


@pytest.mark.parametrize(
    ("op", "left", "right", "leaves"),
    [("/", -128, -1, True), ("/", -127, -1, False), ("MOD", -128, -1, True), ("/", -128, 2, False)],
)
def test_only_the_lowest_value_divided_by_minus_1_overflows(
    op: str, left: int, right: int, leaves: bool
) -> None:
    kind = ELEMENTARY["SINT"]
    assert overflow.arithmetic(op, left, right, kind, overflow.NANOSECONDS) is leaves


@pytest.mark.parametrize(
    ("source", "target", "value", "leaves"),
    [
        ("INT", "UINT", -1, True),
        ("UINT", "INT", 32768, True),
        ("DINT", "INT", -32768, False),
        ("DINT", "INT", 32768, True),
        ("INT", "WORD", -1, False),  # The bit pattern does not change.
        ("WORD", "INT", 0xFFFF, False),
        ("WORD", "BYTE", 0x0100, True),
        ("WORD", "BYTE", 0x00FF, False),
        ("INT", "BYTE", -128, False),
        ("INT", "BYTE", -129, True),
        ("INT", "DINT", -1, False),
    ],
)
def test_a_conversion_that_loses_a_value_is_found(
    source: str, target: str, value: int, leaves: bool
) -> None:
    kinds = ELEMENTARY[source], ELEMENTARY[target]
    assert overflow.conversion(value, *kinds) is leaves
    width = {"INT": 16, "UINT": 16, "WORD": 16, "DINT": 32}[source]
    found = overflow.conversion(z3.BitVec("a", width), *kinds)
    if not isinstance(found, bool):
        found = z3.substitute(found, (z3.BitVec("a", width), z3.BitVecVal(value, width)))
        found = z3.is_true(z3.simplify(found))
    assert found is leaves
