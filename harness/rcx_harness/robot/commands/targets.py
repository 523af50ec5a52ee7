"""What the programmed movements have in common: the target of a point, and the arch."""

from __future__ import annotations

from collections.abc import Hashable, Iterable

from rcx_harness.robot.commands.base import Call, CommandError
from rcx_harness.robot.commands.moving import Moving, check_movable, chosen_places
from rcx_harness.robot.commands.planning import Arch, place_pulses, pulses_of, way_pulses
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.paths import Path
from rcx_harness.robot.stored import Point

__all__ = ["arch_of", "begin", "movable_places", "target_of"]


def movable_places(machine: Machine, call: Call) -> tuple[int, ...]:
    """The places (0 to 5) of the axes that the command designates.

    Raises:
        CommandError: the robot has no such axis, or these axes cannot move now.
    """
    places = chosen_places(machine, call)
    check_movable(machine, call.robot, places)
    return places


def target_of(machine: Machine, robot: int, point: Point, places: Iterable[int]) -> dict[int, int]:
    """Where a point is, by place [pulses]."""
    pulses = pulses_of(machine, robot, point.data, mm=point.mm)
    return {place: pulses[place] for place in places}


def begin(
    machine: Machine,
    call: Call,
    path: Path,
    hand: int = 0,
    *,
    relative: Hashable | None = None,
) -> Moving:
    """Start a movement; a SCARA robot takes the hand system (1 right, 2 left) of its target."""
    movement = machine.move(call.robot, path, relative=relative)
    if hand and call.robot in machine.config.scara_robots:
        machine.settings.of(call.robot).arm_status = hand - 1
    return Moving(call, movement)


def arch_of(machine: Machine, call: Call) -> Arch:
    """The arch axis, its position and its distances [pulses].

    Raises:
        CommandError: the robot has no such axis, or a distance is negative.
    """
    values, mm = call.values, bool(call.values["arch_unit"])
    place = int(values["arch_axis"]).bit_length() - 1
    if place >= len(machine.config.axes_of(call.robot)):
        raise CommandError(machine.config.no_axis_alarm)
    distances = values["arch_distance1"], values["arch_distance2"]
    if min(distances) < 0:
        raise CommandError(machine.config.format_alarm)
    ways = [way_pulses(machine, call.robot, place, one, mm=mm) for one in distances]
    if machine.config.arch_zero_is_parameter:
        parameters = machine.memory.parameters
        names = ("ARCHP1", "ARCHP2")
        ways = [
            way or parameters.get(call.robot, name, place)
            for way, name in zip(ways, names, strict=True)
        ]
    position = place_pulses(machine, call.robot, place, values["arch_position"], mm=mm)
    return Arch(place, position, *ways)
