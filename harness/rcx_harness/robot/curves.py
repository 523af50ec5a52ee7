"""The curves that a tool follows: line and arc, in 0.001 mm (0.001 degree where an axis turns)."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

__all__ = ["Arc", "Curve", "Line"]

_XYZ = 3
_FLAT = 1e-6  # sine of the angle below which three points count as one line


class Curve(Protocol):
    """A curve by the part of its length, 0 to 1.

    Attributes:
        length: Of the way of X, Y and Z; or of the other axes together, where that is longer.
        samples: Into how many parts it must be cut to look straight.
    """

    length: float
    samples: int

    def at(self, share: float) -> Sequence[float]:
        """Position of all axes after that part of the length."""


class Line:
    """Straight from start to end; all axes in proportion."""

    samples = 1

    def __init__(self, start: Sequence[float], end: Sequence[float]) -> None:
        self._start = tuple(start)
        self._way = tuple(b - a for a, b in zip(start, end, strict=True))
        self.length = max(math.hypot(*self._way[:_XYZ]), math.hypot(*self._way[_XYZ:]))

    def at(self, share: float) -> Sequence[float]:
        """Position of all axes after that part of the length."""
        return [a + way * share for a, way in zip(self._start, self._way, strict=True)]


class Arc:
    """The part of a circle from start through `via` to the end, by X, Y and Z.

    The other axes pass `via` with them and move evenly before and after it.

    Raises:
        ValueError: the three points lie on a line, so that there is no circle.
    """

    samples = 1024

    def __init__(self, start: Sequence[float], via: Sequence[float], end: Sequence[float]) -> None:
        self._others = [part[_XYZ:] for part in (start, via, end)]
        self._size = len(start)
        a, b, c = (_space(part) for part in (start, via, end))
        first, whole = _minus(b, a), _minus(c, a)
        normal = _cross(first, whole)
        if math.hypot(*normal) <= _FLAT * math.hypot(*first) * math.hypot(*whole):
            raise ValueError("no circle goes through three points on one line")
        bend = [_dot(first, first) * w - _dot(whole, whole) * f
                for f, w in zip(first, whole, strict=True)]  # fmt: skip
        to_centre = [part / (2 * _dot(normal, normal)) for part in _cross(bend, normal)]
        self._centre = [p + d for p, d in zip(a, to_centre, strict=True)]
        self._u = [-part for part in to_centre]  # from the centre to the start
        radius = math.hypot(*self._u)
        self._v = [part / math.hypot(*normal) for part in _cross(normal, self._u)]
        self._angle = self._angle_of(c)
        self._via = self._angle_of(b) / self._angle
        self.length = radius * self._angle

    def at(self, share: float) -> Sequence[float]:
        """Position of all axes after that part of the length."""
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
        """From the start to `point`, on the way that the arc takes [rad]."""
        arm = _minus(point, self._centre)
        return math.atan2(_dot(arm, self._v), _dot(arm, self._u)) % math.tau


def _space(point: Sequence[float]) -> list[float]:
    """X, Y and Z; axes that are not there are 0."""
    return [*point[:_XYZ], *[0.0] * (_XYZ - len(point))]


def _minus(p: Sequence[float], q: Sequence[float]) -> list[float]:
    return [a - b for a, b in zip(p, q, strict=True)]


def _dot(p: Sequence[float], q: Sequence[float]) -> float:
    return sum(a * b for a, b in zip(p, q, strict=True))


def _cross(p: Sequence[float], q: Sequence[float]) -> list[float]:
    return [p[(k + 1) % 3] * q[(k + 2) % 3] - p[(k + 2) % 3] * q[(k + 1) % 3] for k in range(3)]
