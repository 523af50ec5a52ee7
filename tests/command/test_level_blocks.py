"""What FB_Jog and FB_ContinuousPosition have in common: the shortest limit, and the channel."""

from __future__ import annotations

import pytest

from plc_bench import ROOT, PlcBench


@pytest.fixture
def plc() -> PlcBench:
    plc = PlcBench(program=ROOT / "tests/data/library/Levels.st")
    plc.power_up()
    plc.scan(3)
    return plc


@pytest.mark.parametrize("block", ["Jog", "Position"])
def test_a_timeout_of_one_millisecond_is_a_limit(plc: PlcBench, block: str) -> None:
    """T#0s alone is no limit.

    Source: docs/errors.md, 16#8015.
    """
    plc.answer(0x0200)
    plc[f"{block}.Timeout"], plc[f"{block}.Enable"] = "T#1ms", True
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]), most=4)
    assert plc[f"{block}.ErrorID"] == 0x8015


@pytest.mark.parametrize(("block", "code"), [("Jog", 0x3020), ("Position", 0x3505)])
def test_the_channel_shows_the_code_of_the_command(plc: PlcBench, block: str, code: int) -> None:
    """Source: remote command guide 4.2.6 and 4.7.4: R in bits 15 to 12."""
    plc[f"{block}.RobotNumber"], plc[f"{block}.Enable"] = 3, True
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc["Robot.Command.Holder"] == code
