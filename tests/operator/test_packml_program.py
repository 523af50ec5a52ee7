"""docs/operator/PackMlCell.st: a robot program behind PackML, on the virtual controller."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.robot.ports import port

_PROGRAM = ROOT / "docs/operator/PackMlCell.st"
_ROBOT = ROOT / "plc/examples/15_panel/robot.toml"


class _Line:
    """The line that gives the commands."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.seen = ["ABORTED"]

    def command(self, command: str) -> None:
        """Give a command, then take the request away."""
        self.cell["Main.CntrlCmd"] = f"PACKML_CMD_{command}"
        self.cell["Main.Change"] = True
        self.scan()
        self.cell["Main.Change"] = False

    def scan(self) -> None:
        """One scan; new states are noted."""
        self.cell.scan()
        state = str(self.cell["Main.PackMl.State"]).removeprefix("PACKML_")
        if state != self.seen[-1]:
            self.seen.append(state)

    def until(self, state: str) -> None:
        """Scan until it is in this state."""
        for _ in range(500):
            if self.seen[-1] == state:
                return
            self.scan()
        raise AssertionError(f"no {state}: {self.seen}, {self.cell['Main.PackMl.AbortID']:04X}")


@pytest.fixture
def line() -> Iterator[_Line]:
    """A cell that has just been switched on."""
    with Cell.build(_PROGRAM, robot=_ROBOT, scan="10ms", engine="builtin") as cell:
        cell["Main.CellSafe"] = True
        cell.run("200ms")
        yield _Line(cell)


def test_the_page_shows_this_program() -> None:
    page = (ROOT / "docs/operator/packml.md").read_text(encoding="utf-8")
    assert Path("PackMlCell.st").name in page


def test_a_robot_program_runs_to_complete_with_a_hold_and_a_suspension_in_between(
    line: _Line,
) -> None:
    """Source: the transitions of docs/operator/packml.md; manual chapter 5, 3."""
    for command, end in (
        ("CLEAR", "STOPPED"),
        ("RESET", "IDLE"),
        ("START", "EXECUTE"),
        ("HOLD", "HELD"),
        ("UNHOLD", "EXECUTE"),
        ("SUSPEND", "SUSPENDED"),
        ("UNSUSPEND", "EXECUTE"),
    ):
        line.command(command)
        line.until(end)
        for _ in range(10):
            line.scan()
    line.until("COMPLETE")
    assert line.cell.robot.machine.ports.read(port("SO2()")) == 4, "to its last line"
    line.command("RESET")
    line.until("IDLE")
    assert line.seen == [
        *("ABORTED", "CLEARING", "STOPPED", "RESETTING", "IDLE", "STARTING", "EXECUTE"),
        *("HOLDING", "HELD", "UNHOLDING", "EXECUTE"),
        *("SUSPENDING", "SUSPENDED", "UNSUSPENDING", "EXECUTE"),
        *("COMPLETING", "COMPLETE", "RESETTING", "IDLE"),
    ]
    assert not line.cell.violations


@pytest.mark.parametrize(
    ("event", "back", "error"),
    [
        ("emergency_stop", "emergency_stop_release", 0x8003),
        ("link_down", "link_up", 0x8001),
        ("alarm", "", 0x8004),
    ],
)
def test_what_takes_the_robot_away_aborts_and_nothing_starts_until_it_is_said(
    line: _Line, event: str, back: str, error: int
) -> None:
    """Source: manual chapter 1, 5 and chapter 5, 3.1; PackML, Aborting."""
    for command, end in (("CLEAR", "STOPPED"), ("RESET", "IDLE"), ("START", "EXECUTE")):
        line.command(command)
        line.until(end)
    line.cell.inject(event)
    line.until("ABORTED")
    assert line.cell["Main.PackMl.AbortID"] == error
    if back:
        line.cell.inject(back)
    for _ in range(100):
        line.scan()
    assert line.seen[-1] == "ABORTED"
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    line.command("CLEAR")
    line.until("STOPPED")
    for _ in range(50):
        line.scan()
    assert line.seen[-1] == "STOPPED"
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    for command, end in (("RESET", "IDLE"), ("START", "COMPLETE")):
        line.command(command)
        line.until(end)


def test_stop_leads_to_stopped_from_where_a_new_run_begins(line: _Line) -> None:
    """Source: PackML, Stopping."""
    for command, end in (("CLEAR", "STOPPED"), ("RESET", "IDLE"), ("START", "EXECUTE")):
        line.command(command)
        line.until(end)
    line.command("STOP")
    line.until("STOPPED")
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    for command, end in (("RESET", "IDLE"), ("START", "COMPLETE")):
        line.command(command)
        line.until(end)
