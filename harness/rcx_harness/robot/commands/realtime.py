"""Category 8: real time output (guide, 4.9)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.realtime import Definition


@act(0x701)
def define(machine: Machine, call: Call) -> Response:
    """Define what a word shows (4.9.1)."""
    values = call.values
    definition = Definition(values["item"], values["option1"], values["option2"])
    if not definition.sound(machine.config):
        raise CommandError(machine.config.no_axis_alarm)
    machine.data.real_time.define(values["output_word"], definition)
    return {}


@act(0x702)
def read_definition(machine: Machine, call: Call) -> Response:
    """What a word is defined to show (4.9.2); item 0 for nothing."""
    word = call.values["output_word"]
    definition = machine.data.real_time.definitions.get(word, Definition())
    return {
        "output_word": word,
        "item": definition.item,
        "option1": definition.option1,
        "option2": definition.option2,
    }


@act(0x703)
def enable(machine: Machine, call: Call) -> Response:
    """Put the defined words out, or no longer (4.9.3)."""
    machine.data.real_time.enable(bool(call.values["enabled"]))
    return {}
