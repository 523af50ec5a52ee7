"""The ways that a robot can take, each a function of the time since its start.

PTP: all axes start and end together. Line and arc: the tool follows a curve in millimetres. Arch:
one axis gets out of the way, the others follow, and it comes back. Positions are in pulses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from rcx_harness.robot.curves import Curve
from rcx_harness.robot.kinematics import Frame
from rcx_harness.robot.profile import Profile

__all__ = ["ArchPath", "AxisMove", "CurvePath", "Path", "PtpPath"]


@dataclass(frozen=True)
class AxisMove:
    """One axis of a movement: index, way in pulses, limits in pulses/s and pulses/s^2."""

    axis: int
    start: int
    target: int
    speed: float
    acceleration: float
    deceleration: float

    @property
    def way(self) -> int:
        """From start to target [pulses], with its sign."""
        return self.target - self.start

    def profile(self) -> Profile:
        """As fast as this axis can."""
        return Profile.over(abs(self.way), self.speed, self.acceleration, self.deceleration)


class Path(Protocol):
    """A way to a target; it never changes."""

    @property
    def target(self) -> Mapping[int, int]:
        """Index of each axis that moves, and where it ends."""

    @property
    def seconds(self) -> float:
        """From start to target."""

    @property
    def arrival(self) -> str:
        """Parameter that says how near to its target an axis counts as arrived."""

    @property
    def approach(self) -> float:
        """Seconds after the start from when on it can count so: it may pass there before."""

    def at(self, t: float) -> Mapping[int, float]:
        """Where the moving axes are `t` seconds after the start, before the target is reached."""


class _Fixed:
    """What never changes is its own copy, so that snapshots are cheap."""

    def __deepcopy__(self, memo: object) -> _Fixed:
        return self


class PtpPath(_Fixed):
    """All axes start and end together; the slowest of them moves as fast as it can."""

    arrival = "TOLE"

    def __init__(self, moves: Sequence[AxisMove]) -> None:
        self._moves = tuple(moves)
        profiles = (move.profile() for move in moves)
        self._profile = max(profiles, key=lambda profile: profile.seconds, default=Profile())
        self.target = {move.axis: move.target for move in moves}
        self.seconds = self._profile.seconds
        self.approach = 0.0

    def at(self, t: float) -> Mapping[int, float]:
        """Every axis has done the same part of its way."""
        share = self._profile.share(t)
        return {move.axis: move.start + move.way * share for move in self._moves}


class CurvePath(_Fixed):
    """The tool follows a curve; the axes are where its place in millimetres puts them."""

    arrival = "TOLE"

    def __init__(
        self, curve: Curve, profile: Profile, frame: Frame, axes: Mapping[int, int],
        target: Mapping[int, int],
    ) -> None:  # fmt: skip
        """`axes` gives the index of each axis that moves by its place in the robot, 0 to 5."""
        self._curve, self._profile, self._frame = curve, profile, frame
        self._axes = dict(axes)
        self.target = dict(target)
        self.seconds = profile.seconds
        self.approach = profile.seconds / 2

    def at(self, t: float) -> Mapping[int, float]:
        """Where the curve is after that part of its length."""
        pulses = self._frame.to_pulses(self._curve.at(self._profile.share(t)))
        return {index: pulses[place] for place, index in self._axes.items()}


class ArchPath(_Fixed):
    """One axis to its arch position, the others, and that axis to its target (guide, 4.2.1).

    The others start once the arch axis has done distance 1, at the latest at the arch position. The
    arch axis leaves that position so that distance 2 remains to it when the others arrive; a
    distance longer than its way means that it waits for them.
    """

    arrival = "OUTPOS"

    def __init__(
        self, rise: AxisMove, fall: AxisMove, others: PtpPath, distance1: int, distance2: int
    ) -> None:
        """`rise` and `fall` are the ways of the arch axis; distances in pulses, from 0 on."""
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
        """The arch axis on its way up, waiting, or on its way down; the others beside it."""
        if t < self._fall_start:
            arch = self._rise.start + self._rise.way * self._up.share(t)
        else:
            arch = self._fall.start + self._fall.way * self._down.share(t - self._fall_start)
        others = self._others.at(min(max(0.0, t - self._others_start), self._others.seconds))
        return {**others, self._rise.axis: arch}


def _part(distance: int, way: int) -> float:
    """Part of the way that a distance is, at most all of it."""
    return min(1.0, distance / abs(way)) if way else 1.0
