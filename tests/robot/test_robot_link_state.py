"""LEDs, IP address, parallel I/O board and emergency stops work as in chapter 1, 3 to 5."""

from __future__ import annotations

import pytest

from rcx_harness.robot import Led
from robot_master import Master, powered_up, servos_on


def _leds(master: Master) -> tuple[Led, Led]:
    return master.robot.module_led, master.robot.network_led


def _numbers(master: Master) -> list[str]:
    return [alarm.number for alarm in master.robot.alarms.active]


def test_the_leds_show_power_on_loss_and_recovery_of_the_connection() -> None:
    """Rule: leds. Source: manual chapter 1, 3; chapter 4, 2."""
    master = Master(boot_time=100, booted=False)
    master.connected = False
    master.run(50)
    assert _leds(master) == (Led.SELF_TEST, Led.SELF_TEST)
    master.run(100)
    assert _leds(master) == (Led.GREEN_FLASHING, Led.GREEN_FLASHING)
    master.connected = True
    master.run(10)
    assert _leds(master) == (Led.GREEN, Led.GREEN)
    master.connected = False
    master.run(10)
    assert _leds(master) == (Led.GREEN_FLASHING, Led.RED_FLASHING)
    master.connected = True
    master.run(10)
    assert _leds(master) == (Led.GREEN, Led.GREEN)
    master.robot.inject("power_off")
    assert _leds(master) == (Led.OFF, Led.OFF)


@pytest.mark.parametrize(
    ("category", "led"), [(762, Led.RED), (763, Led.RED_FLASHING), (600, Led.GREEN)]
)
def test_module_status_shows_faults_of_the_module(category: int, led: Led) -> None:
    """Rule: leds, module-faults."""
    master = powered_up()
    master.robot.inject("alarm", group=12, category=category)
    assert master.robot.module_led is led


@pytest.mark.parametrize(("address", "led"), [("none", Led.OFF), ("duplicate", Led.RED)])
def test_without_an_ip_address_of_its_own_there_is_no_connection(address: str, led: Led) -> None:
    """Rule: conditions, leds, power-on-state. Source: manual chapter 3, 1; chapter 1, 3."""
    master = powered_up(ip_address=address)
    assert _leds(master) == (Led.GREEN_FLASHING, led)
    assert not master.robot.online
    assert _numbers(master) == ["12.551"]
    assert master.on("SO00")


@pytest.mark.parametrize("connected", [True, False])
def test_the_safety_connector_stops_with_and_without_a_connection(connected: bool) -> None:
    """The connector causes an alarm even if SI(00) has already stopped the robot.

    Rule: emergency-terminal, emergency-terminal-alarm.
    Source: manual chapter 1, 5; chapter 4, 4
    """
    master = Master()
    master.connected = connected
    master.run(300)
    master.robot.inject("emergency_stop")
    master.run(10)
    assert "12.600" in _numbers(master)
    master.connected = True
    master.turn_and_wait("SI00", True)
    assert master.on("SO00")
    master.robot.inject("emergency_stop_release")
    master.run(10)
    assert not master.on("SO00")


def test_a_power_on_with_the_safety_connector_open_is_an_alarm() -> None:
    """Rule: emergency-terminal-alarm."""
    master = Master()
    master.run(10)
    master.robot.inject("emergency_stop")
    master.robot.inject("power_cycle")
    assert _numbers(master) == []
    master.run(300)
    assert _numbers(master) == ["12.600"]


def test_an_emergency_stop_in_the_boot_is_an_alarm_at_its_end() -> None:
    """Rule: emergency-terminal-alarm, boot."""
    master = Master(boot_time=100, booted=False)
    master.run(50)
    master.robot.inject("emergency_stop")
    master.run(45)
    assert _numbers(master) == []
    master.run(20)
    assert _numbers(master) == ["12.600"]
    assert [alarm.t_us for alarm in master.robot.alarms.history] == [100_000]


def test_si00_and_si06_are_those_of_the_master_again_after_recovery() -> None:
    """Rule: link-recovery. Source: manual chapter 1, 5.2."""
    master = powered_up()
    master.connected = False
    master.run(50)
    assert (master.robot.machine.si00, master.robot.machine.si06) == (False, False)
    master.connected = True
    master.run(50)
    assert (master.robot.machine.si00, master.robot.machine.si06) == (True, True)


@pytest.mark.parametrize(("state", "stopped"), [("valid", True), ("invalid", False)])
def test_the_parallel_board_has_no_dedicated_input_but_its_stop(state: str, stopped: bool) -> None:
    """DI01 and DI12 have no effect. DI06 stops the robot if the board is valid.

    Rule: parallel-inputs, parallel-stop.
    Source: manual chapter 1, 4.1
    """
    master = powered_up(parallel_io=state)
    for port in (1, 12, 14, 15, 17):
        master.robot.inject("parallel_input", port=port, on=1)
        master.run(600)
    assert not master.on("SO02")
    assert not master.on("SO13")
    master.pulse("SI12")
    assert master.on("SO13")
    master.robot.inject("parallel_input", port=12, on=0)
    master.run(50)
    assert master.on("SO13")
    master.robot.inject("parallel_input", port=6, on=0)
    master.run(50)
    assert master.on("SO13") is not stopped


def test_auto_mode_needs_both_switches_and_its_time() -> None:
    """Rule: auto-switches, answers. Source: manual chapter 5, 3.2, AUTO mode changeover."""
    master = powered_up(auto_mode=False, auto_mode_delay=50)
    master.robot.inject("auto_input_on")
    master.run(100)
    assert not master.on("SO10")
    master.robot.inject("manual_lock_off")
    master.run(45)
    assert not master.on("SO10")
    master.run(10)
    assert master.on("SO10")
    master.robot.inject("manual_lock_on")
    master.run(5)
    assert not master.on("SO10")
    master.robot.inject("manual_lock_off")
    master.run(5)
    master.robot.inject("auto_input_off")
    master.run(100)
    assert not master.on("SO10")


def test_auto_mode_comes_its_time_after_the_last_change() -> None:
    """Rule: auto-switches, answers."""
    master = powered_up(auto_mode=False, auto_mode_delay=100)
    master.robot.inject("auto_mode")
    master.run(60)
    master.robot.inject("manual_lock_on")
    master.run(20)
    master.robot.inject("manual_lock_off")
    master.run(90)
    assert not master.on("SO10")
    master.run(15)
    assert master.on("SO10")


def test_after_a_power_cycle_an_earlier_connection_loss_has_no_effect() -> None:
    """After a power cycle without a connection, the controller counts as never connected.

    The Network Status LED is green, and the alarm is 12.551.

    Rule: leds, link-error-at-power-on.
    Source: manual chapter 1, 3 and 5.3
    """
    master = powered_up()
    master.connected = False
    master.run(10)
    assert _leds(master)[1] is Led.RED_FLASHING
    master.robot.inject("power_cycle")
    master.run(500)
    assert _leds(master)[1] is Led.GREEN_FLASHING
    assert _numbers(master) == ["12.551"]


def test_without_main_power_there_is_no_servo_on() -> None:
    """Rule: mp-ready-power, main-power. Source: manual chapter 5, 2, SO(04)."""
    master = servos_on()
    master.robot.inject("main_power_off")
    master.run(5)
    assert (master.on("SO02"), master.on("SO03"), master.on("SO04")) == (False, False, False)
    master.pulse("SI01")
    assert not master.on("SO02")
    master.robot.inject("main_power_on")
    master.run(5)
    assert master.on("SO04")
    master.pulse("SI01")
    assert master.on("SO02")


def test_the_alarm_history_keeps_the_latest_alarms_with_their_time() -> None:
    """Rule: history."""
    master = Master(alarm_history_length=2)
    master.run(300)
    for category in (701, 702, 703):
        master.robot.inject("alarm", group=17, category=category)
        master.run(10)
    found = [(alarm.number, alarm.t_us) for alarm in master.robot.alarms.history]
    assert found == [("17.702", 305_000), ("17.703", 315_000)]
