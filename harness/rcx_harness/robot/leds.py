"""The two LEDs of the EtherNet/IP module (manual chapter 1, 3 and chapter 4, 2)."""

from __future__ import annotations

from enum import Enum

from rcx_harness.robot.machine import Machine

__all__ = ["Led", "module_led", "network_led"]


class Led(Enum):
    """What an LED shows."""

    OFF = "off"
    GREEN = "green"
    GREEN_FLASHING = "green, flashing"
    RED = "red"
    RED_FLASHING = "red, flashing"
    SELF_TEST = "green and red, flashing"


def module_led(machine: Machine) -> Led:
    """Module Status: power, self-test, fault, connection with the master."""
    if not machine.booted:
        return Led.SELF_TEST if machine.powered else Led.OFF
    config = machine.config
    if any(machine.alarms.has(number) for number in config.module_fault_alarms):
        return Led.RED
    if any(machine.alarms.has(number) for number in config.module_error_alarms):
        return Led.RED_FLASHING
    return Led.GREEN if machine.link == "normal" else Led.GREEN_FLASHING


def network_led(machine: Machine) -> Led:
    """Network Status: power, self-test, IP address, connection, time-out."""
    address = machine.config.ip_address
    if not machine.booted and machine.powered:
        return Led.SELF_TEST
    if not machine.powered or address == "none":
        return Led.OFF
    if address == "duplicate":
        return Led.RED
    states = {"normal": Led.GREEN, "lost": Led.RED_FLASHING}
    return states.get(machine.link, Led.GREEN_FLASHING)
