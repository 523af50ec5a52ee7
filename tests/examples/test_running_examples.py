"""Examples 08, 10 and 11 run programs by name, monitor the robot, and recover from a stop."""

from __future__ import annotations

import pytest

from example_runs import finished
from rcx_harness.cell import Cell
from rcx_harness.robot.ports import port
from rcx_tools.docs.examples import examples


def _build(name: str) -> Cell:
    return examples()[name].build("builtin")


def _running(cell: Cell) -> list[str]:
    tasks = cell.robot.machine.program.tasks
    return [task.program.name for task in tasks if task.state == "running"]


def test_only_the_program_of_the_recipe_is_registered_and_runs() -> None:
    """Only the program that the recipe names is registered and runs.

    Source: guide 4.6.1, 4.6.2, 4.6.4.
    """
    mark = port("SO2()")
    with _build("08_program_by_name") as cell:
        ports = cell.robot.machine.ports
        cell.run("1600ms")
        assert _running(cell) == ["BOX_LARGE"]
        assert ports.read(mark) == 2
        cell.run("1s")
        assert _running(cell) == []
        assert cell["Main.Ran"] == "BOX_LARGE", "Ran must be the name from the controller"
        cell.run("1s")
        assert _running(cell) == ["CLEAN"]
        assert ports.read(mark) == 4
        cell.run("1200ms")
        assert (cell["Main.Stage"], cell["Main.Fault"]) == ("NAME_FAULT", 0x8044)
        cell.run("1s")
        assert (cell["Main.Stage"], cell["Main.Fault"]) == ("NAME_IDLE", 0)
        assert _running(cell) == []
        assert not cell.violations


@pytest.mark.parametrize(
    ("event", "fault"), [("emergency_stop", 0x8004), ("alarm", 0x8004), ("link_down", 0x8001)]
)
def test_a_stopped_program_is_a_fault(event: str, fault: int) -> None:
    """A stopped program is a fault, not a complete run. Source: manual chapter 5, 2, SO(13)."""
    with _build("08_program_by_name") as cell:
        cell.run_until(lambda: cell["Main.Stage"] == "NAME_RUNNING", within="2s")
        cell.inject(event)
        cell.run("500ms")
        assert (cell["Main.Stage"], cell["Main.Fault"]) == ("NAME_FAULT", fault)
        assert cell["Main.Ran"] == ""


def test_motor_duty_is_read_during_a_movement_and_position_after_it() -> None:
    """The motor duty is read during a movement, position and torque after it.

    The rated torque is 20 % of the maximum torque, so 2 % + 9 % of the maximum are 55 % of the
    rated torque.

    Source: guide 4.9.1, 4.7.4, 4.7.12; robot.toml of the example.
    """
    with _build("10_monitoring") as cell:
        cell.run("1400ms")
        assert (cell["Main.Duty1"], cell["Main.Torques"][:2]) == (10, [2, 4])
        cell.run("500ms")
        assert 0 < cell.robot.positions[0] < 150_000, "the robot must be moving now"
        assert (cell["Main.Duty1"], cell["Main.Torques"][0]) == (55, 2)
        assert cell["Main.Shown"][0] == 0.0, "a moving command keeps its turn"
        cell.run("600ms")
        assert cell["Main.Shown"][:2] == [150.0, -90.0]
        assert cell["Main.Duty1"] == 10


def test_an_alarm_is_read_once_and_the_monitoring_continues() -> None:
    """An alarm is read once, and the monitoring continues.

    Source: chapter 5, 2, SO(03); guide 4.7.7.
    """
    cell = finished("10_monitoring").cell
    assert (cell["Main.Group"], cell["Main.Category"]) == (99, 999)
    assert cell["Main.Robot.SO.SO03_Alarm"]
    assert cell["Main.Fault"] == 0
    assert cell["Main.Torques"][:2] == [0, 0], "the position was read after the servos went OFF"
    assert cell["Main.NewAlarm"] is False


def test_a_lost_link_ends_the_monitoring_until_reset_and_start() -> None:
    """After a loss of the link, monitoring stays off until Reset and Start.

    Source: design of the examples: a fault is kept, nothing restarts by itself.
    """
    with _build("10_monitoring") as cell:
        cell.run("1400ms")
        cell.inject("link_down")
        cell.run("300ms")
        assert (cell["Main.Stage"], cell["Main.Fault"]) == ("WATCH_OFF", 0x8001)
        cell.inject("link_up")
        cell["Main.Start"] = True
        cell.run("300ms")
        assert cell["Main.Stage"] == "WATCH_OFF", "the fault is not acknowledged"
        cell.run("1s")  # wait until the stimulus has raised its alarm
        cell["Main.Start"], cell["Main.Reset"] = False, True
        cell.run("100ms")
        assert cell["Main.Fault"] == 0
        assert not cell["Main.Robot.SO.SO02_ServoOn"]
        cell["Main.Start"] = True
        cell.run_until(lambda: cell["Main.Stage"] == "WATCH_TORQUE", within="3s")


def _stages(cell: Cell, duration: str) -> list[str]:
    """Run example 11, and return its stages in their order."""
    seen = [str(cell["Main.Stage"])]
    for _ in range(int(duration.removesuffix("s")) * 100):
        cell.scan()
        if cell["Main.Stage"] != seen[-1]:
            seen.append(str(cell["Main.Stage"]))
    return [stage.removeprefix("SAFE_") for stage in seen]


def test_after_an_emergency_stop_the_operator_continues_or_restarts_the_program() -> None:
    """After an emergency stop the operator can continue the program or start it from the beginning.

    Source: manual chapter 5, 3.1 (servo ON from emergency stop) and 3.3.
    """
    with _build("11_emergency_stop") as cell:
        stages = _stages(cell, "10s")
        begin = ["PROGRAM_RESET", "START", "RUNNING"]
        servo = ["STOPPED", "SERVO_ON", "READY"]
        assert stages == [*servo, *begin, *servo, "START", "RUNNING", *servo, *begin, "READY"]
        assert cell.robot.machine.ports.read(port("SO(20)")) == 1, "the program has run to its end"
        assert cell["Main.Fault"] == 0
        assert not cell.violations


def test_si00_is_off_in_the_scan_of_the_emergency_and_stays_off_until_reset() -> None:
    """SI(00) is OFF in the scan in which CellSafe falls, and stays OFF until Reset.

    Source: manual chapter 5, 3.1, shift to emergency stop.
    """
    with _build("11_emergency_stop") as cell:
        cell.run_until(lambda: cell["Main.Stage"] == "SAFE_RUNNING", within="3s")
        cell["Main.CellSafe"] = False
        cell.scan()
        assert not cell["Main.Robot.SI.SI00_EmergencyStop"]
        assert cell["Main.Fault"] == 0x8003
        cell.run("100ms")
        assert _running(cell) == []
        cell["Main.CellSafe"] = True
        cell["Main.Start"] = cell["Main.GoOn"] = True
        cell.run("300ms")
        assert not cell["Main.Robot.SI.SI00_EmergencyStop"], "SI(00) must stay OFF until Reset"
        assert cell["Main.Stage"] == "SAFE_STOPPED"


def test_a_held_reset_button_has_no_effect() -> None:
    """A Reset button that is held during the stop has no effect. Source: design of the examples."""
    with _build("11_emergency_stop") as cell:
        cell.run_until(lambda: cell["Main.Stage"] == "SAFE_RUNNING", within="3s")
        cell["Main.Reset"] = True
        cell.run("50ms")
        cell.robot.inject("emergency_stop")
        cell.run("100ms")
        cell.robot.inject("emergency_stop_release")
        cell.run("200ms")
        assert cell["Main.Stage"] == "SAFE_STOPPED"
        assert cell["Main.Fault"] == 0x8003
