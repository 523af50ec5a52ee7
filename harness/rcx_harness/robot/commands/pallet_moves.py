"""Pallet movement: to a work position of a pallet (guide, 4.2.5)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, last
from rcx_harness.robot.commands.moving import Moving, pace
from rcx_harness.robot.commands.planning import plan_arch, plan_ptp
from rcx_harness.robot.commands.targets import arch_of, begin, movable_places, target_of
from rcx_harness.robot.machine import Machine

__all__ = ["move_to_work_position"]

_ARCH = 0x019


@last(0x018, 0x019)
def move_to_work_position(machine: Machine, call: Call) -> Moving:
    """All axes with PTP, or in an arch."""
    places = movable_places(machine, call)
    point = machine.memory.work_point(call.values["pallet"], call.values["work"])
    target = target_of(machine, call.robot, point, places)
    how = pace(machine, call)
    if call.code == _ARCH:
        path = plan_arch(machine, call.robot, target, how, arch_of(machine, call))
    else:
        path = plan_ptp(machine, call.robot, target, how)
    return begin(machine, call, path, point.hand)
