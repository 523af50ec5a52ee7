"""A piece of generated code with what is known about its value."""

from __future__ import annotations

from dataclasses import dataclass

from rcx_harness.engine.frontend.scalars import INT_RANGE, WIDTH
from rcx_harness.engine.types import ElementaryType, Type

__all__ = ["Value", "of_type", "settle", "type_name"]


@dataclass(frozen=True)
class Value:
    """Code of an expression.

    Attributes:
        code: Python, in parentheses where it needs them.
        limits: Least and greatest value of an integer before it is wrapped; (0, 0) for others.
        wide: A REAL in double precision, not rounded yet.
    """

    code: str
    limits: tuple[int, int] = (0, 0)
    wide: bool = False


def type_name(kind: Type) -> str:
    """Name of an elementary type; empty for others."""
    return kind.name if isinstance(kind, ElementaryType) else ""


def of_type(code: str, kind: Type) -> Value:
    """Code whose value is one of the type."""
    return Value(code, INT_RANGE.get(type_name(kind), (0, 0)))


def settle(value: Value, kind: Type) -> str:
    """Code for the value brought into its type: wrapped, or rounded to single precision."""
    name = type_name(kind)
    if value.wide and name == "REAL":
        return f"f32({value.code})"
    if name not in INT_RANGE:
        return value.code
    low, high = INT_RANGE[name]
    if low <= value.limits[0] and value.limits[1] <= high:
        return value.code
    mask = (1 << WIDTH[name]) - 1
    if low == 0:
        return f"({value.code} & {mask})"
    return f"(({value.code} + {-low} & {mask}) - {-low})"
