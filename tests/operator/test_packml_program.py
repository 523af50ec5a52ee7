"""docs/how-to/operator/PackMlCell.st runs a robot program with PackML on the virtual controller."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.robot.ports import port

_PROGRAM = ROOT / "docs/how-to/operator/PackMlCell.st"
_ROBOT = ROOT / "docs/how-to/operator/robot.toml"


class _Line:
    """A production line that gives the PackML commands to the cell."""

    def __init__(self, cell: Cell) -> None:
        self.cell = cell
        self.seen = ["ABORTED"]

    def command(self, command: str) -> None:
        """Give a PackML command, then withdraw its request."""
        self.cell["Main.CntrlCmd"] = f"PACKML_CMD_{command}"
        self.cell["Main.Change"] = True
        self.scan()
        self.cell["Main.Change"] = False

    def scan(self, count: int = 1) -> None:
        """Run scans, and record each new PackML state."""
        for _ in range(count):
            self.cell.scan()
            state = str(self.cell["Main.PackMl.State"]).removeprefix("PACKML_")
            if state != self.seen[-1]:
                self.seen.append(state)

    def go(self, *steps: tuple[str, str]) -> None:
        """Give each command, and scan until the state that must follow this command."""
        for command, state in steps:
            self.command(command)
            self.until(state)

    def until(self, state: str) -> None:
        """Run scans until the cell is in this PackML state."""
        for _ in range(500):
            if self.seen[-1] == state:
                return
            self.scan()
        raise AssertionError(f"no {state}: {self.seen}, {self.cell['Main.PackMl.AbortID']:04X}")


def _cell(robot: Path) -> Cell:
    cell = Cell.build(_PROGRAM, robot=robot, scan="10ms", engine="builtin")
    cell["Main.CellSafe"] = True
    cell.run("200ms")
    return cell


@pytest.fixture
def line() -> Iterator[_Line]:
    """Return a cell that has just been switched on."""
    with _cell(_ROBOT) as cell:
        yield _Line(cell)


def test_the_page_shows_this_program() -> None:
    page = (ROOT / "docs/how-to/operator/packml.md").read_text(encoding="utf-8")
    assert _PROGRAM.name in page
    assert _ROBOT.name in page


def test_a_robot_program_runs_to_complete_with_a_hold_and_a_suspension_in_between(
    line: _Line,
) -> None:
    """Source: the transitions of docs/how-to/operator/packml.md; manual chapter 5, 3."""
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
        line.scan(10)
    line.until("COMPLETE")
    assert line.cell.robot.machine.ports.read(port("SO3()")) == 4, (
        "the program ran to its last line"
    )
    line.go(("RESET", "IDLE"))
    assert line.seen == [
        *("ABORTED", "CLEARING", "STOPPED", "RESETTING", "IDLE", "STARTING", "EXECUTE"),
        *("HOLDING", "HELD", "UNHOLDING", "EXECUTE"),
        *("SUSPENDING", "SUSPENDED", "UNSUSPENDING", "EXECUTE"),
        *("COMPLETING", "COMPLETE", "RESETTING", "IDLE"),
    ]
    assert not line.cell.violations


@pytest.mark.parametrize("link", ["", "link_down"])
def test_a_second_run_is_complete_only_at_its_own_end(line: _Line, link: str) -> None:
    """A second run is complete only at its own end.

    At its start SO(20) is still ON from the first run, even after a loss of the link.

    Source: docs/how-to/operator/packml.md.
    """
    _to_execute(line)
    line.until("COMPLETE")
    if link:
        line.cell.inject(link)
        line.until("ABORTED")
        line.cell.inject("link_up")
        line.scan(50)
        line.go(("CLEAR", "STOPPED"))
    line.go(("RESET", "IDLE"), ("START", "EXECUTE"))
    begun = line.cell.now_us
    line.until("COMPLETE")
    assert line.cell.now_us - begun >= 1_200_000, "the program takes 1.3 s"


def _to_execute(line: _Line) -> None:
    line.go(("CLEAR", "STOPPED"), ("RESET", "IDLE"), ("START", "EXECUTE"))


@pytest.mark.parametrize(
    ("event", "back", "error"),
    [
        ("manual_mode", "auto_mode", 0x8006),
        ("auto_input_off", "auto_input_on", 0x8006),
        ("manual_lock_on", "manual_lock_off", 0x8006),
        ("parallel_stop", "parallel_stop_release", 0x8007),
    ],
)
def test_a_program_stopped_from_outside_is_held_and_continues_to_its_end(
    tmp_path: Path, event: str, back: str, error: int
) -> None:
    """A program that is stopped outside of PackML is held, and an Unhold continues it to its end.

    An Unhold that comes too early leads back to Held.

    Source: manual chapter 1, 5.1; chapter 5, 2 and 3.2, SO(10), SO(13);
    docs/how-to/operator/packml.md.
    """
    robot = tmp_path / "robot.toml"
    board = 'parallel_io = "valid"\n' if event == "parallel_stop" else ""
    robot.write_text(board + _ROBOT.read_text(encoding="utf-8"), encoding="utf-8")
    with _cell(robot) as cell:
        line = _Line(cell)
        _to_execute(line)
        line.scan(20)
        cell.inject(event)
        line.until("HELD")
        assert "COMPLETING" not in line.seen
        assert cell["Main.OwnID"] == error
        line.go(("UNHOLD", "UNHOLDING"))
        line.scan(600)
        assert line.seen[-4:] == ["UNHOLDING", "EXECUTE", "HOLDING", "HELD"]
        assert cell["Main.OwnID"] != 0
        cell.inject(back)
        line.scan(50)
        if event == "manual_lock_on":
            cell.inject("auto_mode")
            cell.run("100ms")
        line.go(("UNHOLD", "COMPLETE"))
        assert cell.robot.machine.ports.read(port("SO3()")) == 4
        assert cell["Main.OwnID"] == 0


def test_a_program_that_ends_before_its_last_line_is_not_complete(line: _Line) -> None:
    """Source: docs/how-to/operator/packml.md: only SO(20) reports the last line."""
    _to_execute(line)
    line.scan(20)
    line.cell.inject("program_end")
    line.until("HELD")
    assert "COMPLETING" not in line.seen
    line.go(("UNHOLD", "COMPLETE"))


@pytest.mark.parametrize("command", ["HOLD", "SUSPEND"])
@pytest.mark.parametrize("ahead", range(2, 9))
def test_a_hold_near_the_end_does_not_run_the_program_again(
    line: _Line, command: str, ahead: int
) -> None:
    """Source: docs/how-to/operator/packml.md."""
    _to_execute(line)
    end = line.cell.now_us
    line.until("COMPLETING")
    scans = (line.cell.now_us - end) // 10_000
    line.until("COMPLETE")
    line.go(("RESET", "IDLE"), ("START", "EXECUTE"))
    line.scan(scans - ahead)
    assert line.seen[-1] == "EXECUTE"
    line.command(command)
    line.until("HELD" if command == "HOLD" else "SUSPENDED")
    line.scan(30)
    line.command(f"UN{command}")
    began = line.cell.now_us
    line.until("COMPLETE")
    assert line.cell.now_us - began < 800_000, "the whole program takes 1.3 s"
    assert line.cell.robot.machine.ports.read(port("SO3()")) == 4


def test_a_failure_in_resetting_or_starting_leads_to_stopped(line: _Line) -> None:
    """If Resetting or Starting fails, the cell goes to Stopped. The missing condition is AUTO mode.

    Source: manual chapter 5, 2, SI(15): it is necessary that the controller is in the AUTO mode.
    """
    line.go(("CLEAR", "STOPPED"))
    for reached in ("STOPPED", "IDLE"):
        line.cell.inject("manual_mode")
        line.scan(5)
        line.command("RESET" if reached == "STOPPED" else "START")
        line.until("STOPPING")
        line.until("STOPPED")
        assert line.cell["Main.OwnID"] == 0x8006
        line.cell.inject("auto_mode")
        line.scan(20)
        line.go(("RESET", "IDLE"))
        assert line.cell["Main.OwnID"] == 0
    line.go(("START", "COMPLETE"))


@pytest.mark.parametrize(
    ("event", "back", "error"),
    [
        ("main_power_off", "main_power_on", 0x8005),
        ("emergency_stop", "emergency_stop_release", 0x8009),
    ],
)
def test_a_failure_in_clearing_aborts_and_the_servos_stay_off(
    line: _Line, event: str, back: str, error: int
) -> None:
    """A failure in Clearing leads to Aborted, and the servos do not turn ON later.

    Source: manual chapter 5, 2, SO(04), and 3.1.
    """
    line.cell.inject(event)
    line.scan(20)
    line.go(("CLEAR", "ABORTING"))
    line.until("ABORTED")
    assert line.cell["Main.OwnID"] == error
    line.cell.inject(back)
    for _ in range(300):
        line.scan()
        assert not line.cell["Main.Robot.SO.SO02_ServoOn"]
    line.go(("CLEAR", "STOPPED"))


def test_a_fault_during_servo_on_aborts_and_ends_in_aborted(line: _Line) -> None:
    """Source: PackML, Aborting."""
    line.command("CLEAR")
    line.scan()
    line.go(("ABORT", "ABORTED"))
    on = line.cell["Main.Robot.SO.SO02_ServoOn"]
    for _ in range(500):
        line.scan()
        assert line.cell["Main.Robot.SO.SO02_ServoOn"] == on


@pytest.mark.parametrize("later", [1, 2])
def test_no_command_of_the_line_is_lost_beside_a_command_of_the_program(
    line: _Line, later: int
) -> None:
    """Source: PackTags: a rising edge of CmdChangeRequest."""
    _to_execute(line)
    line.scan(20)
    line.cell.inject("manual_mode")
    while line.cell["Main.Robot.SO.SO13_ProgramRunning"]:
        if line.seen[-1] != "EXECUTE":
            break
        line.scan()
    line.scan(later - 1)
    line.go(("STOP", "STOPPED"))


@pytest.mark.parametrize(
    ("event", "back", "error"),
    [
        ("emergency_stop", "emergency_stop_release", 0x8003),
        ("link_down", "link_up", 0x8001),
        ("alarm", "", 0x8004),
    ],
)
def test_an_unavailable_robot_aborts_and_nothing_starts_without_a_command(
    line: _Line, event: str, back: str, error: int
) -> None:
    """Source: manual chapter 1, 5 and chapter 5, 3.1; PackML, Aborting."""
    _to_execute(line)
    line.cell.inject(event)
    line.until("ABORTED")
    assert line.cell["Main.PackMl.AbortID"] == error
    if back:
        line.cell.inject(back)
    line.scan(100)
    assert line.seen[-1] == "ABORTED"
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    line.go(("CLEAR", "STOPPED"))
    line.scan(50)
    assert line.seen[-1] == "STOPPED"
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    line.go(("RESET", "IDLE"), ("START", "COMPLETE"))


def test_after_stop_a_new_run_can_begin(line: _Line) -> None:
    """Source: PackML, Stopping."""
    _to_execute(line)
    line.go(("STOP", "STOPPED"))
    assert not line.cell["Main.Robot.SO.SO13_ProgramRunning"]
    line.go(("RESET", "IDLE"), ("START", "COMPLETE"))
