"""FB_SequenceControl follows chapter 5, 2, SI(10) and SO(12).

The test plays the controller.
"""

from __future__ import annotations

import pytest

from alone import Alone
from plc_bench import PlcBench
from sequence_bench import sequences, servo_on


def _level(plc: PlcBench) -> str:
    names = ("Valid", "Busy", "Error")
    return " ".join(name for name in names if plc[f"SequenceControl.{name}"])


def _running() -> PlcBench:
    plc = sequences()
    plc.change("SequenceControl.Enable", to=True)
    plc.outputs(SO12=True, scans=1)
    assert _level(plc) == "Valid"
    return plc


def test_the_sequence_program_is_executed_while_the_signal_is_on() -> None:
    """Source: manual chapter 5, 2, SI(10) and SO(12)."""
    plc = sequences()
    assert _level(plc) == ""
    plc.change("SequenceControl.Enable", to=True)
    assert _level(plc) == "Busy"
    assert plc.inputs == ["SI00", "SI06", "SI10"]
    plc.scan(30)
    assert _level(plc) == "Busy"
    plc.outputs(SO12=True, scans=1)
    assert _level(plc) == "Valid"
    plc.change("SequenceControl.Enable", to=False)
    assert _level(plc) == ""
    assert plc.inputs == ["SI00", "SI06"]


def test_sequence_control_needs_no_turn_but_keeps_the_interval() -> None:
    """Source: manual chapter 5, 3, caution."""
    plc = servo_on()
    plc.change("AutoStart.Execute", "SequenceControl.Enable", to=True)
    assert plc.inputs == ["SI00", "SI06", "SI10"]
    assert plc.scan_until(lambda: "SI12" in plc.inputs) == 12
    plc["SequenceControl.Enable"] = False
    assert plc.scan_until(lambda: "SI10" not in plc.inputs) == 12
    assert plc["AutoStart.Active"]


def test_an_output_that_goes_off_is_waited_for_again() -> None:
    plc = _running()
    plc.outputs(SO12=False, scans=1)
    assert _level(plc) == "Busy"
    plc.outputs(SO12=True, scans=1)
    assert _level(plc) == "Valid"


def test_a_missing_answer_is_an_error_until_enable_falls() -> None:
    plc = sequences()
    plc["SequenceControl.Timeout"] = "T#300ms"
    plc.change("SequenceControl.Enable", to=True, scans=30)
    assert _level(plc) == "Busy"
    plc.scan()
    assert _level(plc) == "Error"
    assert plc["SequenceControl.ErrorID"] == 0x8010
    assert plc.inputs == ["SI00", "SI06"]
    plc.outputs(SO12=True, scans=20)
    assert _level(plc) == "Error"
    plc.change("SequenceControl.Enable", to=False)
    assert _level(plc) == ""
    assert plc["SequenceControl.ErrorID"] == 0


def test_timeout_zero_is_no_limit() -> None:
    plc = sequences()
    plc["SequenceControl.Timeout"] = "T#0s"
    plc.change("SequenceControl.Enable", to=True, scans=2000)
    assert _level(plc) == "Busy"


@pytest.mark.parametrize("cause", ["link", "SO01"])
def test_after_a_lost_controller_nothing_restarts_by_itself(cause: str) -> None:
    """Source: manual chapter 1, 5.2."""
    plc = _running()
    if cause == "link":
        plc["Connected"] = False
    else:
        plc.outputs(SO01=False)
    plc.scan()
    assert _level(plc) == "Error"
    assert plc["SequenceControl.ErrorID"] == (0x8001 if cause == "link" else 0x8002)
    plc["Connected"] = True
    plc.outputs(SO01=True, scans=60)
    assert _level(plc) == "Error"
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("SequenceControl.Enable", to=False)
    plc.change("SequenceControl.Enable", to=True, scans=2)
    assert _level(plc) == "Valid"


def test_an_output_that_is_on_before_the_signal_is_no_answer() -> None:
    plc = sequences()
    plc.outputs(SO12=True)
    plc.change("SequenceControl.Enable", to=True)
    assert _level(plc) == "Busy"
    plc.scan()
    assert _level(plc) == "Valid"


@pytest.fixture
def block() -> Alone:
    """Return an enabled block with a controller that is powered up."""
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
