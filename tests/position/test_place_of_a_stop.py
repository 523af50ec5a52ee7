"""Two calls in docs/how-to/position.md move the tool back to the position of a stop."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from both_engines import ENGINES
from plc_bench import ROOT
from rcx_harness import Cell

_PAGE = ROOT / "docs/how-to/position.md"
_PROGRAM = """PROGRAM Stops
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    ServoOn : FB_ServoOn;
    Travel : FB_MoveDirectMm;
    Jogged : FB_MoveDirectMm;
    Place : FB_ReadPositionMm;
    Back : FB_MoveDirectMm;
    Power, Stopped, GoBack : BOOL;
    StopOk : BOOL := TRUE;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  ServoOn(Robot := Robot, Execute := Power);
  Travel(Robot := Robot);
  Jogged(Robot := Robot);
{calls}
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms, EmergencyStopOk := TRUE,
            StopOk := StopOk);
END_PROGRAM
"""


def _calls() -> str:
    part = _PAGE.read_text(encoding="utf-8").partition("## Back to the place of a stop")[2]
    found = re.search(r"```iecst\n(.*?)```", part, re.DOTALL)
    assert found is not None
    return found[1]


def _run(cell: Cell, block: str) -> object:
    cell[f"Main.{block}.Execute"] = True
    cell.scan(2)
    cell.run_until(lambda: not cell[f"Main.{block}.Busy"], within="20s")
    cell[f"Main.{block}.Execute"] = False
    return cell[f"Main.{block}.ErrorID"]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_two_calls_of_the_page_move_back_to_the_position_of_the_stop(
    engine: str, tmp_path: Path
) -> None:
    """After a stop and a movement by hand, the tool returns to the position of the stop.

    The stopped movement goes to X 500 mm and Y -300 mm.

    Source: docs/how-to/position.md; remote command guide 4.2.1 and 4.7.4
    """
    file = tmp_path / "Stops.st"
    file.write_text(_PROGRAM.replace("{calls}", _calls()), encoding="utf-8")
    with Cell.build([file], scan="10ms", engine=engine) as cell:
        cell.run("500ms")
        cell["Main.Power"] = True
        cell.run_until(lambda: cell["Main.ServoOn.Done"], within="5s")
        cell["Main.Travel.TargetMm"] = [500.0, -300.0, 20.0, 45.0, 0.0, 0.0]
        cell["Main.Travel.Execute"] = True
        cell.run("400ms")
        cell["Main.StopOk"] = False
        cell.run_until(lambda: cell["Main.Travel.Error"], within="5s")
        cell["Main.Travel.Execute"] = False
        cell["Main.Stopped"] = True
        cell.run_until(lambda: cell["Main.Place.Done"], within="5s")
        place = cell["Main.Place.PositionMm"]
        assert isinstance(place, list)
        assert 10 < place[0] < 490
        cell["Main.StopOk"] = True
        cell.run("500ms")
        cell["Main.Jogged.TargetMm"] = [0.0, 100.0, 0.0, 0.0, 0.0, 0.0]
        assert _run(cell, "Jogged") == 0
        cell["Main.GoBack"] = True
        cell["Main.Back.PositionOutput"] = "POSITION_MM"
        cell.run_until(lambda: cell["Main.Back.Done"], within="60s")
        assert cell["Main.Back.PositionMm"] == pytest.approx(place, abs=0.002)
        assert _run(cell, "Travel") == 0
        assert not cell.violations
