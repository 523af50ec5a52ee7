"""Proofs show that no index leaves its array and no conversion leaves its range."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
import z3

from proving import library, statuses
from rcx_tools.evidence.prove.safety import PROPERTIES, exactly
from rcx_tools.evidence.prove.solve import ask

pytestmark = pytest.mark.exhaustive

(_SAFETY,) = PROPERTIES


@pytest.mark.parametrize("block", ["FB_RealTimeValue", "FB_WriteBit", "FB_SetInchingAmount"])
def test_no_index_or_conversion_of_a_block_leaves_its_range(block: str, tmp_path: Path) -> None:
    """No index or conversion in a block leaves its range, for any values of the pins."""
    assert statuses(_SAFETY, library(tmp_path, block), block.upper()) == {"proved"}


def test_a_number_is_converted_only_if_an_integer_can_hold_it(tmp_path: Path) -> None:
    """A REAL is converted only if an integer can hold it, even for infinity and not-a-number."""
    assert statuses(_SAFETY, library(tmp_path, "FB_MoveTPtp"), "FB_MOVETPTP") == {"proved"}


@pytest.mark.parametrize("compared", [z3.fpLT, z3.fpLEQ, z3.fpGT, z3.fpGEQ])
def test_a_limit_of_a_scaled_number_becomes_a_limit_of_the_number(compared: Any) -> None:
    """A limit of a scaled number is replaced by a limit of the number itself.

    Half a number compared with 3.0 becomes the number compared with 6.0.
    """
    pattern = z3.BitVec("pattern", 32)
    number = z3.fpFPToFP(z3.RNE(), z3.fpBVToFP(pattern, z3.Float32()), z3.Float64())
    half = z3.fpMul(z3.RNE(), number, z3.FPVal(0.5, z3.Float64()))
    found = exactly(compared(half, z3.FPVal(3.0, z3.Float64())))
    assert not any(z3.is_fp(child) for child in found.children())
    assert ask((), found == compared(number, z3.FPVal(6.0, z3.Float64())), 20.0).status == "proved"


def test_a_limit_that_is_not_a_literal_is_kept() -> None:
    """A comparison with an unknown limit is not replaced."""
    pattern, limit = z3.BitVec("pattern", 32), z3.FP("limit", z3.Float64())
    number = z3.fpFPToFP(z3.RNE(), z3.fpBVToFP(pattern, z3.Float32()), z3.Float64())
    assert exactly(number < limit).eq(number < limit)
    assert exactly(number <= limit).eq(number <= limit)


@pytest.mark.parametrize(
    ("bug", "block"),
    [
        ("area-of-a-negative-image", "FB_ReadPort"),
        ("real-time-word-behind-the-last", "FB_RealTimeValue"),
        ("log-one-longer", "FB_EventLog"),
    ],
)
def test_what_leaves_its_range_is_not_proved(bug: str, block: str, tmp_path: Path) -> None:
    broken = library(tmp_path, block, bug=bug, bugs="safety")
    assert "refuted" in statuses(_SAFETY, broken, block.upper())
