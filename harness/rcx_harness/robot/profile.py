"""How far a movement has come: constant acceleration, constant speed, constant deceleration.

The manual gives no motion times; this is the usual profile, without the speed phase where the way
is too short for it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

__all__ = ["Profile"]


@dataclass(frozen=True)
class Profile:
    """Seconds of acceleration, constant speed and deceleration."""

    up: float = 0.0
    even: float = 0.0
    down: float = 0.0

    @classmethod
    def over(cls, way: float, speed: float, acceleration: float, deceleration: float) -> Profile:
        """The fastest profile over `way` (not below 0), in any unit, that unit/s and unit/s^2."""
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
        """From start to end."""
        return self.up + self.even + self.down

    def share(self, t: float) -> float:
        """Part of the way that is done `t` seconds after the start, 0 to 1."""
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
        """Seconds after the start when that part of the way is done: `share` the other way."""
        if share >= 1 or self.seconds == 0:
            return self.seconds
        done = share * self._whole
        if done < self.up / 2:
            return math.sqrt(2 * done * self.up)
        if done < self.up / 2 + self.even:
            return done + self.up / 2
        return self.seconds - math.sqrt(2 * (self._whole - done) * self.down)

    @property
    def _whole(self) -> float:
        """The way, in units of the peak speed."""
        return self.up / 2 + self.even + self.down / 2
