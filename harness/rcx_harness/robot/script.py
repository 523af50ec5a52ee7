"""The steps of a robot program, in a small part of the robot language.

    WAIT SI(20)=1        SO(20)=1        SOW(2)=256      A%=SIW(3)       DELAY 500
    SET SO(20)           SO2()=A         SOD(2)=&H11111  C=SID(2)        START 2
    RESET SO(20)         OUT SO(20),200  MO(20)=1        A=DI2()         SUSPEND 2
    GOSUB *PICK          *PICK:          RETURN          END             RESTART 2
    HALT

DELAY and the time of OUT are in ms. START starts another program, by its number (its place in the
list of programs), as a task beside this one. SUSPEND stops its task and RESTART continues it.
GOSUB executes the steps from a label to RETURN. END goes to the end of the program, and so does
RETURN without a GOSUB. HALT ends all tasks.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Protocol

from rcx_harness.robot.ports import Port, Ports, port
from structured_text.errors import InputError

__all__ = ["Delay", "End", "Gosub", "Return", "ScriptStep", "TaskStep", "Wait", "World", "script"]

_LABEL = r"\*[A-Z][A-Z0-9_]*"
_VARIABLE = r"[A-Z][A-Z0-9_]*[%!]?"
_NUMBER = r"-?\d+|&H[0-9A-F]+"
_PORT = r"(?:S[IO](?:[WD]\(\d+\)|\d+\(\)|\(?\d+\)?)|(?:D[IO]|MO|LO|TO)(?:\d+\(\)|\(\d+\)))"
_HINT = "write one of: WAIT SI(20)=1, SO(20)=1, SOW(2)=256, A=SIW(3), DELAY 500, SET SO(20) ..."


class World(Protocol):
    """The interface on which a step acts; see Programs."""

    ports: Ports
    variables: dict[str, int]

    def pulse(self, place: Port, ms: int) -> None:
        """Turn an output ON, and OFF again after `ms`."""

    def halt(self) -> None:
        """End all tasks."""


@dataclass(frozen=True)
class Wait:
    """A step that waits until an input has a value."""

    place: Port
    value: int


@dataclass(frozen=True)
class Delay:
    """A step that waits for a time."""

    us: int


@dataclass(frozen=True)
class TaskStep:
    """A step that starts program `number` (1 is the first) as a task, or acts on its task.

    `what` is `START`, `SUSPEND` or `RESTART`.
    """

    what: str
    number: int


@dataclass(frozen=True)
class Gosub:
    """A step that jumps behind the label at step `at`, until a RETURN."""

    at: int


@dataclass(frozen=True)
class Return:
    """A step that returns behind the GOSUB."""


@dataclass(frozen=True)
class End:
    """A step that jumps to the end of the program."""


#: A step that waits, acts on a task, jumps, or is executed at once.
ScriptStep = Wait | Delay | TaskStep | Gosub | Return | End | Callable[[World], None]


@cache
def script(lines: tuple[str, ...], size: int) -> tuple[ScriptStep, ...]:
    """Return the steps of a program on a robot with areas of `size` bytes."""
    texts = tuple(line.upper().strip() for line in lines)
    labels = {text.rstrip(": "): k for k, text in enumerate(texts) if text.startswith("*")}
    return tuple(_step(line, text, size, labels) for line, text in zip(lines, texts, strict=True))


def _step(line: str, text: str, size: int, labels: Mapping[str, int]) -> ScriptStep:
    if match := re.fullmatch(rf"GOSUB\s+({_LABEL})", text):
        if match[1] not in labels:
            raise InputError(
                f"'steps' has no label {match[1]}", hint=f"write {match[1]}: as a step"
            )
        return Gosub(labels[match[1]])
    for name in re.findall(rf"\b{_PORT}", text):
        port(name).check(size)
    for pattern, make in _FORMS:
        match = pattern.fullmatch(text)
        if match:
            return make(*match.groups())
    raise InputError(f"'steps' cannot have {line!r}", hint=_HINT)


def _wait(name: str, value: str) -> ScriptStep:
    place = port(name)
    if place.output:
        raise InputError(f"'steps' cannot wait for {name}", hint="inputs can be waited for")
    return Wait(place, _number(value))


def _set(name: str, value: int) -> ScriptStep:
    place = _output(name)
    return lambda world: world.ports.write(place, value)


def _out(name: str, ms: str | None) -> ScriptStep:
    place = _output(name)
    if ms is None:
        return lambda world: world.ports.write(place, 1)
    duration = int(ms)
    return lambda world: world.pulse(place, duration)


def _assign(target: str, source: str) -> ScriptStep:
    value = _source(source)
    if re.fullmatch(_PORT, target):
        place = _output(target)
        return lambda world: world.ports.write(place, value(world))
    return lambda world: world.variables.update({target: value(world)})


def _source(text: str) -> Callable[[World], int]:
    if re.fullmatch(_NUMBER, text):
        number = _number(text)
        return lambda world: number
    if re.fullmatch(_PORT, text):
        place = port(text)
        return lambda world: world.ports.read(place)
    return lambda world: world.variables.get(text, 0)


def _output(name: str) -> Port:
    place = port(name)
    if not place.output:
        raise InputError(f"'steps' cannot set {name}", hint="outputs can be set")
    return place


def _number(text: str) -> int:
    return int(text[2:], 16) if text.startswith("&H") else int(text)


def _halt(world: World) -> None:
    world.halt()


def _pass(world: World) -> None:
    """Do nothing: the step is a label."""


_FORMS: tuple[tuple[re.Pattern[str], Callable[..., ScriptStep]], ...] = tuple(
    (re.compile(pattern), make)
    for pattern, make in (
        (rf"WAIT\s+({_PORT})\s*=\s*({_NUMBER})", _wait),
        (r"DELAY\s+(\d+)", lambda ms: Delay(int(ms) * 1000)),
        (r"(START|SUSPEND|RESTART)\s+(\d+)", lambda what, number: TaskStep(what, int(number))),
        (r"HALT", lambda: _halt),
        (r"END", End),
        (r"RETURN", Return),
        (rf"{_LABEL}\s*:", lambda: _pass),
        (rf"SET\s+({_PORT})", lambda name: _set(name, 1)),
        (rf"RESET\s+({_PORT})", lambda name: _set(name, 0)),
        (rf"OUT\s+({_PORT})(?:\s*,\s*(\d+))?", _out),
        (rf"({_PORT}|{_VARIABLE})\s*=\s*({_NUMBER}|{_PORT}|{_VARIABLE})", _assign),
    )
)
