"""A normal run does not reveal any of five faults that were put into a user's cell.

The cell has two robots. A campaign finds the faults: see test_planted_found.py.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from planted import FAULTS, PLANTED, Fault, planted
from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.app import main
from rcx_harness.robot import RobotConfig

Captured = pytest.CaptureFixture[str]

_six = pytest.mark.parametrize(
    "fault", [None, *FAULTS], ids=lambda fault: fault.name if fault else "good"
)
_RUN_US = 14_000_000


def _cell(project: Path) -> Cell:
    robots = tuple(RobotConfig.load(project / f"robot_{name}.toml") for name in "ab")
    cell = Cell.build(sorted(project.glob("plc/*.st")), robot=robots, engine="builtin")
    Stimulus.load(project / "stimulus.toml").schedule(cell)
    return cell


def _broken(cell: Cell) -> list[str]:
    """Return the names of the properties in the cell's README that are violated now."""
    a, b = cell["Main.A.Holds"], cell["Main.B.Holds"]
    safe = cell["Main.CellSafe"]
    linked = cell["Main.Connected"] and cell["Main.Connected2"]
    emergency = [cell[f"Main.Robot{name}.SO.SO00_EmergencyStop"] for name in "AB"]
    state = cell["Main.State"]
    holds = {
        "one at the table": not (cell["Main.A.InTable"] and cell["Main.B.InTable"]),
        "vented hand A": not (a and (not safe or emergency[0])),
        "vented hand B": not (b and (not safe or emergency[1])),
        "nothing stored": not (state == "CELL_READY" and cell["Main.Stopping"]),
        "no time-out": cell["Main.Fault"] != 0x8011,
        "stopped": not (state == "CELL_RUNNING" and not (safe and linked)),
        "pallet": cell["Main.OnPallet"] <= 6,
    }
    return [name for name, good in holds.items() if not good]


@pytest.mark.exhaustive(but=["race", "time limit"])
@_six
def test_the_cell_compiles_and_is_portable(
    fault: Fault | None, tmp_path: Path, capsys: Captured
) -> None:
    plc = str(planted(tmp_path, fault) / "plc")
    assert main(["check", plc]) == 0
    assert "no errors, no broken rules, no warnings" in capsys.readouterr().out
    assert main(["check", "--lint", plc]) == 0


@pytest.mark.exhaustive(but=["latch"])
@_six
def test_the_normal_run_breaks_no_property(fault: Fault | None, tmp_path: Path) -> None:
    """With and without a fault, the normal run breaks no property: 11 parts, a new pallet, Stop.

    Source: tests/data/planted/cell/README.md.
    """
    with _cell(planted(tmp_path, fault)) as cell:
        while cell.now_us < _RUN_US:
            cell.scan()
            assert not _broken(cell), f"properties are violated at {cell.now_us} us"
            assert cell["Main.Fault"] == 0
        assert not cell.violations
        assert cell["Main.State"] == "CELL_READY"
        assert (cell["Main.Parts"], cell["Main.OnPallet"]) == (11, 11 - 6)
        assert [cell[f"Main.{name}.Lost"] for name in "AB"] == [0, 0]


@pytest.mark.exhaustive
def test_at_most_one_robot_is_at_the_pallet(tmp_path: Path) -> None:
    """At most one robot is at positive pulses of axis 1, where the pallet is.

    Source: points 1, 10 and 21 to 26 of robot_a.toml and robot_b.toml.
    """
    with _cell(planted(tmp_path)) as cell:
        over: set[int] = set()
        while cell.now_us < _RUN_US:
            cell.scan()
            there = {k for k, one in enumerate(cell.robots) if one.positions[0] > 0}
            assert len(there) < 2, f"both robots are at the pallet at {cell.now_us} us"
            over |= there
        assert over == {0, 1}


@pytest.mark.exhaustive
def test_the_command_in_the_readme_runs_the_cell(capsys: Captured) -> None:
    project = PLANTED / "cell"
    text = (project / "README.md").read_text(encoding="utf-8")
    line = re.search(r"^rcx (run .*)$", text, re.MULTILINE)
    assert line
    names = {"plc", "robot_a.toml", "robot_b.toml", "stimulus.toml"}
    words = [str(project / word) if word in names else word for word in line[1].split()]
    assert main([*words, "--engine", "builtin"]) == 0
    assert "no violations" in capsys.readouterr().out


def test_each_of_five_faults_has_a_row_in_the_readme_and_a_property() -> None:
    text = (PLANTED / "README.md").read_text(encoding="utf-8")
    table = re.findall(r"^\| ([a-z ]+) \|.*\| ([^|]+) \|$", text, re.MULTILINE)
    rows = dict(table)
    assert list(rows) == [fault.name for fault in FAULTS]
    assert len(FAULTS) == 5
    cell = (PLANTED / "cell/README.md").read_text(encoding="utf-8")
    for fault in FAULTS:
        assert rows[fault.name].startswith(fault.breaks)
        assert f"| {fault.breaks} |" in cell


def test_a_fault_whose_text_is_missing_is_reported(tmp_path: Path) -> None:
    twice = Fault("twice", "cell/plc/FB_Station.st", "", "", "Holds := FALSE", "Holds := TRUE")
    with pytest.raises(ValueError, match=r"twice: .* does not stand once in cell/plc/FB_Station"):
        planted(tmp_path, twice)
