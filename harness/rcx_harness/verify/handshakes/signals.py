"""The signals in a property of a handshake: ports of the areas, or variables of the PLC."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from typing import Any

from rcx_harness.robot.ports import Port, port, value_in
from rcx_harness.verify.properties import Areas
from structured_text.engines.base import Program
from structured_text.engines.conditions import Condition
from structured_text.errors import InputError

__all__ = ["bit_reader", "bits_of", "is_port", "word_reader"]

_PORT = re.compile(r"\s*S[IO](?:[WD]?\s*\(\s*\d+\s*\)|\d+\s*\(\s*\))\s*", re.IGNORECASE)


def is_port(text: str) -> bool:
    """Return whether a text names a port: `SI(20)`, `SO2()`, `SIW(2)`, `SOD(2)`."""
    return _PORT.fullmatch(text) is not None


def bits_of(place: Port) -> set[tuple[bool, int]]:
    """Return the bits of an area that belong to a port, and the direction of the port."""
    if place.bit is not None:
        return {(place.output, 8 * place.at + place.bit)}
    return {(place.output, 8 * place.at + k) for k in range(8 * place.size)}


def bit_reader(
    text: str, made: Iterator[Condition], areas: Areas | None, controller: int
) -> tuple[Callable[[], bool], tuple[str, ...]]:
    """Return a function that reads a bit, and the variables that it reads.

    If the text is not a port, it is a condition. `made` yields the compiled condition.
    """
    if not is_port(text):
        condition = next(made)
        return condition.holds, condition.paths
    read = _port_reader(text, areas, controller)
    if port(text).bit is None:
        raise InputError(f"{text} is not a bit", hint="write SI(20) or SO(20)")
    return lambda: bool(read()), ()


def word_reader(
    text: str, program: Program, areas: Areas | None, controller: int
) -> Callable[[], Any]:
    """Return a function that reads a variable or a port.

    Raises:
        InputError: there is no such variable, or the cell has no such port.
    """
    if is_port(text):
        return _port_reader(text, areas, controller)
    program.type_of(text)
    read = program.reader([text])
    return lambda: read()[0]


def _port_reader(text: str, areas: Areas | None, controller: int) -> Callable[[], int]:
    place = port(text)
    if areas is None:
        raise InputError(f"{text}: the program has no robot", hint="name a variable of the program")
    count = len(areas())
    if controller > count:
        raise InputError(f"there is no controller {controller}; the cell has {count}")
    place.check(len(areas()[controller - 1][0]))
    side = 0 if place.output else 1
    return lambda: value_in(place, areas()[controller - 1][side])
