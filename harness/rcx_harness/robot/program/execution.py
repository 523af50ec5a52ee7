"""The execution of the instructions of a robot program, one function for each kind.

Each function returns NEXT, STAY (the task executes this instruction again in the next cycle), or
the position of the next instruction. The module `movements` executes movements.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.ports import Port
from rcx_harness.robot.program.expressions import (
    assign,
    evaluate,
    inputs_only,
    is_true,
    number_of,
    write_ports,
)
from rcx_harness.robot.program.motion import change_parameter
from rcx_harness.robot.program.movements import (
    MovingTask,
    MovingWorld,
    command,
    define_path,
    move,
    wait_arm,
)
from rcx_harness.robot.program.syntax import MOVES, NEXT, STAY, Instruction, Node, Program
from rcx_harness.robot.program.values import Value, convert, integer
from rcx_harness.robot.stored import COUNTS, Pallet

__all__ = ["Frame", "Order", "Running", "World", "execute"]

_MS = 1000


@dataclass
class Frame:
    """A call of a subroutine that has not returned yet.

    Attributes:
        back: Position of the instruction behind the call.
        variables: Variables of a SUB; None: a GOSUB, which has no variables of its own.
        shared: Names of variables that a SHARED statement shares with the main program.
        references: Maps the name of each REF parameter to the variable of the caller.
    """

    back: int
    variables: dict[str, Value] | None = None
    shared: set[str] = field(default_factory=set)
    references: dict[str, tuple[int, str]] = field(default_factory=dict)


@dataclass(frozen=True)
class Order:
    """An order of a program to a task; `what` is START, SUSPEND, RESTART or CUT.

    Attributes:
        program: Name of the program, or its number (the position in the list of programs), or None.
        task: Number of the task, or None.
        priority: Priority of a task that START starts; None: the usual priority.
    """

    what: str
    program: str | int | None
    task: int | None = None
    priority: int | None = None


class Running(MovingTask, Protocol):
    """The properties of the executing task that the instructions use; see RobotTask."""

    until_us: int | None
    waits: bool
    frames: list[Frame]
    handler: int
    error_at: int

    @property
    def code(self) -> Program:
        """Return the program of the task."""

    def passed_us(self, now_us: int) -> int:
        """Return the time for which the program has run [us]; stops do not count."""


class World(MovingWorld, Protocol):
    """The parts of the controller that the instructions use; see Programs."""

    def reset_counter(self) -> None:
        """Reset the counter of the function TCOUNTER to 0."""

    def pulse(self, place: Port, ms: int) -> None:
        """Turn an output ON, and turn it OFF after `ms` milliseconds."""

    def order(self, task: Any, wanted: Order) -> None:
        """Start, suspend, restart or cut a task, as the order says."""

    def end(self, task: Any, *, everything: bool) -> None:
        """End the program of the task; with `everything`, end all programs."""

    def hold(self, task: Any, *, everything: bool) -> None:
        """Stop the program of the task; with `everything`, stop all programs.

        The next start continues the stopped programs.
        """


def execute(one: Instruction, task: Running, world: World) -> int:
    """Execute one instruction.

    Raises:
        CommandError: the execution fails; the program gets the alarm with this number.
    """
    return _FUNCTIONS[one.kind](one, task, world)


# --- program flow ---


def _label(one: Instruction, task: Running, world: World) -> int:
    return NEXT


def _goto(one: Instruction, task: Running, world: World) -> int:
    return one.jump


def _unless(one: Instruction, task: Running, world: World) -> int:
    return NEXT if is_true(one.args[0], world, task) else one.jump


def _case(one: Instruction, task: Running, world: World) -> int:
    selected, *values = one.args
    for value in values:
        if is_true(Node("compare", (selected, "=", value)), world, task):
            return NEXT
    return one.jump


def _for_test(one: Instruction, task: Running, world: World) -> int:
    value, limit, step = (number_of(evaluate(part, world, task), world.config) for part in one.args)
    over = value > limit if step >= 0 else value < limit
    return one.jump if over else NEXT


def _for_next(one: Instruction, task: Running, world: World) -> int:
    variable, _, step = one.args
    assign(variable, Node("add", (variable, step)), world, task)
    return NEXT


def _gosub(one: Instruction, task: Running, world: World) -> int:
    return _enter(Frame(task.at + 1), one.jump, task, world)


def _on_goto(one: Instruction, task: Running, world: World) -> int:
    number = integer(evaluate(one.args[0], world, task), world.config)
    places = one.args[1]
    return places[number - 1] if 1 <= number <= len(places) else NEXT


def _on_gosub(one: Instruction, task: Running, world: World) -> int:
    place = _on_goto(one, task, world)
    return NEXT if place == NEXT else _enter(Frame(task.at + 1), place, task, world)


def _enter(frame: Frame, place: int, task: Running, world: World) -> int:
    if len(task.frames) >= world.config.program_stack:
        raise CommandError(world.config.program_stack_alarm)
    task.frames = [*task.frames, frame]
    return place


def _return(one: Instruction, task: Running, world: World) -> int:
    if task.frames and task.frames[-1].variables is None:
        frame = task.frames[-1]
        task.frames = task.frames[:-1]
        return frame.back
    if task.code.shared:  # a RETURN without GOSUB ends a program of steps
        return len(task.code.code)
    raise CommandError(world.config.program_stack_alarm)


def _call(one: Instruction, task: Running, world: World) -> int:
    name, *given = one.args
    sub = task.code.subs[name]
    arguments = [part for part in given if part is not None]
    if len(arguments) != len(sub.parameters):
        raise CommandError(world.config.program_type_alarm)
    frame = Frame(task.at + 1, {})
    for parameter, argument in zip(sub.parameters, arguments, strict=True):
        (part,) = argument.args
        if argument.kind == "reference":
            depth = max((k for k, one in enumerate(task.frames) if one.variables is not None),
                        default=-1)  # fmt: skip
            frame.references[parameter] = (depth, part.args[0])
        else:
            value = convert(
                parameter, evaluate(part, world, task), world.config, integers=task.integers
            )
            assert frame.variables is not None
            frame.variables[parameter] = value
    return _enter(frame, sub.at, task, world)


def _exit_sub(one: Instruction, task: Running, world: World) -> int:
    for depth in reversed(range(len(task.frames))):
        if task.frames[depth].variables is not None:
            back = task.frames[depth].back
            task.frames = task.frames[:depth]
            return back
    raise CommandError(world.config.program_stack_alarm)


def _shared(one: Instruction, task: Running, world: World) -> int:
    for frame in reversed(task.frames):
        if frame.variables is not None:
            frame.shared.update(one.args)
            return NEXT
    raise CommandError(world.config.program_type_alarm)


def _dim(one: Instruction, task: Running, world: World) -> int:
    for part in one.args:
        name, *sizes = part.args
        limits = tuple(integer(evaluate(size, world, task), world.config) for size in sizes)
        if any(limit < 0 for limit in limits) or math.prod(k + 1 for k in limits) > _LARGEST_ARRAY:
            raise CommandError(world.config.program_type_alarm)
        task.assign_variable(f"DIM@{name}", limits)  # type: ignore[arg-type]
    return NEXT


_LARGEST_ARRAY = 32768


# --- handling of errors ---


def _on_error(one: Instruction, task: Running, world: World) -> int:
    task.handler = one.jump
    return NEXT


def _no_on_error(one: Instruction, task: Running, world: World) -> int:
    task.handler = -1
    return NEXT


def _resume(one: Instruction, task: Running, world: World) -> int:
    """Execute RESUME: continue at the instruction with the error, after it, or at a label."""
    if task.error_at < 0:
        raise CommandError(world.config.program_stack_alarm)
    at, task.error_at = task.error_at, -1
    if one.kind == "resume_at":
        return one.jump
    if one.kind == "resume":
        return at
    behind = task.code.code[at].behind
    return behind if behind >= 0 else at + 1


# --- ends of programs, and orders to tasks ---


def _halt(one: Instruction, task: Running, world: World) -> int:
    world.end(task, everything=one.kind == "halt_all")
    return STAY


def _end(one: Instruction, task: Running, world: World) -> int:
    return len(task.code.code)


def _hold(one: Instruction, task: Running, world: World) -> int:
    world.hold(task, everything=one.kind == "hold_all")
    return NEXT


def _exit_task(one: Instruction, task: Running, world: World) -> int:
    world.end(task, everything=False)
    return STAY


def _start_task(one: Instruction, task: Running, world: World) -> int:
    program, number, priority = one.args
    level = None
    if priority is not None:
        level = integer(evaluate(priority, world, task), world.config)
        if not 1 <= level <= 64:
            raise CommandError(world.config.format_alarm)
    world.order(task, Order("START", program.args[0], number and int(number[1:]), level))
    return NEXT


def _task_order(one: Instruction, task: Running, world: World) -> int:
    (named,) = one.args
    what = one.kind.upper()
    if named.kind == "task_number":
        world.order(task, Order(what, None, int(named.args[0][1:])))
    else:
        world.order(task, Order(what, named.args[0]))
    return NEXT


# --- inputs and outputs ---


def _assign(one: Instruction, task: Running, world: World) -> int:
    *_, target, source = one.args
    assign(target, source, world, task)
    return NEXT


def _set(one: Instruction, task: Running, world: World) -> int:
    ports = one.args[0].args
    write_ports(ports, (1 << len(ports)) - 1 if one.kind == "set_" else 0, world)
    return NEXT


def _reset_counter(one: Instruction, task: Running, world: World) -> int:
    world.reset_counter()
    return NEXT


def _out(one: Instruction, task: Running, world: World) -> int:
    port, duration = one.args
    if duration is None:
        write_ports(port.args, (1 << len(port.args)) - 1, world)
        return NEXT
    ms = integer(evaluate(duration, world, task), world.config)
    for place in port.args:
        world.pulse(place, ms)
    return NEXT


# --- instructions that wait ---


def _delay(one: Instruction, task: Running, world: World) -> int:
    passed_us = task.passed_us(world.now_us)
    if task.until_us is None:
        ms = number_of(evaluate(one.args[0], world, task), world.config)
        task.until_us = passed_us + max(0, round(ms * _MS))
    return _until(task, passed_us)


def _duration(one: Instruction, task: Running, world: World) -> int:
    """Wait until the program has run for its configured duration."""
    task.until_us = one.args[0]
    return _until(task, task.passed_us(world.now_us))


def _until(task: Running, passed_us: int) -> int:
    assert task.until_us is not None
    if passed_us < task.until_us:
        return STAY
    task.until_us = None
    return NEXT


def _wait(one: Instruction, task: Running, world: World) -> int:
    condition, limit = one.args
    if is_true(condition, world, task):
        task.waits, task.until_us = False, None
        return NEXT
    task.waits = inputs_only(condition)
    if limit is None:
        return STAY
    passed_us = task.passed_us(world.now_us)
    if task.until_us is None:
        ms = number_of(evaluate(limit, world, task), world.config)
        task.until_us = passed_us + max(0, round(ms * _MS))
    result = _until(task, passed_us)
    task.waits = task.waits and result == STAY
    return result


# --- settings ---


def _setting(one: Instruction, task: Running, world: World) -> int:
    change_parameter(one, world, task)
    return NEXT


def _pdef(one: Instruction, task: Running, world: World) -> int:
    pallet, nx, ny, nz, first = one.args
    numbers = [
        1 if part is None else integer(evaluate(part, world, task), world.config)
        for part in (pallet, nx, ny, nz, first.args[0])
    ]
    number, across, along, high, point = numbers
    if not 0 <= number < COUNTS["pallets"] or min(across, along, high) < 1:
        raise CommandError(world.config.format_alarm)
    world.memory.pallets[number] = Pallet(across, along, high, point)
    return NEXT


_FUNCTIONS: dict[str, Callable[[Instruction, Any, Any], int]] = {
    **dict.fromkeys(("label", "declare"), _label),
    **dict.fromkeys(("goto", "jump", "leave"), _goto),
    "unless": _unless,
    "case": _case,
    "for_test": _for_test,
    "for_next": _for_next,
    "gosub": _gosub,
    "return_": _return,
    "on_goto": _on_goto,
    "on_gosub": _on_gosub,
    "on_error": _on_error,
    "no_on_error": _no_on_error,
    **dict.fromkeys(("resume", "resume_next", "resume_at"), _resume),
    "call": _call,
    "exit_sub": _exit_sub,
    "exit_task": _exit_task,
    "shared": _shared,
    "dim": _dim,
    **dict.fromkeys(("halt", "halt_all"), _halt),
    **dict.fromkeys(("hold", "hold_all"), _hold),
    "end": _end,
    "start_task": _start_task,
    **dict.fromkeys(("suspend", "restart", "cut"), _task_order),
    **dict.fromkeys(("set_", "reset"), _set),
    "reset_counter": _reset_counter,
    **dict.fromkeys(("path_set", "path", "path_end"), define_path),
    "out": _out,
    "delay": _delay,
    "duration": _duration,
    "wait": _wait,
    "wait_arm": wait_arm,
    **dict.fromkeys(MOVES, move),
    **dict.fromkeys(
        ("servo", "motor", "origin", "shift_select", "hand_select", "righty", "lefty", "armsel"),
        command,
    ),
    **dict.fromkeys(("setting", "setting_axis"), _setting),
    "pdef": _pdef,
    "assign": _assign,
}
