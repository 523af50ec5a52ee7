"""The registration of remote commands: functions that act at once, and classes that take time."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, TypeVar

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.kinematics import UnreachableError
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.program.motion import Request
from rcx_harness.spec import FieldValue
from rcx_harness.spec.wire import CYCLE_US

__all__ = [
    "Action",
    "Call",
    "Execution",
    "Response",
    "act",
    "acts_once",
    "answers_absent",
    "perform",
    "registered",
    "start",
    "statement",
    "takes_time",
]

#: The fields of a response, by their names in remote_commands.toml.
Response = Mapping[str, FieldValue]


@dataclass(frozen=True)
class Call:
    """A remote command: its code without the robot digit R, the addressed robot, and the fields.

    `designated` is R as it was sent, 0 to 4. Some commands distinguish 0 from robot 1. With
    `by_program` the command comes from a statement of a robot program.
    """

    code: int
    arm: Arm
    values: Mapping[str, Any]
    designated: int = 0
    by_program: bool = False

    @property
    def places(self) -> tuple[int, ...]:
        """Return the indices in the robot (0 to 5) of the selected axes; by default, of all axes.

        The fields `axis_designation` and `axes` select axes.
        """
        count = len(self.arm.axes)
        if not self.values.get("axis_designation", "axes" in self.values):
            return tuple(range(count))
        chosen = self.values["axes"]
        if chosen >> count:
            raise CommandError(self.arm.config.no_axis_alarm)
        return tuple(place for place in range(count) if chosen >> place & 1)

    @property
    def indices(self) -> tuple[int, ...]:
        """Return the selected axes as indices into all axes of the controller."""
        return tuple(self.arm.indices[place] for place in self.places)


class Execution:
    """A command that is being executed. By default the status reset command does not end it."""

    stoppable = False
    """Whether the status reset command may end the command (continuous output) legally."""

    def step(self, machine: Machine) -> Response | None:
        """Execute the command for one cycle; return the response at its normal end, else None."""
        raise NotImplementedError

    def interim(self, machine: Machine) -> Response:
        """Return the response that is shown with status 0x0100 before the end; by default empty."""
        return {}


_Action = Callable[[Machine, Call], Response | None]
_A = TypeVar("_A", bound=_Action)
_Starter = Callable[[Machine, Call], Execution]
_S = TypeVar("_S", bound=_Starter)

_ACTIONS: dict[int, _Action] = {}
_STARTERS: dict[int, _Starter] = {}
_STATEMENTS: dict[int, _Starter] = {}
_ABSENT: set[int] = set()


def act(*codes: int, absent: bool = False) -> Callable[[_A], _A]:
    """Register a function that executes a whole command at the end of its `command_delay`.

    The function returns the response fields, or None if there are none. `codes` are the codes of
    the commands without the robot digit. With `absent` the function is also called for a robot that
    does not exist.
    """

    def register(function: _A) -> _A:
        _ACTIONS.update(dict.fromkeys(codes, function))
        if absent:
            _ABSENT.update(codes)
        return function

    return register


def acts_once(code: int) -> bool:
    """Return whether the command acts once when its `command_delay` is over."""
    return code in _ACTIONS


def answers_absent(code: int) -> bool:
    """Return whether the command answers for a robot that does not exist."""
    return code in _ABSENT


def takes_time(*codes: int) -> Callable[[_S], _S]:
    """Register a class, or a function that returns an Execution, for a command that takes time."""

    def register(starter: _S) -> _S:
        _STARTERS.update(dict.fromkeys(codes, starter))
        return starter

    return register


def statement(code: int) -> Callable[[_S], _S]:
    """Register a statement of robot programs that has no remote command, under our own code."""

    def register(starter: _S) -> _S:
        _STATEMENTS[code] = starter
        return starter

    return register


def registered() -> list[int]:
    """Return the codes of all registered commands, without the robot digit R."""
    return sorted({*_ACTIONS, *_STARTERS})


def start(machine: Machine, call: Call) -> Execution:
    """Begin a remote command, and return the object that executes it in the following cycles."""
    starter = _STARTERS.get(call.code) or (call.by_program and _STATEMENTS.get(call.code))
    if starter:
        try:
            return starter(machine, call)
        except UnreachableError:
            raise CommandError(machine.config.out_of_reach_alarm) from None
    if call.code in _ACTIONS:
        return Action(machine, call)
    raise CommandError(machine.config.undefined_code_alarm)


def perform(machine: Machine, wanted: Request) -> Execution | None:
    """Execute a statement of a robot program as the remote command that does the same.

    Returns:
        The command under way, or None if the command is done.

    Raises:
        CommandError: the statement cannot be executed.
    """
    values, code = wanted.values, wanted.code
    call = Call(code, machine.arm(wanted.robot or 1), values, wanted.robot, by_program=True)
    if code in _STARTERS or code in _STATEMENTS:
        return start(machine, call)
    _ACTIONS[code](machine, call)
    return None


class Action(Execution):
    """A command that acts once, `command_delay` after it was accepted.

    If the delay is shorter than a cycle, the command acts at once. Then the run status may be
    skipped.
    """

    def __init__(self, machine: Machine, call: Call) -> None:
        self._call = call
        delay_us = machine.draw_us("command_delay")
        self._due_us = machine.now_us + (0 if delay_us < CYCLE_US else delay_us)

    def step(self, machine: Machine) -> Response | None:
        """Call the function of the command once the delay is over; return None before that."""
        if machine.now_us < self._due_us:
            return None
        return _ACTIONS[self._call.code](machine, self._call) or {}
