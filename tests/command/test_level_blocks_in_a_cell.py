"""FB_Jog moves the virtual robot, and FB_ContinuousPosition reports its position."""

from __future__ import annotations

import pytest

from plc_bench import ROOT
from rcx_harness import Cell, RobotConfig

PROGRAM = ROOT / "tests/data/library/Levels.st"


@pytest.fixture
def cell() -> Cell:
    """Return a cell in which the servos, SI(00) and SI(06) are ON."""
    cell = Cell.build(PROGRAM, scan="10ms", robot=RobotConfig(manual_speed=50))
    cell.run_until(lambda: bool(cell["Main.Robot.Settled"]), within="2s")
    cell["Main.ServoOn.Execute"] = True
    cell.run_until(lambda: bool(cell["Main.Robot.SO.SO02_ServoOn"]), within="1s")
    return cell


def test_the_axis_moves_while_enable_is_true_and_its_position_is_shown(cell: Cell) -> None:
    """The axis moves while Enable is TRUE, and the outputs show where it stops.

    Source: guide 4.2.6.
    """
    cell["Main.Jog.Axis"], cell["Main.Jog.PositionOutput"] = 2, "POSITION_PULSES"
    cell["Main.Jog.Direction"] = "DIRECTION_MINUS"
    cell["Main.Jog.Enable"] = True
    cell.run("300ms")
    assert cell["Main.Jog.Valid"]
    assert cell.robot.positions[1] < 0
    cell["Main.Jog.Enable"] = False
    cell.scan()
    cell.run_until(lambda: not cell["Main.Jog.Stopping"], within="1s")
    stands = list(cell.robot.positions)
    assert cell["Main.Jog.Pulses"] == [*stands, 0, 0]
    cell.run("200ms")
    assert cell.robot.positions == stands
    assert not cell["Main.Jog.Error"]
    assert not cell.violations


def test_after_a_jog_the_next_command_is_sent(cell: Cell) -> None:
    """A command that waits for the end of a jog is sent when SI(06) is ON again."""
    cell["Main.Jog.Enable"] = True
    cell.run("200ms")
    cell["Main.Jog.Enable"] = False
    cell["Main.First.Code"], cell["Main.First.Data[3]"] = 0x0006, 0
    cell["Main.First.Data[4]"] = 1000
    cell["Main.First.Execute"] = True
    cell.run_until(lambda: bool(cell["Main.First.Done"]), within="3s")
    assert cell.robot.positions[0] == 1000
    assert not cell.violations


def test_a_jog_into_the_soft_limit_ends_with_2_334_and_the_way_back_is_free(cell: Cell) -> None:
    """A jog ends at the soft limit with alarm 2.334, and can move back. Source: guide 1.1."""
    limit = cell.robot.config.axes[0].soft_high
    cell.robot.positions[0] = limit - 2000
    cell["Main.Jog.Enable"] = True
    cell.run_until(lambda: bool(cell["Main.Jog.Error"]), within="2s")
    assert (cell["Main.Jog.AlarmGroup"], cell["Main.Jog.AlarmCategory"]) == (2, 334)
    assert cell.robot.positions[0] == limit
    cell["Main.Jog.Enable"] = False
    cell.run("50ms")
    cell["Main.Jog.Direction"], cell["Main.Jog.Enable"] = "DIRECTION_MINUS", True
    cell.run("300ms")
    assert cell["Main.Jog.Valid"]
    assert cell.robot.positions[0] < limit
    cell["Main.Jog.Enable"] = False
    cell.run("500ms")
    assert not cell.violations


def test_each_change_of_the_position_is_shown(cell: Cell) -> None:
    """The block shows each position of the robot. Source: guide 4.7.4, continuous output mode."""
    cell["Main.Position.Enable"] = True
    cell.run_until(lambda: bool(cell["Main.Position.Valid"]), within="500ms")
    for place in (1234, -4321):
        cell.robot.positions[2] = place
        cell.robot.inject("pendant_on")  # an event lets the controller calculate its outputs
        cell.robot.inject("pendant_off")
        cell.run("60ms")
        assert cell["Main.Position.Pulses"][2] == place
    cell["Main.Position.Enable"] = False
    cell.run("100ms")
    assert cell["Main.Robot.Status"] == 0
    assert not cell.violations


def test_an_emergency_stop_ends_a_jog_with_12_600(cell: Cell) -> None:
    """An emergency stop ends the jog with alarm 12.600. Source: guide 1.2: 0x000C, 0x0258."""
    cell["Main.Jog.Enable"] = True
    cell.run("200ms")
    cell.robot.inject("emergency_stop")
    cell.run("100ms")
    assert (cell["Main.Jog.AlarmGroup"], cell["Main.Jog.AlarmCategory"]) == (12, 600)
    assert not cell.violations
