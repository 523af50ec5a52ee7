"""Examples 16 and 17: the PLC requests jobs, and robot programs execute the movements."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import pytest

from example_runs import ROOT, finished
from rcx_harness.cell import Cell

_JOBS, _BELT = "16_robot_program", "17_conveyor"
_TABLES = {20: -40000, 21: -50000, 22: -60000}


def _build(name: str) -> Cell:
    """Build the cell of an example without its stimulus file."""
    folder = ROOT / "plc/examples" / name
    files = sorted(folder.glob("*.st"))
    return Cell.build(files, robot=folder / "robot.toml", engine="builtin")


def _until(cell: Cell, condition: Callable[[], bool], within: str = "4s") -> None:
    cell.run_until(condition, within=within)


def _releases(cell: Cell, parts: int) -> list[int]:
    """Run until the hand has opened `parts` times, and return the positions of axis 1 [pulses]."""
    found: list[int] = []
    closed = cell.robot.read_port("DO(20)")
    for _ in range(1000):
        if len(found) == parts:
            break
        cell.scan()
        was, closed = closed, cell.robot.read_port("DO(20)")
        if was and not closed:
            found.append(cell.robot.positions[0])
    return found


def test_the_robot_program_of_example_16_is_that_of_the_library() -> None:
    """The example's robot program is plc/robot/JOBS.PGM with other routines.

    Source: docs/how-to/robot-program.md.
    """
    frame = (ROOT / "plc/robot/JOBS.PGM").read_text(encoding="utf-8").partition("IF SGI30=0")
    ours = (ROOT / "plc/examples" / _JOBS / "CARRY.PGM").read_text(encoding="utf-8")
    begin, end = frame[1], "\n' Your routines."
    assert begin + frame[2].partition(end)[0] in ours


def test_each_part_goes_to_the_next_place_of_the_tray() -> None:
    """Four parts go to points 20, 21, 22 and 20 again. Source: example 16."""
    with _build(_JOBS) as cell:
        cell["Main.CellSafe"] = True
        cell.run("300ms")
        cell["Main.Start"] = True
        assert _releases(cell, 4) == [_TABLES[20], _TABLES[21], _TABLES[22], _TABLES[20]]


def test_stop_parks_the_robot_after_the_present_part() -> None:
    """After Stop the part is placed and the robot moves to point 1, which is 0 of each axis."""
    cell = finished(_JOBS).cell
    assert cell["Main.Stage"] == "CELL_IDLE"
    assert cell["Main.Count"] == 4
    assert list(cell.robot.positions) == [0, 0, 0, 0]
    assert cell["Main.Fault"] == 0


def _with_a_part_in_the_hand(cell: Cell) -> None:
    cell["Main.CellSafe"] = True
    cell.run("300ms")
    _press(cell)
    _until(cell, lambda: cell["Main.Count"] == 1 and cell.robot.read_port("DO(20)") == 1)


def _press(cell: Cell) -> None:
    cell["Main.Start"] = True
    cell.run("200ms")
    cell["Main.Start"] = False


@pytest.mark.parametrize(
    ("event", "back"),
    [("link_down", "link_up"), ("emergency_stop", "emergency_stop_release")],
)
def test_a_stopped_job_continues_after_start(event: str, back: str) -> None:
    """A stopped job continues after Start with the same part. Before, nothing moves.

    Source: manual chapter 1, 5.2; chapter 5, 2: the program continues with the interrupted line.
    """
    with _build(_JOBS) as cell:
        _with_a_part_in_the_hand(cell)
        cell.inject(event)
        cell.run("1s")
        cell.inject(back)
        cell.run("1s")
        assert cell["Main.Count"] == 1
        _press(cell)
        assert _releases(cell, 2) == [_TABLES[21], _TABLES[22]]
        assert not cell["Main.Fault"]


def test_a_job_interrupted_by_a_power_failure_is_reported_and_repeated() -> None:
    """After a power failure, the interrupted job is reported with 16#8083, and Start repeats it.

    Source: FB_ProgramCall, 16#8083.
    """
    with _build(_JOBS) as cell:
        _with_a_part_in_the_hand(cell)
        cell.inject("power_cycle")
        cell.run("8s")
        _press(cell)
        _until(cell, lambda: cell["Main.Fault"] == 0x8083, within="8s")
        assert cell["Main.Stage"] == "CELL_IDLE"
        assert cell["Main.Count"] == 1
        _press(cell)
        _until(cell, lambda: cell["Main.Count"] == 2, within="8s")


def test_robot_and_exchanger_are_never_in_the_tray_together() -> None:
    """The tray never moves while the robot has permission for the area (SO(24) and SI(24) ON).

    Source: example 17; the tray is exchanged once, and three parts are placed.
    """
    with _build(_BELT) as cell:
        moved = []

        def scan() -> None:
            cell.scan()
            moved.append(bool(cell["Main.TrayMoves"]))
            assert not (cell["Main.TrayMoves"] and cell["Main.Granted"])

        for part in range(1, 4):
            cell["Main.CellSafe"] = True
            cell["Main.Start"] = cell.now_us > 300_000
            while not cell["Main.Belt"]:
                cell["Main.Start"] = cell.now_us > 300_000
                scan()
            cell["Main.PartAtEnd"] = True
            while cell.robot.read_port("DO(20)") == 0:
                scan()
            cell["Main.PartAtEnd"] = False
            cell["Main.ChangeTray"] = part == 2
            while cell.robot.read_port("SOW(2)") < part:
                scan()
            cell["Main.ChangeTray"] = False
        assert [now for was, now in pairwise(moved) if was != now] == [True, False]


def test_the_robot_keeps_the_area_while_its_position_is_unknown() -> None:
    """After a loss of the link, the robot keeps its permission, because its position is unknown.

    Source: example 17; manual chapter 1, 5.2.
    """
    with _build(_BELT) as cell:
        cell["Main.CellSafe"] = True
        cell.run("300ms")
        cell["Main.Start"] = True
        _until(cell, lambda: bool(cell["Main.Belt"]))
        cell["Main.Start"] = False
        cell["Main.PartAtEnd"] = True
        _until(cell, lambda: bool(cell["Main.Granted"]))
        cell.inject("link_down")
        cell["Main.ChangeTray"] = True
        cell.run("2s")
        assert cell["Main.Granted"]
        assert not cell["Main.TrayMoves"]


def test_the_belt_stops_while_a_part_lies_at_its_end() -> None:
    """The belt stops when a part is at its end. Source: example 17, BELT.PGM."""
    with _build(_BELT) as cell:
        cell["Main.CellSafe"] = True
        cell.run("300ms")
        cell["Main.Start"] = True
        _until(cell, lambda: bool(cell["Main.Belt"]))
        cell["Main.PartAtEnd"] = True
        cell.run("100ms")
        assert not cell["Main.Belt"]
        assert [task.program.name for task in cell.robot.program.tasks] == ["MAIN", "BELT"]
