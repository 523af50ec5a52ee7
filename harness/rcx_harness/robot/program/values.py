"""The values of the robot language: integers, single-precision numbers, texts and points."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import AXES, Hand, Point, Shift, fits_integer, nearest, single

__all__ = ["Value", "calculate", "combine", "compare", "convert", "integer", "number", "to_point"]

#: A value of an expression. A shift is a tuple of four integers.
Value = int | float | str | Point | Shift | Hand

_TRUE, _FALSE = -1, 0
_SCALE = 1000


def convert(name: str, value: Value, config: RobotConfig, *, integers: bool) -> Value:
    """Convert a value to the type of the variable `name`: A% integer, A! real, A$ text.

    Raises:
        CommandError: the value has another type, or is too large.
    """
    if "@" in name:  # `name` is the hidden variable for the limit of a FOR
        return value
    if name.endswith("$"):
        if not isinstance(value, str):
            raise CommandError(config.program_type_alarm)
        return value
    if name.endswith("%") or (integers and not name.endswith("!")):
        return integer(value, config)
    return number(value, config)


def integer(value: Value, config: RobotConfig) -> int:
    """Convert a number to an integer of 32 bits; the configuration determines the rounding.

    Raises:
        CommandError: the value is not a number, or is too large.
    """
    plain = _numeric(value, config)
    if isinstance(plain, float):
        if not math.isfinite(plain):
            raise CommandError(config.overflow_alarm)
        exact = Fraction(plain)
        plain = nearest(exact) if config.real_to_integer == "round" else math.trunc(exact)
    if not fits_integer(plain):
        raise CommandError(config.overflow_alarm)
    return plain


def number(value: Value, config: RobotConfig) -> float:
    """Convert a number to single precision.

    Raises:
        CommandError: the value is not a number, or is too large.
    """
    result = single(float(_numeric(value, config)))
    if not math.isfinite(result):
        raise CommandError(config.overflow_alarm)
    return result


def calculate(operator: str, left: Value, right: Value, config: RobotConfig) -> Value:
    """Return the result of an operator on two numbers; `+` also joins texts.

    Two integers give an integer, except if a division has a remainder or a power is negative.

    Raises:
        CommandError: a value has a wrong type, the divisor is 0, or the result is too large.
    """
    if operator == "add" and isinstance(left, str) and isinstance(right, str):
        return left + right
    a, b = _numeric(left, config), _numeric(right, config)
    if operator in ("divide", "modulo") and b == 0:
        raise CommandError(config.division_alarm)
    try:
        result = _OPERATORS[operator](a, b)
    except (OverflowError, ZeroDivisionError, ValueError):
        raise CommandError(config.overflow_alarm) from None
    if isinstance(result, complex):
        raise CommandError(config.overflow_alarm)
    if isinstance(result, int):
        return integer(result, config)
    return number(result, config)


def _divide(a: float, b: float) -> float:
    if isinstance(a, int) and isinstance(b, int) and a % b == 0:
        return a // b
    return a / b


def _modulo(a: float, b: float) -> float:
    return a - b * int(a / b) if isinstance(a, float) or isinstance(b, float) else _rest(a, b)


def _rest(a: int, b: int) -> int:
    """Return the remainder of a division that is rounded toward 0, with the sign of `a`."""
    rest = abs(a) % abs(b)
    return -rest if a < 0 else rest


_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "add": lambda a, b: a + b,
    "subtract": lambda a, b: a - b,
    "multiply": lambda a, b: a * b,
    "divide": _divide,
    "modulo": _modulo,
    "power": lambda a, b: a**b,
}


def compare(operator: str, left: Value, right: Value, config: RobotConfig) -> int:
    """Return -1 (true) or 0 (false) for a comparison of two numbers or two texts.

    Raises:
        CommandError: the values have different types.
    """
    if isinstance(left, str) and isinstance(right, str):
        order = (left > right) - (left < right)
    else:
        a, b = _numeric(left, config), _numeric(right, config)
        order = (a > b) - (a < b)
    return _TRUE if order in _ORDERS[operator] else _FALSE


_ORDERS = {
    "=": (0,),
    "<>": (-1, 1),
    "<": (-1,),
    ">": (1,),
    "<=": (-1, 0),
    "=<": (-1, 0),
    ">=": (0, 1),
    "=>": (0, 1),
}


def combine(operator: str, left: Value, right: Value, config: RobotConfig) -> Value:
    """Return the sum or difference of two points or two shifts, axis by axis.

    Raises:
        CommandError: the points have different units, the values have different types, or a result
            is too large.
    """
    sign = 1 if operator == "add" else -1
    if isinstance(left, Point) and isinstance(right, Point):
        if left.mm != right.mm:
            raise CommandError(config.point_unit_alarm)
        data = _combined(left.data, right.data, sign, config)
        return Point(data, left.mm, left.hand, left.arm1, left.arm2)
    if isinstance(left, tuple) and isinstance(right, tuple):
        x, y, z, r = _combined(left, right, sign, config)
        return (x, y, z, r)
    raise CommandError(config.program_type_alarm)


def _combined(
    left: Sequence[int], right: Sequence[int], sign: int, config: RobotConfig
) -> tuple[int, ...]:
    values = tuple(a + sign * b for a, b in zip(left, right, strict=True))
    if not all(map(fits_integer, values)):
        raise CommandError(config.overflow_alarm)
    return values


def to_point(values: Sequence[float], *, mm: bool) -> Point:
    """Return the point with these coordinates [mm or pulses], hand flag and arm flags.

    There may be up to six coordinates. Missing coordinates are 0.
    """
    scale = _SCALE if mm else 1
    data = [round(value * scale) for value in values[:AXES]]
    flags = [int(value) for value in values[AXES : AXES + 3]] + [0, 0, 0]
    return Point((*data, *[0] * (AXES - len(data))), mm, flags[0], flags[1], flags[2])


def _numeric(value: Value, config: RobotConfig) -> int | float:
    if isinstance(value, (int, float)):
        return value
    raise CommandError(config.program_type_alarm)
