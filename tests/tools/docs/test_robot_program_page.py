"""The robot programs of docs/how-to/robot-program.md and tutorial part 5 run as described."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from rcx_harness import Cell
from rcx_tools.docs.pages import ROOT

_TUTORIAL = ROOT / "docs/tutorial/robot"
_WAY = ROOT / "docs/how-to/robot/WAY.PGM"
#: Pulses per millimetre of an axis if the robot file has no axes.
_PULSES = 1000
_POINTS = {20: (100, 0), 21: (100, 100), 22: (0, 100), 23: (0, 0)}


@pytest.fixture
def cell(tmp_path: Path) -> Iterator[Cell]:
    """Return the cell of the tutorial with WAY.PGM, which moves along a square of 100 mm."""
    points = (
        f"[points.{number}]\nmm = [{x}.0, {y}.0, 0.0, 0.0]\n" for number, (x, y) in _POINTS.items()
    )
    robot = tmp_path / "robot.toml"
    robot.write_text(f"[[programs]]\nfile = {str(_WAY)!r}\n" + "".join(points), encoding="utf-8")
    with Cell.build(
        sorted((_TUTORIAL / "plc").glob("*.st")), robot=robot, engine="builtin"
    ) as cell:
        cell["Main.CellSafe"] = True
        cell.run("300ms")
        cell["Main.Start"] = True
        yield cell


def _line(cell: Cell) -> int:
    return cell.robot.program.tasks[0].line


def test_the_robot_does_not_stop_between_two_lines_with_cont(cell: Cell) -> None:
    """Source: docs/how-to/robot-program.md; MOVE with CONT begins in the OUT position range."""
    cell.run_until(lambda: _line(cell) == 5, within="4s")
    assert cell.robot.positions[1] < _POINTS[21][1] * _PULSES


def test_an_output_turns_on_20_mm_after_the_begin_of_a_line(cell: Cell) -> None:
    """Source: docs/how-to/robot-program.md: `DO(21)=1@20.0` on the line from P21 to P22."""
    cell.run_until(lambda: cell.robot.read_port("DO(21)") == 1, within="6s")
    x_mm = cell.robot.positions[0] / _PULSES
    assert 70 <= x_mm <= 80


def test_an_input_ends_a_movement_early(cell: Cell) -> None:
    """Source: docs/how-to/robot-program.md: STOPON; the Request of the PLC is SI(20)."""
    cell.run_until(lambda: _line(cell) == 6, within="6s")
    assert cell["Main.Requested"]
    cell.run_until(lambda: _line(cell) == 7, within="2s")
    assert cell.robot.positions[1] > _POINTS[23][1] * _PULSES


def test_the_tutorial_programs_with_the_mistake_wait_for_each_other() -> None:
    """Source: docs/tutorial/5-robot-program.md: only one input differs."""
    good = (_TUTORIAL / "PLACE.PGM").read_text(encoding="utf-8")
    stuck = (_TUTORIAL / "stuck/PLACE.PGM").read_text(encoding="utf-8")
    assert stuck == good.replace("WAIT SI(20)=1", "WAIT SI(21)=1")
