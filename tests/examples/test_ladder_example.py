"""The ladder program of docs/how-to/ladder.md drives the robot; coverage and sweep judge it."""

from __future__ import annotations

import re
from functools import partial
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main

Captured = pytest.CaptureFixture[str]

_PAGE = ROOT / "docs/how-to/ladder.md"
_FOLDER = ROOT / "docs/how-to/ladder"
_PROGRAM = _FOLDER / "PowerAndMove.xml"
_PICK, _PLACE = 120_000, -60_000
_IDLE = ("Released", "MoveToPlace.Busy", "MoveToPick.Busy", "FaultStored")
_FAULTS = ("emergency_stop", "link_down", "alarm", "manual_mode", "plc_stop", "power_cycle")


def _options(*more: str) -> list[str]:
    return [f"--robot={_FOLDER / 'robot.toml'}", f"--stimulus={_FOLDER / 'stimulus.toml'}", *more]


@pytest.fixture(scope="module")
def cell() -> Cell:
    """Return the cell of the page, at power on."""
    made = Cell.build([_PROGRAM], engine="builtin", robot=[_FOLDER / "robot.toml"])
    Stimulus.load(_FOLDER / "stimulus.toml").schedule(made)
    return made


def _is_at(cell: Cell, place: int) -> bool:
    return bool(cell.robots[0].positions[0] == place)


def test_the_robot_moves_between_both_points_until_stop(cell: Cell) -> None:
    """Axis 1 reaches the points 20 and 19 of robot.toml, and Stop ends the work."""
    for place in (_PLACE, _PICK, _PLACE):
        cell.run_until(partial(_is_at, cell, place), within="3s")
    assert cell["Main.Count"] == 1
    cell.run("3s")
    assert not any(cell[f"Main.{name}"] for name in _IDLE)
    assert cell.violations == []


def test_coverage_names_the_rungs(tmp_path: Path, capsys: Captured) -> None:
    """The report names network 8, whose reset of the fault the good run does not execute."""
    options = _options("--for=6s", "--coverage", f"--coverage-out={tmp_path}", "--engine=builtin")
    assert main(["run", str(_PROGRAM), *options]) == 0
    assert "network 8" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_the_program_recovers_from_each_fault(tmp_path: Path, capsys: Captured) -> None:
    """A sample of the scans, as the page says for all."""
    options = _options(
        *(f"--properties={_FOLDER / 'sweep.toml'}", "--for=5s", f"--inject={','.join(_FAULTS)}"),
        *("--every=97", "--workers=0", "--engine=builtin", f"--out={tmp_path / 'out'}"),
    )
    assert main(["sweep", str(_PROGRAM), *options]) == 0
    assert "the cell recovers from all of them" in capsys.readouterr().out


@pytest.mark.exhaustive
def test_a_rung_that_starts_by_itself_is_found(tmp_path: Path, capsys: Captured) -> None:
    """With `Start` as a closed contact, the robot starts without the button."""
    text = _PROGRAM.read_text(encoding="utf-8")
    changed = text.replace('negated="false" edge="rising"', 'negated="true"', 1)
    assert changed != text
    program = tmp_path / "PowerAndMove.xml"
    program.write_text(changed, encoding="utf-8")
    options = _options(
        *(f"--properties={_FOLDER / 'sweep.toml'}", "--for=1s", "--inject=emergency_stop"),
        *("--every=50", "--workers=0", "--engine=builtin", f"--out={tmp_path / 'out'}"),
    )
    assert main(["sweep", str(program), *options]) != 0
    assert "nothing starts without Start" in "".join(capsys.readouterr())


def test_the_statements_of_the_page_are_those_of_the_import(tmp_path: Path) -> None:
    assert main(["import", str(_PROGRAM), f"--out={tmp_path / 'st'}"]) == 0
    written = (tmp_path / "st/PowerAndMove.st").read_text(encoding="utf-8")
    (shown,) = re.findall(r"```iecst\n(.*?)```", _PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert shown in written
