"""DRIVE: one axis to an absolute position (guide, 4.2.3)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, last
from rcx_harness.robot.commands.moving import Moving, pace
from rcx_harness.robot.commands.planning import place_pulses, plan_ptp
from rcx_harness.robot.commands.targets import begin, movable_places, target_of
from rcx_harness.robot.machine import Machine

__all__ = ["axis_target", "drive"]

_TO_POINT = (0x010, 0x04B)
_MM = (0x012, 0x04C)


def axis_target(machine: Machine, call: Call) -> dict[int, int]:
    """Place of the one axis, and where it is to go [pulses]: point, or position in the command.

    Raises:
        CommandError: no such axis or point, or the axis cannot move now.
    """
    places = movable_places(machine, call)
    if call.code in _TO_POINT:
        point = machine.memory.point(call.values["point"])
        return target_of(machine, call.robot, point, places)
    value, mm = call.values["target"], call.code in _MM
    return {place: place_pulses(machine, call.robot, place, value, mm=mm) for place in places}


@last(0x010, 0x012, 0x013)
def drive(machine: Machine, call: Call) -> Moving:
    """PTP with one axis."""
    target = axis_target(machine, call)
    return begin(machine, call, plan_ptp(machine, call.robot, target, pace(machine, call)))
