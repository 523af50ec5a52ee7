"""Single elements of points and shifts (guide, 4.4.4)."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["assign_point_element", "assign_shift_element"]

_MM = 0x241


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


def _replaced(machine: Machine, call: Call, data: Sequence[int]) -> tuple[int, ...]:
    """The data with the value in the place (or places) that the data number designates."""
    bits, value = call.values["data_number"], call.values["value"]
    if bits & (bits - 1) and not machine.config.several_elements:
        raise CommandError(machine.config.format_alarm)
    return tuple(value if bits >> k & 1 else old for k, old in enumerate(data))
