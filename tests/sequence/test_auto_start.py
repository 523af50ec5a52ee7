"""FB_AutoStart follows chapter 5, 3.2 and 3.3, step by step.

The test plays the controller.
"""

from __future__ import annotations

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    plc.outputs(SO02=True, SO14=True)
    return plc


def test_program_execution_process() -> None:
    """The start input turns ON, then the reset status OFF and running ON, then the start input OFF.

    Source: manual chapter 5, 3.2, program execution process.
    """
    plc = _plc()
    plc.change("AutoStart.Execute", to=True, scans=30)
    assert plc.inputs == ["SI00", "SI06", "SI12"]
    assert plc["AutoStart.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0012
    plc.outputs(SO14=False, SO13=True, scans=1)
    assert plc["AutoStart.Done"]
    assert plc.inputs == ["SI00", "SI06"]


def test_the_reset_status_alone_does_not_confirm_the_start() -> None:
    """Source: manual chapter 5, 3.2, program execution process, step 3: SO(13) confirms."""
    plc = _plc()
    plc.change("AutoStart.Execute", to=True, scans=3)
    plc.outputs(SO14=False, scans=20)
    assert plc["AutoStart.Busy"]


def test_the_stop_input_turns_on_before_the_start() -> None:
    """Source: manual chapter 5, 3.3, program execution after stopping program with stop input."""
    plc = _plc()
    plc.change("StopOk", to=False, scans=20)
    plc.change("StopOk", "AutoStart.Execute", to=True)
    assert plc.inputs == ["SI00", "SI06"]
    assert plc.scan_until(lambda: "SI12" in plc.inputs) == 12
