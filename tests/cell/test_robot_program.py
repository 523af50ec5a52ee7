"""A PLC program and a robot program in one cell exchange bits and words."""

from __future__ import annotations

from pathlib import Path

import pytest

from plc_bench import ROOT
from rcx_harness.cell import Cell
from rcx_harness.testing.evidence import state_of

FOLDER = ROOT / "tests/data/robot_programs"


def _cell(link: str = "direct", trace: Path | None = None, positions: str = "") -> Cell:
    """Return a cell at 500 ms with CellSafe and Start TRUE."""
    cell = Cell.build(
        FOLDER / "Supervisor.st",
        engine="builtin",
        link=link,
        robot=FOLDER / "robot.toml",
        trace=trace,
        positions=positions,
    )
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    cell["Main.Start"] = True
    return cell


def test_the_robot_brings_each_part_to_the_place_that_the_plc_names() -> None:
    """Places 1 and 2 alternate. The robot's count in SOW(2) equals the PLC's count."""
    with _cell() as cell:
        for count, target in (
            (1, [100_000, 50_000]),
            (2, [-60_000, 50_000]),
            (3, [100_000, 50_000]),
        ):
            cell.run_until(lambda: cell["Main.Count"] >= count, within="4s")  # noqa: B023
            assert cell.robot.positions[:2] == target
            assert cell.robot.read_port("SOW(2)") == count
        assert cell["Main.Fault"] == 0
        assert cell.robot.alarms.history == []


@pytest.mark.exhaustive
def test_over_ethernet_ip_the_trace_is_the_same() -> None:
    """The direct link and EtherNet/IP give equal traces: areas, positions and program lines."""
    seen = []
    for link in ("direct", "enip"):
        with _cell(link, positions="mm") as cell:
            cell.run("2s")
            seen.append(list(cell.trace.lines()))
            assert cell["Main.Count"] >= 1
    direct, enip = seen
    assert direct[0] == enip[0].replace('"link":"enip"', '"link":"direct"')
    assert direct[1:] == enip[1:]
    assert sum('"tasks":' in line for line in direct) > 5


def test_the_same_run_gives_the_same_trace(tmp_path: Path) -> None:
    """Two identical runs give trace files that are equal byte for byte."""
    for name in ("first.jsonl", "second.jsonl"):
        with _cell(trace=tmp_path / name) as cell:
            cell.run("2s")
    first, second = ((tmp_path / name).read_bytes() for name in ("first.jsonl", "second.jsonl"))
    assert first == second


def test_after_a_restore_the_trace_names_the_lines_of_all_tasks() -> None:
    """The first cycle after `restore` names the line of each task, whatever was recorded before."""
    with _cell() as cell:
        cell.run("2s")
        begin = cell.snapshot()
        lines = []
        for _ in range(2):
            cell.restore(begin)
            cell.run("50ms")
            cycles = cell.trace.cycles()[-10:]
            assert cycles[0].tasks is not None
            lines.append([cycle.line() for cycle in cycles])
        assert lines[0] == lines[1]


def test_a_failed_test_reports_the_line_of_each_task() -> None:
    """The report of a failed test names the line of each robot task."""
    with _cell() as cell:
        assert "robot task 1: PLACE ready" in state_of(cell)
        cell.run_until(lambda: cell.robot.program.main.line == 4, within="4s")
        assert "robot task 1: PLACE:4 WAIT SI(20)=1" in state_of(cell).splitlines()


def test_a_controller_restored_during_a_movement_repeats_it() -> None:
    """A controller that is restored during a movement repeats the rest of the movement exactly."""
    with _cell() as cell:
        cell.run_until(lambda: cell.robot.machine.motion.under_way, within="4s")
        robot = cell.robot
        begin = robot.snapshot()
        inputs = bytearray(48)
        inputs[4], inputs[32] = 1, 0x41  # SIW(2) = 1; SI(00) and SI(06) are ON
        now = 10_000_000
        ways = []
        for _ in range(2):
            robot.restore(begin)
            way = []
            for k in range(100):
                area = robot.cycle(now + 5000 * k, bytes(inputs))
                way.append((tuple(robot.positions), area, robot.program.tasks[0].line))
            ways.append(way)
        assert ways[0] == ways[1]
        assert len({places for places, _, _ in ways[0]}) > 10


def test_an_unknown_place_ends_the_robot_program() -> None:
    """For an unknown place, the robot program sets SO(21) and ends."""
    with _cell() as cell:
        cell["Main.Place"] = 7
        cell.run_until(lambda: cell.robot.read_port("SO(21)") == 1, within="4s")
        assert cell.robot.program.tasks[0].state == "ended"
        assert cell["Main.Count"] == 0
