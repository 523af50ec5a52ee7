"""Categories 7 and 8: clock, alarm reset, accumulated data, real time output (guide, 4.8, 4.9)."""

from __future__ import annotations

from dataclasses import asdict

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.data import Definition
from rcx_harness.robot.machine import Machine


@act(0x602)
def set_date(machine: Machine, call: Call) -> None:
    """Set the date (4.8.1); end with an alarm if the date does not exist."""
    values = call.values
    try:
        machine.data.clock.set_date(machine.now_us, values["year"], values["month"], values["day"])
    except ValueError:
        raise CommandError(machine.config.impossible_date_alarm) from None


@act(0x603)
def set_time(machine: Machine, call: Call) -> None:
    """Set the time of the controller's clock (4.8.2)."""
    hour, minute, second = (call.values[name] for name in ("hour", "minute", "second"))
    machine.data.clock.set_time(machine.now_us, hour, minute, second)


@act(0x604)
def reset_alarm(machine: Machine, call: Call) -> None:
    """Reset the alarms (4.8.3); a remaining alarm ends the command with its own number."""
    remaining = machine.reset_alarms()
    if remaining:
        raise CommandError(remaining)


@act(0x605)
def reset_motor_data(machine: Machine, call: Call) -> None:
    """Reset one kind of accumulated data of one motor or of all motors (4.8.4)."""
    config = machine.config
    of_all = config.motor_data_of_all_robots
    motors = range(len(config.axes)) if of_all else call.arm.indices
    indices = call.indices or motors
    machine.data.accumulated.reset_motors(indices, call.values["item"])


@act(0x606)
def reset_system_data(machine: Machine, call: Call) -> None:
    """Reset one kind of accumulated data of the controller (4.8.5)."""
    machine.data.accumulated.reset_system(call.values["item"])


@act(0x607)
def reset_all_data(machine: Machine, call: Call) -> None:
    """Reset all accumulated data (4.8.6)."""
    machine.data.accumulated.reset_motors(range(len(machine.config.axes)))
    machine.data.accumulated.reset_system()


@act(0x701)
def define(machine: Machine, call: Call) -> None:
    """Define the content of a word of the real time output (4.9.1)."""
    values = call.values
    definition = Definition(values["item"], values["option1"], values["option2"])
    if not definition.sound(machine.config):
        raise CommandError(machine.config.no_axis_alarm)
    machine.data.real_time.define(values["output_word"], definition)


@act(0x702)
def read_definition(machine: Machine, call: Call) -> Response:
    """Return the definition of a word of the real time output (4.9.2); item 0: not defined."""
    word = call.values["output_word"]
    definition = machine.data.real_time.definitions.get(word, Definition())
    return {"output_word": word, **asdict(definition)}


@act(0x703)
def enable(machine: Machine, call: Call) -> None:
    """Start or stop the real time output of the defined words (4.9.3)."""
    machine.data.real_time.enable(bool(call.values["enabled"]))
