"""If a program has two FB_Jog for one robot, the idle block does not change the other's stop."""

from __future__ import annotations

import pytest

from plc_bench import PlcBench

_PROGRAM = """PROGRAM Jogs
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    First, Second : FB_Jog;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := TRUE);
  First(Robot := Robot);
  Second(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.mark.parametrize("jog", ["First", "Second"])
def test_a_jog_stops_at_once_in_each_order_of_calls(jog: str) -> None:
    """SI(06) turns OFF at once, whichever block is called first.

    Source: remote command guide 4.2.6.
    """
    plc = PlcBench(program=_PROGRAM)
    plc.power_up()
    plc.change(f"{jog}.Enable", to=True, scans=3)
    plc.answer(0x0100, scans=5)
    assert plc.words[0] == 0x0020
    assert plc.inputs == ["SI00", "SI06"]
    plc.change(f"{jog}.Enable", to=False)
    assert plc.inputs == ["SI00"]
