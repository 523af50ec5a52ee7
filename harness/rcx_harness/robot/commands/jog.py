"""Category 1: jog and inching in pulses, Cartesian and tool coordinates (guide, 4.2.6, 4.2.7)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import chain

from rcx_harness.robot.alarms import SOFT_LIMIT, STOP, CommandError
from rcx_harness.robot.commands.base import Call, Response, takes_time
from rcx_harness.robot.commands.moves import Moving, position_output
from rcx_harness.robot.kinematics import UnreachableError
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.motion import Movement
from rcx_harness.robot.paths import Pace, plan_line, plan_ptp

_PULSES = (0x020, 0x024)
_TOOL = (0x022, 0x026)
_R = 3
_PROBE = 1000  # 1 mm or 1 degree: far enough to find the axes that a direction moves
_STEP = 250.0  # step of the search for a soft limit if an arm or hand turns [0.001 mm or degree]
_FAR = 1e7  # beyond the reach of any robot [0.001 mm, 0.001 degree]


@takes_time(0x020, 0x021, 0x022)
class Jog(Moving):
    """A jog: the axis moves until a stop input turns OFF, or until it reaches a soft limit.

    A stop is an abnormal end with the position in the response. At the soft limit the jog ends with
    alarm 2.334, or normally if `jog_limit` permits it.
    """

    def __init__(self, machine: Machine, call: Call) -> None:
        if call.code in _PULSES:
            movement = _drive(machine, call, *_end(call))
        else:
            movement = _follow(machine, call, lambda: _reach(call))
        super().__init__(call, movement)

    def step(self, machine: Machine) -> Response | None:
        """Return the position at the end of the jog, if it was requested; None before the end."""
        if self.movement.stopped_by == STOP:
            raise CommandError(STOP, position_output(self.call))
        response = super().step(machine)
        if response is not None and machine.config.jog_limit == "alarm":
            raise CommandError(SOFT_LIMIT, axis=self.call.values["axes"].bit_length())
        return response


@takes_time(0x024, 0x025, 0x026)
def inch(machine: Machine, call: Call) -> Moving:
    """Move an axis or the tool by the inching amount, in pulses or 0.001 mm."""
    amount = call.arm.settings.inching_amount
    if call.code not in _PULSES:
        return Moving(call, _follow(machine, call, lambda: amount))
    place, sign = _axis(call)
    target = call.arm.here[place] + sign * amount
    return Moving(call, _drive(machine, call, place, target))


def _axis(call: Call) -> tuple[int, int]:
    """Return the index of the selected axis in the robot (0 to 5), and the direction, +1 or -1."""
    (place,) = call.places
    return place, -1 if call.values["direction"] else 1


def _end(call: Call) -> tuple[int, int]:
    """Return the index of the axis in the robot (0 to 5), and the end of its jog [pulses].

    The end is the soft limit, or the current position if the axis is already beyond the limit.
    """
    place, sign = _axis(call)
    axis, now = call.arm.axes[place], call.arm.here[place]
    return place, max(now, axis.soft_high) if sign > 0 else min(now, axis.soft_low)


def _drive(machine: Machine, call: Call, place: int, target: int) -> Movement:
    """Move one axis alone to `target` [pulses]."""
    machine.check_movable(call.arm, (place,))
    return machine.move(call.arm.number, plan_ptp(call.arm, {place: target}, _manual(call)))


def _follow(machine: Machine, call: Call, distance: Callable[[], float]) -> Movement:
    """Move the tool in the commanded direction by `distance` [0.001 mm or 0.001 degree]."""
    arm = call.arm
    places = arm.beyond(_ways(call, _PROBE), mm=True) if arm.frame.straight else None
    machine.check_movable(arm, places)
    target = arm.beyond(_ways(call, distance()), mm=True)
    return machine.move(arm.number, plan_line(arm, target, _manual(call)))


def _manual(call: Call) -> Pace:
    return Pace(call.arm.settings.manual_speed / 100)


def _ways(call: Call, distance: float) -> Mapping[int, float]:
    """Return the change of each coordinate, by its index, if the tool moves by `distance`."""
    place, sign = _axis(call)
    ways = {place: sign * distance}
    if call.code in _TOOL:
        frame = call.arm.frame
        position = frame.to_mm(call.arm.here)
        way = [ways.get(k, 0.0) for k in range(len(position))]
        end = frame.tool_to_mm(position, way)
        ways = {k: end[k] - position[k] for k in range(len(position)) if end[k] != position[k]}
    return ways


def _reach(call: Call) -> float:
    """Return the distance to the first soft limit [0.001 mm or 0.001 degree].

    If all axes move in proportion to the distance, the distance is calculated from the limit of
    each axis. If a hand or an arm turns, the distance is searched in steps.
    """
    axes, frame = call.arm.axes, call.arm.frame
    start = frame.to_mm(call.arm.here)
    ways = _ways(call, 1.0)

    def at(distance: float) -> tuple[float, ...]:
        return frame.to_pulses([v + ways.get(k, 0.0) * distance for k, v in enumerate(start)])

    def inside(distance: float) -> bool:
        try:
            there = at(distance)
        except UnreachableError:
            return False
        bend = frame.bend(there)
        return (bend is None or abs(bend) >= call.arm.config.outer_angle) and all(
            min(axis.soft_low, was) <= place <= max(axis.soft_high, was)
            for place, was, axis in zip(there, now, axes, strict=True)
        )

    now: Sequence[float] = call.arm.here
    if not frame.straight:
        return _last(inside, _FAR)
    turning = frame.turning_hand and _R in ways
    now, then, reach = at(0.0), at(1.0), []
    for place, axis in enumerate(axes):
        rate = then[place] - now[place]
        if rate and (place in ways or not turning):
            limit = axis.soft_high if rate > 0 else axis.soft_low
            reach.append(max(0.0, (limit - now[place]) / rate))
    return _last(inside, min(reach)) if turning else min(reach)


def _last(inside: Callable[[float], bool], end: float) -> float:
    """Search the longest distance within the soft limits, in steps and then by bisection."""
    steps: Iterable[float] = (k * _STEP for k in range(1, int(end / _STEP) + 1))
    out = next((distance for distance in chain(steps, (end,)) if not inside(distance)), None)
    if out is None:
        return end
    low = max(0.0, out - _STEP)
    for _ in range(20):
        middle = (low + out) / 2
        low, out = (middle, out) if inside(middle) else (low, middle)
    return low
