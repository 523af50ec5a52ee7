"""The emergency stop acts at once, and nothing continues by itself."""

from __future__ import annotations

import pytest
from panel import press

from rcx_harness import Cell


def test_an_open_safety_circuit_switches_the_servos_off_and_shows_a_fault(moving: Cell) -> None:
    moving["Main.CellSafe"] = False
    with moving.takes(scans=1):
        moving.scan()
    assert not moving["Main.Robot.SI.SI00_EmergencyStop"], "SI(00) is OFF in the same scan"
    moving.run("200ms")
    assert not moving["Main.Robot.SO.SO02_ServoOn"]
    assert moving["Main.Stage"] == "CELL_FAULT"
    assert moving["Main.Fault"] != 0


def test_the_cell_continues_only_after_acknowledge_and_start(moving: Cell) -> None:
    moving["Main.CellSafe"] = False
    moving.run("500ms")
    moving["Main.CellSafe"] = True
    moving.run("5s")
    assert moving["Main.Stage"] == "CELL_FAULT", "nothing restarts by itself"
    assert not moving["Main.Robot.SO.SO02_ServoOn"]

    press(moving, "Main.Acknowledge")
    moving.run("2s")
    assert moving["Main.Stage"] == "CELL_IDLE"
    assert moving["Main.Fault"] == 0
    assert not moving["Main.Robot.SO.SO02_ServoOn"]

    press(moving, "Main.Start")
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="10s")


def test_the_robots_own_emergency_stop_is_a_fault(moving: Cell) -> None:
    moving.inject("emergency_stop")
    moving.run("200ms")
    assert moving["Main.Stage"] == "CELL_FAULT"

    moving.inject("emergency_stop_release")
    press(moving, "Main.Acknowledge")
    press(moving, "Main.Start")
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="10s")


STAGES = ["CELL_POWER_UP", "CELL_TO_PICK", "CELL_GRIP", "CELL_TO_PLACE", "CELL_RELEASE"]


@pytest.mark.parametrize("stage", STAGES)
def test_an_open_safety_circuit_stops_the_cell_in_every_stage(cell: Cell, stage: str) -> None:
    cell["Main.CellSafe"] = True
    cell.run_until(lambda: cell["Main.Robot.SO.SO01_CpuOk"], within="1s")
    cell["Main.Start"] = True
    cell.run_until(lambda: cell["Main.Stage"] == stage, within="10s")
    cell.run("20ms")  # until the action of the stage has begun
    cell["Main.CellSafe"] = False
    cell.run_until(lambda: cell["Main.Stage"] == "CELL_FAULT", within="15s")
    assert cell["Main.Fault"] != 0
