"""Dedicated outputs, effects of the dedicated inputs, changes of the link, and the LEDs."""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from itertools import compress

from rcx_harness.robot.alarms import STOP
from rcx_harness.robot.area import OUTPUTS
from rcx_harness.robot.machine import Machine

__all__ = [
    "REQUESTS",
    "Led",
    "dedicated_outputs",
    "lose_link",
    "module_led",
    "network_led",
    "regain_link",
]

_SHOWN = ("SO00", "SO01", "SO02", "SO03", "SO04", "SO10", "SO11", "SO12", "SO13", "SO14", "SO15")
_MASKS = tuple(OUTPUTS[name] for name in _SHOWN)


class Led(Enum):
    """The states of an LED of the EtherNet/IP module (manual chapter 1, 3 and chapter 4, 2)."""

    OFF = "off"
    GREEN = "green"
    GREEN_FLASHING = "green, flashing"
    RED = "red"
    RED_FLASHING = "red, flashing"
    SELF_TEST = "green and red, flashing"


def lose_link(machine: Machine, *, in_operation: bool) -> None:
    """Process the loss of the link: SI(00), SI(06), SI(10) count as OFF (manual chapter 1, 5)."""
    config = machine.config
    machine.si00 = machine.si06 = machine.si10 = False
    machine.link = "lost" if in_operation else "none"
    if config.loss_clears_inputs:
        machine.ports.forget_inputs()
    if in_operation:
        machine.raise_alarm(config.link_loss_alarm)
    else:
        machine.schedule("link_error_delay")


def regain_link(machine: Machine) -> None:
    """Process the opening of a connection, for the first time or after a loss."""
    machine.link = "normal"
    machine.pending.pop("link_error_delay", None)
    if not machine.config.link_error_latches:
        machine.alarms.clear(machine.config.link_error_alarm)


def dedicated_outputs(machine: Machine) -> int:
    """Return ports SO0() (low byte) and SO1() as one word (manual chapter 5, 1)."""
    faults = machine.config.cpu_fault_alarms
    states = (
        machine.emergency,  # SO00
        not any(map(machine.alarms.has, faults)),  # SO01
        machine.servo_on,  # SO02
        machine.alarms.serious,  # SO03
        machine.mp_ready,  # SO04
        machine.auto_mode,  # SO10
        machine.origin_complete,  # SO11
        machine.sequence_running,  # SO12
        machine.program.running,  # SO13
        machine.program.is_reset,  # SO14
        machine.alarms.warning,  # SO15
    )
    return sum(compress(_MASKS, states))


def module_led(machine: Machine) -> Led:
    """Return the state of the Module Status LED: power, self-test, fault, connection."""
    if not machine.booted:
        return Led.SELF_TEST if machine.powered else Led.OFF
    config = machine.config
    if any(machine.alarms.has(number) for number in config.module_fault_alarms):
        return Led.RED
    if any(machine.alarms.has(number) for number in config.module_error_alarms):
        return Led.RED_FLASHING
    return Led.GREEN if machine.link == "normal" else Led.GREEN_FLASHING


def network_led(machine: Machine) -> Led:
    """Return the state of the Network Status LED: power, self-test, IP address, connection."""
    address = machine.config.ip_address
    if not machine.booted and machine.powered:
        return Led.SELF_TEST
    if not machine.powered or address == "none":
        return Led.OFF
    if address == "duplicate":
        return Led.RED
    states = {"normal": Led.GREEN, "lost": Led.RED_FLASHING}
    return states.get(machine.link, Led.GREEN_FLASHING)


# Requests of the dedicated inputs. The real controller ignores an impossible request without an
# answer, and so does this controller.


def _servo_on(machine: Machine) -> None:
    if machine.may_switch_servo_on() and not machine.servos.all_on:
        machine.schedule("servo_on_delay")


def _alarm_reset(machine: Machine) -> None:
    machine.schedule("alarm_reset_delay")


def _program_reset(machine: Machine) -> None:
    running = machine.program.busy and not machine.config.reset_while_running
    if machine.auto_mode and not running and not machine.pendant_blocks():
        machine.program.order_reset(None)
        machine.schedule("program_reset_delay")


def _program_start(machine: Machine) -> None:
    if machine.pendant_blocks() or not machine.mode_allows_start() or machine.program.running:
        return
    if machine.stopped and not machine.emergency:
        machine.raise_alarm(STOP)
    if machine.may_run_program():
        machine.program.order_start(None)
        machine.schedule("program_start_delay")


def _origin(machine: Machine, name: str) -> None:
    free = not machine.motion.under_way and not machine.origin_running
    groups = machine.origins.plan(name)
    if machine.pendant_blocks() or not free or not groups:
        return
    if machine.stopped and not machine.emergency:
        machine.raise_alarm(STOP)
    servo = machine.servos.are_on(index for group in groups for index in group)
    if machine.may_move() and (servo or not machine.config.origin_needs_servo):
        machine.return_to_origin(groups)


#: Maps a dedicated input to its request function, which is called at the OFF to ON edge.
REQUESTS: dict[str, Callable[[Machine], None]] = {
    "SI01": _servo_on,
    "SI12": _program_start,
    "SI14": lambda machine: _origin(machine, "SI14"),
    "SI15": _program_reset,
    "SI16": _alarm_reset,
    "SI17": lambda machine: _origin(machine, "SI17"),
}
