"""MOVET: to a position in tool coordinates (guide, 4.2.21)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, last
from rcx_harness.robot.commands.moving import Moving, pace
from rcx_harness.robot.commands.planning import frame_of, here, plan_line, plan_ptp
from rcx_harness.robot.commands.targets import begin, movable_places
from rcx_harness.robot.machine import Machine

__all__ = ["move_in_tool_coordinates"]

_LINEAR = 0x045


@last(0x044, 0x045)
def move_in_tool_coordinates(machine: Machine, call: Call) -> Moving:
    """From where the tool is, by the point's data along the axes of the tool.

    The designated axes are those of the tool: the robot's axes move as these need them.
    """
    robot, places = call.robot, movable_places(machine, call)
    point = machine.memory.point(call.values["point"])
    axes = [machine.config.axes[index] for index in machine.config.axes_of(robot)]
    way = [0.0] * len(axes)
    for place in places:
        scale = 1 if point.mm else 1000 / axes[place].pulses_per_mm
        way[place] = point.data[place] * scale
    frame = frame_of(machine, robot)
    start = here(machine, robot)
    ends = frame.to_pulses(frame.tool_to_mm(frame.to_mm(start), way))
    target = {
        place: round(end)
        for place, end in enumerate(ends)
        if place in places or round(end) != start[place]
    }
    plan = plan_line if call.code == _LINEAR else plan_ptp
    return begin(machine, call, plan(machine, robot, target, pace(machine, call)), point.hand)
