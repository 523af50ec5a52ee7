"""MOVEI and DRIVEI: by a distance from where the robot is (guide, 4.2.2 and 4.2.4).

A movement that was interrupted goes on to where it was to end when the same command comes again
(parameter "MOVEI/DRIVEI start position": Keep); with Reset it starts anew from where it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rcx_harness.robot.commands.base import Call, last
from rcx_harness.robot.commands.moving import Moving, Pace, pace
from rcx_harness.robot.commands.planning import beyond, plan_line, plan_ptp
from rcx_harness.robot.commands.targets import begin, movable_places
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.paths import Path

__all__ = ["drivei_direct", "move_by_point", "movei_direct"]

_Plan = Callable[[Machine, int, Mapping[int, int], Pace], Path]

_LINEAR = 0x00A
_ONE_AXIS = 0x014
_MM = (0x00E, 0x016)


@last(0x009, 0x00A, 0x014)
def move_by_point(machine: Machine, call: Call) -> Moving:
    """By the data of a point: MOVEI with PTP or linear interpolation, DRIVEI with one axis."""
    places = movable_places(machine, call)
    point = machine.memory.point(call.values["point"])
    ways = {place: point.data[place] for place in places}
    plan = plan_line if call.code == _LINEAR else plan_ptp
    hand = 0 if call.code == _ONE_AXIS else point.hand
    return _go(machine, call, ways, mm=point.mm, plan=plan, hand=hand)


@last(0x00E, 0x00F)
def movei_direct(machine: Machine, call: Call) -> Moving:
    """MOVEI by distances in the command."""
    ways = {place: call.values["distances"][place] for place in movable_places(machine, call)}
    hand = call.values.get("hand", 0) % 3  # 3 is none, as 0
    return _go(machine, call, ways, mm=call.code in _MM, hand=hand)


@last(0x016, 0x017)
def drivei_direct(machine: Machine, call: Call) -> Moving:
    """DRIVEI by the distance in the command."""
    ways = dict.fromkeys(movable_places(machine, call), call.values["distance"])
    return _go(machine, call, ways, mm=call.code in _MM)


def _go(
    machine: Machine,
    call: Call,
    ways: Mapping[int, int],
    *,
    mm: bool,
    plan: _Plan = plan_ptp,
    hand: int = 0,
) -> Moving:
    """Move each axis (by its place) by its way [pulses or 0.001 mm].

    It is the same movement again where code, axes and ways are the same; speed and output may
    differ.
    """
    again = (call.code, mm, tuple(sorted(ways.items())))
    kept = machine.motion.kept_target(call.robot, again)
    if kept is None:
        target = beyond(machine, call.robot, ways, mm=mm)
    else:
        axes = machine.config.axes_of(call.robot)
        target = {place: kept[axes[place]] for place in ways}
    path = plan(machine, call.robot, target, pace(machine, call))
    return begin(machine, call, path, hand, relative=again)
