"""Category 7: alarm reset and accumulated data (guide, 4.8.3 to 4.8.6)."""

from __future__ import annotations

from rcx_harness.robot.commands.axes import chosen_axes
from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["reset_alarm", "reset_all_data", "reset_motor_data", "reset_system_data"]


@act(0x604)
def reset_alarm(machine: Machine, call: Call) -> Response:
    """Reset the alarms (4.8.3); an alarm that stays ends the command with its own number."""
    remaining = machine.reset_alarms()
    if remaining:
        raise CommandError(remaining)
    return {}


@act(0x605)
def reset_motor_data(machine: Machine, call: Call) -> Response:
    """Reset one kind of accumulated data of one motor or of all (4.8.4)."""
    config = machine.config
    of_all = config.motor_data_of_all_robots
    motors = range(len(config.axes)) if of_all else config.axes_of(call.robot)
    indices = chosen_axes(machine, call) or motors
    machine.data.accumulated.reset_motors(indices, call.values["item"])
    return {}


@act(0x606)
def reset_system_data(machine: Machine, call: Call) -> Response:
    """Reset one kind of accumulated data of the controller (4.8.5)."""
    machine.data.accumulated.reset_system(call.values["item"])
    return {}


@act(0x607)
def reset_all_data(machine: Machine, call: Call) -> Response:
    """Reset all accumulated data (4.8.6)."""
    machine.data.accumulated.reset_motors(range(len(machine.config.axes)))
    machine.data.accumulated.reset_system()
    return {}
