"""The static variables SGI0 to SGI31 and SGR0 to SGR31, and calculating with them."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TypeVar

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.numbers import fits_integer, nearest, single, toward_zero
from rcx_harness.robot.stored import FIRST_REAL, VARIABLES, variable_number

__all__ = ["Variables", "is_real"]

_Number = TypeVar("_Number", Fraction, float)


def is_real(number: int) -> bool:
    """The variable of that number is one of SGR0 to SGR31."""
    return number >= FIRST_REAL


class Variables:
    """Integers of 32 bits and single-precision real numbers, by the numbers of the guide, 4.4.1.

    Attributes:
        integers: SGI0 to SGI31.
        reals: SGR0 to SGR31.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.integers = [0] * VARIABLES
        self.reals = [0.0] * VARIABLES
        for name, value in config.variables.items():
            number = variable_number(name)
            assert number is not None, name
            self.assign(number, value)

    def value(self, number: int) -> int | float:
        """The variable with that number."""
        return self.reals[number - FIRST_REAL] if is_real(number) else self.integers[number]

    def assign(self, number: int, value: float) -> None:
        """Give a variable a value; it takes the variable's type.

        Raises:
            CommandError: it is too large for the variable.
        """
        if is_real(number):
            value = single(value)
            if not math.isfinite(value):
                raise CommandError(self._config.overflow_alarm)
            self.reals[number - FIRST_REAL] = value
            return
        self.integers[number] = self._integer(Fraction(value))

    def calculate(self, number: int, operator: str, value: float) -> None:
        """Variable = variable `operator` value; the operator is `+`, `-`, `*` or `/`.

        Two integers are calculated without loss, all else in single precision; then the result
        takes the variable's type.

        Raises:
            CommandError: division by 0, or the result is too large; the variable stays as it was.
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
        whole = nearest(value) if rounds else toward_zero(value)
        if not fits_integer(whole):
            raise CommandError(self._config.overflow_alarm)
        return whole


def _result(first: _Number, operator: str, second: _Number) -> _Number:
    """What the operator makes of two numbers."""
    if operator == "+":
        return first + second
    if operator == "-":
        return first - second
    return first * second if operator == "*" else first / second
