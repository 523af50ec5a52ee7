"""Parts go from point 1 to point 2."""

from __future__ import annotations

import pytest
from panel import press

from rcx_harness import Cell


def gripper(cell: Cell) -> bool:
    """Return DO2(0), bit 0 of output port 2 of the robot."""
    return bool(cell.robot.read_port("DO(20)"))


def point(cell: Cell, number: int) -> list[int]:
    """Return the position of a point of robot.toml in pulses of the robot's axes."""
    return list(cell.robot.points[number].data[: len(cell.robot.positions)])


def test_one_part_is_picked_at_point_1_and_placed_at_point_2(moving: Cell) -> None:
    moving["Main.LastPart"] = True
    moving.run_until(lambda: moving["Main.Stage"] == "CELL_GRIP", within="5s")
    assert moving.robot.positions == point(moving, 1)
    assert not gripper(moving)

    moving.run_until(lambda: moving["Main.Stage"] == "CELL_TO_PLACE", within="1s")
    assert gripper(moving)

    moving.run_until(lambda: moving["Main.Stage"] == "CELL_RELEASE", within="5s")
    assert moving.robot.positions == point(moving, 2)
    assert gripper(moving)

    moving.run_until(lambda: moving["Main.Stage"] == "CELL_IDLE", within="1s")
    assert not gripper(moving)
    assert moving["Main.Parts"] == 1


def test_the_cycle_repeats_until_the_last_part_is_requested(moving: Cell) -> None:
    for parts in (1, 2, 3):
        moving.run_until(lambda: moving["Main.Stage"] == "CELL_RELEASE", within="10s")
        moving.run_until(lambda: moving["Main.Stage"] == "CELL_TO_PICK", within="1s")
        assert moving["Main.Parts"] == parts
    moving["Main.LastPart"] = True
    moving.run_until(lambda: moving["Main.Stage"] == "CELL_IDLE", within="10s")
    assert moving["Main.Parts"] == 4
    moving.run("5s")
    assert moving["Main.Parts"] == 4


def test_start_acts_when_it_is_pressed_and_only_in_an_idle_cell(cell: Cell) -> None:
    cell["Main.CellSafe"] = True
    cell.run_until(lambda: cell["Main.Robot.SO.SO01_CpuOk"], within="1s")
    assert cell["Main.Stage"] == "CELL_IDLE"
    cell["Main.Start"] = True
    cell.scan()
    assert cell["Main.Stage"] == "CELL_POWER_UP"
    cell["Main.Start"] = False
    cell.run_until(lambda: cell["Main.Stage"] == "CELL_TO_PICK", within="5s")
    press(cell, "Main.Start")
    assert cell["Main.Stage"] == "CELL_TO_PICK"


def test_start_has_no_effect_while_the_cell_is_not_safe(cell: Cell) -> None:
    cell.run("500ms")
    press(cell, "Main.Start")
    cell.run("2s")
    assert not cell["Main.Robot.SI.SI00_EmergencyStop"], "SI(00) stays OFF"
    assert not cell["Main.Robot.SO.SO02_ServoOn"]


@pytest.mark.rcx(scan="20ms", rpi="20ms", jitter="5ms")
def test_the_cycle_also_works_with_a_slow_plc_and_a_slow_network(moving: Cell) -> None:
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="20s")
