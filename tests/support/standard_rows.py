"""A row of the table of standard functions: a call and the value that the standard gives it."""

from __future__ import annotations

from datetime import timedelta
from typing import Any, NamedTuple


class Row(NamedTuple):
    """A call and its value.

    Attributes:
        code: The expression, `{0}` and so on for the arguments.
        arguments: Type and value of each, separated by a blank.
        kind: Type of the result.
        value: The result.
        alike: matiec does the same.
    """

    code: str
    arguments: tuple[str, ...]
    kind: str
    value: Any
    alike: bool = True


def rows(code: str, kind: str, *cases: tuple[Any, ...], alike: bool = True) -> list[Row]:
    """Return rows of one call. Each case consists of the arguments and, last, the result."""
    return [Row(code, case[:-1], kind, case[-1], alike) for case in cases]


def call(name: str, number: int) -> str:
    return f"{name}({', '.join(f'{{{k}}}' for k in range(number))})"


def ms(value: float) -> timedelta:
    return timedelta(milliseconds=value)
