"""Cycle times of the robot models in the standard cycle: calculated, and measured in virtual time.

`python -m rcx_tools.docs.cycle_times` fits the law of acceleration again, and prints the two
parameters of the law.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import product

from rcx_harness import spec
from rcx_harness.robot import Controller, Point, RobotConfig
from rcx_harness.robot.area import INPUTS
from rcx_harness.robot.kinematics import Scara
from rcx_harness.robot.paths import ArchPath, AxisMove, PtpPath
from rcx_harness.spec.robots import Law, RobotModel, law, robot_models
from rcx_harness.spec.wire import CYCLE_US

__all__ = ["cycle_ends", "fitted", "measured_cycle", "planned_cycle"]

#: The standard cycle: height up and down, width across, Z depth [mm].
UP, ACROSS, DEPTH = 25.0, 300.0, 50.0
_ARCH, _READY, _DONE = 0x002, 0x0000, 0x0200
_ROBOT, _FROM, _TO = 1, 1, 2
_STEPS, _ROUNDS = 12, 16
#: Limits of the two parameters of the law of acceleration in the fit: factor and share.
_LOW, _HIGH = (0.3, 0.01), (12.0, 3.0)


def cycle_ends(model: RobotModel) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return X and Y of both ends of the cycle across the front [mm].

    With the arms at a right angle, the hand has the same distance from the base as both ends.
    """
    far = math.hypot(*model.arms)
    y = math.sqrt(far**2 - (ACROSS / 2) ** 2)
    return (-ACROSS / 2, y), (ACROSS / 2, y)


def planned_cycle(model: RobotModel, of: Law, load: float) -> float:
    """Return the cycle time [s] that the controller's planner calculates with a given law."""
    ends = _angles(model)

    def move(place: int, start: float, end: float) -> AxisMove:
        joint = model.joints[place]
        ramp = joint.acceleration(of, load) * joint.pulses_per_unit
        first, last = (round(at * joint.pulses_per_unit) for at in (start, end))
        return AxisMove(place, first, last, joint.speed * joint.pulses_per_unit, ramp, ramp)

    turns = [move(place, ends[0][place] / 1000, ends[1][place] / 1000) for place in (0, 1)]
    rise, fall = move(2, UP, 0.0), move(2, 0.0, UP)
    return 2 * ArchPath(rise, fall, PtpPath(turns), 0, 0).seconds


@cache
def _angles(model: RobotModel) -> Sequence[Sequence[float]]:
    """Return the arm's angles at both ends of the cycle [1/1000 degree]."""
    return [_arm(model).inverse((1000 * x, 1000 * y, 0, 0)) for x, y in cycle_ends(model)]


def fitted(names: Sequence[str]) -> Law:
    """Fit the law of acceleration to the cycle times of these models, by least relative squares.

    The search uses a grid that becomes finer. Every call gives the same result.
    """
    models = [robot_models()[name] for name in names]

    def error(factor: float, share: float) -> float:
        of = Law(factor, share, tuple(names))
        return sum(
            (planned_cycle(model, of, load) / seconds - 1) ** 2
            for model in models
            for load, seconds in model.cycles[:1]
        )

    factors, shares = ((low, high) for low, high in zip(_LOW, _HIGH, strict=True))
    for _ in range(_ROUNDS):
        every = product(_grid(*factors), _grid(*shares))
        best = min(every, key=lambda pair: error(*pair))
        factors, shares = (
            (max(least, at - (high - low) / 5), min(most, at + (high - low) / 5))
            for at, (low, high), least, most in zip(
                best, (factors, shares), _LOW, _HIGH, strict=True
            )
        )
    return Law(round(best[0], 3), round(best[1], 3), tuple(names))


def _grid(low: float, high: float) -> list[float]:
    return [low + (high - low) * step / _STEPS for step in range(_STEPS + 1)]


def measured_cycle(name: str, load: float) -> float:
    """Return the cycle time in virtual time [s], for MOVE with arch by remote command.

    The time is the number of controller cycles of 5 ms, from the first cycle with moving axes to
    the cycle of the end status.
    """
    model = robot_models()[name]
    points = {
        number: Point(_wire((x, y, DEPTH)), mm=True, hand=1)
        for number, (x, y) in zip((_FROM, _TO), cycle_ends(model), strict=True)
    }
    config = RobotConfig(robot=(name,), points=points, parameters={"WEIGHT": round(load)})
    start = _arm(model).inverse(points[_FROM].data)
    config = replace(
        config,
        axes=tuple(
            replace(axis, start=round(at * axis.pulses_per_mm / 1000 + axis.zero))
            for axis, at in zip(config.axes, start, strict=False)
        ),
    )
    master = _Master(config)
    return master.arch(_TO) + master.arch(_FROM)


def _arm(model: RobotModel) -> Scara:
    """Return the kinematics of the robot in right-handed posture."""
    arm1, arm2 = model.arms
    return Scara(1000 * arm1, 1000 * arm2)


def _wire(mm: Sequence[float]) -> tuple[int, ...]:
    """Return a position in the unit of a point [0.001 mm]."""
    return (*(round(1000 * at) for at in mm), *(0,) * (6 - len(mm)))


class _Master:
    """A master that switches the servos on and starts movements."""

    def __init__(self, config: RobotConfig) -> None:
        self._robot = Controller(config)
        self._area = bytearray(config.size)
        self._cycle = 0
        self._run(60)
        for inputs in (("SI00",), ("SI00", "SI06"), ("SI00", "SI06", "SI01")):
            bits = sum(INPUTS[name] for name in inputs)
            self._area[32:34] = bits.to_bytes(2, "little")
            self._run(30)

    def arch(self, point: int) -> float:
        """Move to a point. Return the seconds from the start of the movement to its end status."""
        values = {
            "axis_designation": 1, "axes": 0b111, "speed_mode": 2, "speed": 100, "point": point,
            "arch_unit": 1, "arch_axis": 0b100, "arch_position": round(1000 * (DEPTH - UP)),
        }  # fmt: skip
        words = spec.commands()[_ARCH].encode(values, _ROBOT)
        self._area[:32] = b"".join(word.to_bytes(2, "little") for word in words)
        here, count, moving = list(self._robot.positions), 0, False
        while self._status != _DONE:
            self._run(1)
            moving = moving or list(self._robot.positions) != here
            count += moving
            assert count < 1000, "the movement does not end"
        self._area[:32] = bytes(32)
        self._run(20)
        assert self._status == _READY
        return count * CYCLE_US / 1e6

    @property
    def _status(self) -> int:
        return int.from_bytes(self._answer[:2], "little")

    def _run(self, cycles: int) -> None:
        for _ in range(cycles):
            self._answer = self._robot.cycle(self._cycle * CYCLE_US, bytes(self._area))
            self._cycle += 1


if __name__ == "__main__":
    found = fitted(law().fitted)
    print(f"factor = {found.factor}\nown_share = {found.own_share}")
