"""Category 1: point teaching (guide, 4.2.9)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.commands.moving import positions_of
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Point

__all__ = ["teach_point"]


@act(0x028)
def teach_point(machine: Machine, call: Call) -> Response:
    """Store where the robot is as a point; axes that it does not have are 0.

    The point has no hand system and no arm rotation, as the current position reference has none.
    """
    mm = bool(call.values["unit"])
    data = positions_of(machine, call.robot, mm=mm)
    machine.points[call.values["point"]] = Point(data, mm=mm)
    return {}
