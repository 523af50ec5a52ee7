"""Calls before FB_ReadArea or after FB_WriteArea, and their effects on the wire.

tests/contract/test_out_of_place.py tries every block. These tests check stops, releases, requests
without a block, and movements.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from both_engines import ENGINES
from plc_bench import PlcBench
from rcx_harness import Cell
from rcx_harness.robot import Axis, RobotConfig

OUT_OF_PLACE = 0x8017
PLACES = ("Early", "Late")
_CALLS = """Halt(Robot := Robot); Release(Robot := Robot); Stop(Robot := Robot);
    Go(Robot := Robot); Watch(Robot := Robot); Cycle(Robot := Robot, CellSafe := TRUE);
    Moving(Robot := Robot); Robot.Inner.Request := Robot.Inner.Request OR Request;
    IF Code <> WORD#16#0000 THEN
      Robot.Inner.Code := Code;
      Robot.Inner.CodeRequest := TRUE;
    END_IF;"""


@cache
def _compiled(words: str) -> PlcBench:
    """Compile a program that calls its blocks at up to three places, each enabled by a variable.

    Early is before FB_ReadArea, There is between the area blocks, Late is after FB_WriteArea.
    """
    image = "RCX_IMAGE_WORDS" if words else "RCX_IMAGE"
    panel = "Keys(Robot := Robot, Panel := Panel);"
    return PlcBench(
        program=f"""PROGRAM Places
  VAR
    InputArea, OutputArea : {image};
    Robot : RCX_REF;
    ReadArea : FB_ReadArea{words};
    WriteArea : FB_WriteArea{words};
    Panel : RCX_PANEL;
    Keys : FB_Operator;
    Halt : FB_EmergencyStop;
    Release : FB_ServoOnFromEmergencyStop;
    Stop : FB_ProgramStop;
    Go : FB_ProgramContinue;
    Watch : FB_ContinuousPosition;
    Cycle : FB_WorkCycle;
    Moving, Other : FB_MovePtp;
    Request, Code : WORD;
    Connected, There : BOOL := TRUE;
    Early, Late : BOOL;
  END_VAR
  IF Early THEN
    {_CALLS}
    {panel}
  END_IF;
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  IF There THEN
    {_CALLS}
    {panel}
  END_IF;
  Other(Robot := Robot);
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := TRUE, StopOk := TRUE);
  IF Late THEN
    {_CALLS}
    {panel}
  END_IF;
END_PROGRAM
""",
        contract=False,
    )


def _first(words: str = "") -> PlcBench:
    """Return the bench, reset to its state before the first scan."""
    plc = _compiled(words)
    if not hasattr(plc, "first"):
        plc.first = plc.program.snapshot()  # type: ignore[attr-defined]
    plc.program.restore(plc.first)  # type: ignore[attr-defined]
    plc.now_us = 0
    plc.so[:] = bytes(len(plc.so))
    return plc


def _up(words: str = "") -> PlcBench:
    plc = _first(words)
    plc.outputs(SO02=True, SO11=True)
    plc.power_up()
    return plc


def _move(plc: PlcBench, place: str) -> None:
    """Call the blocks only at this place (Early, There or Late) from now on."""
    for name in ("Early", "There", "Late"):
        plc[name] = name == place


@pytest.mark.parametrize("words", ["", "Words"], ids=["bytes", "words"])
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(
    ("block", "input_name", "kept"), [("Halt", "SI00", ["SI06"]), ("Stop", "SI06", ["SI00"])]
)
def test_a_stop_called_out_of_place_acts_until_a_block_in_its_place_releases_it(
    place: str, block: str, input_name: str, kept: list[str], words: str
) -> None:
    """A stop block called outside the area blocks still stops, and reports 16#8017.

    The next FB_WriteArea sends the stop. Only a block between the area blocks releases it.

    Source: manual chapter 5, 2: SI(00) and SI(06) OFF stop; docs/reference/errors.md, 16#8017.
    """
    plc = _up(words)
    _move(plc, place)
    plc.change(f"{block}.Execute", to=True)
    assert (plc[f"{block}.Error"], plc[f"{block}.ErrorID"]) == (True, OUT_OF_PLACE)
    plc.change(f"{block}.Execute", to=False)
    assert plc.inputs == kept
    plc.scan(30)
    assert plc.inputs == kept, "the stop is held"
    release = {"Halt": "Release", "Stop": "Go"}[block]
    plc.change(f"{release}.Execute", to=True, scans=30)
    assert plc[f"{release}.ErrorID"] == OUT_OF_PLACE
    assert plc.inputs == kept, "no release out of place"
    plc.change(f"{release}.Execute", to=False)
    _move(plc, "There")
    plc.scan(2)
    plc.change(f"{release}.Execute", to=True, scans=14)
    assert input_name in plc.inputs


@pytest.mark.parametrize("place", PLACES)
def test_a_busy_stop_stays_active_if_its_call_moves_out_of_place(place: str) -> None:
    """Source: manual chapter 5, 2, SI(00); head of FB_EmergencyStop: until it is released."""
    plc = _up()
    plc.change("Halt.Execute", to=True, scans=2)
    assert plc["Halt.Busy"]
    _move(plc, place)
    plc.scan()
    assert plc["Halt.ErrorID"] == OUT_OF_PLACE
    plc.change("Halt.Execute", to=False, scans=40)
    assert plc.inputs == ["SI06"]


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize(("block", "hold"), [("Release", "HoldEmergency"), ("Go", "HoldStop")])
def test_a_release_whose_call_moves_out_of_place_restores_the_hold(
    place: str, block: str, hold: str
) -> None:
    """Source: heads of FB_ServoOnFromEmergencyStop and FB_ProgramContinue."""
    plc = _up()
    stop = {"Release": "Halt", "Go": "Stop"}[block]
    plc.outputs(SO13=True)
    plc.change(f"{stop}.Execute", to=True, scans=2)
    plc[f"{stop}.Execute"] = False
    plc.outputs(SO00=True, SO02=False, SO13=False, scans=4)
    assert plc[f"Robot.Inner.{hold}"]
    plc[f"{block}.Execute"] = True
    plc.outputs(SO00=False, SO02=True, scans=1)
    assert not plc[f"Robot.Inner.{hold}"]
    _move(plc, place)
    plc.scan()
    assert plc[f"{block}.ErrorID"] == OUT_OF_PLACE
    assert plc[f"Robot.Inner.{hold}"]


@pytest.mark.parametrize("words", ["", "Words"], ids=["bytes", "words"])
@pytest.mark.parametrize("place", PLACES)
def test_requests_set_outside_of_the_area_blocks_are_dropped(place: str, words: str) -> None:
    """A request or code that is set before FB_ReadArea or after FB_WriteArea is dropped.

    It does not matter which block sets it.

    This holds also after a call of FB_WriteArea with an illegal area (n = 600).

    Source: docs/explanation/scan-model.md, where a block is called.
    """
    plc = _up(words)
    _move(plc, place)
    plc["Request"], plc["Code"] = 0x8000, 0x0001
    plc.scan(20)
    plc.change("WriteArea.n", to=600, scans=3)
    plc.change("WriteArea.n", to=0, scans=20)
    assert plc.words == [0] * 16
    assert plc.inputs == ["SI00", "SI06"]


def test_a_block_called_before_the_first_read_area_is_refused() -> None:
    """A block called before the first call of FB_ReadArea reports 16#8017, since no state is known.

    Source: docs/reference/errors.md, 16#8017.
    """
    plc = _first()
    _move(plc, "Early")
    plc["Moving.Execute"] = True
    plc.outputs(SO01=True, SO02=True, SO04=True, scans=1)
    assert plc["Moving.ErrorID"] == OUT_OF_PLACE
    plc.scan(60)
    assert plc.words[0] == 0
    plc.change("Moving.Execute", to=False)
    _move(plc, "There")
    plc.scan()
    plc.change("Moving.Execute", to=True, scans=3)
    assert plc.words[0] == 0x0001


@pytest.mark.parametrize("place", PLACES)
def test_a_position_output_is_ended_if_its_block_is_called_out_of_place(place: str) -> None:
    """Source: remote command guide 4.7.4, status reset."""
    plc = _up()
    plc["Watch.Enable"] = True
    plc.scan_until(lambda: plc.words[0] == 0x0505)
    plc.answer(0x0100, scans=3)
    assert plc["Watch.Valid"]
    _move(plc, place)
    plc.scan()
    assert (plc["Watch.Valid"], plc["Watch.ErrorID"]) == (False, OUT_OF_PLACE)
    plc.scan(1)
    assert plc.words[0] == 0
    plc.answer(0, scans=10)
    assert plc.words[0] == 0
    plc.change("Other.Execute", to=True, scans=3)
    assert plc.words[0] == 0x0001


@pytest.mark.parametrize("order", ["There", "Early"])
def test_a_block_that_changes_its_place_from_scan_to_scan_sends_at_most_once(order: str) -> None:
    """One Execute sends at most one command, in any order of calls. Source: errors.md, 16#8017."""
    plc = _up()
    places = ["There", "Late", "Early"]
    codes, before = 0, 0
    plc["Moving.Execute"] = True
    for scan in range(60):
        _move(plc, places[(scan + places.index(order)) % 3])
        plc.scan()
        code = plc.words[0]
        codes += code != 0 and before == 0
        before = code
        plc.answer(0x0200 if code else 0)
    assert codes == 0, "the code would follow its data a scan later"
    assert plc["Moving.ErrorID"] == OUT_OF_PLACE


@pytest.mark.parametrize("place", PLACES)
def test_an_operator_panel_out_of_place_reports_it_and_can_only_stop(place: str) -> None:
    """Source: head of FB_Operator: Stop always acts; docs/reference/errors.md, 16#8017."""
    plc = _up()
    plc.outputs(SO02=False, scans=4)
    assert plc["Panel.Can.ServoOn"]
    _move(plc, place)
    plc.scan()
    assert (plc["Keys.Error"], plc["Keys.ErrorID"]) == (True, OUT_OF_PLACE)
    assert (plc["Panel.MessageID"], plc["Panel.Can.ServoOn"]) == (OUT_OF_PLACE, False)
    plc.change("Panel.Key.ServoOn", to=True, scans=30)
    assert plc.inputs == ["SI00", "SI06"]
    plc.change("Panel.Key.Stop", to=True, scans=2)
    assert plc.inputs == ["SI00"]
    plc.change("Panel.Key.Stop", to=False, scans=2)
    plc.change("Panel.Key.Reset", to=True, scans=30)
    assert plc.inputs == ["SI00"], "no release out of place"


@pytest.mark.parametrize("place", PLACES)
def test_a_work_cycle_out_of_place_is_a_fault(place: str) -> None:
    """If FB_WorkCycle is called before FB_ReadArea or after FB_WriteArea, it reports a fault.

    Its output Run starts the work like an edge of Execute.

    Source: docs/reference/errors.md, 16#8017.
    """
    plc = _up()
    plc.scan(2)
    _move(plc, place)
    plc.change("Cycle.Start", to=True)
    assert (plc["Cycle.ErrorID"], plc["Cycle.State"]) == (OUT_OF_PLACE, "WORK_FAULT")
    plc.scan(30)
    assert not plc["Cycle.Run"]
    assert plc.inputs == ["SI00", "SI06"]


# --- movements with the virtual robot ---

_CELL = """PROGRAM Places
  VAR
    InputArea, OutputArea, InputTwo, OutputTwo : RCX_IMAGE;
    Robot, Two : RCX_REF;
    ReadArea, ReadTwo : FB_ReadArea;
    WriteArea, WriteTwo : FB_WriteArea;
    Connected, ConnectedTwo : BOOL;
    Up : FB_PowerUp;
    Power, Go : BOOL;
    Place : INT;
    Way : RCX_POSITION;
    MoveI : FB_MoveIDirectMm;
  END_VAR
  Way[1] := 10.0;
  IF Place = 1 THEN MoveI(Robot := Robot, Execute := Go, DistanceMm := Way); END_IF;
  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  Up(Robot := Robot, Execute := Power, StartProgram := FALSE);
  IF Place = 0 THEN MoveI(Robot := Robot, Execute := Go, DistanceMm := Way); END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, Margin := T#20ms,
            EmergencyStopOk := TRUE, StopOk := TRUE);
  IF Place = 2 THEN MoveI(Robot := Robot, Execute := Go, DistanceMm := Way); END_IF;
  ReadTwo(Robot := Two, Image := InputTwo, Connected := TRUE);
  IF Place = 3 THEN MoveI(Robot := Robot, Execute := Go, DistanceMm := Way); END_IF;
  WriteTwo(Robot := Two, Image := OutputTwo, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""


@pytest.fixture
def moved(build_cell: Callable[..., Cell], tmp_path: Path) -> Callable[[str, str, int], Cell]:
    """Return a function that calls a relative movement of 10 mm at a place in a new cell."""

    def tried(engine: str, skip: str, place: int) -> Cell:
        program = tmp_path / "Places.st"
        program.write_text(_CELL, encoding="utf-8")
        robot = RobotConfig(axes=tuple(Axis() for _ in range(4)), skip_run_status=skip)
        cell = build_cell(program, engine=engine, robot=robot, scan="10ms")
        cell["Main.Power"] = True
        cell.run_until(lambda: bool(cell["Main.Up.Done"]), "10s")
        cell["Main.Place"], cell["Main.Go"] = place, True
        cell.run("1s")
        return cell

    return tried


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("skip", ["never", "always"])
def test_a_relative_movement_is_made_once_or_not_at_all(
    moved: Callable[[str, str, int], Cell], engine: str, skip: str
) -> None:
    """A relative movement is made once or not at all, with and without status 0x0100.

    Place 3 is between the area blocks of another robot.

    Source: remote command guide 1.2: the status 0x0100 may be skipped; docs/reference/errors.md,
    16#8017.
    """
    cell = moved(engine, skip, 1)
    for place in (1, 2, 3):
        cell["Main.Go"] = False
        cell.run("100ms")
        cell["Main.Place"], cell["Main.Go"] = place, True
        cell.run("500ms")
        assert cell["Main.MoveI.ErrorID"] == OUT_OF_PLACE
        assert cell.robot.commands_executed == 0
        assert cell.robot.positions[0] == 0
    assert {one.rule for one in cell.violations} == {"contract"}
    assert "move the call between the two" in cell.violations[0].text
    cell["Main.Go"], cell["Main.Place"] = False, 0
    cell.scan(2)
    cell["Main.Go"] = True
    cell.run("2s")
    assert cell["Main.MoveI.Done"]
    assert cell.robot.commands_executed == 1
    assert cell.robot.positions[0] == 10_000
