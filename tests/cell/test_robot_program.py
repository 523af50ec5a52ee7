"""A PLC program and a robot program in one cell: they shake hands through bits and words."""

from __future__ import annotations

from pathlib import Path

import pytest

from example_runs import changes
from plc_bench import ROOT
from rcx_harness.cell import Cell

FOLDER = ROOT / "tests/data/robot_programs"


def _cell(link: str = "direct", trace: Path | None = None) -> Cell:
    """Return the cell with CellSafe; Start is pressed at 500 ms."""
    cell = Cell.build(
        FOLDER / "Supervisor.st",
        engine="builtin",
        link=link,
        robot=FOLDER / "robot.toml",
        trace=trace,
    )
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    cell["Main.Start"] = True
    return cell


def test_the_robot_brings_each_part_to_the_place_that_the_plc_names() -> None:
    """The places 1 and 2 follow each other; the robot counts in SOW(2) as the PLC does."""
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
def test_over_ethernet_ip_the_same_bytes_go_over_the_wire() -> None:
    """Time is virtual, so that both links show the same areas at the same times."""
    seen = []
    for link in ("direct", "enip"):
        with _cell(link) as cell:
            cell.run("2s")
            seen.append(list(changes(cell.trace.lines())))
            assert cell["Main.Count"] >= 1
    assert seen[0] == seen[1]


def test_the_same_run_gives_the_same_trace(tmp_path: Path) -> None:
    """Byte for byte."""
    for name in ("first.jsonl", "second.jsonl"):
        with _cell(trace=tmp_path / name) as cell:
            cell.run("2s")
    first, second = ((tmp_path / name).read_bytes() for name in ("first.jsonl", "second.jsonl"))
    assert first == second


def test_a_snapshot_in_the_middle_of_a_movement_continues_alike() -> None:
    """A controller that is restored goes the same way again."""
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


def test_a_place_that_the_robot_does_not_know_ends_its_program() -> None:
    """The robot sets SO(21) and ends; SO(13) is OFF."""
    with _cell() as cell:
        cell["Main.Place"] = 7
        cell.run_until(lambda: cell.robot.read_port("SO(21)") == 1, within="4s")
        assert cell.robot.program.tasks[0].state == "ended"
        assert cell["Main.Count"] == 0
