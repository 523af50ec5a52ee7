"""Static variables SGI and SGR (guide, 4.4.1)."""

from __future__ import annotations

import math

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.numbers import from_bits, to_bits
from rcx_harness.robot.variables import is_real

__all__ = ["assign_value", "assign_variable", "read_variable"]

_OPERATORS = {0x204: "+", 0x208: "-", 0x20C: "*", 0x210: "/"}


@act(0x200, 0x204, 0x208, 0x20C, 0x210)
def assign_value(machine: Machine, call: Call) -> Response:
    """Variable 1 = value, or variable 1 = variable 1 (+ - * /) value."""
    number, raw = call.values["variable1"], call.values["value"]
    value = from_bits(raw) if is_real(number) else raw
    if not math.isfinite(value):
        raise CommandError(machine.config.format_alarm)
    _put(machine, call.code, number, value)
    return {}


@act(0x201, 0x205, 0x209, 0x20D, 0x211)
def assign_variable(machine: Machine, call: Call) -> Response:
    """Variable 1 = variable 2, or variable 1 = variable 1 (+ - * /) variable 2."""
    value = machine.memory.variables.value(call.values["variable2"])
    _put(machine, call.code & ~1, call.values["variable1"], value)
    return {}


@act(0x214)
def read_variable(machine: Machine, call: Call) -> Response:
    """Give the value of a variable back; a real number as its bits."""
    number = call.values["variable"]
    value = machine.memory.variables.value(number)
    return {"variable": number, "value": to_bits(value) if is_real(number) else value}


def _put(machine: Machine, code: int, number: int, value: float) -> None:
    operator = _OPERATORS.get(code)
    if operator:
        machine.memory.variables.calculate(number, operator, value)
    else:
        machine.memory.variables.assign(number, value)
