"""From where a robot is now to a target: the paths of its movements, within speeds and limits.

A target is given as pulses by place, 0 to 5 for axis 1 to 6 of the robot; the places that are not
in it stand still.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rcx_harness.robot.alarms import SOFT_LIMIT, CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.geometry import Arc, Curve, Frame, Line
from rcx_harness.robot.paths import ArchPath, AxisMove, CurvePath, Path, Profile, PtpPath

__all__ = ["Arch", "Pace", "plan_arc", "plan_arch", "plan_line", "plan_ptp"]

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


def plan_ptp(arm: Arm, target: Mapping[int, int], pace: Pace) -> PtpPath:
    """All axes start and end together.

    Raises:
        CommandError: the target is beyond a soft limit.
    """
    start = arm.here
    return PtpPath(
        [_axis_move(arm, place, (start[place], end), pace) for place, end in target.items()]
    )


def plan_arch(arm: Arm, target: Mapping[int, int], pace: Pace, arch: Arch) -> Path:
    """The arch axis to its arch position, the others to the target, the arch axis to its own.

    Raises:
        CommandError: the target or the arch position is beyond a soft limit.
    """
    start = arm.here[arch.place]
    others = {place: end for place, end in target.items() if place != arch.place}
    end = target.get(arch.place, start)
    return ArchPath(
        rise=_axis_move(arm, arch.place, (start, arch.position), pace),
        fall=_axis_move(arm, arch.place, (arch.position, end), pace),
        others=plan_ptp(arm, others, pace),
        distance1=arch.distance1,
        distance2=arch.distance2,
    )


def plan_line(arm: Arm, target: Mapping[int, int], pace: Pace) -> Path:
    """The tool on a straight line; what turns does so in proportion.

    Raises:
        CommandError: the target or a place on the way is beyond a soft limit.
    """
    frame = arm.frame
    line = Line(frame.to_mm(arm.here), frame.to_mm(_completed(arm, target)))
    return _curve(arm, frame, line, target, pace)


def plan_arc(arm: Arm, via: Mapping[int, int], target: Mapping[int, int], pace: Pace) -> Path:
    """The tool on the circle through where it is, `via` and the target.

    Raises:
        CommandError: the three lie on a line, or a place on the way is beyond a soft limit.
    """
    frame = arm.frame
    points = (_completed(arm, places) for places in ({}, via, target))
    try:
        arc = Arc(*(frame.to_mm(point) for point in points))
    except ValueError:
        raise CommandError(arm.config.no_circle_alarm) from None
    return _curve(arm, frame, arc, target, pace)


def _axis_move(arm: Arm, place: int, way: tuple[int, int], pace: Pace) -> AxisMove:
    """The way of one axis from here to there [pulses]; there within the soft limits."""
    axis = arm.axes[place]
    if not axis.soft_low <= way[1] <= axis.soft_high:
        raise CommandError(SOFT_LIMIT, axis=place + 1)
    up, down = _ramps(arm, place, pace)
    return AxisMove(arm.indices[place], *way, axis.max_speed * pace.share, up, down)


def _ramps(arm: Arm, place: int, pace: Pace) -> tuple[float, float]:
    """Acceleration and deceleration of an axis [pulses/s^2]."""
    up, down = (
        arm.parameter(name, place) / 100 if given is None else given
        for name, given in (("ACCEL", pace.up), ("DECEL", pace.down))
    )
    highest = arm.axes[place].max_acceleration
    return highest * up, highest * down


def _completed(arm: Arm, target: Mapping[int, int]) -> tuple[int, ...]:
    """Pulses of all axes at the target."""
    return tuple(target.get(place, now) for place, now in enumerate(arm.here))


def _curve(arm: Arm, frame: Frame, curve: Curve, target: Mapping[int, int], pace: Pace) -> Path:
    """The fastest way along a curve on which no axis is faster than it can."""
    samples = max(curve.samples, _TURNING_SAMPLES if frame.turning_hand else 1)
    every = [frame.to_pulses(curve.at(k / samples)) for k in range(samples + 1)]
    length = curve.length / 1000
    speeds = [arm.line_speed * pace.share if pace.mm_per_s is None else pace.mm_per_s]
    ramps = []
    for place in target:
        axis = arm.axes[place]
        values = [pulses[place] for pulses in every]
        if _leaves(values, axis.soft_low, axis.soft_high):
            raise CommandError(SOFT_LIMIT, axis=place + 1)
        step = max(abs(after - before) for before, after in pairwise(values))
        if length and step:
            rate = step * samples / length  # pulses of the axis for each mm of the tool
            share = pace.share if pace.mm_per_s is None else 1.0
            speeds.append(axis.max_speed * share / rate)
            ramps.append([ramp / rate for ramp in _ramps(arm, place, pace)])
    up, down = (min(kind) for kind in zip(*ramps, strict=True)) if ramps else (1.0, 1.0)
    profile = Profile.over(length if ramps else 0.0, min(speeds), up, down)
    axes = {place: arm.indices[place] for place in target}
    ends = {arm.indices[place]: end for place, end in target.items()}
    return CurvePath(curve, profile, frame, axes, ends)


def _leaves(values: Sequence[float], low: int, high: int) -> bool:
    """The way goes beyond the soft limits; one that only leads back from there does not."""
    start, *_, end = (round(value) for value in values)
    far = round(min(values)) < min(low, start) or round(max(values)) > max(high, start)
    return far or not low <= end <= high
