"""The statements that move a robot or change its settings, translated to remote commands.

The remote command guide defines the effect of each command. Because a statement is executed as a
command (`Request`), its effect cannot differ from that of the command.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.program.expressions import Scope, Surroundings, evaluate, number_of
from rcx_harness.robot.program.syntax import Instruction, Node
from rcx_harness.robot.program.values import integer
from rcx_harness.robot.stored import AXES, ROBOT_PARAMETERS, Point, parameter_ranges

__all__ = ["PATH_START", "Request", "Way", "change_parameter", "path_part", "request"]

_SCALE = 1000
_DIRECT_SPEED, _PERCENT, _MM_PER_S = 1, 2, 3
_SPEEDS = {"S": _PERCENT, "SPEED": _PERCENT, "DSPEED": _DIRECT_SPEED, "VEL": _MM_PER_S}
_ACCELERATIONS = {"ACC": "acceleration", "DEC": "deceleration"}
_ARCHES = ("A1", "A2", "A3", "A4", "A5", "A6")

#: Maps a statement and its interpolation to a remote command (guide, 4.2.1, 4.2.2, 4.2.21).
_CODES = {
    ("move", "P"): 0x001,
    ("move", "L"): 0x003,
    ("move", "C"): 0x004,
    ("movei", "P"): 0x009,
    ("movei", "L"): 0x00A,
    ("movet", "P"): 0x044,
    ("movet", "L"): 0x045,
}
_ARCH, _PALLET, _PALLET_ARCH = 0x002, 0x018, 0x019
#: The remote commands for one axis: to a point, in mm, in pulses (guide, 4.2.3, 4.2.4, 4.2.23).
_AXIS_CODES = {
    "drive": (0x010, 0x012, 0x013),
    "drivei": (0x014, 0x016, 0x017),
    "push": (0x04B, 0x04C, 0x04D),
}


#: The code for PATH START, which has no remote command. A master cannot send this code.
PATH_START = -1
_POSITIONS, _DISTANCES = 0x007, 0x00F


@dataclass(frozen=True)
class Way:
    """A path that PATH statements define.

    Attributes:
        start: The start of the path [pulses].
        parts: The points of each line or arc, and the fields of its speed and accelerations (see
            Request).
        ended: Whether PATH END has ended the definition of the path.
    """

    start: tuple[int, ...]
    parts: tuple[tuple[tuple[Point, ...], Mapping[str, Any]], ...] = ()
    ended: bool = False


@dataclass(frozen=True)
class Request:
    """A remote command: its code without R, the robot (0: all robots), and its fields."""

    code: int
    robot: int
    values: Mapping[str, Any]


def request(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    """Translate a statement to the remote command with the same effect.

    Raises:
        CommandError: an argument is invalid; the program gets the alarm with this number.
    """
    return _REQUESTS[one.kind](one, world, scope)


def _move(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    robot, kind, targets, options = one.args
    values = _paced(options, world, scope)
    points = [evaluate(target, world, scope) for target in targets]
    names = ("point1", "point2") if kind == "C" else ("point",)
    values.update(zip(names, points, strict=True))
    code = _CODES[one.kind, kind]
    if arch := _arch(options, world, scope):
        if (one.kind, kind) != ("move", "P"):
            raise CommandError(world.config.format_alarm)
        code = _ARCH
        values.update(arch)
    return Request(code, robot, values)


def path_part(
    one: Instruction, world: Surroundings, scope: Scope
) -> tuple[tuple[Point, ...], Mapping[str, Any]]:
    """Return the points and fields that a PATH statement adds to a Way.

    Raises:
        CommandError: a point is not defined, or an option is impossible.
    """
    _, _, targets, options = one.args
    points = tuple(evaluate(target, world, scope) for target in targets)
    return points, _paced(options, world, scope)


def _axis(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    robot, pair, *options = one.args
    pairs = [pair, *(option for option in options if option.kind == "axis_target")]
    if len(pairs) > 1:
        return _axes(one, pairs, world, scope)
    axis, target = (evaluate(part, world, scope) for part in pair.args)
    values = _paced(options, world, scope)
    values["axes"] = 1 << _axis_place(axis, world)
    to_point, in_mm, in_pulses = _AXIS_CODES[one.kind]
    field = "distance" if one.kind == "drivei" else "target"
    if isinstance(target, Point):
        code = to_point
        values["point"] = target
    else:
        mm = isinstance(target, float)
        code = in_mm if mm else in_pulses
        values[field] = round(target * _SCALE) if mm else integer(target, world.config)
    if one.kind == "push":
        time_ms = _option(options, "TIM", world, scope)
        values["push_time_flag"] = time_ms is not None
        values["push_time"] = 0 if time_ms is None else integer(time_ms, world.config)
    return Request(code, robot, values)


def _axes(one: Instruction, pairs: Sequence[Node], world: Surroundings, scope: Scope) -> Request:
    """Return the command for DRIVE or DRIVEI with several axes, which move together."""
    robot, _, *options = one.args
    arm, relative = world.arm(robot), one.kind == "drivei"
    places, values = 0, [0] * AXES
    for pair in pairs:
        axis, target = (evaluate(part, world, scope) for part in pair.args)
        place = _axis_place(axis, world)
        if place >= len(arm.axes) or places >> place & 1:
            raise CommandError(world.config.no_axis_alarm)
        places |= 1 << place
        mm = isinstance(target, float) or (isinstance(target, Point) and target.mm)
        if isinstance(target, Point):
            value = target.data[place]
            if not relative:
                hand = target.hand or arm.designated_hand
                values[place] = arm.pulses_of(target.data, mm=mm, hand=hand)[place]
                continue
        else:
            value = round(target * _SCALE) if mm else integer(target, world.config)
        convert = arm.way_pulses if relative else arm.place_pulses
        values[place] = convert(place, value, mm=mm)
    fields = {**_paced(options, world, scope), "axis_designation": 1, "axes": places}
    name = "distances" if relative else "targets"
    return Request(_DISTANCES if relative else _POSITIONS, robot, {**fields, name: tuple(values)})


def _pallet(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    robot, pair, *options = one.args
    pallet, work = (integer(evaluate(part, world, scope), world.config) for part in pair.args)
    values = {**_paced(options, world, scope), "pallet": pallet, "work": work}
    if arch := _arch(options, world, scope):
        return Request(_PALLET_ARCH, robot, {**values, **arch})
    return Request(_PALLET, robot, values)


def _servo(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    robot, switch, axis = one.args
    code = {"ON": 0x034, "OFF": 0x035, "FREE": 0x036}.get(switch)
    if code is None:
        raise CommandError(world.config.format_alarm)
    values: dict[str, Any] = {}
    if axis is not None:
        values["axes"] = 1 << _axis_place(evaluate(axis, world, scope), world)
    return Request(code, robot, values)


def _motor(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    code = {"OFF": 0x041, "ON": 0x042, "PWR": 0x043}.get(one.args[0])
    if code is None:
        raise CommandError(world.config.format_alarm)
    return Request(code, 1, {})


def _origin(one: Instruction, world: Surroundings, scope: Scope) -> Request:
    flags = ("incremental_flag", "absolute_flag", "incomplete_flag")
    return Request(0x032, one.args[0], dict.fromkeys(flags, 0))


def _select(code: int, field: str) -> Callable[[Instruction, Surroundings, Scope], Request]:
    """Return the command for SHIFT or CHANGE, which select a shift or a hand."""

    def make(one: Instruction, world: Surroundings, scope: Scope) -> Request:
        robot, selected = one.args
        number = integer(evaluate(selected.args[0], world, scope), world.config)
        return Request(code, robot, {field: number})

    return make


def _arm(arm: int | None) -> Callable[[Instruction, Surroundings, Scope], Request]:
    """Return the command for RIGHTY, LEFTY or ARMSEL; for ARMSEL, `arm` is None."""

    def make(one: Instruction, world: Surroundings, scope: Scope) -> Request:
        value = arm
        if value is None:
            value = integer(evaluate(one.args[1], world, scope), world.config)
            if value not in (0, 1):
                raise CommandError(world.config.format_alarm)
        return Request(0x03D, one.args[0], {"arm": value})

    return make


_REQUESTS: dict[str, Callable[[Instruction, Surroundings, Scope], Request]] = {
    **dict.fromkeys(("move", "movei", "movet"), _move),
    **dict.fromkeys(("drive", "drivei", "push"), _axis),
    "pmove": _pallet,
    "servo": _servo,
    "motor": _motor,
    "origin": _origin,
    "shift_select": _select(0x03B, "shift"),
    "hand_select": _select(0x03C, "hand_number"),
    "righty": _arm(0),
    "lefty": _arm(1),
    "armsel": _arm(None),
}


# --- statements that change settings ---

#: Maps a statement to the field of the robot's settings that contains its speed.
_SPEED_SETTINGS = {"SPEED": "program_speed", "ASPEED": "auto_speed"}


def change_parameter(one: Instruction, world: Surroundings, scope: Scope) -> None:
    """Execute SPEED, ASPEED or a statement that changes a parameter of a robot or of its axes.

    Raises:
        CommandError: the axis does not exist, or the value is outside of its range.
    """
    name, robot, *rest = one.args
    value = integer(evaluate(rest[-1], world, scope), world.config)
    axis = evaluate(rest[0], world, scope) if one.kind == "setting_axis" else None
    arm = world.arm(robot)
    if name in _SPEED_SETTINGS:
        _check_range(value, 1, 100, world)
        if axis is not None:
            raise CommandError(world.config.format_alarm)
        setattr(arm.settings, _SPEED_SETTINGS[name], value)
        return
    _check_range(value, *parameter_ranges()[name], world)
    places: Sequence[int] = range(len(arm.axes))
    if name in ROBOT_PARAMETERS:
        places = (0,)
    elif axis is not None:
        places = (_axis_place(axis, world),)
    if max(places) >= len(arm.axes):
        raise CommandError(world.config.no_axis_alarm)
    for place in places:
        world.memory.parameters.set(robot, name, value, place)


def _check_range(value: int, low: float, high: float, world: Surroundings) -> None:
    if not low <= value <= high:
        raise CommandError(world.config.format_alarm)


# --- options of movements ---


def _paced(options: Sequence[Node], world: Surroundings, scope: Scope) -> dict[str, Any]:
    """Return the fields of speed, acceleration and deceleration; the last of each option counts."""
    values: dict[str, Any] = {"speed_mode": 0}
    for name, mode in _SPEEDS.items():
        given = _option(options, name, world, scope)
        if given is None:
            continue
        speed = number_of(given, world.config)
        most = 1000 if mode == _MM_PER_S else 100
        if not 0 < speed <= most:
            raise CommandError(world.config.format_alarm)
        values["speed_mode"] = mode
        values["speed"] = speed * 100 if mode == _DIRECT_SPEED else speed
    for name, field in _ACCELERATIONS.items():
        given = _option(options, name, world, scope)
        if given is not None:
            percent = number_of(given, world.config)
            _check_range(integer(percent, world.config), 1, 100, world)
            values[f"{field}_flag"] = 1
            values[field] = percent
    return values


def _arch(options: Sequence[Node], world: Surroundings, scope: Scope) -> dict[str, Any]:
    """Return the fields of an arch movement (guide, 4.2.1); empty without an arch option."""
    arches = [one for one in options if one.kind == "option" and one.args[0] in _ARCHES]
    if not arches:
        return {}
    if len(arches) > 1:
        raise CommandError(world.config.format_alarm)
    name, *parts = arches[0].args
    numbers = [
        0 if part is None else number_of(evaluate(part, world, scope), world.config)
        for part in parts
    ]
    mm = isinstance(numbers[0], float)
    position, first, second = (round(one * _SCALE) if mm else round(one) for one in numbers)
    return {
        "arch_axis": 1 << int(name[1:]) - 1,
        "arch_unit": mm,
        "arch_position": position,
        "arch_distance1": first,
        "arch_distance2": second,
    }


def _option(options: Sequence[Node], name: str, world: Surroundings, scope: Scope) -> Any:
    """Return the value of an option, or None if the statement does not have it."""
    given = [one for one in options if one.kind == "option" and one.args[0] == name]
    return evaluate(given[-1].args[1], world, scope) if given else None


def _axis_place(axis: Any, world: Surroundings) -> int:
    place = integer(axis, world.config) - 1
    if not 0 <= place < 6:
        raise CommandError(world.config.no_axis_alarm)
    return place
