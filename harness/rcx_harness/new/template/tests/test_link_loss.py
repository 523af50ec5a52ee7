"""A lost link stops the cycle, and the return of the link starts nothing."""

from __future__ import annotations

from panel import press

from rcx_harness import Cell


def test_a_lost_link_ends_in_a_fault(moving: Cell) -> None:
    moving.inject("link_down")
    moving.run_until(lambda: moving["Main.Stage"] == "CELL_FAULT", within="1s")
    assert moving["Main.Fault"] == 0x8001, "not connected"


def test_nothing_restarts_when_the_link_is_back(moving: Cell) -> None:
    moving.inject("link_down")
    moving.run("1s")
    moving.inject("link_up")
    moving.run("5s")
    assert moving["Main.Stage"] == "CELL_FAULT"
    assert not moving["Main.Robot.SO.SO02_ServoOn"]

    press(moving, "Main.Acknowledge")
    press(moving, "Main.Start")
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="10s")


def test_after_a_power_cycle_of_the_controller_the_cell_can_start_again(moving: Cell) -> None:
    moving.inject("power_cycle")
    moving.run_until(lambda: moving["Main.Stage"] == "CELL_FAULT", within="2s")
    moving.run("2s")
    press(moving, "Main.Acknowledge")
    press(moving, "Main.Start")
    moving.run_until(lambda: moving["Main.Parts"] == 1, within="10s")
