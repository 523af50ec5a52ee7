"""The paths of a robot: positions as a function of the time since the start.

PTP: all axes start and end together. Line and arc: the tool follows a curve in millimetres. Arch:
the arch axis moves to its arch position, the other axes move to the target, then the arch axis
moves to its target. Positions are in pulses. The manual gives no motion times, so each path has
constant acceleration, constant speed and constant deceleration. A short path has no phase of
constant speed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rcx_harness.robot.alarms import SOFT_LIMIT, CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.geometry import Arc, Chain, Curve, Frame, Line
from rcx_harness.robot.schedule import AxisLimits, Schedule

__all__ = [
    "Arch",
    "ArchPath",
    "AxisMove",
    "CurvePath",
    "Leg",
    "Pace",
    "Path",
    "Profile",
    "PtpPath",
    "plan_arc",
    "plan_arch",
    "plan_chain",
    "plan_line",
    "plan_ptp",
]

_TURNING_SAMPLES = 256  # number of samples of a line on which the hand or an arm turns


@dataclass(frozen=True)
class Profile:
    """A speed profile: seconds of acceleration, constant speed and deceleration."""

    up: float = 0.0
    even: float = 0.0
    down: float = 0.0

    @classmethod
    def over(cls, way: float, speed: float, acceleration: float, deceleration: float) -> Profile:
        """Return the fastest profile for a distance `way` (not below 0).

        The limits are in the unit of the distance per s and per s^2.
        """
        peak = min(
            speed,
            math.sqrt(2 * way * acceleration * deceleration / (acceleration + deceleration)),
        )
        if peak == 0:
            return cls()
        up, down = peak / acceleration, peak / deceleration
        return cls(up, way / peak - (up + down) / 2, down)

    @property
    def seconds(self) -> float:
        """Return the time from start to end [s]."""
        return self.up + self.even + self.down

    def share(self, t: float) -> float:
        """Return the share of the distance, 0 to 1, that is covered `t` seconds after the start."""
        if t >= self.seconds:
            return 1.0
        whole = self._whole
        if t < self.up:
            return t * t / (2 * self.up) / whole
        if t < self.up + self.even:
            return (t - self.up / 2) / whole
        left = self.seconds - t
        return 1.0 - left * left / (2 * self.down) / whole

    def when(self, share: float) -> float:
        """Return the time [s] at which a share of the distance is covered; inverse of `share`."""
        done = share * self._whole
        if done < self.up / 2:
            return math.sqrt(2 * done * self.up)
        if done < self.up / 2 + self.even:
            return done + self.up / 2
        return self.seconds - math.sqrt(2 * (self._whole - done) * self.down)

    @property
    def _whole(self) -> float:
        """Return the distance divided by the peak speed [s]."""
        return self.up / 2 + self.even + self.down / 2


@dataclass(frozen=True)
class AxisMove:
    """The movement of one axis: index, start and target [pulses], and limits of speed and ramps."""

    axis: int
    start: int
    target: int
    speed: float
    acceleration: float
    deceleration: float

    @property
    def way(self) -> int:
        """Return the distance from start to target [pulses], with its sign."""
        return self.target - self.start

    def profile(self) -> Profile:
        """Return the fastest speed profile of the axis from start to target."""
        return Profile.over(abs(self.way), self.speed, self.acceleration, self.deceleration)


class Path:
    """A path to a target. It never changes, so a snapshot needs no copy.

    Attributes:
        target: Target [pulses] of each moving axis by its index.
        seconds: Time from start to target.
        arrival: Name of the parameter with the distance to the target at which an axis counts as
            arrived.
        approach: Earliest time [s] at which an axis counts as arrived. Before it, an axis may pass
            its target without having arrived.
    """

    target: Mapping[int, int]
    seconds: float
    arrival: str
    approach: float

    def at(self, t: float) -> Mapping[int, float]:
        """Return the positions of the moving axes `t` seconds after the start, before the end."""
        raise NotImplementedError

    def __deepcopy__(self, memo: object) -> Path:
        return self


class PtpPath(Path):
    """A PTP path: all axes start and end together; the slowest axis moves as fast as it can."""

    arrival = "TOLE"

    def __init__(self, moves: Sequence[AxisMove]) -> None:
        self._moves = tuple(moves)
        profiles = (move.profile() for move in moves)
        self._profile = max(profiles, key=lambda profile: profile.seconds, default=Profile())
        self.target = {move.axis: move.target for move in moves}
        self.seconds = self._profile.seconds
        self.approach = 0.0

    def at(self, t: float) -> Mapping[int, float]:
        """Return the positions at time `t`; every axis has moved the same part of its distance."""
        share = self._profile.share(t)
        return {move.axis: move.start + move.way * share for move in self._moves}


class CurvePath(Path):
    """A path of the tool along a curve; the axes follow from the tool's position in millimetres."""

    arrival = "TOLE"

    def __init__(
        self, curve: Curve, profile: Profile | Schedule, frame: Frame, axes: Mapping[int, int],
        target: Mapping[int, int], approach: float | None = None,
    ) -> None:  # fmt: skip
        """Plan the path; `axes` maps axis indices in the robot to indices in the controller."""
        self._curve, self._profile, self._frame = curve, profile, frame
        self._axes = dict(axes)
        self.target = dict(target)
        self.seconds = profile.seconds
        self.approach = profile.seconds / 2 if approach is None else approach

    def at(self, t: float) -> Mapping[int, float]:
        """Return the positions of the axes at the point of the curve for the time `t`."""
        pulses = self._frame.to_pulses(self._curve.at(self._profile.share(t)))
        return {index: pulses[place] for place, index in self._axes.items()}


class ArchPath(Path):
    """An arch: the arch axis rises, the other axes move, and the arch axis falls (guide, 4.2.1).

    The other axes start when the arch axis has moved distance 1 or has reached the arch position.
    The arch axis leaves the arch position early: when the other axes arrive, it is still distance 2
    away from its target. If distance 2 is longer than its whole way to the target, the arch axis
    waits for the other axes.
    """

    arrival = "OUTPOS"

    def __init__(
        self, rise: AxisMove, fall: AxisMove, others: PtpPath, distance1: int, distance2: int
    ) -> None:
        """Combine `rise` and `fall` of the arch axis with the path of the other axes [pulses]."""
        self._rise, self._fall, self._others = rise, fall, others
        self._up, self._down = rise.profile(), fall.profile()
        self._others_start = self._up.when(_part(distance1, rise.way))
        arrival = self._others_start + others.seconds
        leaves = self._down.when(1 - _part(distance2, fall.way))
        self._fall_start = max(self._up.seconds, arrival - leaves)
        self.approach = self._fall_start
        self.target = {**others.target, fall.axis: fall.target}
        self.seconds = self._fall_start + self._down.seconds

    def at(self, t: float) -> Mapping[int, float]:
        """Return the positions of the arch axis and of the other axes at time `t`."""
        if t < self._fall_start:
            arch = self._rise.start + self._rise.way * self._up.share(t)
        else:
            arch = self._fall.start + self._fall.way * self._down.share(t - self._fall_start)
        others = self._others.at(min(max(0.0, t - self._others_start), self._others.seconds))
        return {**others, self._rise.axis: arch}


def _part(distance: int, way: int) -> float:
    """Return an arch distance as a part of the whole distance of the arch axis, at most 1."""
    return min(1.0, distance / abs(way)) if way else 1.0


@dataclass(frozen=True)
class Pace:
    """The speed and the accelerations of a movement.

    Attributes:
        share: Speed as a part of the maximum of the axes; on lines and arcs, of the tool.
        up: Acceleration as a part of the maximum; None: parameter ACCEL of each axis.
        down: Deceleration as a part of the maximum; None: parameter DECEL of each axis.
        mm_per_s: Speed of the tool on lines and arcs; `share` then limits only the axes.
    """

    share: float = 1.0
    up: float | None = None
    down: float | None = None
    mm_per_s: float | None = None


@dataclass(frozen=True)
class Arch:
    """The index of the arch axis in the robot, its arch position and arch distances [pulses]."""

    place: int
    position: int
    distance1: int
    distance2: int


def plan_ptp(arm: Arm, target: Mapping[int, int], pace: Pace) -> PtpPath:
    """Plan a PTP path: all axes start and end together.

    Raises:
        CommandError: the target is beyond a soft limit.
    """
    start = arm.here
    return PtpPath(
        [_axis_move(arm, place, (start[place], end), pace) for place, end in target.items()]
    )


def plan_arch(arm: Arm, target: Mapping[int, int], pace: Pace, arch: Arch) -> Path:
    """Plan an arch to a target (see ArchPath).

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
    """Plan a straight line of the tool; it rotates in proportion to the distance.

    Raises:
        CommandError: the target or a position on the line is beyond a soft limit.
    """
    frame = arm.frame
    line = Line(frame.to_mm(arm.here), frame.to_mm(_completed(arm, target)))
    return _curve(arm, frame, line, target, pace)


def plan_arc(arm: Arm, via: Mapping[int, int], target: Mapping[int, int], pace: Pace) -> Path:
    """Plan an arc of the tool from its current position through `via` to the target.

    Raises:
        CommandError: the three points lie on a line, or a position on the arc is beyond a soft
            limit.
    """
    frame = arm.frame
    points = (_completed(arm, places) for places in ({}, via, target))
    try:
        arc = Arc(*(frame.to_mm(point) for point in points))
    except ValueError:
        raise CommandError(arm.config.no_circle_alarm) from None
    return _curve(arm, frame, arc, target, pace)


@dataclass(frozen=True)
class Leg:
    """A line or an arc of a chained path: its targets [pulses] by the axis in the robot, its pace.

    An arc has two targets: a point on the arc, and the end of the arc.
    """

    targets: tuple[Mapping[int, int], ...]
    pace: Pace


def plan_chain(
    arm: Arm, start: Sequence[int], legs: Sequence[Leg], *, resumed: bool = False
) -> Path:
    """Plan a path of lines and arcs that follow each other without a stop between them.

    At a corner the tool slows down as far as the accelerations of the axes require.

    Args:
        arm: The robot.
        start: The start of the path [pulses].
        legs: The lines and arcs of the path.
        resumed: Whether a stop has interrupted the movement. The robot must then be on the path,
            and moves on the rest of the path. Otherwise the robot must be within OUTPOS of the
            start.

    Raises:
        CommandError: the robot is neither on the path nor at its start, an arc has no circle, or a
            soft limit is exceeded.
    """
    frame, curves = arm.frame, list[Curve]()
    at = frame.to_mm(start)
    for leg in legs:
        *via, end = (frame.to_mm(_completed(arm, target)) for target in leg.targets)
        try:
            curves.append(Arc(at, via[0], end) if via else Line(at, end))
        except ValueError:
            raise CommandError(arm.config.no_circle_alarm) from None
        at = end
    away = [abs(a - b) > arm.parameter("OUTPOS", k)
            for k, (a, b) in enumerate(zip(start, arm.here, strict=True))]  # fmt: skip
    first = 0
    if any(away) and resumed:
        first, curves = _rest(arm, curves)
    elif any(away):
        raise CommandError(arm.config.program_path_alarm)
    chain = Chain(curves)
    target = dict(enumerate(arm.here)) | dict(legs[-1].targets[-1])
    shares = [curve.length / chain.length if chain.length else 0.0 for curve in curves]
    speeds = [_tool_speed(arm, leg.pace) for leg in legs[first:]]
    slowest = Pace(
        max(leg.pace.share for leg in legs),
        min((leg.pace.up for leg in legs if leg.pace.up is not None), default=None),
        min((leg.pace.down for leg in legs if leg.pace.down is not None), default=None),
    )
    return _curve(arm, frame, chain, target, slowest, list(zip(shares, speeds, strict=True)))


def _rest(arm: Arm, curves: Sequence[Curve]) -> tuple[int, list[Curve]]:
    """Return the number of the curve on which the robot is, and the rest of the curves."""
    here = arm.frame.to_mm(arm.here)
    places = [(math.dist(curve.at(k / _RESUMED), here), n, k / _RESUMED)
              for n, curve in enumerate(curves) for k in range(_RESUMED + 1)]  # fmt: skip
    distance, number, share = min(places)
    curve = curves[number]
    if distance > max(curve.length / _RESUMED, _OFF_PATH):
        raise CommandError(arm.config.program_path_alarm)
    end = curve.at(1.0)
    rest: Curve = Line(here, end)
    if isinstance(curve, Arc) and share < _NEARLY:
        rest = Arc(here, curve.at((share + 1) / 2), end)
    return number, [rest, *curves[number + 1 :]]


#: Constants for the continuation after a stop. The robot's position is compared with _RESUMED
#: positions on each curve. Up to _OFF_PATH [0.001 mm] away the robot counts as on the path. Beyond
#: the part _NEARLY of an arc, the rest of the arc is replaced by a line.
_RESUMED, _OFF_PATH, _NEARLY = 256, 1000, 0.99


def _tool_speed(arm: Arm, pace: Pace) -> float:
    """Return the highest speed of the tool for a movement with the given pace [mm/s]."""
    return arm.line_speed * pace.share if pace.mm_per_s is None else pace.mm_per_s


def _axis_move(arm: Arm, place: int, way: tuple[int, int], pace: Pace) -> AxisMove:
    """Return the movement of one axis; raise CommandError if its target exceeds a soft limit."""
    axis = arm.axes[place]
    if not axis.soft_low <= way[1] <= axis.soft_high:
        raise CommandError(SOFT_LIMIT, axis=place + 1)
    up, down = _ramps(arm, place, pace)
    return AxisMove(arm.indices[place], *way, axis.max_speed * pace.share, up, down)


def _ramps(arm: Arm, place: int, pace: Pace) -> tuple[float, float]:
    """Return acceleration and deceleration of an axis [pulses/s^2]."""
    up, down = (
        arm.parameter(name, place) / 100 if given is None else given
        for name, given in (("ACCEL", pace.up), ("DECEL", pace.down))
    )
    highest = arm.acceleration(place)
    return highest * up, highest * down


def _completed(arm: Arm, target: Mapping[int, int]) -> tuple[int, ...]:
    """Return the positions of all axes at the end [pulses]; axes without a target do not move."""
    return tuple(target.get(place, now) for place, now in enumerate(arm.here))


def _curve(
    arm: Arm,
    frame: Frame,
    curve: Curve,
    target: Mapping[int, int],
    pace: Pace,
    parts: Sequence[tuple[float, float]] = (),
) -> Path:
    """Plan the fastest path along a curve on which no axis exceeds its limits.

    `parts` has an entry for each curve of a Chain: its share of the length, and its speed [mm/s].
    """
    turning = frame.turning_hand or not frame.straight
    samples = max(curve.samples, _TURNING_SAMPLES if turning else 1)
    every = [frame.to_pulses(curve.at(k / samples)) for k in range(samples + 1)]
    _keep_hand(arm, frame, every, _completed(arm, target))
    length = curve.length / 1000
    limits = []
    for place in target:
        axis = arm.axes[place]
        values = [pulses[place] for pulses in every]
        if _leaves(values, axis.soft_low, axis.soft_high):
            raise CommandError(SOFT_LIMIT, axis=place + 1)
        speed = axis.max_speed * pace.share
        limits.append(AxisLimits(values, speed, *_ramps(arm, place, pace)))
    speed = _tool_speed(arm, pace)
    profile: Profile | Schedule = (
        _even(length, speed, limits, samples)
        if not length or (frame.straight and not isinstance(curve, Chain))
        else Schedule(
            length, _speeds(parts, samples) if parts else speed, limits, straights=bool(parts)
        )
    )
    axes = {place: arm.indices[place] for place in target}
    ends = {arm.indices[place]: end for place, end in target.items()}
    approach = _when(profile, curve.last) if isinstance(curve, Chain) else None
    return CurvePath(curve, profile, frame, axes, ends, approach)


def _speeds(parts: Sequence[tuple[float, float]], samples: int) -> list[float]:
    """Return the highest speed at each position of a chain; at a joint, the lower speed applies."""
    speeds = [math.inf] * (samples + 1)
    begin = 0.0
    for share, speed in parts:
        end = begin + share
        for k in range(math.floor(begin * samples), min(samples, math.ceil(end * samples)) + 1):
            speeds[k] = min(speeds[k], speed)
        begin = end
    return speeds


def _when(profile: Profile | Schedule, share: float) -> float:
    """Return the time [s] at which a share of the distance is covered, searched by bisection."""
    low, high = 0.0, profile.seconds
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if profile.share(middle) < share else (low, middle)
    return low


_HALVINGS = 40


def _even(length: float, speed: float, limits: Sequence[AxisLimits], samples: int) -> Profile:
    """Return a speed profile whose limits are the same on the whole path."""
    speeds, ramps = [speed], []
    for axis in limits:
        step = max(abs(after - before) for before, after in pairwise(axis.places))
        if length and step:
            rate = step * samples / length  # pulses of the axis for each mm of the tool
            speeds.append(axis.speed / rate)
            ramps.append([axis.up / rate, axis.down / rate])
    up, down = (min(kind) for kind in zip(*ramps, strict=True)) if ramps else (1.0, 1.0)
    return Profile.over(length if ramps else 0.0, min(speeds), up, down)


def _keep_hand(
    arm: Arm, frame: Frame, every: Sequence[Sequence[float]], end: Sequence[int]
) -> None:
    """Check that a curve keeps the hand system and does not come too near to the stretched arm.

    Raises:
        CommandError: the hand system changes, or the arm is stretched too far.
    """
    bends = [bend for pulses in every if (bend := frame.bend(pulses)) is not None]
    if not bends:
        return
    if min(map(abs, bends)) < arm.config.outer_angle:
        raise CommandError(arm.config.outer_range_alarm)
    if (frame.bend(end) or 0.0) * bends[0] < 0:
        to_left = bends[0] > 0
        raise CommandError(arm.config.to_left_alarm if to_left else arm.config.to_right_alarm)


def _leaves(values: Sequence[float], low: int, high: int) -> bool:
    """Return whether an axis exceeds its soft limits; a way back into the limits is allowed."""
    start, *_, end = (round(value) for value in values)
    far = round(min(values)) < min(low, start) or round(max(values)) > max(high, start)
    return far or not low <= end <= high
