"""Forward and inverse kinematics of the robots, in closed form.

Joint values are in 0.001 degree for a turning joint, else in 0.001 mm. Positions are X, Y, Z [0.001
mm] and R [0.001 degree] in the robot's own coordinates. Further axes follow unconverted. Z is
positive downwards, as the controller counts it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["CARTESIAN", "Kinematics", "Scara", "UnreachableError"]

_X, _Y, _Z, _R = range(4)
_UNIT = 1000.0  # number of joint units (0.001 degree) in one degree
_HALF_TURN, _TURN = 180 * _UNIT, 360 * _UNIT


class UnreachableError(ValueError):
    """The error for a position that the robot cannot reach."""


@dataclass(frozen=True)
class _Cartesian:
    """The kinematics of a Cartesian robot: each axis is a coordinate."""

    straight = True
    left = False

    def forward(self, joints: Sequence[float]) -> list[float]:
        """Convert joint values to a position: the values are the same."""
        return list(joints)

    def inverse(self, place: Sequence[float]) -> list[float]:
        """Convert a position to joint values: the values are the same."""
        return list(place)

    def bend(self, joints: Sequence[float]) -> float | None:
        """Return None, because a Cartesian robot has no arm that bends."""
        return None


CARTESIAN = _Cartesian()


@dataclass(frozen=True)
class Scara:
    """Two arms that turn about vertical axes, then Z and R.

    At 0 degrees of axes 1 and 2 the arms are stretched along Y, the front; positive angles turn
    from X to Y. R is the sum of the three angles plus 90 degrees, so R is 90 for the stretched arm.
    If axis 2 is positive, the arm is right-handed: the elbow is on the right of the line from the
    base to the hand.

    Attributes:
        arm1: Length of arm 1 [0.001 mm].
        arm2: Length of arm 2 [0.001 mm].
        offset: Angle between arm 2 and the line from the elbow to the hand [0.001 degree]; 0 if the
            hand is on the R axis.
        left: Whether the left-handed solution for the joints is used; otherwise the right-handed
            solution.
    """

    arm1: float
    arm2: float
    offset: float = 0.0
    left: bool = False

    straight = False
    _front = 90 * _UNIT

    def forward(self, joints: Sequence[float]) -> list[float]:
        """Convert joint values to the position of the flange."""
        first = self._front + joints[_X]
        second = first + joints[_Y] + self.offset
        x1, y1 = _polar(self.arm1, first)
        x2, y2 = _polar(self.arm2, second)
        r = [second - self.offset + joints[_R]] if len(joints) > _R else []
        return [x1 + x2, y1 + y2, *joints[_Z:_R], *r, *joints[_R + 1 :]]

    def inverse(self, place: Sequence[float]) -> list[float]:
        """Convert a position to joint values; axes 1 and 2 are from -180 to 180 degrees."""
        # The law of cosines gives the bend at the elbow from the distance to the base. Both signs
        # of the bend are solutions, and `left` selects one. Axis 1 is the direction of the hand
        # minus the direction that the hand has with axis 1 at 0. The tolerance of 1e-12 accepts the
        # stretched arm in spite of rounding.
        x, y = place[_X], place[_Y]
        far = x * x + y * y
        cosine = (far - self.arm1**2 - self.arm2**2) / (2 * self.arm1 * self.arm2)
        if abs(cosine) > 1 + 1e-12:
            raise UnreachableError(f"{math.hypot(x, y) / _UNIT:.3f} mm from the base")
        bend = math.degrees(math.acos(max(-1.0, min(1.0, cosine)))) * _UNIT
        if self.left:
            bend = -bend
        elbow_x, elbow_y = _polar(self.arm2, bend)
        first = math.degrees(math.atan2(y, x) - math.atan2(elbow_y, self.arm1 + elbow_x)) * _UNIT
        first = (first - self._front + _HALF_TURN) % _TURN - _HALF_TURN
        second = math.remainder(bend - self.offset, _TURN)
        r = [place[_R] - self._front - first - second] if len(place) > _R else []
        return [first, second, *place[_Z:_R], *r, *place[_R + 1 :]]

    def bend(self, joints: Sequence[float]) -> float | None:
        """Return the angle between arm 1 and the line from the elbow to the hand [degree]."""
        angle = joints[_Y] + self.offset
        return ((angle + _HALF_TURN) % _TURN - _HALF_TURN) / _UNIT


#: The kinematics of a robot type. `straight`: the joints move in proportion while the tool moves on
#: a line. `left`: the left-handed solution is used.
Kinematics = _Cartesian | Scara


def _polar(length: float, angle: float) -> tuple[float, float]:
    """Return X and Y of an arm at `angle` [0.001 degree]."""
    turned = math.radians(angle / _UNIT)
    return length * math.cos(turned), length * math.sin(turned)
