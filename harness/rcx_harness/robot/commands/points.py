"""Point data, and what is made of other points (guide, 4.3.1 and 4.4.3)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Point

__all__ = ["add_point", "assign_pallet_point", "assign_point", "read_point", "write_point"]

_TURNS = {1: 1, 15: -1}  # four bits to arm rotation; all other patterns mean 0
_SUBTRACT = 0x235


@act(0x100)
def write_point(machine: Machine, call: Call) -> Response:
    """Define a point (4.3.1); hand and arm rotation count only in mm, and with a SCARA robot."""
    values = call.values
    mm = bool(values["unit"])
    scara = mm and bool(machine.config.scara_robots)
    machine.points[values["point"]] = Point(
        data=values["positions"],
        mm=mm,
        hand=values["hand"] % 3 if scara else 0,  # 3 is none, as 0
        arm1=_TURNS.get(values["arm1"], 0) if scara else 0,
        arm2=_TURNS.get(values["arm2"], 0) if scara else 0,
    )
    return {}


@act(0x101)
def read_point(machine: Machine, call: Call) -> Response:
    """Give a point back in its own unit (4.3.1)."""
    number = call.values["point"]
    point = machine.memory.point(number)
    return {
        "point": number,
        "unit": int(point.mm),
        "hand": point.hand,
        "arm1": point.arm1 & 0xF,
        "arm2": point.arm2 & 0xF,
        "positions": point.data,
    }


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
