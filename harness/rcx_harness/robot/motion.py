"""A point-to-point movement: all axes start and end together, the slowest with a trapezoid.

The manual gives no motion times. This profile is the usual one: constant acceleration, constant
speed, constant deceleration; without the speed phase where the way is too short for it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["AxisMove", "Movement"]


@dataclass(frozen=True)
class AxisMove:
    """One axis of a movement: index, way in pulses, limits in pulses/s and pulses/s^2."""

    axis: int
    start: int
    target: int
    speed: float
    acceleration: float
    deceleration: float

    def phases(self) -> tuple[float, float, float]:
        """Seconds of acceleration, constant speed and deceleration."""
        way = abs(self.target - self.start)
        peak = min(
            self.speed,
            math.sqrt(2 * way * self.acceleration * self.deceleration
                      / (self.acceleration + self.deceleration)),
        )  # fmt: skip
        if peak == 0:
            return (0.0, 0.0, 0.0)
        up, down = peak / self.acceleration, peak / self.deceleration
        return (up, way / peak - (up + down) / 2, down)


class Movement:
    """A movement under way.

    Attributes:
        done: It has reached its target.
        stopped_by: Number of the alarm that stopped it on its way, else empty.
    """

    def __init__(self, moves: Sequence[AxisMove], start_us: int) -> None:
        self._moves = tuple(moves)
        self._start_us = start_us
        self._phases = max((move.phases() for move in moves), key=sum, default=(0.0, 0.0, 0.0))
        self.done = False
        self.stopped_by = ""

    @property
    def duration_us(self) -> int:
        """From start to target [us]."""
        return math.ceil(round(sum(self._phases) * 1e6, 3))  # no cycle more for 1e-9 us

    def advance(self, now_us: int, positions: list[int]) -> None:
        """Put the moving axes of `positions` [pulses] where they are at `now_us`."""
        passed = now_us - self._start_us
        self.done = passed >= self.duration_us
        share = 1.0 if self.done else self._share(passed / 1e6)
        for move in self._moves:
            positions[move.axis] = move.start + round((move.target - move.start) * share)

    def _share(self, t: float) -> float:
        """Part of the way that is done `t` seconds after the start, 0 to 1."""
        up, even, down = self._phases
        whole = up / 2 + even + down / 2  # the way, in units of the peak speed
        if t < up:
            return t * t / (2 * up) / whole
        if t < up + even:
            return (t - up / 2) / whole
        left = up + even + down - t
        return 1.0 - left * left / (2 * down) / whole
