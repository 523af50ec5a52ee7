"""Coordinates of a robot in millimetres, and the curves on which its tool moves.

Coordinates 1 to 3 are X, Y and Z, the fourth is the rotation R about Z. A factor for each axis
converts pulses to joint values, and the kinematics convert joint values to the position of the
flange. The hand is the offset from the flange to the tool; a hand on the R axis turns with that
axis. The shift moves the coordinates and turns them about its own origin. Lengths are in 0.001 mm,
angles in 0.001 degree, as on the wire.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate
from typing import Protocol

from rcx_harness.robot.kinematics import CARTESIAN, Kinematics

__all__ = ["Arc", "Chain", "Curve", "Frame", "Line"]

_X, _Y, _R = 0, 1, 3
_NONE = (0.0, 0.0, 0.0, 0.0)
_XYZ = 3
_FLAT = 1e-6  # sine of the angle below which three points count as one line


@dataclass(frozen=True)
class Frame:
    """The coordinates of one robot.

    Attributes:
        pulses_per_mm: Pulses of each axis per mm, or per degree if the axis turns.
        shift: The selected shift of the coordinates: X, Y, Z and R.
        hand: The offset of the tool from the flange: X, Y and Z.
        on_r: Whether the hand is mounted on the R axis.
        zeros: Pulses of each axis at 0 mm or 0 degrees; empty if all are 0.
        kinematics: The kinematics of the robot; for a SCARA robot, with the hand system of
            `to_pulses`.
    """

    pulses_per_mm: tuple[float, ...]
    shift: Sequence[float] = _NONE
    hand: Sequence[float] = _NONE[:3]
    on_r: bool = False
    zeros: tuple[float, ...] = ()
    kinematics: Kinematics = CARTESIAN

    @property
    def straight(self) -> bool:
        """Return whether all axes move in proportion on a line of the tool without rotation."""
        return self.kinematics.straight

    @property
    def turning_hand(self) -> bool:
        """Return whether a turn of the R axis also moves the tool in X and Y."""
        return self.on_r and len(self.pulses_per_mm) > _R and any(self.hand[:2])

    def to_mm(self, pulses: Sequence[float]) -> tuple[float, ...]:
        """Convert pulses of the axes to the position of the tool in the shifted coordinates."""
        own = self.kinematics.forward(self._joints(pulses))
        if self._plain:
            return tuple(own)
        mm = _padded(own)
        tool = self._tool(mm[_R])
        mm = [mm[k] + tool[k] - self.shift[k] for k in range(4)] + mm[4:]
        mm[_X], mm[_Y] = _turned(mm[_X], mm[_Y], -self._turn)
        return tuple(mm[: len(own)])

    def to_pulses(self, mm: Sequence[float]) -> tuple[float, ...]:
        """Convert a position of the tool to pulses of the axes, which are not rounded."""
        own = list(mm)
        if not self._plain:
            own = _padded(own)
            own[_X], own[_Y] = _turned(own[_X], own[_Y], self._turn)
            tool = self._tool(own[_R] + self.shift[_R])
            own = [own[k] + self.shift[k] - tool[k] for k in range(4)] + own[4:]
        joints = zip(self.kinematics.inverse(own), self.pulses_per_mm, strict=False)
        return self._from_zero([value * per / 1000 for value, per in joints])

    def bend(self, pulses: Sequence[float]) -> float | None:
        """Return the bend of the arm [degree], positive if right-handed; None without an arm.

        The bend of the stretched arm is 0.
        """
        return self.kinematics.bend(self._joints(pulses))

    def tool_to_mm(self, mm: Sequence[float], way: Sequence[float]) -> tuple[float, ...]:
        """Return the position of the tool after a movement from `mm` by `way` in tool coordinates.

        If the hand is mounted on the R axis, the R axis turns the tool coordinates. Otherwise the
        tool coordinates are parallel to the coordinates of the robot.
        """
        ways = list(way)
        if self.on_r and len(mm) > _R:
            ways[_X], ways[_Y] = _turned(ways[_X], ways[_Y], mm[_R])
        return tuple(value + ways[k] for k, value in enumerate(mm))

    def _joints(self, pulses: Sequence[float]) -> list[float]:
        if self.zeros:
            pulses = [value - zero for value, zero in zip(pulses, self.zeros, strict=True)]
        return [value * 1000 / per for value, per in zip(pulses, self.pulses_per_mm, strict=True)]

    def _from_zero(self, pulses: Sequence[float]) -> tuple[float, ...]:
        zeros = self.zeros or (0.0,) * len(pulses)
        return tuple(value + zero for value, zero in zip(pulses, zeros, strict=False))

    @property
    def _plain(self) -> bool:
        return not any(self.shift) and not any(self.hand)

    @property
    def _turn(self) -> float:
        """Return the rotation of the shifted coordinates; 0 for a robot with one axis."""
        return self.shift[_R] if len(self.pulses_per_mm) > _Y else 0.0

    def _tool(self, r: float) -> tuple[float, float, float, float]:
        """Return the offset from the flange to the tool at the angle `r` of the R axis."""
        x, y, z = self.hand[:3]
        if self.turning_hand:
            x, y = _turned(x, y, r)
        return (x, y, z, 0.0)


def _padded(values: list[float]) -> list[float]:
    return values + [0.0] * (4 - len(values))


def _turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """Return X and Y, turned by `angle` [0.001 degree]."""
    if not angle:
        return (x, y)
    sine, cosine = math.sin(math.radians(angle / 1000)), math.cos(math.radians(angle / 1000))
    return (x * cosine - y * sine, x * sine + y * cosine)


class Curve(Protocol):
    """A curve of the tool. The part of its length, 0 to 1, determines a position on the curve.

    Attributes:
        length: Length in X, Y and Z, or the distance of the other axes together if that is longer.
        samples: Number of parts of the curve; each part is treated as straight.
    """

    length: float
    samples: int

    def at(self, share: float) -> Sequence[float]:
        """Return the position of all axes after a share of the length, 0 to 1."""


class Line:
    """A straight line from start to end; all axes move in proportion."""

    samples = 1

    def __init__(self, start: Sequence[float], end: Sequence[float]) -> None:
        self._start = tuple(start)
        self._way = tuple(b - a for a, b in zip(start, end, strict=True))
        self.length = max(math.hypot(*self._way[:_XYZ]), math.hypot(*self._way[_XYZ:]))

    def at(self, share: float) -> Sequence[float]:
        """Return the position of all axes after a share of the length, 0 to 1."""
        return [a + way * share for a, way in zip(self._start, self._way, strict=True)]


class Arc:
    """The part of a circle from start through `via` to the end, in X, Y and Z.

    The other axes reach their values of `via` at the same time. Before and after `via` they move
    evenly.

    Raises:
        ValueError: the three points are on a line, so there is no circle.
    """

    samples = 1024

    def __init__(self, start: Sequence[float], via: Sequence[float], end: Sequence[float]) -> None:
        self._others = [part[_XYZ:] for part in (start, via, end)]
        self._size = len(start)
        a, b, c = (_space(part) for part in (start, via, end))
        first, whole = _minus(b, a), _minus(c, a)
        # The centre of the circle is the circumcentre of the triangle start, via, end. Let f = via
        # - start, w = end - start and n = f x w. Then the centre is start + ((|f|^2 w - |w|^2 f) x
        # n) / (2 |n|^2). Points on one line have n = 0. `_v` is `_u` turned by 90 degrees in the
        # plane of the circle. The angle therefore grows from the start through `via` to the end.
        normal = _cross(first, whole)
        if math.hypot(*normal) <= _FLAT * math.hypot(*first) * math.hypot(*whole):
            raise ValueError("no circle goes through three points on one line")
        bend = [_dot(first, first) * w - _dot(whole, whole) * f
                for f, w in zip(first, whole, strict=True)]  # fmt: skip
        to_centre = [part / (2 * _dot(normal, normal)) for part in _cross(bend, normal)]
        self._centre = [p + d for p, d in zip(a, to_centre, strict=True)]
        self._u = [-part for part in to_centre]  # vector from the centre to the start
        radius = math.hypot(*self._u)
        self._v = [part / math.hypot(*normal) for part in _cross(normal, self._u)]
        self._angle = self._angle_of(c)
        self._via = self._angle_of(b) / self._angle
        self.length = radius * self._angle

    def at(self, share: float) -> Sequence[float]:
        """Return the position of all axes after a share of the length, 0 to 1."""
        cosine, sine = math.cos(share * self._angle), math.sin(share * self._angle)
        space = [p + u * cosine + v * sine
                 for p, u, v in zip(self._centre, self._u, self._v, strict=True)]  # fmt: skip
        if share < self._via:
            before, after, part = *self._others[:2], share / self._via
        else:
            before, after, part = *self._others[1:], (share - self._via) / (1 - self._via)
        others = [p + (q - p) * part for p, q in zip(before, after, strict=True)]
        return space[: self._size] + others

    def _angle_of(self, point: Sequence[float]) -> float:
        """Return the angle from the start to `point` in the direction of the arc [rad]."""
        arm = _minus(point, self._centre)
        return math.atan2(_dot(arm, self._v), _dot(arm, self._u)) % math.tau


class Chain:
    """A curve that joins several curves; each curve begins at the end of the curve before it."""

    def __init__(self, curves: Sequence[Curve]) -> None:
        """Join the curves; the length of at least one curve must be above 0."""
        self._curves = [curve for curve in curves if curve.length] or list(curves[:1])
        self._ends = [*accumulate(curve.length for curve in self._curves)]
        self.length = self._ends[-1]
        step = min(curve.length / max(_PARTS, curve.samples) for curve in self._curves)
        self.samples = min(_MOST_PARTS, math.ceil(self.length / step)) if step else 1

    def at(self, share: float) -> Sequence[float]:
        """Return the position of all axes after a share of the length, 0 to 1."""
        done = share * self.length
        k = min(bisect_left(self._ends, done), len(self._curves) - 1)
        curve = self._curves[k]
        if share >= 1.0 or not curve.length:
            return curve.at(1.0)
        return curve.at((done - self._ends[k] + curve.length) / curve.length)

    @property
    def last(self) -> float:
        """Return the position at which the last curve begins, as a part of the whole length."""
        return 1.0 - self._curves[-1].length / self.length if self.length else 0.0


#: The smallest number of samples for each curve of a chain, and the greatest number for the chain.
_PARTS, _MOST_PARTS = 64, 8192


def _space(point: Sequence[float]) -> list[float]:
    """Return X, Y and Z of a position; a missing coordinate is 0."""
    return [*point[:_XYZ], *[0.0] * (_XYZ - len(point))]


def _minus(p: Sequence[float], q: Sequence[float]) -> list[float]:
    return [a - b for a, b in zip(p, q, strict=True)]


def _dot(p: Sequence[float], q: Sequence[float]) -> float:
    return sum(a * b for a, b in zip(p, q, strict=True))


def _cross(p: Sequence[float], q: Sequence[float]) -> list[float]:
    return [p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3] for k in range(3)]
