"""A movement ends when a sensor responds or a key is released, as docs/how-to/position.md says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from both_engines import ENGINES
from plc_bench import ROOT
from rcx_harness import Cell

_PAGE = ROOT / "docs/how-to/position.md"
_PROGRAM = """PROGRAM Searches
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected : BOOL;
    Robot : RCX_REF;
    ReadArea : FB_ReadArea;
    WriteArea : FB_WriteArea;
    ServoOn : FB_ServoOn;
    Way : FB_MoveLinear;
    Place : FB_ReadPositionMm;
    Power, Search, Touched, Halt : BOOL;
    EmergencyStopOk, StopOk : BOOL := TRUE;
  END_VAR
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  ServoOn(Robot := Robot, Execute := Power);
{calls}
END_PROGRAM
"""
_ROBOT = """[points.5]
mm = [500.0, -300.0, 20.0, 45.0]
"""


def _calls() -> str:
    heading = "## Move until a sensor or a key stops the robot"
    part = _PAGE.read_text(encoding="utf-8").partition(heading)[2]
    found = re.search(r"```iecst\n(.*?)```", part, re.DOTALL)
    assert found is not None
    return found[1]


@pytest.fixture(params=ENGINES)
def cell(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Cell]:
    """Return a cell with the servos on and the tool at X 0."""
    file, robot = tmp_path / "Searches.st", tmp_path / "robot.toml"
    file.write_text(_PROGRAM.replace("{calls}", _calls()), encoding="utf-8")
    robot.write_text(_ROBOT, encoding="utf-8")
    with Cell.build([file], scan="10ms", engine=request.param, robot=robot) as one:
        one.run("500ms")
        one["Main.Power"] = True
        one.run_until(lambda: one["Main.ServoOn.Done"], within="5s")
        yield one
        assert not one.violations


def _x(cell: Cell) -> float:
    place: Any = cell["Main.Place.PositionMm"]
    return float(place[0])


def _rest(cell: Cell) -> None:
    """Check that the stop has ended: SI(06) is ON again, and the robot does not move."""
    cell["Main.Search"] = False
    cell.run("500ms")
    assert (cell["Main.Halt"], cell["Main.Robot.SI.SI06_Stop"]) == (False, True)
    before = list(cell.robot.positions)
    cell.run("1s")
    assert list(cell.robot.positions) == before


def test_a_movement_ends_at_the_sensor_and_its_position_is_shown(cell: Cell) -> None:
    """Source: manual chapter 5, 3.3; guide 4.2.1, 4.7.4; 12.400 is the stop."""
    cell["Main.Search"] = True
    cell.run_until(lambda: cell["Main.Robot.Status"] == 0x0100, within="5s")
    cell.run("300ms")
    cell["Main.Touched"] = True
    cell.run_until(lambda: cell["Main.Way.Error"], within="2s")
    cell.run_until(lambda: cell["Main.Place.Done"], within="2s")
    first = _x(cell)
    assert 1 < first < 499
    _rest(cell)
    cell["Main.Touched"] = False
    cell["Main.Search"] = True
    cell.run_until(lambda: cell["Main.Way.Done"], within="60s")
    assert not cell["Main.Place.Busy"], "the tool touched nothing"


def test_the_robot_moves_only_as_long_as_the_key_is_held(cell: Cell) -> None:
    """Source: manual chapter 5, 3.3."""
    cell["Main.Search"] = True
    cell.run_until(lambda: cell["Main.Robot.Status"] == 0x0100, within="5s")
    cell.run("300ms")
    cell["Main.Search"] = False
    cell.scan(2)
    assert not cell["Main.Robot.SI.SI06_Stop"], "at once"
    cell.run_until(lambda: cell["Main.Place.Done"], within="2s")
    assert 1 < _x(cell) < 499
    _rest(cell)


@pytest.mark.parametrize("why", ["Touched", "key"])
def test_a_movement_whose_end_condition_is_true_is_stopped_at_once(cell: Cell, why: str) -> None:
    """If the end condition is TRUE before the movement begins, the movement is stopped at once.

    Its command was requested, so it is sent.

    Source: guide chapter 2.
    """
    before = list(cell.robot.positions)
    cell["Main.Touched"] = why == "Touched"
    cell["Main.Search"] = True
    cell.scan()
    cell["Main.Search"] = why == "Touched"
    cell.run_until(lambda: cell["Main.Way.AlarmGroup"] == 12, within="2s")
    assert cell["Main.Way.AlarmCategory"] == 400
    _rest(cell)
    assert list(cell.robot.positions) == before
