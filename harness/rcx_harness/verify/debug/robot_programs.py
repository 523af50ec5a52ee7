"""The robot's own programs for the debugger: files, lines, tasks, and the values of a task."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import accumulate
from typing import Any

from rcx_harness.robot import Controller, Point
from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.program.execution import Frame
from rcx_harness.robot.program.expressions import evaluate, number_of
from rcx_harness.robot.program.reader import read_expression
from rcx_harness.robot.program.syntax import Instruction, Node
from rcx_harness.robot.program.task import RobotTask
from rcx_harness.robot.program.values import Value
from structured_text.debug.devices import DeviceFrame, Devices, DeviceStep
from structured_text.debug.machine import Scope
from structured_text.debug.places import real_path
from structured_text.debug.values import Item, Text
from structured_text.errors import InputError

__all__ = ["RobotPrograms", "robot_programs"]

#: Decimals of lengths and angles; points store 0.001 mm and 0.001 degree.
_SCALE = 1000


def robot_programs(controllers: Sequence[Controller]) -> Devices | None:
    """Return the robot programs of a cell. Return None if no robot has a program in source text."""
    texts = any(one.text for robot in controllers for one in robot.config.programs)
    return RobotPrograms(controllers) if texts else None


class RobotPrograms:
    """The programs in the robot's own language, of all controllers of a cell.

    The debugger numbers the programs of all controllers. A program keeps its number if it is
    registered in another task.
    """

    def __init__(self, controllers: Sequence[Controller]) -> None:
        self._controllers = controllers
        counts = [len(robot.config.programs) for robot in controllers]
        self._first = list(accumulate(counts, initial=1))
        self._watching: list[tuple[Controller, _Watch]] = []

    @property
    def files(self) -> list[str]:
        """Return the source files of all robot programs."""
        found = [one.path for robot in self._controllers for one in robot.config.programs]
        return list(dict.fromkeys(filter(None, found)))

    def lines(self, file: str) -> list[int]:
        """Return the sorted lines of a file at which statements begin; empty for other files."""
        wanted = real_path(file)
        return sorted(
            {
                line + task.program.offset
                for _, task in self._every()
                if task.program.path and real_path(task.program.path) == wanted
                for line in task.code.begins.values()
            }
        )

    @property
    def tasks(self) -> list[tuple[int, str]]:
        """Return number and name of each task that is in use."""
        return [(number, self._name(number)) for number, task in self._every() if task.number]

    def stack(self, task: int) -> list[DeviceFrame]:
        """Return the calls of a task; the innermost call is first."""
        robot, of = self._task(task)
        calls = of.stack
        return [
            DeviceFrame(
                name,
                of.program.path,
                line + of.program.offset,
                self._scopes(robot, task, len(calls) - 1 - depth),
            )
            for depth, (name, line) in enumerate(calls)
        ]

    @property
    def positions(self) -> list[str]:
        """Return a text for each task in use: its program, line, state and statement."""
        return [
            f"{name}, line {of.line + of.program.offset}, {of.state}: {_statement(of)}"
            for number, name in self.tasks
            for _, of in (self._task(number),)
        ]

    def condition(self, text: str) -> Callable[[int], bool]:
        """Return a function that evaluates a condition in the task with the given number.

        Raise InputError if the text is not an expression of the robot language. The function raises
        InputError if the expression has no value.
        """
        node = read_expression(text)

        def holds(number: int) -> bool:
            robot, task = self._task(number)
            try:
                value = evaluate(node, robot.program, task)
                return number_of(value, robot.config) != 0
            except CommandError as error:
                raise InputError(f"{text} has no value: alarm {error.number}") from None

        return holds

    def watch(self, look: Callable[[DeviceStep], None] | None) -> None:
        """Call `look` before each line that a task begins. With None the calls end."""
        for robot, watch in self._watching:
            robot.program.observers.remove(watch)
        self._watching = []
        if look is not None:
            firsts = zip(self._controllers, self._first, strict=False)
            self._watching = [(robot, _Watch(robot, first, look)) for robot, first in firsts]
        for robot, watch in self._watching:
            robot.program.observers.append(watch)

    def _every(self) -> Iterator[tuple[int, RobotTask]]:
        """Yield number and task of each program with source text."""
        for robot, first in zip(self._controllers, self._first, strict=False):
            for number, task in enumerate(robot.program.tasks, first):
                if task.program.text:
                    yield number, task

    def _task(self, number: int) -> tuple[Controller, RobotTask]:
        """Return the task with this number, and its controller."""
        place = max(k for k, first in enumerate(self._first[:-1]) if first <= number)
        robot = self._controllers[place]
        return robot, robot.program.tasks[number - self._first[place]]

    def _name(self, number: int) -> str:
        robot, task = self._task(number)
        which = f" {self._controllers.index(robot) + 1}" if len(self._controllers) > 1 else ""
        return f"Robot{which} task {task.number}: {task.program.name}"

    def _scopes(self, robot: Controller, number: int, depth: int) -> list[Scope]:
        """Return the groups of values of a frame; `depth` is the number of calls around it.

        The values are read from the current state of the task when the user opens a group.
        """

        def of(items: Callable[[Controller, RobotTask], list[Item]]) -> Callable[[], list[Item]]:
            return lambda: items(robot, self._task(number)[1])

        return [
            ("Variables", of(partial(_variables, depth=depth))),
            ("Program variables", of(partial(_variables, depth=0))),
            ("SGI, SGR", of(_static)),
            ("Points", of(_points)),
            ("Ports", of(_ports)),
            ("Task", of(_state)),
        ][0 if depth else 1 :]


class _Watch:
    """An observer that reports the lines that the tasks of a controller begin."""

    def __init__(self, robot: Controller, first: int, look: Callable[[DeviceStep], None]) -> None:
        self._robot, self._first, self._look = robot, first, look
        self._files = {
            one.name: real_path(one.path) if one.path else "" for one in robot.config.programs
        }

    def begins(self, task: RobotTask, at: int) -> None:
        """Report the line if the instruction is the first of this line."""
        line = task.code.begins.get(at)
        if line is None or not task.program.text:
            return
        number = self._first + self._robot.program.tasks.index(task)
        file, depth = self._files[task.program.name], len(task.frames) + 1
        self._look(DeviceStep(number, file, line + task.program.offset, depth))

    def ends(self, task: RobotTask, at: int, to: int) -> None:
        """Do nothing, because the debugger stops only before statements."""


def _statement(task: RobotTask) -> str:
    """Return the text of the current line without its comment at the end."""
    texts = task.code.texts
    return texts[task.line - 1].partition(" '")[0].strip() if task.line <= len(texts) else ""


# --- values -------------------------------------------------------------------------------------


def _variables(_: Controller, task: RobotTask, *, depth: int) -> list[Item]:
    """Return the variables of the program, or of the SUB at this depth of calls."""
    return [
        Text(name, _shown(value), _TYPES.get(name.partition("(")[0][-1:], ""))
        for name, value in sorted(_own(task.frames[:depth], task.variables).items())
        if "@" not in name  # leave out internal variables of FOR, SELECT and array sizes
    ]


def _own(frames: list[Frame], of_program: dict[str, Value]) -> dict[str, Value]:
    """Return the variables of the innermost SUB. A GOSUB uses the variables of its caller."""
    own = (frame.variables for frame in reversed(frames))
    return next((found for found in own if found is not None), of_program)


_TYPES = {"%": "integer", "!": "real", "$": "character string"}


def _static(robot: Controller, task: RobotTask) -> list[Item]:
    """Return the static variables that the program uses or that are not 0."""
    variables, used = robot.program.memory.variables, _used(task, "variable")
    every: list[tuple[str, float, str]] = [
        (f"SGI{k}", v, "integer") for k, v in enumerate(variables.integers)
    ]
    every += [(f"SGR{k}", v, "real") for k, v in enumerate(variables.reals)]
    return [Text(name, _shown(value), kind) for name, value, kind in every if value or name in used]


def _points(robot: Controller, task: RobotTask) -> list[Item]:
    """Return the points whose numbers the program contains."""
    points = robot.program.memory.points
    numbers = sorted(
        node.args[0].args[0]
        for node in _nodes(task.code.code)
        if node.kind == "point" and isinstance(node.args[0], Node) and node.args[0].kind == "number"
    )
    return [
        Text(f"P{k}", _shown(points[k]) if k in points else "not defined", "point")
        for k in dict.fromkeys(numbers)
    ]


def _ports(robot: Controller, task: RobotTask) -> list[Item]:
    """Return the ports that a robot program names, with their values."""
    found = {place.name: place for node in _nodes(task.code.code) if node.kind == "port"
             for place in node.args}  # fmt: skip
    return [Text(name, str(robot.program.ports.read(found[name]))) for name in sorted(found)]


def _state(_: Controller, task: RobotTask) -> list[Item]:
    error = f"{task.error[0]} in line {task.error[1]}" if task.error else "none"
    return [
        Text("state", task.state),
        Text("priority", str(task.priority)),
        Text("line", str(task.line + task.program.offset)),
        Text("statement", _statement(task)),
        Text("error", error),
    ]


def _used(task: RobotTask, kind: str) -> set[str]:
    return {node.args[0] for node in _nodes(task.code.code) if node.kind == kind}


def _nodes(code: Sequence[Instruction]) -> Iterator[Node]:
    """Yield all nodes of a program, also those in lists of targets and options."""

    def inside(part: Any) -> Iterator[Node]:
        if isinstance(part, Node):
            yield part
        for one in part.args if isinstance(part, Node) else part if isinstance(part, tuple) else ():
            yield from inside(one)

    for one in code:
        yield from inside(one.args)


def _shown(value: Value) -> str:
    """Return a value in the notation of the robot language."""
    if isinstance(value, Point):
        if value.mm:
            return " ".join(f"{part / _SCALE:.3f}" for part in value.data)
        return " ".join(map(str, value.data))
    if isinstance(value, tuple):
        return " ".join(f"{part / _SCALE:.3f}" for part in value)
    return f'"{value}"' if isinstance(value, str) else str(value)
