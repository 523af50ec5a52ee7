"""The stored data of the controller, which survive a power cycle.

Remote commands read and change them.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from fractions import Fraction
from typing import TypeVar

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import (
    FIRST_REAL,
    PARAMETER_DEFAULTS,
    ROBOT_PARAMETERS,
    ROBOTS,
    VARIABLES,
    Hand,
    Pallet,
    Point,
    Shift,
    fits_integer,
    nearest,
    single,
    variable_number,
)

__all__ = ["Memory", "Parameters", "Variables", "is_real"]

_GRAMS = 1000

_Number = TypeVar("_Number", Fraction, float)


def is_real(number: int) -> bool:
    """Return whether the number means a real variable, SGR0 to SGR31."""
    return number >= FIRST_REAL


class Memory:
    """All stored data by their numbers; robot number 0 means robot 1.

    Attributes:
        comments: Point comments, without spaces at their ends.
        shifts: Shift data that were defined.
        hands: Hand data that were defined, by robot (1 to 4) and hand number.
    """

    def __init__(self, config: RobotConfig) -> None:
        self.config = config
        self.points: dict[int, Point] = dict(config.points)
        self.comments: dict[int, str] = {n: text.rstrip() for n, text in config.comments.items()}
        self.pallets: dict[int, Pallet] = dict(config.pallets)
        self.shifts: dict[int, Shift] = dict(config.shifts)
        self.hands: dict[tuple[int, int], Hand] = dict(config.hands)
        self.variables = Variables(config)
        self.parameters = Parameters(config)

    def point(self, number: int) -> Point:
        """Return the point with this number; raise CommandError if the point is not defined."""
        if number not in self.points:
            raise CommandError(self.config.undefined_point_alarm)
        return self.points[number]

    def comment(self, number: int) -> str:
        """Return the comment of a point, even if the point itself is not defined."""
        if number not in self.comments:
            self._undefined_data()
        return self.comments.get(number, "")

    def pallet(self, number: int) -> Pallet:
        """Return the pallet with this number; raise CommandError if the pallet is not defined."""
        if number not in self.pallets:
            raise CommandError(self.config.undefined_pallet_alarm)
        return self.pallets[number]

    def work_point(self, pallet: int, work: int) -> Point:
        """Return a work position of a pallet, with the unit, hand and arm of its first point."""
        found = self.pallet(pallet)
        if not 1 <= work <= found.count:
            raise CommandError(self.config.work_position_alarm)
        weight = _weights(found, work)
        points = {offset: self.point(found.first + offset) for offset in weight}
        first = self.point(found.first)
        if any(point.mm != first.mm for point in points.values()):
            raise CommandError(self.config.point_unit_alarm)
        data = _interpolated({offset: point.data for offset, point in points.items()}, weight)
        return self.changed(first, data)

    def changed(self, point: Point, data: tuple[int, ...]) -> Point:
        """Return a copy of a point with other data; raise CommandError if a value is too large."""
        if not all(map(fits_integer, data)):
            raise CommandError(self.config.overflow_alarm)
        return Point(data, point.mm, point.hand, point.arm1, point.arm2)

    def shift(self, number: int) -> Shift:
        """Return the shift with this number; all data are 0 if it is not defined.

        Shift 0 always exists.

        Raises:
            CommandError: the shift is not defined, and the configuration has an alarm for this
                error.
        """
        if number and number not in self.shifts:
            self._undefined_data()
        return self.shifts.get(number, (0, 0, 0, 0))

    def hand(self, robot: int, number: int) -> Hand:
        """Return the hand of a robot; all data are 0 if it is not defined.

        Hand 0 always exists.

        Raises:
            CommandError: the hand is not defined, and the configuration has an alarm for this
                error.
        """
        key = (robot or 1, number)
        if number and key not in self.hands:
            self._undefined_data()
        return self.hands.get(key, Hand())

    def _undefined_data(self) -> None:
        if self.config.undefined_data_alarm:
            raise CommandError(self.config.undefined_data_alarm)


class Parameters:
    """The parameters of all robots and axes.

    The payload in kg and the payload in g share a value.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self._values: dict[tuple[str, int], int] = {}
        for name, given in config.parameters.items():
            count = ROBOTS if name in ROBOT_PARAMETERS else len(config.axes)
            every = given if isinstance(given, tuple) else (given,) * count
            for place, value in enumerate(every):
                self._put(name, place, value)

    def get(self, robot: int, name: str, axis: int = 0) -> int:
        """Return the value of a parameter, in the unit of the guide's table.

        Robot 0 means robot 1. `axis` is the index of the axis in the robot, 0 to 5.
        """
        place = self._place(robot, name, axis)
        if name == "WEIGHT":
            return self.get(robot, "WEIGHTG") // _GRAMS
        return self._values.get((name, place), PARAMETER_DEFAULTS[name])

    def set(self, robot: int, name: str, value: int, axis: int = 0) -> None:
        """Set the value of a parameter; the caller checks the range of the value."""
        self._put(name, self._place(robot, name, axis), value)

    def _put(self, name: str, place: int, value: int) -> None:
        if name == "WEIGHT":
            name, value = "WEIGHTG", value * _GRAMS
        self._values[name, place] = value

    def _place(self, robot: int, name: str, axis: int) -> int:
        """Return the index of the robot, or the index of the axis in the controller."""
        if name in ROBOT_PARAMETERS:
            return (robot or 1) - 1
        return self._config.axes_of(robot)[axis]


class Variables:
    """Integers of 32 bits and single-precision real numbers, by the numbers of the guide, 4.4.1.

    Attributes:
        integers: Values of SGI0 to SGI31.
        reals: Values of SGR0 to SGR31.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.clear()
        for name, value in config.variables.items():
            number = variable_number(name)
            assert number is not None, name
            self.assign(number, value)

    def clear(self) -> None:
        """Set all variables to zero."""
        self.integers = [0] * VARIABLES
        self.reals = [0.0] * VARIABLES

    def value(self, number: int) -> int | float:
        """Return the value of the variable with this number."""
        return self.reals[number - FIRST_REAL] if is_real(number) else self.integers[number]

    def assign(self, number: int, value: float) -> None:
        """Convert a finite value to the type of the variable, and assign it."""
        if is_real(number):
            self.reals[number - FIRST_REAL] = single(value)
            return
        self.integers[number] = self._integer(Fraction(value))

    def calculate(self, number: int, operator: str, value: float) -> None:
        """Set a variable to the result of `variable operator value`, with `+`, `-`, `*` or `/`.

        Two integers are calculated exactly, all other values in single precision. The result is
        then converted to the variable's type.
        """
        own = self.value(number)
        if operator == "/" and value == 0:
            raise CommandError(self._config.division_alarm)
        if isinstance(own, int) and isinstance(value, int):
            self.integers[number] = self._integer(_result(Fraction(own), operator, Fraction(value)))
            return
        result = single(_result(float(own), operator, float(value)))
        if not math.isfinite(result):
            raise CommandError(self._config.overflow_alarm)
        self.assign(number, result)

    def _integer(self, value: Fraction) -> int:
        rounds = self._config.real_to_integer == "round"
        whole = nearest(value) if rounds else math.trunc(value)
        if not fits_integer(whole):
            raise CommandError(self._config.overflow_alarm)
        return whole


def _result(first: _Number, operator: str, second: _Number) -> _Number:
    """Return the result of the operator `+`, `-`, `*` or `/` for two numbers."""
    if operator == "+":
        return first + second
    if operator == "-":
        return first - second
    return first * second if operator == "*" else first / second


def _weights(pallet: Pallet, work: int) -> Mapping[int, Fraction]:
    """Return the weights of the pallet's points, which together give a work position.

    The corners 0 to 3 are weighted bilinearly in X and Y. The end in Z adds a part of the vector
    from the first point to that end, so the weight of the first point is reduced by this part.

    Work positions count from 1; X counts first, then Y, then Z.

    Returns:
        Maps the offset from the pallet's first point to the weight; zero weights are left out.
        Offset 0 is the first work position, 1 the end in X, 2 the end in Y, 3 the corner of X and
        Y, 4 the end in Z.
    """
    rest, x = divmod(work - 1, pallet.nx)
    z, y = divmod(rest, pallet.ny)
    u, v, w = _share(x, pallet.nx), _share(y, pallet.ny), _share(z, pallet.nz)
    every = {0: (1 - u) * (1 - v) - w, 1: u * (1 - v), 2: v * (1 - u), 3: u * v, 4: w}
    return {offset: weight for offset, weight in every.items() if weight}


def _interpolated(
    data: Mapping[int, tuple[int, ...]], weight: Mapping[int, Fraction]
) -> tuple[int, ...]:
    """Return the data of a work position, the weighted sum of the data of the pallet's points."""
    axes = zip(*(data[offset] for offset in weight), strict=True)
    return tuple(
        nearest(sum((w * v for w, v in zip(weight.values(), axis, strict=True)), Fraction(0)))
        for axis in axes
    )


def _share(index: int, count: int) -> Fraction:
    """Return position `index` of `count` equidistant positions as a part of the whole distance."""
    return Fraction(index, count - 1) if count > 1 else Fraction(0)
