"""The rules of the pins (Execute, Busy, Done, Error, ...) are proved for blocks."""

from __future__ import annotations

from pathlib import Path

import pytest

from proving import library, statuses
from rcx_tools.evidence.prove.contract import PROPERTIES

pytestmark = pytest.mark.exhaustive

(_CONTRACT,) = PROPERTIES


@pytest.mark.exhaustive(but=["FB_Jog", "FB_ReadMessage", "FB_ReadPort", "FB_WriteBit"])
@pytest.mark.parametrize(
    "block",
    ["FB_ReadMessage", "FB_Jog", "FB_ReadPort", "FB_WriteBit", "FB_ServoOnFromEmergencyStop"],
)
def test_a_block_keeps_the_contract_of_its_pins(block: str, tmp_path: Path) -> None:
    """Source: docs/explanation/architecture.md, the contract of every block."""
    assert statuses(_CONTRACT, library(tmp_path, block), block.upper()) == {"proved"}


@pytest.mark.exhaustive(but=["done-beside-error-FB_RcxJob", "jog-forgets-that-it-is-locked-FB_Jog"])
@pytest.mark.parametrize(
    ("bug", "block"),
    [
        ("done-beside-error", "FB_RcxJob"),
        ("message-not-cleared", "FB_ReadMessage"),
        ("jog-forgets-that-it-is-locked", "FB_Jog"),
    ],
)
def test_a_broken_contract_is_not_proved(bug: str, block: str, tmp_path: Path) -> None:
    broken = library(tmp_path, block, bug=bug, bugs="contract")
    assert "refuted" in statuses(_CONTRACT, broken, block.upper())
