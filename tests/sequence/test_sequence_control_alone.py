"""FB_SequenceControl alone: what it asks for while it is Valid, and which error stays."""

from __future__ import annotations

import pytest

from alone import Alone


@pytest.fixture
def block() -> Alone:
    """Enabled, the controller is up."""
    alone = Alone("FB_SequenceControl", {"Robot": "RCX_REF"})
    alone["Robot.Connected"] = alone["Robot.SO.SO01_CpuOk"] = alone["Block.Enable"] = True
    alone["Block.Timeout"] = "T#100ms"
    return alone


def test_si10_stays_requested_while_the_sequence_program_runs(block: Alone) -> None:
    """Source: manual chapter 5, 2, SI(10) and SO(12)."""
    block["Robot.SI.SI10_SequenceControl"] = block["Robot.SO.SO12_SequenceRunning"] = True
    for now in (0, 10, 200):
        block["Robot.Inner.Request"] = 0
        block.scan(now)
        assert block["Block.Valid"] is True
        assert block["Robot.Inner.Request"] == 0x0100, "bit 0 of byte n + 33"


@pytest.mark.parametrize("lost", ["Robot.Connected", "Robot.SO.SO01_CpuOk"])
def test_the_first_error_stays_until_enable_falls(block: Alone, lost: str) -> None:
    """Source: design of the library, 3; head of FB_SequenceControl."""
    for now in (0, 100):
        block.scan(now)
    assert block["Block.ErrorID"] == 0x8010
    block[lost] = False
    block.scan(110)
    assert block["Block.ErrorID"] == 0x8010
    block["Block.Enable"] = False
    block.scan(120)
    assert block["Block.ErrorID"] == 0
