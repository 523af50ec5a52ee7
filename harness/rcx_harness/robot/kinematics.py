"""From pulses to millimetres and back: Cartesian axes, the selected shift and hand.

Axes 1 to 3 are X, Y and Z, axis 4 is the rotation R about Z; each is pulses by a factor. The hand
is where the tool is, seen from the axes; one that is mounted on the R axis turns with it. The shift
moves the coordinates, and turns them about its own origin. Lengths are in 0.001 mm, angles in 0.001
degree, as on the wire.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["Frame"]

_X, _Y, _R = 0, 1, 3
_NONE = (0.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Frame:
    """The coordinates of one robot.

    Attributes:
        pulses_per_mm: Per axis, as many as the robot has; per degree where it turns.
        shift: X, Y, Z and R of the coordinates.
        hand: X, Y and Z of the tool.
        on_r: The hand is mounted on the R axis.
    """

    pulses_per_mm: tuple[float, ...]
    shift: Sequence[float] = _NONE
    hand: Sequence[float] = _NONE[:3]
    on_r: bool = False

    @property
    def turning_hand(self) -> bool:
        """A turn of the R axis moves the tool."""
        return self.on_r and len(self.pulses_per_mm) > _R and any(self.hand[:2])

    def to_mm(self, pulses: Sequence[float]) -> tuple[float, ...]:
        """Where the tool is, in the shifted coordinates."""
        own = [value * 1000 / per for value, per in zip(pulses, self.pulses_per_mm, strict=True)]
        if self._plain:
            return tuple(own)
        mm = _padded(own)
        tool = self._tool(mm[_R])
        mm = [mm[k] + tool[k] - self.shift[k] for k in range(4)] + mm[4:]
        mm[_X], mm[_Y] = _turned(mm[_X], mm[_Y], -self._turn)
        return tuple(mm[: len(own)])

    def to_pulses(self, mm: Sequence[float]) -> tuple[float, ...]:
        """Where the axes are when the tool is at `mm`; not rounded."""
        own = list(mm)
        if not self._plain:
            own = _padded(own)
            own[_X], own[_Y] = _turned(own[_X], own[_Y], self._turn)
            tool = self._tool(own[_R] + self.shift[_R])
            own = [own[k] + self.shift[k] - tool[k] for k in range(4)] + own[4:]
        return tuple(
            value * per / 1000 for value, per in zip(own, self.pulses_per_mm, strict=False)
        )

    def tool_to_mm(self, mm: Sequence[float], way: Sequence[float]) -> tuple[float, ...]:
        """Where the tool at `mm` gets to on a way that is given in its own coordinates.

        These are turned by the R axis where the hand is mounted on it, else they lie as the
        coordinates themselves.
        """
        ways = list(way)
        if self.on_r and len(mm) > _R:
            ways[_X], ways[_Y] = _turned(ways[_X], ways[_Y], mm[_R])
        return tuple(value + ways[k] for k, value in enumerate(mm))

    @property
    def _plain(self) -> bool:
        return not any(self.shift) and not any(self.hand)

    @property
    def _turn(self) -> float:
        """Angle of the coordinates; a robot with one axis has no plane to turn."""
        return self.shift[_R] if len(self.pulses_per_mm) > _Y else 0.0

    def _tool(self, r: float) -> tuple[float, float, float, float]:
        """The tool as seen from the axes, at the angle `r` of the R axis."""
        x, y, z = self.hand[:3]
        if self.turning_hand:
            x, y = _turned(x, y, r)
        return (x, y, z, 0.0)


def _padded(values: list[float]) -> list[float]:
    return values + [0.0] * (4 - len(values))


def _turned(x: float, y: float, angle: float) -> tuple[float, float]:
    """X and Y, turned by `angle` [0.001 degree]."""
    if not angle:
        return (x, y)
    sine, cosine = math.sin(math.radians(angle / 1000)), math.cos(math.radians(angle / 1000))
    return (x * cosine - y * sine, x * sine + y * cosine)
