"""Category 3: variables, parameters, operations with points and elements (guide, 4.4)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.memory import is_real
from rcx_harness.robot.stored import from_bits, parameter_names, to_bits

_OPERATORS = {0x204: "+", 0x208: "-", 0x20C: "*", 0x210: "/"}
#: Grams or kilograms in one kg of the maximum payload.
_PAYLOADS = {"WEIGHT": 1, "WEIGHTG": 1000, "AXWGHT": 1}
_SUBTRACT = 0x235
_MM = 0x241


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


@act(0x220)
def write_parameter(machine: Machine, call: Call) -> Response:
    """Assign a value; a payload is at most the maximum payload."""
    name, axis, value = _name(call), _axis(call), call.values["value"]
    if name in _PAYLOADS and value > machine.config.max_payload * _PAYLOADS[name]:
        raise CommandError(machine.config.format_alarm)
    machine.memory.parameters.set(call.arm.number, name, value, axis)
    return {}


@act(0x224)
def read_parameter(machine: Machine, call: Call) -> Response:
    """Give the value of a parameter back."""
    value = call.arm.parameter(_name(call), _axis(call))
    asked = {key: call.values[key] for key in ("parameter", "axes")}
    return {**asked, "value": value}


@act(0x230)
def assign_point(machine: Machine, call: Call) -> Response:
    """Point 1 = point 2, with all that belongs to its data."""
    machine.points[call.values["point1"]] = machine.memory.point(call.values["point2"])
    return {}


@act(0x234, 0x235)
def add_point(machine: Machine, call: Call) -> Response:
    """Point 1 = point 1 + point 2 or point 1 - point 2; point 1 keeps its hand and arm rotation."""
    memory = machine.memory
    first, second = memory.point(call.values["point1"]), memory.point(call.values["point2"])
    if first.mm != second.mm:
        raise CommandError(machine.config.point_unit_alarm)
    sign = -1 if call.code == _SUBTRACT else 1
    data = tuple(a + sign * b for a, b in zip(first.data, second.data, strict=True))
    memory.points[call.values["point1"]] = memory.changed(first, data)
    return {}


@act(0x238)
def assign_pallet_point(machine: Machine, call: Call) -> Response:
    """Point = work position of a pallet."""
    values = call.values
    machine.points[values["point"]] = machine.memory.work_point(values["pallet"], values["work"])
    return {}


@act(0x240, 0x241)
def assign_point_element(machine: Machine, call: Call) -> Response:
    """Assign a value to one element of a point that has the same unit."""
    memory, number = machine.memory, call.values["point"]
    point = memory.point(number)
    if point.mm != (call.code == _MM):
        raise CommandError(machine.config.point_unit_alarm)
    memory.points[number] = memory.changed(point, _replaced(machine, call, point.data))
    return {}


@act(0x245)
def assign_shift_element(machine: Machine, call: Call) -> Response:
    """Assign a value to one element of a shift."""
    number = call.values["shift"]
    one, two, three, four = _replaced(machine, call, machine.memory.shift(number))
    machine.memory.shifts[number] = (one, two, three, four)
    return {}


def _put(machine: Machine, code: int, number: int, value: float) -> None:
    operator = _OPERATORS.get(code)
    if operator:
        machine.memory.variables.calculate(number, operator, value)
    else:
        machine.memory.variables.assign(number, value)


def _name(call: Call) -> str:
    return parameter_names()[call.values["parameter"]]


def _axis(call: Call) -> int:
    """Place of the axis in the robot; 0 for a parameter of the robot."""
    places = call.places
    return places[0] if places else 0


def _replaced(machine: Machine, call: Call, data: Sequence[int]) -> tuple[int, ...]:
    """The data with the value in the place (or places) that the data number designates."""
    bits, value = call.values["data_number"], call.values["value"]
    if bits & (bits - 1) and not machine.config.several_elements:
        raise CommandError(machine.config.format_alarm)
    return tuple(value if bits >> k & 1 else old for k, old in enumerate(data))
