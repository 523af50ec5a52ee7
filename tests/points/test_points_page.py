"""The program of docs/how-to/points.md saves points, finds differences, and writes points back."""

from __future__ import annotations

import pytest

from both_engines import ENGINES
from plc_bench import ROOT
from points_bench import PointsBench
from rcx_harness import Cell
from rcx_harness.robot.stored import Point

_PAGE, _PROGRAM = ROOT / "docs/how-to/points.md", ROOT / "docs/how-to/points/Points.st"


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
        cell["Main.CellSafe"] = True
        cell.run("500ms")
        _press(cell, "Save", "Backup")
        assert cell["Main.Head.Count"] == 100
        assert cell["Main.Rows[51].Values[2]"] == -20_000
        points[50] = Point()
        _press(cell, "Compare", "Check")
        assert (cell["Main.Check.Differences"], cell["Main.Check.LastDifferent"]) == (1, 50)
        assert points[50] == Point()
        _press(cell, "Load", "Restore")
        assert points == before
        assert not cell.violations


class _Panel(PointsBench):
    """The program of docs/how-to/points.md, and a controller with points 0 to 99."""

    def __init__(self, engine: str) -> None:
        super().__init__(engine, _PROGRAM)
        self["Connected"] = True
        self.define(range(100))

    def define(self, numbers: range, x: int = 0) -> None:
        for number in numbers:
            self.stored[0x100, number] = [1, 0, x or number, *[0] * 11]

    def press(self, button: str, block: str) -> object:
        """Press a button until its block has ended, and return the ErrorID.

        Afterwards `sent` has only the telegrams since this press.
        """
        self.sent.clear()
        self[button] = True
        self.scan(2)
        self.scan_until(lambda: not self[f"{block}.Busy"], most=3000)
        error = self[f"{block}.ErrorID"]
        self[button] = False
        self.scan(3)
        return error

    @property
    def numbers(self) -> list[int]:
        return [words[2] for words in self.sent]


@pytest.fixture(params=ENGINES)
def panel(request: pytest.FixtureRequest) -> _Panel:
    return _Panel(request.param)


def test_a_resume_switch_left_on_never_gives_done_without_work(panel: _Panel) -> None:
    """If the switch stays at "go on" after the end, Done never appears without work.

    After all rows are saved and compared, a restore writes all rows, and a backup reports 16#8069.

    Source: docs/how-to/points.md, In the PLC; docs/reference/errors.md, 16#8069
    """
    assert panel.press("Save", "Backup") == 0
    panel["GoOn"] = True
    assert panel.press("Compare", "Check") == 0
    assert panel.numbers == list(range(100))
    for _ in range(2):
        panel.stored.clear()
        assert panel.press("Load", "Restore") == 0
        assert panel.numbers == list(range(100))
    panel.define(range(100), x=7777)
    assert panel.press("Save", "Backup") == 0x8069
    assert panel.numbers == []
    panel["GoOn"] = False
    assert panel.press("Save", "Backup") == 0
    assert panel.row(1)[2][0] == 7777


def test_the_resume_switch_continues_a_restore_where_it_stopped(panel: _Panel) -> None:
    """Source: docs/how-to/points.md, In the PLC."""
    assert panel.press("Save", "Backup") == 0
    panel["GoOn"] = True
    panel.refuses[40] = (12, 76)
    assert panel.press("Compare", "Check") == 0x8020
    panel.refuses = {60: (12, 76)}
    assert panel.press("Load", "Restore") == 0x8020
    assert panel.numbers == list(range(61))
    panel.refuses.clear()
    assert panel.press("Compare", "Check") == 0
    assert panel.numbers == list(range(100))
    assert panel.press("Load", "Restore") == 0
    assert panel.numbers == list(range(60, 100))

    panel.refuses = {60: (12, 76)}
    assert panel.press("Load", "Restore") == 0x8020
    assert panel.numbers == list(range(61))
    panel["GoOn"] = False
    panel.refuses.clear()
    assert panel.press("Save", "Backup") == 0
    panel["GoOn"] = True
    assert panel.press("Load", "Restore") == 0
    assert panel.numbers == list(range(100))


def test_the_resume_switch_continues_a_backup_after_the_saved_rows(panel: _Panel) -> None:
    """Source: docs/how-to/points.md, In the PLC."""
    panel.refuses[30] = (12, 76)
    assert panel.press("Save", "Backup") == 0x8020
    panel.refuses.clear()
    panel["GoOn"] = True
    assert panel.press("Save", "Backup") == 0
    assert panel.numbers == list(range(30, 100))
    assert panel["Head.Count"] == 100


def test_the_page_shows_lines_of_its_program() -> None:
    shown = _PAGE.read_text(encoding="utf-8").partition("```iecst\n")[2].partition("```")[0]
    program = [line.strip() for line in _PROGRAM.read_text(encoding="utf-8").splitlines()]
    assert [line for line in shown.splitlines() if line.strip() not in program] == []
