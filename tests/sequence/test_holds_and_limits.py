"""A hold that is put back, and two blocks that end one."""

from __future__ import annotations

from pathlib import Path

import pytest

from plc_bench import PlcBench

_PROGRAM = """PROGRAM Holds
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Stop : FB_ProgramStop;
    First, Second : FB_ProgramContinue;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Stop(Robot := Robot);
  First(Robot := Robot);
  Second(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms, EmergencyStopOk := TRUE,
            StopOk := TRUE);
END_PROGRAM
"""


@pytest.fixture
def stopped(tmp_path: Path) -> PlcBench:
    """The controller is up, and FB_ProgramStop has just taken SI(06) away."""
    program = tmp_path / "Holds.st"
    program.write_text(_PROGRAM, encoding="utf-8")
    plc = PlcBench(program=program)
    plc.outputs(SO01=True, SO02=True, SO04=True, SO10=True, scans=60)
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Stop.Execute", to=True)
    assert plc.inputs == ["SI00"]
    return plc


def test_a_continuation_that_the_link_ends_puts_the_hold_back_in_the_same_scan(
    stopped: PlcBench,
) -> None:
    """SI(06) had not gone ON yet: the interval since its switch-off was not over.

    Source: manual chapter 5, 3.1, caution, and 3.3; head of FB_ProgramContinue.
    """
    stopped.scan(1)
    stopped.change("Stop.Execute", to=False, scans=60)
    assert stopped["Stop.Busy"] is False
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("First.Execute", to=True)
    assert stopped["First.Busy"] is True
    assert "SI06" not in stopped.inputs
    stopped["First.Execute"] = False
    stopped.change("Connected", to=False)
    assert stopped["First.ErrorID"] == 0x8001
    stopped.change("Connected", to=True, scans=60)
    assert "SI06" not in stopped.inputs


def test_one_that_was_refused_does_not_hold_against_another(stopped: PlcBench) -> None:
    """It puts the hold back once, although its Execute stays TRUE; SI(06) waits for its interval.

    Source: manual chapter 5, 3.3; head of FB_ProgramContinue.
    """
    stopped.change("Stop.Execute", to=False, scans=60)
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("First.Execute", to=True)
    stopped.change("Connected", to=False)
    assert stopped["First.ErrorID"] == 0x8001
    stopped.change("Connected", to=True, scans=60)
    assert "SI06" not in stopped.inputs
    stopped.change("Connected", to=False)
    stopped["Connected"] = True
    stopped.change("Second.Execute", to=True, scans=30)
    assert "SI06" in stopped.inputs
