"""FB_ProgramReset follows chapter 5, 3.2, step by step.

The test plays the controller.
"""

from __future__ import annotations

from plc_bench import PlcBench


def _plc() -> PlcBench:
    plc = PlcBench()
    plc.power_up()
    return plc


def test_program_reset_process() -> None:
    """The program reset input and the reset status turn ON, then the input turns OFF.

    Source: manual chapter 5, 3.2, program reset process.
    """
    plc = _plc()
    plc.change("ProgramReset.Execute", to=True, scans=30)
    assert plc.inputs == ["SI00", "SI06", "SI15"]
    assert plc["ProgramReset.Active"]
    assert plc["Robot.Inner.Sequence.Holder"] == 0x0015
    plc.outputs(SO14=True, scans=1)
    assert plc["ProgramReset.Done"]
    assert plc.inputs == ["SI00", "SI06"]
