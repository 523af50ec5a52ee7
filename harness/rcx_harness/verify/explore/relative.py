"""The state of a cell without absolute times, so that a state can recur.

Two states with the same key behave alike in all later scans. The key does not contain data without
later effect: scan numbers, the alarm history, operation counters.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from enum import Enum
from functools import partial
from random import Random
from types import BuiltinFunctionType, FunctionType, MethodType
from typing import Any

from rcx_harness.robot import RobotConfig
from rcx_harness.robot.alarms import AlarmList
from rcx_harness.robot.config import RobotProgram
from rcx_harness.robot.data import Accumulated
from rcx_harness.robot.dedicated import DedicatedInputs
from rcx_harness.robot.findings import Findings
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.ports import Ports
from rcx_harness.robot.program.syntax import Program
from rcx_harness.robot.program.task import RobotTask
from rcx_harness.robot.tasks import Programs

__all__ = ["relative"]

#: Names of attributes that have no effect on later scans.
_DROPPED: dict[type, frozenset[str]] = {
    AlarmList: frozenset({"history"}),
    DedicatedInputs: frozenset({"_last_change"}),
    Machine: frozenset({"rng", "_observers"}),
    Ports: frozenset({"accesses", "statement"}),
    Programs: frozenset({"errors", "observers", "_machine"}),
}
#: Names of attributes with an absolute time that has no effect on later scans.
_NO_EFFECT = frozenset({"now_us", "t_us", "executed"})
#: Names of attributes with a due time. All due times in the past have the same effect.
_DUE = frozenset({"_due_us", "wake_us"})
#: Names of attributes with a duration.
_DURATIONS = frozenset({"duration_us", "_interval_us", "_time_us", "servo_on_us", "operating_us"})
#: Values of these types become a part of the key without conversion.
_PLAIN = (bool, int, float, str, bytes, type(None))


def relative(value: Any, now_us: int) -> Any:
    """Return a value as nested tuples of numbers and texts, with times relative to `now_us`."""
    return _Walk(now_us).of(value)


class _Walk:
    """The conversion of the objects of one state to nested tuples."""

    def __init__(self, now_us: int) -> None:
        self._now_us = now_us
        self._inside: set[int] = set()

    def of(self, value: Any) -> Any:
        """Return an object of the state as nested tuples."""
        kind = type(value)
        if kind in _PLAIN:
            return value
        for types, reduced in _REDUCED:
            if isinstance(value, types):
                return reduced(self, value)
        if id(value) in self._inside:  # the object contains itself: a reference to an outer object
            return ...
        self._inside.add(id(value))
        try:
            special = _SPECIAL.get(kind)
            parts = special(self, value) if special else self._attributes(value)
            return kind.__qualname__, tuple(parts)
        finally:
            self._inside.discard(id(value))

    def pairs(self, value: Mapping[Any, Any]) -> Any:
        """Return the entries of a mapping as pairs, in the order of the mapping."""
        return tuple((self.of(key), self.of(one)) for key, one in value.items())

    def function(self, value: Any) -> Any:
        """Return a function as its name and the values that it has captured."""
        cells = tuple(self.of(cell.cell_contents) for cell in value.__closure__ or ())
        return value.__module__, value.__qualname__, cells, self.of(value.__defaults__)

    def _attributes(self, value: Any) -> Iterator[Any]:
        dropped = _DROPPED.get(type(value), frozenset())
        for name, one in _named(value):
            if name not in dropped and name not in _NO_EFFECT:
                yield name, self._attribute(name, one)

    def _attribute(self, name: str, one: Any) -> Any:
        if not name.endswith("_us") or name in _DURATIONS or one is None:
            return self.of(one)
        # A name that is not in the tables counts as an absolute time without a limit. In the worst
        # case, states that behave alike then have different keys. States that behave differently
        # never have the same key.
        since_us = one - self._now_us
        return max(0, since_us) if name in _DUE else since_us

    def machine(self, value: Machine) -> Iterator[Any]:
        """Yield the state of a machine. The times of pending answers are relative to now."""
        for part in self._attributes(value):
            if part[0] != "pending":
                yield part
        yield "pending", tuple((name, due - self._now_us) for name, due in value.pending.items())
        if _draws(value.config):
            yield "rng", value.rng.getstate()

    def programs(self, value: Programs) -> Iterator[Any]:
        """Yield the state of the robot programs. The times of their pulses are relative to now."""
        for name, one in _named(value):
            if name == "_pulses":
                yield name, tuple((due - self._now_us, place.name) for due, place in one)
            elif name not in _DROPPED[Programs] and name != "config":
                yield name, self.of(one)

    def task(self, value: RobotTask) -> Iterator[Any]:
        """Yield the state of a task. Its times are replaced by the remaining waiting time."""
        for name, one in _named(value):
            if name not in ("program", "code", "since_us", "elapsed_us", "until_us"):
                yield name, self.of(one)
        passed_us = value.elapsed_us
        if value.state == "running":
            passed_us = value.passed_us(self._now_us)
        at = value.code.code[value.at].kind if value.at < len(value.code.code) else ""
        left_us = None if value.until_us is None else value.until_us - passed_us
        # For a program that is only a duration, the progress decides when it ends.
        yield "left", left_us, passed_us if at == "duration" else None

    def inputs(self, value: DedicatedInputs) -> Iterator[Any]:
        """Yield the state of the dedicated inputs.

        A change is left out if it is older than the minimum interval of two changes.
        """
        for part in self._attributes(value):
            if part[0] == "_changed_us" and part[1] is not None:
                yield part[0], max(part[1], -dict(_named(value))["_interval_us"])
            else:
                yield part


def _named(value: Any) -> Iterator[tuple[str, Any]]:
    if hasattr(value, "__dict__"):
        yield from vars(value).items()
    for kind in type(value).__mro__:
        slots = kind.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            if hasattr(value, name) and name != "__dict__":
                yield name, getattr(value, name)


def _draws(config: RobotConfig) -> bool:
    """Return whether the controller draws a delay from a range."""
    return any(
        isinstance(value, tuple) and value[0] != value[-1]
        for name, value in vars(config).items()
        if value and name.endswith(("_delay", "_time"))
    )


#: Types with a special conversion. The attributes of all other objects are converted.
_REDUCED: list[tuple[Any, Callable[[_Walk, Any], Any]]] = [
    (Enum, lambda walk, value: value.name),
    ((tuple, list), lambda walk, value: tuple(map(walk.of, value))),
    (dict, _Walk.pairs),
    ((set, frozenset), lambda walk, value: tuple(sorted(map(repr, value)))),
    ((bytearray, memoryview), lambda walk, value: bytes(value)),
    (RobotConfig, lambda walk, value: None),
    (RobotProgram, lambda walk, value: value.name),
    (Program, lambda walk, value: None),
    ((Accumulated, Findings), lambda walk, value: None),
    (Random, lambda walk, value: value.getstate()),
    (FunctionType, _Walk.function),
    (MethodType, lambda walk, value: (walk.of(value.__func__), walk.of(value.__self__))),
    (BuiltinFunctionType, lambda walk, value: value.__qualname__),
    (
        partial,
        lambda walk, value: (walk.of(value.func), walk.of(value.args), walk.of(value.keywords)),
    ),
    (type, lambda walk, value: value.__qualname__),
]
_SPECIAL: dict[type, Callable[[_Walk, Any], Iterator[Any]]] = {
    Machine: _Walk.machine,
    Programs: _Walk.programs,
    RobotTask: _Walk.task,
    DedicatedInputs: _Walk.inputs,
}
