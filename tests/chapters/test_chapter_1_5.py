"""The sentences of chapter 1, 5, about the connection and its effects on the controller."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell
from rcx_harness.robot import Led
from robot_master import Master

Start = Callable[..., ChapterCell]

NO_LINK = 0x8001


def _never_connected(start: Start, **config: object) -> ChapterCell:
    """Return a cell with a cable that was unplugged before power-on."""
    cell = start(**config)
    cell.cell.inject("link_down")
    cell.run("500ms")
    return cell


def _lost(start: Start, **config: object) -> ChapterCell:
    """Return a cell with a cable that was unplugged while a program ran."""
    cell = start(**config).program()
    cell.cell.inject("link_down")
    cell.run("500ms")
    return cell


def _restored(cell: ChapterCell, *events: str) -> ChapterCell:
    """Inject the given events, plug the cable in again, and run the cell for 1 s."""
    for event in (*events, "link_up"):
        cell.cell.inject(event)
    cell.run("1s")
    return cell


def _read_version(cell: ChapterCell) -> int:
    """Execute a remote command, and return its ErrorID."""
    cell["Command.Code"] = 0x0501
    return cell.execute("Command")


# The first sentence of section 5, before its three numbered items


def test_the_controller_always_starts_in_the_servo_off_state_after_power_on(start: Start) -> None:
    """The servos are OFF after every power-on, even if they were ON before a power cycle.

    Source: manual chapter 1, 5.
    """
    cell = start().settle()
    assert not cell.on("SO02")
    assert cell.execute("ServoOn") == 0
    cell.cell.inject("power_cycle")
    cell.run("1500ms")
    assert cell.is_on("SO01", "SO02") == (True, False)


# 1. Normal connection when the power is turned ON


def test_communication_with_the_host_is_enabled_when_the_system_is_connected(start: Start) -> None:
    """The controller answers a remote command. Source: manual chapter 1, 5, 1."""
    cell = start().settle()
    assert _read_version(cell) == 0
    assert cell.robot.network_led is Led.GREEN


def test_with_a_connection_the_emergency_stop_signal_of_the_network_is_valid(start: Start) -> None:
    """Source: manual chapter 1, 5, 1."""
    cell = start().settle()
    assert not cell.on("SO00")
    cell["CellSafe"] = False
    cell.wait("SO00")


def test_with_a_connection_the_stop_signal_of_the_network_is_valid(start: Start) -> None:
    """Source: manual chapter 1, 5, 1."""
    cell = start().program()
    cell["StopReleased"] = False
    cell.wait("SO13", False)


def test_with_a_connection_the_safety_connector_is_valid(start: Start) -> None:
    """Source: manual chapter 1, 5, 1."""
    cell = start().servo_on()
    cell.cell.inject("emergency_stop")
    cell.wait("SO00")
    assert not cell.on("SO02")


@pytest.mark.parametrize(("board", "stops"), [("valid", True), ("invalid", False)])
def test_with_a_connection_the_stop_signal_of_a_parallel_board_works_unless_disabled(
    start: Start, board: str, stops: bool
) -> None:
    """Source: manual chapter 1, 5, 1."""
    cell = start(parallel_io=board).program()
    cell.cell.inject("parallel_stop")
    cell.run("100ms")
    assert cell.on("SO13") is not stops


# 2. Transition from the normal connection to the connection error


def test_after_the_loss_of_the_connection_communication_is_disabled(start: Start) -> None:
    """Commands do not reach the controller, and there is alarm 12.552.

    Source: manual chapter 1, 5, 2; chapter 4, 4
    """
    cell = _lost(start)
    assert cell["Connected"] is False
    assert _read_version(cell) == NO_LINK
    assert cell.alarms() == ["12.552", "12.600"]
    assert cell.robot.network_led is Led.RED_FLASHING


def test_after_the_loss_of_the_connection_si00_turns_off_in_the_controller(start: Start) -> None:
    """The controller turns SI(00) OFF although SI(00) is still ON in the PLC's image.

    Source: manual chapter 1, 5, 2
    """
    cell = start().servo_on()
    assert cell.robot.machine.si00
    cell.cell.inject("link_down")
    cell.run("500ms")
    assert not cell.robot.machine.si00
    assert cell.robot.machine.emergency
    assert not cell.robot.machine.servo_on


def test_after_the_loss_of_the_connection_si06_turns_off_in_the_controller(start: Start) -> None:
    """Source: manual chapter 1, 5, 2."""
    cell = _lost(start)
    assert not cell.robot.machine.si06
    assert cell.robot.machine.stopped
    assert not cell.robot.program.running


def test_after_the_loss_of_the_connection_the_safety_connector_is_valid(start: Start) -> None:
    """If the SAFETY connector opens during the loss, the emergency stop is active afterwards.

    Source: manual chapter 1, 5, 2.
    """
    cell = _restored(_lost(start), "emergency_stop")
    assert cell["Connected"] is True
    assert cell.robot.machine.si00
    assert cell.on("SO00")


@pytest.mark.parametrize(("board", "stops"), [("valid", True), ("invalid", False)])
def test_after_the_loss_of_the_connection_the_stop_of_a_parallel_board_works_unless_disabled(
    start: Start, board: str, stops: bool
) -> None:
    """If the parallel board's stop input opens during the loss, the stop is active afterwards.

    Source: manual chapter 1, 5, 2.
    """
    cell = _restored(_lost(start, parallel_io=board), "parallel_stop")
    assert cell.robot.machine.si06
    assert cell.robot.machine.stopped is stops


def test_after_its_loss_the_connection_must_be_restored_to_the_normal_state(start: Start) -> None:
    """Nothing works until the connection is restored.

    Then SI(00), alarm reset and servo on allow the program to start.

    Source: manual chapter 1, 5, 2, first note
    """
    cell = _lost(start)
    assert cell.execute("FromEmergency") == NO_LINK
    _restored(cell)
    assert cell.is_on("SO00", "SO02", "SO03", "SO13") == (False, False, True, False)
    assert cell.execute("FromEmergency") == 0
    assert cell.execute("AutoStart") == 0


def test_communication_is_enabled_again_when_the_lost_connection_is_recovered(start: Start) -> None:
    """Source: manual chapter 1, 5, 2, second note."""
    cell = _restored(_lost(start))
    assert _read_version(cell) == 0
    assert cell.robot.network_led is Led.GREEN


# 3. Connection error when the power is turned ON


def test_a_connection_error_at_power_on_may_come_from_the_cable(start: Start) -> None:
    """The cable is unplugged, or the address is wrong. There is alarm 12.551.

    Source: manual chapter 1, 5, 3; chapter 4, 4
    """
    cell = _never_connected(start)
    assert cell["Connected"] is False
    assert cell.alarms() == ["12.551"]


def test_a_connection_error_at_power_on_may_come_from_a_wrong_ip_address(start: Start) -> None:
    """Source: manual chapter 1, 5, 3; chapter 3, 1."""
    cell = start(ip_address="duplicate")
    cell.run("500ms")
    assert cell["Connected"] is False
    assert cell.alarms() == ["12.551"]


def test_a_connection_error_at_power_on_may_come_from_a_faulty_master() -> None:
    """No master sends packets. Source: manual chapter 1, 5, 3."""
    master = Master()
    master.connected = False
    master.run(300)
    assert [alarm.number for alarm in master.robot.alarms.active] == ["12.551"]
    assert master.on("SO00")


def test_without_a_connection_at_power_on_communication_is_disabled(start: Start) -> None:
    """Source: manual chapter 1, 5, 3."""
    cell = _never_connected(start)
    assert _read_version(cell) == NO_LINK
    assert cell.robot.commands_executed == 0


def test_without_a_connection_at_power_on_si00_is_off_in_the_controller(start: Start) -> None:
    """Source: manual chapter 1, 5, 3."""
    cell = _never_connected(start)
    assert not cell.robot.machine.si00
    assert cell.robot.machine.emergency


def test_without_a_connection_at_power_on_si06_is_off_in_the_controller(start: Start) -> None:
    """Source: manual chapter 1, 5, 3."""
    cell = _never_connected(start)
    assert not cell.robot.machine.si06
    assert cell.robot.machine.stopped


def test_without_a_connection_at_power_on_the_safety_connector_is_valid(start: Start) -> None:
    """Source: manual chapter 1, 5, 3."""
    cell = _never_connected(start)
    cell.cell.inject("emergency_stop")
    cell.run("50ms")
    assert "12.600" in cell.alarms()
    _restored(cell)
    assert cell.robot.machine.si00
    assert cell.on("SO00")


@pytest.mark.parametrize(("board", "stops"), [("valid", True), ("invalid", False)])
def test_without_a_connection_at_power_on_the_stop_of_a_parallel_board_works_unless_disabled(
    start: Start, board: str, stops: bool
) -> None:
    """Source: manual chapter 1, 5, 3."""
    cell = _restored(_never_connected(start, parallel_io=board), "parallel_stop")
    assert cell.robot.machine.si06
    assert cell.robot.machine.stopped is stops


def test_communication_is_enabled_with_the_first_connection_after_power_on(start: Start) -> None:
    """When the first connection is made, the alarm disappears. Servo on needs no alarm reset.

    Source: manual chapter 1, 5, 3, note
    """
    cell = _restored(_never_connected(start))
    assert cell.alarms() == []
    assert _read_version(cell) == 0
    assert cell.execute("ServoOn") == 0
