"""No index outside of its array, no conversion out of range, proved."""

from __future__ import annotations

from pathlib import Path

import pytest

from proving import library, statuses
from rcx_tools.evidence.prove.safety import PROPERTIES

(_SAFETY,) = PROPERTIES


@pytest.mark.parametrize("block", ["FB_RealTimeValue", "FB_WriteBit", "FB_SetInchingAmount"])
def test_nothing_of_a_block_leaves_its_range(block: str, tmp_path: Path) -> None:
    """Whatever its pins hold."""
    assert statuses(_SAFETY, library(tmp_path, block), block.upper()) <= {"proved"}


def test_a_number_is_converted_only_where_an_integer_can_hold_it(tmp_path: Path) -> None:
    """Each REAL at the pin, up to infinity and what is no number."""
    assert statuses(_SAFETY, library(tmp_path, "FB_MoveTPtp"), "FB_MOVETPTP") == {"proved"}


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
