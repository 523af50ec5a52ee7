"""The appearance of a robot as JSON: arms, limits, points, pallets, work areas and pose.

`robot.js` (rcx_harness.trace.view) draws it. Lengths are in mm, angles in degrees, in the own
coordinates of the robot: Z is positive downwards.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.controller import Controller
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.stored import ROBOTS, Point

__all__ = ["MOST_POINTS", "poses", "shapes"]

#: The greatest number of points that are drawn for a robot, and of work positions for all pallets.
MOST_POINTS = 300
_UNIT = 1000
_LEFT = 2
_TURNING = {
    True: (0, 1, 3),
    False: (3,),
}  # turning axes: of SCARA robots, of all other robots


def shapes(controller: Controller) -> list[dict[str, Any]]:
    """Return the shape of each robot of a controller, in the order of its positions in a trace.

    `robot` is the number, and `name` the type. `kind` is `scara`, `cartesian`, or `axes` if the
    robot file does not name the type. `arms` are the lengths of arms 1 and 2. Each of `axes` has
    the soft limits `low` and `high` in `unit` (`mm`, `deg`), `per` (pulses per unit), and `zero`
    [pulses]. `points` have `number`, an optional `name`, and either `mm`, the position of the tool
    in shifted coordinates, or `joints`. `pallets` have `number`, and `corners` and `places` as
    positions like `mm`. `areas` have a `name`, and opposite corners `from` and `to`. Empty entries
    are left out. A robot without a type has only its axes.
    """
    arms = [controller.machine.arm(robot) for robot in range(1, ROBOTS + 1)]
    return [_shape(one, controller.machine.memory) for one in arms if one.indices]


def poses(controller: Controller) -> list[dict[str, Any]]:
    """Return the settings of each robot that change its appearance, without default values.

    `left` means that the arm is left-handed. `shift` is the selected shift. `hand` has data 1 to 3
    of the selected hand in mm, then 1 if the hand is on the R axis. If the hand of a SCARA robot is
    not on the R axis, data 1 is in degrees.
    """
    arms = [controller.machine.arm(robot) for robot in range(1, ROBOTS + 1)]
    return [_pose(one, controller.machine.memory) for one in arms if one.indices]


def _pose(arm: Arm, memory: Memory) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if arm.model and arm.model.scara and arm.hand_system == _LEFT:
        found["left"] = True
    shift = memory.shift(arm.settings.shift)
    if any(shift):
        found["shift"] = [value / _UNIT for value in shift]
    hand = memory.hand(arm.number, arm.settings.hand)
    if any(hand.data[:3]):
        first, *more = hand.data[:3]
        beside = arm.model and arm.model.scara and not hand.on_r_axis
        per = arm.axes[1].pulses_per_mm if beside else _UNIT
        found["hand"] = [first / per, *(value / _UNIT for value in more), hand.data[3]]
    return found


def _shape(arm: Arm, memory: Memory) -> dict[str, Any]:
    model = arm.model
    kind = "axes" if model is None else "scara" if model.scara else "cartesian"
    turning = _TURNING[kind == "scara"]
    axes = [
        {
            "unit": "deg" if place in turning else "mm",
            "low": _in_units(axis.soft_low - axis.zero, axis.pulses_per_mm),
            "high": _in_units(axis.soft_high - axis.zero, axis.pulses_per_mm),
            "per": axis.pulses_per_mm,
            "zero": axis.zero,
        }
        for place, axis in enumerate(arm.axes)
    ]
    shape: dict[str, Any] = {"robot": arm.number, "kind": kind, "axes": axes}
    if model is not None:
        points = sorted(memory.points.items())[:MOST_POINTS]
        areas = arm.config.work_areas.items()
        shape |= {
            "name": model.name,
            "arms": list(model.arms),
            "points": [_point(arm, *one, memory.comments.get(one[0], "")) for one in points],
            "pallets": list(_pallets(memory)),
            "areas": [{"name": name, "from": [*one], "to": [*two]} for name, (one, two) in areas],
        }
    return {name: value for name, value in shape.items() if value not in ("", [])}


def _in_units(pulses: float, per: float) -> float:
    return round(pulses / per, 3)


def _point(arm: Arm, number: int, point: Point, name: str) -> dict[str, Any]:
    shown: dict[str, Any] = {"number": number}
    if name:
        shown["name"] = name
    if point.mm:
        return shown | {"mm": [value / _UNIT for value in point.data[:4]]}
    pairs = zip(point.data, arm.axes, strict=False)
    joints = [_in_units(value - axis.zero, axis.pulses_per_mm) for value, axis in pairs]
    return shown | {"joints": joints}


def _pallets(memory: Memory) -> Iterator[dict[str, Any]]:
    """Yield the pallets whose points are in mm. Each robot has the same pallets."""
    room = MOST_POINTS
    for number, pallet in sorted(memory.pallets.items()):
        corners = [memory.points.get(pallet.first + k) for k in (0, 1, 3, 2)]
        if not all(corner is not None and corner.mm for corner in corners):
            continue
        try:
            works = range(1, 1 + min(pallet.count, room))
            places = [memory.work_point(number, work) for work in works]
        except CommandError:
            continue
        room -= len(places)
        yield {
            "number": number,
            "corners": [[value / _UNIT for value in one.data[:3]] for one in corners if one],
            "places": [[value / _UNIT for value in one.data[:3]] for one in places],
        }
