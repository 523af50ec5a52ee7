"""FB_Jog and FB_ContinuousPosition have the same time limits and use the command channel."""

from __future__ import annotations

import pytest

from plc_bench import ROOT, PlcBench

BLOCKS = (pytest.param("Jog", id="FB_Jog"), pytest.param("Position", id="FB_ContinuousPosition"))


@pytest.fixture
def plc() -> PlcBench:
    plc = PlcBench(program=ROOT / "tests/data/library/Levels.st")
    plc.power_up()
    plc.scan(3)
    return plc


@pytest.mark.parametrize("block", BLOCKS)
def test_a_timeout_of_one_millisecond_is_a_limit(plc: PlcBench, block: str) -> None:
    """With Timeout = T#1ms the wait ends with 16#8015.

    Source: docs/reference/errors.md, 16#8015.
    """
    plc.answer(0x0200)
    plc[f"{block}.Timeout"], plc[f"{block}.Enable"] = "T#1ms", True
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]), most=4)
    assert plc[f"{block}.ErrorID"] == 0x8015


@pytest.mark.parametrize(("block", "code"), [("Jog", 0x3020), ("Position", 0x3505)])
def test_the_channel_shows_the_code_of_the_command(plc: PlcBench, block: str, code: int) -> None:
    """The channel shows the code with the robot number. Source: guide 4.2.6 and 4.7.4, R."""
    plc[f"{block}.RobotNumber"], plc[f"{block}.Enable"] = 3, True
    plc.scan_until(lambda: plc.words[0] != 0)
    assert plc["Robot.Inner.Command.Holder"] == code


@pytest.mark.parametrize("block", BLOCKS)
def test_behind_a_command_that_never_ends_the_block_ends_at_timeout(
    plc: PlcBench, block: str
) -> None:
    """If another command never ends, the block stops waiting.

    Source: docs/reference/errors.md, 16#8012.
    """
    plc["First.Code"], plc["First.Timeout"] = 0x0501, "T#50ms"
    plc.scan_until(lambda: plc["First.ErrorID"] == 0x8011, execute="First")
    plc[f"{block}.Timeout"], plc[f"{block}.Enable"] = "T#100ms", True
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]), most=13)
    assert plc[f"{block}.ErrorID"] == 0x8012
    assert plc.words[0] == 0x0501, "the other command is still held"


@pytest.mark.parametrize("block", BLOCKS)
def test_the_block_waits_until_timeout_for_the_controller_to_become_ready(
    plc: PlcBench, block: str
) -> None:
    """If the controller does not become ready, the block ends at Timeout.

    Source: docs/reference/errors.md, 16#8015; remote command guide 1.2, code 0x0000.
    """
    plc.answer(0x0200)
    plc[f"{block}.Timeout"], plc[f"{block}.Enable"] = "T#100ms", True
    plc.scan(9)
    assert plc[f"{block}.Busy"]
    plc.scan_until(lambda: bool(plc[f"{block}.Error"]), most=4)
    assert plc[f"{block}.ErrorID"] == 0x8015
    assert plc.words[0] == 0


@pytest.mark.parametrize("block", BLOCKS)
def test_a_timeout_of_zero_is_no_limit(plc: PlcBench, block: str) -> None:
    """With Timeout = T#0s the block waits until the robot is ready, here 2000 scans."""
    plc.answer(0x0200)
    plc[f"{block}.Timeout"], plc[f"{block}.Enable"] = "T#0s", True
    plc.scan(2000)
    assert plc[f"{block}.Busy"]
    plc.answer(0)
    plc.scan_until(lambda: plc.words[0] != 0, most=4)
