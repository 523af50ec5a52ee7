"""Category 1: programmed movements (guide, 4.2.1 to 4.2.5, 4.2.21, 4.2.23).

The commands are MOVE, MOVEI and MOVET with all axes, DRIVE and DRIVEI with one axis, pallet
movement and PUSH. The module also has the functions that all moving commands share.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import replace

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.commands.base import Call, Execution, Response, statement, takes_time
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.motion import Movement
from rcx_harness.robot.paths import (
    Arch,
    Leg,
    Pace,
    Path,
    plan_arc,
    plan_arch,
    plan_chain,
    plan_line,
    plan_ptp,
)
from rcx_harness.robot.program.motion import PATH_START
from rcx_harness.robot.stored import Point

__all__ = ["Moving", "position_output"]

_Plan = Callable[[Arm, Mapping[int, int], Pace], Path]

# speed modes; the unit of the first mode is 0.01 % of the maximum speed
_DIRECT_SPEED, _PERCENT, _MM_PER_S = 1, 2, 3
_LINEAR = (0x003, 0x00A, 0x045)
_ON_CURVE = (*_LINEAR, 0x004, PATH_START)
_MM = (0x006, 0x00E, 0x012, 0x016, 0x04C)
_DRIVE_TO_POINT = (0x010, 0x04B)
_DRIVEI_BY_POINT = 0x014
_PALLET_ARCH = 0x019
_R_ONLY = (3,)  # indices of the axes in the robot, from 0
_R_AND_ARM = (0, 1, 3)


class Moving(Execution):
    """A command that ends when its movement ends."""

    def __init__(self, call: Call, movement: Movement) -> None:
        """Create the command for a `movement` that has already begun."""
        self.call = call
        self.movement = movement

    def step(self, machine: Machine) -> Response | None:
        """Return the requested position at the end of the movement; None before the end."""
        if self.movement.stopped_by:
            raise CommandError(self.movement.stopped_by)
        return position_output(self.call) if self.movement.done else None


def position_output(call: Call) -> Response:
    """Return the position in the requested unit; empty if the command requests no position."""
    if "position_mm" not in call.values:
        return {}
    mm = bool(call.values["position_mm"])
    asked = mm or call.values["position_pulses"]
    if not asked and call.arm.config.unasked_positions_zero:
        return {}
    return {"positions": call.arm.shown(mm=mm)}


@takes_time(0x001, 0x003)
def move_to_point(machine: Machine, call: Call) -> Moving:
    """Move with PTP or linear interpolation to a point (MOVE, 4.2.1)."""
    places = _movable_places(machine, call)
    point = _point(machine, call)
    path = _plan(call)(call.arm, _target(call, point, places), _pace(call))
    return _begin(machine, call, path, point.hand)


@takes_time(0x002)
def move_arch(machine: Machine, call: Call) -> Moving:
    """Move in an arch to a point. If the arch axis is not selected, it returns to its start."""
    places = _movable_places(machine, call)
    point = _point(machine, call)
    arch = _arch(call)
    path = plan_arch(call.arm, _target(call, point, places), _pace(call), arch)
    return _begin(machine, call, path, point.hand)


@takes_time(0x004)
def move_circular(machine: Machine, call: Call) -> Moving:
    """Move all axes on an arc through the first point to the second point."""
    places = _movable_places(machine, call)
    points = [_point(machine, call, name) for name in ("point1", "point2")]
    via, target = (_target(call, point, places) for point in points)
    path = plan_arc(call.arm, via, target, _pace(call))
    return _begin(machine, call, path, points[1].hand)


@statement(PATH_START)
def follow_path(machine: Machine, call: Call) -> Moving:
    """Follow the path that PATH statements have defined. There is no such remote command."""
    places = _movable_places(machine, call)
    way = call.values["way"]
    legs = [
        Leg(
            tuple(_target(call, point, places) for point in points),
            _pace(replace(call, values=paced)),
        )
        for points, paced in way.parts
    ]
    path = plan_chain(call.arm, way.start, legs, resumed=call.values["resumed"])
    return _begin(machine, call, path)


@takes_time(0x006, 0x007)
def move_direct(machine: Machine, call: Call) -> Moving:
    """Move with PTP to a position that the command contains.

    In mm, axis 4 of a SCARA robot also moves axes 1 and 2.
    """
    mm = call.code in _MM
    places = _movable_places(machine, call)
    if mm and places == _R_ONLY and call.arm.scara:
        places = _R_AND_ARM
    hand = _hand(call) or call.arm.designated_hand
    pulses = call.arm.pulses_of(call.values["targets"], mm=mm, hand=hand)
    path = plan_ptp(call.arm, {place: pulses[place] for place in places}, _pace(call))
    return _begin(machine, call, path, _hand(call))


@takes_time(0x009, 0x00A, 0x014)
def move_by_point(machine: Machine, call: Call) -> Moving:
    """Move by the distances of a point: MOVEI with PTP or on a line (4.2.2), DRIVEI (4.2.4)."""
    places = _movable_places(machine, call)
    point = _point(machine, call)
    ways = {place: point.data[place] for place in places}
    one_axis = call.code == _DRIVEI_BY_POINT
    hand = 0 if one_axis else point.hand
    return _go_by(machine, call, ways, mm=point.mm, hand=hand, one_axis=one_axis)


@takes_time(0x00E, 0x00F)
def movei_direct(machine: Machine, call: Call) -> Moving:
    """Move by the distances that the command contains (MOVEI)."""
    ways = {place: call.values["distances"][place] for place in _movable_places(machine, call)}
    return _go_by(machine, call, ways, mm=call.code in _MM, hand=_hand(call))


@takes_time(0x016, 0x017)
def drivei_direct(machine: Machine, call: Call) -> Moving:
    """Move one axis by the distance that the command contains (DRIVEI)."""
    ways = dict.fromkeys(_movable_places(machine, call), call.values["distance"])
    return _go_by(machine, call, ways, mm=call.code in _MM, one_axis=True)


@takes_time(0x010, 0x012, 0x013)
def drive(machine: Machine, call: Call) -> Moving:
    """Move one axis with PTP to an absolute position (DRIVE, 4.2.3)."""
    target = _axis_target(machine, call)
    return _begin(machine, call, plan_ptp(call.arm, target, _pace(call)))


@takes_time(0x018, 0x019)
def move_to_work_position(machine: Machine, call: Call) -> Moving:
    """Move to a work position of a pallet (4.2.5): all axes with PTP, or in an arch."""
    places = _movable_places(machine, call)
    point = machine.memory.work_point(call.values["pallet"], call.values["work"])
    target = _target(call, point, places)
    pace = _pace(call)
    if call.code == _PALLET_ARCH:
        path = plan_arch(call.arm, target, pace, _arch(call))
    else:
        path = plan_ptp(call.arm, target, pace)
    return _begin(machine, call, path, point.hand)


@takes_time(0x044, 0x045)
def move_in_tool_coordinates(machine: Machine, call: Call) -> Moving:
    """Move by the point's data along the axes of the tool (MOVET, 4.2.21).

    The command selects axes of the tool. The axes of the robot move as required.
    """
    arm, places = call.arm, _movable_places(machine, call)
    point = _point(machine, call)
    way = [0.0] * len(arm.axes)
    for place in places:
        scale = 1 if point.mm else 1000 / arm.axes[place].pulses_per_mm
        way[place] = point.data[place] * scale
    frame, start = arm.frame, arm.here
    if point.mm or frame.straight:
        there = arm.frame_with(point.hand) if point.hand else frame
        ends = there.to_pulses(frame.tool_to_mm(frame.to_mm(start), way))
    else:  # in pulses each coordinate belongs to one axis, so no other axis moves
        ends = tuple(at + point.data[k] * (k in places) for k, at in enumerate(start))
    target = {
        place: round(end)
        for place, end in enumerate(ends)
        if place in places or round(end) != start[place]
    }
    return _begin(machine, call, _plan(call)(arm, target, _pace(call)), point.hand)


@takes_time(0x04B, 0x04C, 0x04D)
class Push(Moving):
    """PUSH: one axis moves to a target and pushes against a workpiece that blocks it (4.2.23).

    The command ends when the axis has pushed for the push time, or has reached its target. Without
    a time in the command, the axis' parameter PSHTIME is used; PSHSPD reduces the speed. The value
    of the force is checked, but the force has no effect in this model.
    """

    def __init__(self, machine: Machine, call: Call) -> None:
        arm, values = call.arm, call.values
        target = _axis_target(machine, call)
        (place,) = target
        timed = values["push_time_flag"]
        time_ms = values["push_time"] if timed else arm.parameter("PSHTIME", place)
        self._time_us = time_ms * 1000
        pace = _pace(call)
        pace = replace(pace, share=pace.share * arm.parameter("PSHSPD", place) / 100)
        path = plan_ptp(arm, target, pace)
        super().__init__(call, machine.move(arm.number, path, pushing=True))

    def step(self, machine: Machine) -> Response | None:
        """Return the completion result: 1 after the push time, 0 at the target."""
        reached = super().step(machine)
        if reached is not None:
            return {**reached, "push_done": 0}
        since = self.movement.blocked_us
        if since is None or machine.now_us - since < self._time_us:
            return None
        machine.motion.cancel(self.call.arm.number)
        return {**position_output(self.call), "push_done": 1}


def _point(machine: Machine, call: Call, name: str = "point") -> Point:
    """Return the point of a field, which is a point number or point data of a robot program.

    Raises:
        CommandError: the point is not defined.
    """
    value = call.values[name]
    return value if isinstance(value, Point) else machine.memory.point(value)


def _movable_places(machine: Machine, call: Call) -> tuple[int, ...]:
    """Check that the selected axes may move, and return their indices in the robot (0 to 5)."""
    places = call.places
    machine.check_movable(call.arm, places, by_program=call.by_program)
    return places


def _pace(call: Call) -> Pace:
    """Return speed, acceleration and deceleration of a command; missing fields have defaults."""
    values, settings = call.values, call.arm.settings
    mode, speed = values.get("speed_mode", 0), values.get("speed", 0)
    up = values["acceleration"] / 100 if values.get("acceleration_flag") else None
    down = values["deceleration"] / 100 if values.get("deceleration_flag") else None
    if mode == _MM_PER_S:
        if speed > call.arm.line_speed:
            raise CommandError(call.arm.config.format_alarm)
        return Pace(up=up, down=down, mm_per_s=speed)
    if mode == _DIRECT_SPEED:
        return Pace(speed / 10000, up, down)
    percent = speed if mode == _PERCENT else settings.program_speed
    return Pace(settings.auto_speed / 100 * percent / 100, up, down)


def _plan(call: Call) -> _Plan:
    return plan_line if call.code in _LINEAR else plan_ptp


def _hand(call: Call) -> int:
    return int(call.values.get("hand", 0)) % 3  # both 0 and 3 mean no hand


def _target(call: Call, point: Point, places: Iterable[int]) -> dict[int, int]:
    """Return the position of a point [pulses], by the index of the axis in the robot.

    If the point has no hand system, the arm designation applies. On lines and arcs the current hand
    system applies instead.
    """
    arm = call.arm
    free = arm.hand_system if call.code in _ON_CURVE else arm.designated_hand
    pulses = arm.pulses_of(point.data, mm=point.mm, hand=point.hand or free)
    return {place: pulses[place] for place in places}


def _axis_target(machine: Machine, call: Call) -> dict[int, int]:
    """Return the selected axis and its target [pulses], from a point or from the command."""
    places = _movable_places(machine, call)
    if call.code in _DRIVE_TO_POINT:
        return _target(call, _point(machine, call), places)
    value, mm = call.values["target"], call.code in _MM
    return {place: call.arm.place_pulses(place, value, mm=mm) for place in places}


def _arch(call: Call) -> Arch:
    """Return the arch axis, its arch position and its two arch distances [pulses]."""
    arm, values, mm = call.arm, call.values, bool(call.values["arch_unit"])
    place = int(values["arch_axis"]).bit_length() - 1
    if place >= len(arm.axes):
        raise CommandError(arm.config.no_axis_alarm)
    distances = values["arch_distance1"], values["arch_distance2"]
    if min(distances) < 0:
        raise CommandError(arm.config.format_alarm)
    ways = [arm.way_pulses(place, one, mm=mm) for one in distances]
    if arm.config.arch_zero_is_parameter:
        pairs = zip(ways, ("ARCHP1", "ARCHP2"), strict=True)
        ways = [way or arm.parameter(name, place) for way, name in pairs]
    position = arm.place_pulses(place, values["arch_position"], mm=mm)
    return Arch(place, position, *ways)


def _go_by(
    machine: Machine,
    call: Call,
    ways: Mapping[int, int],
    *,
    mm: bool,
    hand: int = 0,
    one_axis: bool = False,
) -> Moving:
    """Move axes by the distances in `ways` [pulses or 0.001 mm]; the key is the axis in the robot.

    With `one_axis` a movement that needs other axes is refused.

    A command with the same code, axes and distances as an interrupted movement repeats this
    movement. Speed and output may differ. If the parameter "MOVEI/DRIVEI start position" is Keep,
    the repetition continues to the original target. With Reset it starts from the current position.
    """
    arm = call.arm
    again = (call.code, mm, tuple(sorted(ways.items())))
    kept = machine.motion.kept_target(arm.number, again)
    if kept is None:
        target = arm.beyond(ways, mm=mm, hand=hand)
        if one_axis and not arm.frame.straight and len(target) > 1:
            raise CommandError(arm.config.drive_xy_alarm)
    else:
        target = {place: kept[index] for place, index in enumerate(arm.indices) if index in kept}
    path = _plan(call)(arm, target, _pace(call))
    return _begin(machine, call, path, hand, relative=again)


def _begin(
    machine: Machine, call: Call, path: Path, hand: int = 0, *, relative: Hashable | None = None
) -> Moving:
    """Start a movement, and set the hand system of a SCARA robot to `hand` (1 right, 2 left)."""
    movement = machine.move(call.arm.number, path, relative=relative)
    if hand and call.arm.scara:
        call.arm.settings.arm_status = hand - 1
    return Moving(call, movement)
