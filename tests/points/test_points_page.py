"""docs/points.md: its program keeps points, finds what differs, and writes them back."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import ROOT
from rcx_harness import Cell
from rcx_harness.robot.stored import Point

_PAGE, _PROGRAM = ROOT / "docs/points.md", ROOT / "docs/points/Points.st"


def _press(cell: Cell, button: str, block: str) -> object:
    cell[f"Main.{button}"] = True
    cell.scan(2)
    cell.run_until(lambda: not cell[f"Main.{block}.Busy"], within="60s")
    cell[f"Main.{button}"] = False
    cell.scan(2)
    return cell[f"Main.{block}.ErrorID"]


@pytest.mark.parametrize("engine", ENGINES)
def test_the_program_of_the_page_brings_back_a_point_that_was_changed(engine: str) -> None:
    with Cell.build([_PROGRAM], scan="10ms", engine=engine) as cell:
        points = cell.robot.machine.memory.points
        before = dict(points)
        cell.run("500ms")
        _press(cell, "Save", "Backup")
        assert cell["Main.Head.Count"] == 100
        assert cell["Main.Rows[51].Values[2]"] == -20_000
        points[50] = Point()
        _press(cell, "Compare", "Restore")
        assert (cell["Main.Restore.Differences"], cell["Main.Restore.LastDifferent"]) == (1, 50)
        assert points[50] == Point()
        _press(cell, "Load", "Restore")
        assert points == before
        assert not cell.violations


def test_the_page_shows_lines_of_its_program() -> None:
    shown = _PAGE.read_text(encoding="utf-8").partition("```iecst\n")[2].partition("```")[0]
    program = [line.strip() for line in _PROGRAM.read_text(encoding="utf-8").splitlines()]
    assert [line for line in shown.splitlines() if line.strip() not in program] == []
