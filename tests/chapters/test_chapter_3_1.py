"""The sentences of chapter 3, 1, about the state after the controller's power-on."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from chapter_cell import ChapterCell
from rcx_harness.robot import Led
from robot_master import Master

Start = Callable[..., ChapterCell]


def _leds(cell: ChapterCell) -> tuple[Led, Led]:
    return cell.robot.module_led, cell.robot.network_led


# The conditions


def test_to_connect_the_cable_must_be_connected(start: Start) -> None:
    """Source: manual chapter 3, 1."""
    cell = start()
    cell.cell.inject("link_down")
    cell.run("500ms")
    assert cell["Connected"] is False
    cell.cell.inject("link_up")
    cell.run("500ms")
    assert cell["Connected"] is True


@pytest.mark.parametrize("address", ["none", "duplicate"])
def test_to_connect_the_ip_address_must_be_set_correctly(start: Start, address: str) -> None:
    """Source: manual chapter 3, 1."""
    cell = start(ip_address=address)
    cell.run("1s")
    assert cell["Connected"] is False
    assert cell.robot.machine.link == "none"


def test_to_connect_the_master_module_must_operate() -> None:
    """Source: manual chapter 3, 1."""
    master = Master()
    master.connected = False
    master.run(500)
    assert master.robot.machine.link == "none"
    master.connected = True
    master.run(5)
    assert master.robot.machine.link == "normal"


@pytest.mark.parametrize(
    ("robot", "plc", "connected"),
    [(48, 48, True), (256, 256, True), (48, 256, False), (256, 48, False)],
)
def test_to_connect_master_and_controller_must_have_the_same_size_48_or_256_bytes(
    start: Start, robot: int, plc: int, connected: bool
) -> None:
    """The controller has 48 bytes if the parameter SIOW extension is invalid, otherwise 256 bytes.

    Source: manual chapter 3, 1.
    """
    cell = start(size=robot, plc_size=plc)
    cell.run("1s")
    assert cell["Connected"] is connected
    assert (cell.robot.machine.link == "normal") is connected


def test_the_controller_always_begins_in_the_servo_off_state_after_power_on(start: Start) -> None:
    """The servos are OFF after power-on with and without a connection.

    Source: manual chapter 3, 1.
    """
    cell = start()
    cell.cell.inject("link_down")
    cell.run("500ms")
    assert not cell.robot.machine.servo_on
    cell.cell.inject("link_up")
    cell.run("1s")
    assert not cell.on("SO02")


# Correctly connected


def test_correctly_connected_the_leds_show_the_normal_state(start: Start) -> None:
    """Source: manual chapter 3, 1."""
    cell = start().settle()
    assert _leds(cell) == (Led.GREEN, Led.GREEN)


def test_correctly_connected_the_host_must_turn_both_stop_signals_on(start: Start) -> None:
    """The program does not start while SI(00) or SI(06) is OFF. Source: manual chapter 3, 1."""
    cell = start()
    cell["CellSafe"] = cell["StopReleased"] = False
    cell.run("500ms")
    assert cell.on("SO00")
    assert cell.execute("ServoOn") == 0x8003
    cell["CellSafe"] = True
    cell.settle()
    assert cell.execute("ServoOn") == 0
    assert cell.execute("AutoStart") == 0x8007
    cell["StopReleased"] = True
    cell.settle()
    assert cell.execute("AutoStart") == 0


def test_correctly_connected_the_safety_connector_is_always_valid(start: Start) -> None:
    """Source: manual chapter 3, 1."""
    cell = start().servo_on()
    cell.cell.inject("emergency_stop")
    cell.wait("SO00")
    assert cell.is_on("SO02", "SO03") == (False, True)


@pytest.mark.parametrize(("board", "stops"), [("valid", True), ("invalid", False)])
def test_correctly_connected_the_stop_of_a_parallel_board_is_enabled_unless_disabled(
    start: Start, board: str, stops: bool
) -> None:
    """Source: manual chapter 3, 1."""
    cell = start(parallel_io=board, parallel_stop=False).servo_on()
    cell["AutoStart.Timeout"] = "T#1s"
    assert (cell.execute("AutoStart") != 0) is stops
    assert [alarm.number for alarm in cell.robot.alarms.history] == ["12.400"] * stops


# Incorrectly connected


def test_incorrectly_connected_the_leds_show_the_error_state(start: Start) -> None:
    """If the cable is unplugged, the LEDs show the error.

    Source: manual chapter 3, 1; chapter 4, 2.
    """
    cell = start()
    cell.cell.inject("link_down")
    cell.run("500ms")
    assert _leds(cell) == (Led.GREEN_FLASHING, Led.GREEN_FLASHING)


@pytest.mark.parametrize(("address", "network"), [("none", Led.OFF), ("duplicate", Led.RED)])
def test_with_a_wrong_ip_address_the_leds_show_the_error_state(
    start: Start, address: str, network: Led
) -> None:
    """Source: manual chapter 3, 1; chapter 1, 3."""
    cell = start(ip_address=address)
    cell.run("500ms")
    assert _leds(cell) == (Led.GREEN_FLASHING, network)


def test_with_different_sizes_the_leds_show_the_error_state(start: Start) -> None:
    """Source: manual chapter 3, 1."""
    cell = start(size=256, plc_size=48)
    cell.run("500ms")
    assert _leds(cell) == (Led.GREEN_FLASHING, Led.GREEN_FLASHING)


def test_the_leds_show_the_error_state_also_when_the_master_does_not_operate() -> None:
    """The LEDs show the error if the master has never operated, or has stopped.

    Source: manual chapter 3, 1; chapter 4, 2.
    """
    master = Master()
    shown = []
    for connected in (False, True, False):
        master.connected = connected
        master.run(300)
        shown.append((master.robot.module_led, master.robot.network_led))
    assert shown == [
        (Led.GREEN_FLASHING, Led.GREEN_FLASHING),
        (Led.GREEN, Led.GREEN),
        (Led.GREEN_FLASHING, Led.RED_FLASHING),
    ]


def test_incorrectly_connected_the_safety_connector_is_always_valid(start: Start) -> None:
    """Source: manual chapter 3, 1."""
    cell = start(size=256, plc_size=48)
    cell.run("500ms")
    cell.cell.inject("emergency_stop")
    cell.run("50ms")
    assert "12.600" in cell.alarms()


@pytest.mark.parametrize(("board", "stops"), [("valid", True), ("invalid", False)])
def test_incorrectly_connected_the_stop_of_a_parallel_board_is_enabled_unless_disabled(
    start: Start, board: str, stops: bool
) -> None:
    """The stop takes effect as soon as the connection exists. Source: manual chapter 3, 1."""
    cell = start(parallel_io=board, parallel_stop=False)
    cell.cell.inject("link_down")
    cell.run("500ms")
    cell.cell.inject("link_up")
    cell.run("1s")
    assert cell.robot.machine.si06
    assert cell.robot.machine.stopped is stops
