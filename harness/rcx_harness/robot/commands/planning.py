"""From where a robot is now to a target: the paths of its movements, within speeds and limits.

A target is given as pulses by place, 0 to 5 for axis 1 to 6 of the robot; the places that are not
in it stand still.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rcx_harness.robot.alarms import SOFT_LIMIT
from rcx_harness.robot.commands.base import CommandError
from rcx_harness.robot.curves import Arc, Curve, Line
from rcx_harness.robot.kinematics import Frame
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.paths import ArchPath, AxisMove, CurvePath, Path, PtpPath
from rcx_harness.robot.profile import Profile

__all__ = [
    "Arch",
    "Pace",
    "beyond",
    "frame_of",
    "here",
    "line_speed",
    "place_pulses",
    "plan_arc",
    "plan_arch",
    "plan_line",
    "plan_ptp",
    "pulses_of",
    "way_pulses",
]

#: Highest speed of the tool on lines and arcs [mm/s]: SCARA robots, all others (guide, 4.2.1).
_SCARA_SPEED, _LINE_SPEED = 1000.0, 750.0
_TURNING_SAMPLES = 256  # into how many parts a line is cut on which the hand turns


@dataclass(frozen=True)
class Pace:
    """How fast a movement is.

    Attributes:
        share: Speed as a part of the maximum: of the axes, on lines and arcs of the tool.
        up: Acceleration as a part of the maximum; None: each axis as its parameter ACCEL says.
        down: Deceleration likewise, parameter DECEL.
        mm_per_s: Speed of the tool on lines and arcs, instead of `share`.
    """

    share: float = 1.0
    up: float | None = None
    down: float | None = None
    mm_per_s: float | None = None


@dataclass(frozen=True)
class Arch:
    """The arch axis by its place, its arch position and the arch distances [pulses]."""

    place: int
    position: int
    distance1: int
    distance2: int


def frame_of(machine: Machine, robot: int) -> Frame:
    """The coordinates of a robot, with its selected shift and hand."""
    settings, memory = machine.settings.of(robot), machine.memory
    hand = memory.hand(robot, settings.hand)
    axes = machine.config.axes
    return Frame(
        tuple(axes[index].pulses_per_mm for index in machine.config.axes_of(robot)),
        shift=memory.shift(settings.shift),
        hand=hand.data[:3],
        on_r=hand.on_r_axis,
    )


def here(machine: Machine, robot: int) -> tuple[int, ...]:
    """Where the axes of a robot are [pulses]."""
    return tuple(machine.positions[index] for index in machine.config.axes_of(robot))


def pulses_of(machine: Machine, robot: int, data: Sequence[int], *, mm: bool) -> tuple[int, ...]:
    """Point data as pulses of the axes that the robot has; pulses know no shift and no hand."""
    if mm:
        return _rounded(frame_of(machine, robot).to_pulses(data))
    return tuple(data[: len(machine.config.axes_of(robot))])


def place_pulses(machine: Machine, robot: int, place: int, value: int, *, mm: bool) -> int:
    """One axis' coordinate as pulses; in mm the other coordinates are those of the robot now."""
    if not mm:
        return value
    frame = frame_of(machine, robot)
    position = list(frame.to_mm(here(machine, robot)))
    position[place] = value
    return round(frame.to_pulses(position)[place])


def way_pulses(machine: Machine, robot: int, place: int, value: int, *, mm: bool) -> int:
    """The way of one axis as pulses, along that axis."""
    axis = machine.config.axes[machine.config.axes_of(robot)[place]]
    return round(value * axis.pulses_per_mm / 1000) if mm else value


def beyond(machine: Machine, robot: int, ways: Mapping[int, float], *, mm: bool) -> dict[int, int]:
    """The target when each of these coordinates changes by its way [pulses or 0.001 mm].

    In millimetres these are the coordinates of the tool; other axes may have to move for them.
    """
    start = here(machine, robot)
    if not mm:
        return {place: start[place] + round(way) for place, way in ways.items()}
    frame = frame_of(machine, robot)
    position = [value + ways.get(place, 0) for place, value in enumerate(frame.to_mm(start))]
    ends = enumerate(_rounded(frame.to_pulses(position)))
    return {place: end for place, end in ends if place in ways or end != start[place]}


def plan_ptp(machine: Machine, robot: int, target: Mapping[int, int], pace: Pace) -> Path:
    """All axes start and end together.

    Raises:
        CommandError: the target is beyond a soft limit.
    """
    return _ptp(machine, robot, target, pace)


def plan_arch(
    machine: Machine, robot: int, target: Mapping[int, int], pace: Pace, arch: Arch
) -> Path:
    """The arch axis to its arch position, the others to the target, the arch axis to its own.

    Raises:
        CommandError: the target or the arch position is beyond a soft limit.
    """
    start = here(machine, robot)[arch.place]
    others = {place: end for place, end in target.items() if place != arch.place}
    return ArchPath(
        rise=_axis_move(machine, robot, arch.place, (start, arch.position), pace),
        fall=_axis_move(
            machine, robot, arch.place, (arch.position, target.get(arch.place, start)), pace
        ),
        others=_ptp(machine, robot, others, pace),
        distance1=arch.distance1,
        distance2=arch.distance2,
    )


def plan_line(machine: Machine, robot: int, target: Mapping[int, int], pace: Pace) -> Path:
    """The tool on a straight line; what turns does so in proportion.

    Raises:
        CommandError: the target or a place on the way is beyond a soft limit.
    """
    frame = frame_of(machine, robot)
    start, end = here(machine, robot), _completed(machine, robot, target)
    line = Line(frame.to_mm(start), frame.to_mm(end))
    return _curve(machine, robot, frame, line, target, pace)


def plan_arc(
    machine: Machine, robot: int, via: Mapping[int, int], target: Mapping[int, int], pace: Pace
) -> Path:
    """The tool on the circle through where it is, `via` and the target.

    Raises:
        CommandError: the three lie on a line, or a place on the way is beyond a soft limit.
    """
    frame = frame_of(machine, robot)
    points = (_completed(machine, robot, places) for places in ({}, via, target))
    try:
        arc = Arc(*(frame.to_mm(point) for point in points))
    except ValueError:
        raise CommandError(machine.config.no_circle_alarm) from None
    return _curve(machine, robot, frame, arc, target, pace)


def line_speed(machine: Machine, robot: int) -> float:
    """The highest speed of the tool on lines and arcs [mm/s]."""
    return _SCARA_SPEED if robot in machine.config.scara_robots else _LINE_SPEED


def _ptp(machine: Machine, robot: int, target: Mapping[int, int], pace: Pace) -> PtpPath:
    start = here(machine, robot)
    return PtpPath(
        [
            _axis_move(machine, robot, place, (start[place], end), pace)
            for place, end in target.items()
        ]
    )


def _axis_move(
    machine: Machine, robot: int, place: int, way: tuple[int, int], pace: Pace
) -> AxisMove:
    """The way of one axis from here to there [pulses]; there within the soft limits."""
    index = machine.config.axes_of(robot)[place]
    axis = machine.config.axes[index]
    if not axis.soft_low <= way[1] <= axis.soft_high:
        raise CommandError(SOFT_LIMIT, axis=place + 1)
    up, down = _ramps(machine, robot, place, pace)
    return AxisMove(index, *way, axis.max_speed * pace.share, up, down)


def _ramps(machine: Machine, robot: int, place: int, pace: Pace) -> tuple[float, float]:
    """Acceleration and deceleration of an axis [pulses/s^2]."""
    parameters = machine.memory.parameters
    up, down = (
        parameters.get(robot, name, place) / 100 if given is None else given
        for name, given in (("ACCEL", pace.up), ("DECEL", pace.down))
    )
    highest = machine.config.axes[machine.config.axes_of(robot)[place]].max_acceleration
    return highest * up, highest * down


def _completed(machine: Machine, robot: int, target: Mapping[int, int]) -> tuple[int, ...]:
    """Pulses of all axes at the target."""
    return tuple(target.get(place, now) for place, now in enumerate(here(machine, robot)))


def _curve(
    machine: Machine, robot: int, frame: Frame, curve: Curve, target: Mapping[int, int], pace: Pace
) -> Path:
    """The fastest way along a curve on which no axis is faster than it can."""
    samples = max(curve.samples, _TURNING_SAMPLES if frame.turning_hand else 1)
    every = [frame.to_pulses(curve.at(k / samples)) for k in range(samples + 1)]
    indices = machine.config.axes_of(robot)
    length = curve.length / 1000
    highest = line_speed(machine, robot)
    speeds = [highest * pace.share if pace.mm_per_s is None else pace.mm_per_s]
    ramps = []
    for place in target:
        axis = machine.config.axes[indices[place]]
        values = [pulses[place] for pulses in every]
        if _leaves(values, axis.soft_low, axis.soft_high):
            raise CommandError(SOFT_LIMIT, axis=place + 1)
        step = max(abs(after - before) for before, after in pairwise(values))
        if length and step:
            rate = step * samples / length  # pulses of the axis for each mm of the tool
            share = pace.share if pace.mm_per_s is None else 1.0
            speeds.append(axis.max_speed * share / rate)
            ramps.append([ramp / rate for ramp in _ramps(machine, robot, place, pace)])
    up, down = (min(kind) for kind in zip(*ramps, strict=True)) if ramps else (1.0, 1.0)
    profile = Profile.over(length if ramps else 0.0, min(speeds), up, down)
    axes = {place: indices[place] for place in target}
    ends = {indices[place]: end for place, end in target.items()}
    return CurvePath(curve, profile, frame, axes, ends)


def _leaves(values: Sequence[float], low: int, high: int) -> bool:
    """The way goes beyond the soft limits; one that only leads back from there does not."""
    start, *_, end = (round(value) for value in values)
    far = round(min(values)) < min(low, start) or round(max(values)) > max(high, start)
    return far or not low <= end <= high


def _rounded(values: Sequence[float]) -> tuple[int, ...]:
    return tuple(round(value) for value in values)
