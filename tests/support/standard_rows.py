"""A row in the table of standard functions: a call, and its value according to IEC 61131-3."""

from __future__ import annotations

from datetime import timedelta
from typing import Any, NamedTuple


class Row(NamedTuple):
    """A call of a standard function, and its value.

    Attributes:
        code: The expression, `{0}` and so on for the arguments.
        arguments: Type and value of each argument, separated by a blank.
        kind: Type of the result.
        value: The expected result.
        alike: Whether matiec gives the same value.
    """

    code: str
    arguments: tuple[str, ...]
    kind: str
    value: Any
    alike: bool = True


def rows(code: str, kind: str, *cases: tuple[Any, ...], alike: bool = True) -> list[Row]:
    """Return the rows of a call. Each case has the arguments and, at its end, the result."""
    return [Row(code, case[:-1], kind, case[-1], alike) for case in cases]


def call(name: str, number: int) -> str:
    return f"{name}({', '.join(f'{{{k}}}' for k in range(number))})"


def ms(value: float) -> timedelta:
    return timedelta(milliseconds=value)
