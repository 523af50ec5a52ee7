"""The program of position.md uses the real time output, and rejects outdated positions."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from both_engines import ENGINES
from plc_bench import ROOT, PlcBench

_PAGE = ROOT / "docs/how-to/position.md"
_PROGRAM = """PROGRAM Directly
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL := TRUE;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    Output : FB_EnableRealTimeOutput;
    Ended : R_TRIG;
    OutputOn, Enable : BOOL;
    Value1, Value2 : FB_RealTimeValue;
    Arm : RCX_SCARA;
    Pulses : RCX_PULSES;
    Forward : FB_ScaraForward;
    Position : FB_ToolPosition;
  END_VAR
  Arm.Arm1 := 225.0;
  Arm.Arm2 := 175.0;
  Arm.PulsesPerUnit[1] := 1000.0;
  Arm.PulsesPerUnit[2] := 1000.0;
  Arm.PulsesPerUnit[3] := 1000.0;
  Arm.PulsesPerUnit[4] := 1000.0;
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
{calls}
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


def _calls() -> str:
    part = _PAGE.read_text(encoding="utf-8").partition("real time output, positions come")[2]
    found = re.search(r"```iecst\n(.*?)```", part, re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture(params=ENGINES)
def plc(request: pytest.FixtureRequest, tmp_path: Path) -> PlcBench:
    """Return a bench with real time output enabled; axis 2 shows 90000 pulses."""
    file = tmp_path / "Directly.st"
    file.write_text(_PROGRAM.replace("{calls}", _calls()), encoding="utf-8")
    plc = PlcBench(program=file, engine=request.param, size=256)
    plc.power_up()
    plc.scan(3)
    plc.so[52:56] = (90_000).to_bytes(4, "little")  # SOW(26)
    plc.scan_until(lambda: plc.words[0] == 0x0703, execute="Output")
    plc.complete()
    plc.change("Enable", to=True, scans=2)
    return plc


def test_after_enabling_the_position_comes_from_the_words(plc: PlcBench) -> None:
    """Source: docs/how-to/position.md, Age; remote command guide 4.9.3."""
    assert (plc["Output.Done"], plc["Position.Valid"]) == (True, True)
    assert plc["Position.PositionMm"] == pytest.approx([-175, 225, 0, 180, 0, 0], abs=0.001)


@pytest.mark.parametrize("lost", ["link", "CPU_OK"])
@pytest.mark.parametrize("held", [pytest.param(False, marks=pytest.mark.exhaustive), True])
def test_after_a_loss_the_words_are_ignored_until_the_output_is_enabled_again(
    plc: PlcBench, lost: str, held: bool
) -> None:
    """After a loss of the link, the words are not used until the real time output is enabled again.

    A controller that was off shows words of 0, which are not a position. Done of the last Execute
    is still TRUE, but does not make the words valid.

    Source: docs/how-to/position.md, Age
    """
    plc.change("Output.Execute", to=held, scans=2)
    plc["Connected"] = lost != "link"
    plc.outputs(SO01=lost == "link", scans=1)
    assert plc["Position.Valid"] is False
    plc["Connected"] = True
    plc.outputs(SO01=True)
    plc.so[48:56] = bytes(8)
    plc.change("Enable", to=False)
    plc.change("Enable", to=True, scans=2)
    assert (plc["Position.Valid"], plc["Position.Busy"]) == (False, True)
    plc.scan_until(lambda: plc.words[0] == 0x0506, most=40)  # the block sends a command
    assert plc["Position.Valid"] is False
