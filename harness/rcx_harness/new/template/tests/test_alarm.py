"""An alarm of the controller stops the cycle; the operator continues it."""

from __future__ import annotations

from panel import press

from rcx_harness import Cell


def test_an_alarm_on_the_way_stops_the_cycle(moving: Cell) -> None:
    moving.inject("alarm", group=12, category=600)
    moving.run_until(lambda: moving["Main.Stage"] == "CELL_FAULT", within="200ms")
    assert moving["Main.Robot.SO.SO03_Alarm"]
    assert moving["Main.Parts"] == 0


def test_start_resets_the_alarm_and_the_cycle_runs_again(moving: Cell) -> None:
    moving.inject("alarm")
    moving.run("500ms")
    press(moving, "Main.Acknowledge")
    press(moving, "Main.Start")
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="10s")
    assert not moving["Main.Robot.SO.SO03_Alarm"]


def test_a_point_that_is_not_taught_is_a_fault(cell: Cell) -> None:
    del cell.robot.points[1]
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    press(cell, "Main.Start")
    cell.run_until(lambda: cell["Main.Stage"] == "CELL_FAULT", within="5s")
    assert cell["Main.Fault"] == 0x8020, "abnormal end; the alarm says why"
