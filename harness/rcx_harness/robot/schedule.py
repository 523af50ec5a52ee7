"""The timing of a tool on a curve, if the axes do not move in proportion to the tool."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import accumulate, pairwise

from rcx_harness.spec.wire import CYCLE_US

__all__ = ["AxisLimits", "Schedule"]


@dataclass(frozen=True)
class AxisLimits:
    """One axis of a movement along a curve, with its positions and limits.

    Attributes:
        places: Positions of the axis [pulses] after each of the equal steps of the path.
        speed: Highest speed [pulses/s].
        up: Acceleration [pulses/s^2].
        down: Deceleration [pulses/s^2].
    """

    places: Sequence[float]
    speed: float
    up: float
    down: float


#: A step counts as straight if its bend needs at most this part of the acceleration for bends.
_STRAIGHT = 0.01
#: A bend is a corner if it is _CORNER times as strong as the bends before and after it. At a corner
#: the axes change their speeds within one controller cycle, _CYCLE [s].
_CORNER, _CYCLE = 4, CYCLE_US / 1e6


class Schedule:
    """The times of equal steps of a path, as short as the limits of all axes allow.

    The acceleration is constant between two steps. Half of an axis' acceleration is reserved for
    speed changes that the curve causes. The other half is for the acceleration of the tool.
    """

    def __init__(
        self, length: float, speed: float | Sequence[float], axes: Sequence[AxisLimits],
        *, straights: bool = False,
    ) -> None:  # fmt: skip
        """Plan a path of `length` (any unit, above 0) with at most `speed` in that unit/s.

        The speed is one number, or one number for each position in `places`. With `straights`,
        corners are allowed, and on straight parts no acceleration is reserved for bends.
        """
        steps = len(axes[0].places) - 1
        step = length / steps
        speeds = [speed] * (steps + 1) if isinstance(speed, (int, float)) else list(speed)
        ups, downs = [math.inf] * steps, [math.inf] * steps
        for axis in axes:
            rates = [(after - before) / step for before, after in pairwise(axis.places)]
            ramp = min(axis.up, axis.down) / 2
            bends = [0.0, *(abs(after - before) / step for before, after in pairwise(rates)), 0.0]
            for k, rate in enumerate(rates):
                if rate:
                    most = axis.speed / abs(rate)
                    speeds[k], speeds[k + 1] = min(speeds[k], most), min(speeds[k + 1], most)
                    fastest = min(speeds[k], speeds[k + 1])
                    bent = max(bends[k], bends[k + 1]) * fastest**2 > ramp * _STRAIGHT
                    part = 2 if bent or not straights else 1
                    ups[k] = min(ups[k], axis.up / part / abs(rate))
                    downs[k] = min(downs[k], axis.down / part / abs(rate))
            for k, bend in enumerate(bends):
                if bend:
                    speeds[k] = min(speeds[k], math.sqrt(ramp / bend))
                    if straights and bend > _CORNER * max(bends[k - 1], bends[k + 1]):
                        speeds[k] = min(speeds[k], ramp * _CYCLE / (bend * step))
        # `speeds` now has the highest speed at each step, from the axes' speeds and curvatures. It
        # must also be reachable. The forward pass limits each speed to what the acceleration
        # allows from the step before (v^2 = v0^2 + 2 a s). The backward pass does the same with
        # the deceleration, so that the tool stops at the end.
        speeds[0] = speeds[-1] = 0.0
        for k in range(steps):
            speeds[k + 1] = min(speeds[k + 1], math.sqrt(speeds[k] ** 2 + 2 * ups[k] * step))
        for k in reversed(range(steps)):
            speeds[k] = min(speeds[k], math.sqrt(speeds[k + 1] ** 2 + 2 * downs[k] * step))
        spans = [2 * step / (before + after) for before, after in pairwise(speeds)]
        self._speeds, self._step, self._steps = speeds, step, steps
        self._times = [0.0, *accumulate(spans)]

    @property
    def seconds(self) -> float:
        """Return the time from start to end [s]."""
        return self._times[-1]

    def share(self, t: float) -> float:
        """Return the share of the path, 0 to 1, that is covered `t` seconds after the start."""
        if t >= self.seconds:
            return 1.0
        k = min(bisect_right(self._times, t), self._steps) - 1
        since, span = t - self._times[k], self._times[k + 1] - self._times[k]
        first, last = self._speeds[k], self._speeds[k + 1]
        done = first * since + (last - first) * since * since / (2 * span)
        return (k + done / self._step) / self._steps
