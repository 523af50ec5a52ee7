"""Category 2: definition and reference (guide, 4.3)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.config import Point
from rcx_harness.robot.machine import Machine

__all__ = ["read_point", "write_point"]

_TURNS = {1: 1, 15: -1}  # four bits to arm rotation; all other patterns mean 0


@act(0x100)
def write_point(machine: Machine, call: Call) -> Response:
    """Define a point (4.3.1). Hand and arm rotation count only in millimetres."""
    values = call.values
    mm = bool(values["unit"])
    machine.points[values["point"]] = Point(
        data=values["positions"],
        mm=mm,
        hand=values["hand"] % 3 if mm else 0,  # 3 is none, as 0
        arm1=_TURNS.get(values["arm1"], 0) if mm else 0,
        arm2=_TURNS.get(values["arm2"], 0) if mm else 0,
    )
    return {}


@act(0x101)
def read_point(machine: Machine, call: Call) -> Response:
    """Give a point back in its own unit (4.3.1)."""
    number = call.values["point"]
    point = machine.points.get(number)
    if point is None:
        raise CommandError(machine.config.undefined_point_alarm)
    return {
        "point": number,
        "unit": int(point.mm),
        "hand": point.hand,
        "arm1": point.arm1 & 0xF,
        "arm2": point.arm2 & 0xF,
        "positions": point.data,
    }
