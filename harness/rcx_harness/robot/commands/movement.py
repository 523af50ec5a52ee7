"""MOVE: to an absolute position (guide, 4.2.1)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, last
from rcx_harness.robot.commands.moving import Moving, pace
from rcx_harness.robot.commands.planning import (
    plan_arc,
    plan_arch,
    plan_line,
    plan_ptp,
    pulses_of,
)
from rcx_harness.robot.commands.targets import arch_of, begin, movable_places, target_of
from rcx_harness.robot.machine import Machine

__all__ = ["move_arch", "move_circular", "move_direct", "move_to_point"]

_LINEAR = 0x003
_DIRECT_MM = 0x006
_R_ONLY = (3,)  # places, from 0 on
_R_AND_ARM = (0, 1, 3)


@last(0x001, 0x003)
def move_to_point(machine: Machine, call: Call) -> Moving:
    """PTP or linear interpolation to a point."""
    places = movable_places(machine, call)
    point = machine.memory.point(call.values["point"])
    target = target_of(machine, call.robot, point, places)
    plan = plan_line if call.code == _LINEAR else plan_ptp
    return begin(machine, call, plan(machine, call.robot, target, pace(machine, call)), point.hand)


@last(0x002)
def move_arch(machine: Machine, call: Call) -> Moving:
    """In an arch to a point; an arch axis that is not designated comes back to where it was."""
    places = movable_places(machine, call)
    point = machine.memory.point(call.values["point"])
    arch = arch_of(machine, call)
    target = target_of(machine, call.robot, point, places)
    path = plan_arch(machine, call.robot, target, pace(machine, call), arch)
    return begin(machine, call, path, point.hand)


@last(0x004)
def move_circular(machine: Machine, call: Call) -> Moving:
    """On an arc through the first point to the second one, with all axes."""
    places = movable_places(machine, call)
    points = [machine.memory.point(call.values[name]) for name in ("point1", "point2")]
    via, target = (target_of(machine, call.robot, point, places) for point in points)
    path = plan_arc(machine, call.robot, via, target, pace(machine, call))
    return begin(machine, call, path, points[1].hand)


@last(0x006, 0x007)
def move_direct(machine: Machine, call: Call) -> Moving:
    """PTP to a position in the command; axis 4 of a SCARA robot takes axes 1 and 2 along in mm."""
    mm = call.code == _DIRECT_MM
    places = movable_places(machine, call)
    if mm and places == _R_ONLY and call.robot in machine.config.scara_robots:
        places = _R_AND_ARM
    pulses = pulses_of(machine, call.robot, call.values["targets"], mm=mm)
    target = {place: pulses[place] for place in places}
    path = plan_ptp(machine, call.robot, target, pace(machine, call))
    return begin(machine, call, path, call.values.get("hand", 0) % 3)  # 3 is none, as 0
