"""Categories 2 and 3: stored data, and operations on them (guide, 4.3 and 4.4)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.controller_memory import is_real
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Hand, Pallet, Point, from_bits, parameter_names, to_bits

_LENGTH = 16
_OPERATORS = {0x204: "+", 0x208: "-", 0x20C: "*", 0x210: "/"}
#: Maps each payload parameter to the number of its units (kg or g) in one kg.
_PAYLOADS = {"WEIGHT": 1, "WEIGHTG": 1000, "AXWGHT": 1}
_SUBTRACT = 0x235
_MM = 0x241


@act(0x100)
def write_point(machine: Machine, call: Call) -> None:
    """Define a point (4.3.1); hand and arm rotation are stored only in mm and for SCARA robots."""
    point = Point.of(call.values)
    if not (point.mm and machine.config.scara_robots):
        point = Point(point.data, point.mm)
    machine.points[call.values["point"]] = point


@act(0x101)
def read_point(machine: Machine, call: Call) -> Response:
    """Return a point in the unit in which it is stored (4.3.1)."""
    number = call.values["point"]
    return {"point": number, **machine.memory.point(number).fields}


@act(0x104)
def write_comment(machine: Machine, call: Call) -> None:
    """Define the comment of a point; the point itself need not be defined."""
    machine.memory.comments[call.values["point"]] = call.values["comment"].rstrip(" ")


@act(0x105)
def read_comment(machine: Machine, call: Call) -> Response:
    """Return the comment of a point, padded at its end to the length of the field."""
    number = call.values["point"]
    filler = "\0" if machine.config.comment_filler == "zeros" else " "
    return {"point": number, "comment": machine.memory.comment(number).ljust(_LENGTH, filler)}


@act(0x108)
def write_pallet(machine: Machine, call: Call) -> None:
    """Define a pallet. Its points are not checked before a work position is used."""
    machine.memory.pallets[call.values["pallet"]] = Pallet.of(call.values)


@act(0x109)
def read_pallet(machine: Machine, call: Call) -> Response:
    """Return the definition of a pallet."""
    number = call.values["pallet"]
    return {"pallet": number, **machine.memory.pallet(number).fields}


@act(0x10C)
def write_shift(machine: Machine, call: Call) -> None:
    """Define a shift of the coordinates (4.3.4)."""
    machine.memory.shifts[call.values["shift"]] = call.values["shift_data"]


@act(0x10D)
def read_shift(machine: Machine, call: Call) -> Response:
    """Return the data of a shift (4.3.4)."""
    number = call.values["shift"]
    return {"shift": number, "shift_data": machine.memory.shift(number)}


@act(0x110)
def write_hand(machine: Machine, call: Call) -> None:
    """Define a hand of a robot; the data of the hand are stored as received."""
    key = call.arm.number, call.values["hand_number"]
    machine.memory.hands[key] = Hand.of(call.values)


@act(0x111)
def read_hand(machine: Machine, call: Call) -> Response:
    """Return a hand of a robot, with the number of the robot."""
    number = call.values["hand_number"]
    hand = machine.memory.hand(call.arm.number, number)
    return {"hand_number": number, "robot_number": call.arm.number, **hand.fields}


@act(0x200, 0x204, 0x208, 0x20C, 0x210)
def assign_value(machine: Machine, call: Call) -> None:
    """Set variable 1 to a value, or to variable 1 (+ - * /) value."""
    number, raw = call.values["variable1"], call.values["value"]
    value = from_bits(raw) if is_real(number) else raw
    if not math.isfinite(value):
        raise CommandError(machine.config.format_alarm)
    _put(machine, call.code, number, value)


@act(0x201, 0x205, 0x209, 0x20D, 0x211)
def assign_variable(machine: Machine, call: Call) -> None:
    """Set variable 1 to variable 2, or to variable 1 (+ - * /) variable 2."""
    value = machine.memory.variables.value(call.values["variable2"])
    _put(machine, call.code & ~1, call.values["variable1"], value)


@act(0x214)
def read_variable(machine: Machine, call: Call) -> Response:
    """Return the value of a variable; a real number is returned as its 32 bits."""
    number = call.values["variable"]
    value = machine.memory.variables.value(number)
    return {"variable": number, "value": to_bits(value) if is_real(number) else value}


@act(0x220)
def write_parameter(machine: Machine, call: Call) -> None:
    """Set a parameter to a value; a payload may not exceed the maximum payload."""
    name, axis, value = _name(call), _axis(call), call.values["value"]
    if name in _PAYLOADS and value > machine.config.max_payload * _PAYLOADS[name]:
        raise CommandError(machine.config.format_alarm)
    machine.memory.parameters.set(call.arm.number, name, value, axis)


@act(0x224)
def read_parameter(machine: Machine, call: Call) -> Response:
    """Return the value of a parameter."""
    value = call.arm.parameter(_name(call), _axis(call))
    asked = {key: call.values[key] for key in ("parameter", "axes")}
    return {**asked, "value": value}


@act(0x230)
def assign_point(machine: Machine, call: Call) -> None:
    """Copy point 2 to point 1, including its hand and arm rotation."""
    machine.points[call.values["point1"]] = machine.memory.point(call.values["point2"])


@act(0x234, 0x235)
def add_point(machine: Machine, call: Call) -> None:
    """Set point 1 to point 1 + point 2, or to point 1 - point 2.

    Point 1 keeps its hand and arm rotation.
    """
    memory = machine.memory
    first, second = memory.point(call.values["point1"]), memory.point(call.values["point2"])
    if first.mm != second.mm:
        raise CommandError(machine.config.point_unit_alarm)
    sign = -1 if call.code == _SUBTRACT else 1
    data = tuple(a + sign * b for a, b in zip(first.data, second.data, strict=True))
    memory.points[call.values["point1"]] = memory.changed(first, data)


@act(0x238)
def assign_pallet_point(machine: Machine, call: Call) -> None:
    """Set a point to a work position of a pallet."""
    values = call.values
    machine.points[values["point"]] = machine.memory.work_point(values["pallet"], values["work"])


@act(0x240, 0x241)
def assign_point_element(machine: Machine, call: Call) -> None:
    """Set one element of a point to a value that has the unit of the point."""
    memory, number = machine.memory, call.values["point"]
    point = memory.point(number)
    if point.mm != (call.code == _MM):
        raise CommandError(machine.config.point_unit_alarm)
    memory.points[number] = memory.changed(point, _replaced(machine, call, point.data))


@act(0x245)
def assign_shift_element(machine: Machine, call: Call) -> None:
    """Set one element of a shift to a value."""
    number = call.values["shift"]
    one, two, three, four = _replaced(machine, call, machine.memory.shift(number))
    machine.memory.shifts[number] = (one, two, three, four)


def _put(machine: Machine, code: int, number: int, value: float) -> None:
    operator = _OPERATORS.get(code)
    if operator:
        machine.memory.variables.calculate(number, operator, value)
    else:
        machine.memory.variables.assign(number, value)


def _name(call: Call) -> str:
    return parameter_names()[call.values["parameter"]]


def _axis(call: Call) -> int:
    """Return the index of the axis in the robot, 0 to 5; 0 for a parameter of the whole robot."""
    places = call.places
    return places[0] if places else 0


def _replaced(machine: Machine, call: Call, data: Sequence[int]) -> tuple[int, ...]:
    """Return a copy of the data in which the elements of the data number have the new value."""
    bits, value = call.values["data_number"], call.values["value"]
    if bits & (bits - 1) and not machine.config.several_elements:
        raise CommandError(machine.config.format_alarm)
    return tuple(value if bits >> k & 1 else old for k, old in enumerate(data))
