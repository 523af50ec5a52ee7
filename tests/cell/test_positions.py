"""On request, a trace contains the positions of the robots.

The expected values were determined by hand. By default, 1000 pulses are 1 mm and the axes start at
0.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from rcx_harness import Cell, RobotConfig
from rcx_harness.robot.config import Axis
from rcx_harness.trace import read_trace

Build = Callable[..., Cell]

#: Robot 1 has two axes with 1000 and 500 pulses per mm. Robot 2 has one axis.
TWO = RobotConfig(axes=(Axis(), Axis(pulses_per_mm=500.0), Axis(robot=2)))


def shown(cell: Cell) -> list[tuple[float, ...]]:
    return [one.positions for one in cell.trace.cycles() if one.positions is not None]


def test_a_trace_has_positions_on_request_only(raw_cell: Build) -> None:
    cell = raw_cell()
    cell.run("50ms")
    assert not any("positions" in line for line in cell.trace.lines())


@pytest.mark.parametrize(
    ("unit", "titles", "moved"),
    [
        (
            "pulses",
            ["Robot 1 axis 1 [pulses]", "Robot 1 axis 2 [pulses]", "Robot 2 axis 1 [pulses]"],
            (1500, -250, 7),
        ),
        ("mm", ["Robot 1 X [mm]", "Robot 1 Y [mm]", "Robot 2 X [mm]"], (1.5, -0.5, 0.007)),
    ],
)
def test_positions_are_shown_when_they_change(
    raw_cell: Build, unit: str, titles: list[str], moved: tuple[float, ...]
) -> None:
    cell = raw_cell(robot=TWO, positions=unit)
    cell.run("50ms")
    cell.robot.positions[:] = [1500, -250, 7]
    cell.run("50ms")
    assert cell.trace.header["positions"] == [titles]
    assert shown(cell) == [(0, 0, 0), moved]
    after = [one.t_us for one in cell.trace.cycles() if one.positions is not None]
    assert after == [0, 50_000]
    shown_as = f',"positions":{str(list(moved)).replace(" ", "")}}}'
    assert sum(line.endswith(shown_as) for line in cell.trace.lines()) == 1


def test_titles_of_positions_name_the_robot_if_there_are_two(raw_cell: Build) -> None:
    cell = raw_cell(robot=RobotConfig(axes=(Axis(), Axis(robot=4))), positions="mm")
    assert cell.trace.header["positions"] == [["Robot 1 X [mm]", "Robot 4 X [mm]"]]


def test_a_trace_that_is_read_again_has_positions(raw_cell: Build, tmp_path: Path) -> None:
    cell = raw_cell(robot=TWO, positions="mm", trace=tmp_path / "t.jsonl")
    cell.run("50ms")
    cell.close()
    _, records = read_trace(tmp_path / "t.jsonl")
    assert list(records) == list(cell.trace)
    assert shown(cell) == [(0, 0, 0)]


def test_titles_of_positions_do_not_name_a_single_robot(raw_cell: Build) -> None:
    titles = ["Position X [mm]", "Position Y [mm]", "Position Z [mm]", "Position R [deg]"]
    assert raw_cell(positions="mm").trace.header["positions"] == [titles]


def test_a_restored_cell_records_positions_again(raw_cell: Build) -> None:
    cell = raw_cell(robot=TWO, positions="pulses")
    cell.run("20ms")
    before = cell.snapshot()
    cell.robot.positions[0] = 9
    cell.run("20ms")
    cell.restore(before)
    cell.robot.positions[0] = 9
    cell.run("20ms")
    assert shown(cell) == [(0, 0, 0), (9, 0, 0)]
