"""Three typical robot programs of users run with their PLC programs over both links.

The programs resemble public ones. One receives positions from the PLC. One unloads a tray in a loop
and checks the gripper's switch. One is in a file with all data of a controller.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from example_runs import changes
from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.cli.app import main
from serve_process import ServeProcess, own_addresses

FOLDER = ROOT / "tests/data/robot_programs"
#: For each folder: the PLC program, and a variable with its value at the end of a run in which the
#: gripper's switch stays OFF.
CELLS = {
    "unloading": ("Belt.st", "Main.Empty.Value", "TRUE"),
    "positions": ("Positions.st", "Main.k", "4"),
    "two_tasks": ("Gluing.st", "Main.Done", "2"),
}
#: Run time of the longest program, and duration of the compared runs.
LONGEST, COMPARED = "12s", "4s"


def _cell(name: str, link: str = "direct", trace: Path | None = None) -> Cell:
    """Return a cell at 500 ms with CellSafe and Start TRUE."""
    cell = Cell.build(
        FOLDER / name / CELLS[name][0],
        engine="builtin",
        link=link,
        robot=FOLDER / name / "robot.toml",
        trace=trace,
    )
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    cell["Main.Start"] = True
    return cell


def test_a_tray_is_unloaded_except_for_a_part_that_is_not_gripped() -> None:
    """If the vacuum switch DI(20) is OFF at the first part only, 5 of 6 parts reach the belt."""
    with _cell("unloading") as cell:
        robot = cell.robot
        cell.run_until(lambda: robot.read_port("DO(20)") == 1, within="5s")
        assert robot.positions == [-60_000, 0, 30_000, 0]  # This is the first position in the tray.
        cell.run_until(lambda: robot.read_port("SO(22)") == 1, within="5s")
        robot.inject("parallel_input", port=20, on=1)
        places = []
        for count in range(1, 6):
            cell.run_until(lambda: cell["Main.Parts.Value"] == count, within="5s")  # noqa: B023
            places.append(robot.positions[0])
        assert places == [80_000] * 5
        cell.run_until(lambda: cell["Main.Empty.Value"], within="5s")
        assert robot.program.tasks[0].state == "ended"
        assert robot.positions == [0, 0, 0, 0]
        assert robot.alarms.history == []
        assert cell["Main.Fault"] == 0


def test_the_plc_sends_positions_and_receives_the_alarm_of_a_refused_one() -> None:
    """The third position is beyond the soft limit, so the robot has alarm 2.334.

    The robot program sends the number 334 to the PLC.
    """
    with _cell("positions") as cell:
        for count, x, y in ((1, 50_000, 25_000), (2, -20_500, 40_000)):
            cell.run_until(lambda: cell["Main.Count"] == count, within="4s")  # noqa: B023
            assert cell.robot.positions == [x, y, 15_000, 0]
            assert cell["Main.LastX"] == x
        cell.run_until(lambda: cell["Main.Failed"] == 1, within="4s")
        assert cell["Main.LastAlarm"] == 334
        assert cell.robot.program.errors == []
        cell.run_until(lambda: cell["Main.Count"] == 3, within="4s")
        assert cell.robot.positions == [0, 0, 15_000, 0]


def test_two_tasks_share_the_data_of_one_file() -> None:
    """Two tasks of one data file run at once, and the gluing time fits the length of the path."""
    with _cell("two_tasks") as cell:
        robot = cell.robot
        assert robot.config.parameters["ACCEL"] == (80, 80, 50, 100)
        seen = set()

        def done() -> bool:
            seen.add(tuple(task.state for task in robot.program.tasks))
            return bool(cell["Main.Done"] == 2)

        cell.run_until(done, within="12s")
        cell.run("500ms")
        assert ("running", "running") in seen
        assert [task.state for task in robot.program.tasks] == ["ended", "ended"]
        length = 40 + 31.4 + 44.7  # line 40 mm, half circle 31.4 mm, P5 to P2 sqrt(40^2 + 20^2) mm
        assert length / 100 * 1000 <= cell["Main.Milliseconds"] <= length / 100 * 1000 * 1.15
        assert cell["Main.Blinks"] >= 10
        assert robot.positions[:3] == [0, 10_000, 0]
        assert robot.alarms.history == []


@pytest.mark.exhaustive
@pytest.mark.parametrize("name", CELLS)
def test_over_ethernet_ip_the_trace_is_the_same(name: str) -> None:
    """The direct link and EtherNet/IP have the same areas at the same virtual times."""
    seen = []
    for link in ("direct", "enip"):
        with _cell(name, link) as cell:
            cell.run(COMPARED)
            seen.append(list(changes(cell.trace.lines())))
    assert seen[0] == seen[1]
    assert len(seen[0]) > 20


@pytest.mark.parametrize("name", ["two_tasks"])
def test_the_same_run_gives_the_same_trace(name: str, tmp_path: Path) -> None:
    """Two identical runs give trace files that are equal byte for byte."""
    for file in ("first.jsonl", "second.jsonl"):
        with _cell(name, trace=tmp_path / file) as cell:
            cell.run(COMPARED)
    first, second = ((tmp_path / file).read_bytes() for file in ("first.jsonl", "second.jsonl"))
    assert first == second


@pytest.mark.exhaustive
@pytest.mark.skipif(
    not sys.platform.startswith("linux"), reason="it needs loopback addresses besides 127.0.0.1"
)
@pytest.mark.parametrize("name", CELLS)
def test_over_rcx_serve_the_program_runs_to_its_end(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """The program completes in real time with a controller in another process (`rcx serve`)."""
    plc, variable, value = CELLS[name]
    folder = FOLDER / name
    (address,) = own_addresses(1)
    with ServeProcess("--address", address, "--robot", str(folder / "robot.toml")) as served:
        served.wait_for("alarm 12.551 EtherNet/IP link error")
        options = ["--for", LONGEST, "--stimulus", str(folder / "stimulus.toml")]
        options += ["--timeout", "5s", "--engine", "builtin", "--connect", address]
        assert main(["run", str(folder / plc), *options, "--watch", variable]) == 0
        served.interrupt()
        assert served.end()[0] == 0
    assert f"  {variable} = {value}\n" in capsys.readouterr().out
