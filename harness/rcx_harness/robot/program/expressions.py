"""The evaluation of expressions of the robot language, and the assignment of their results."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from datetime import datetime
from typing import Any, Protocol

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.arm import Arm
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.ports import Port, Ports
from rcx_harness.robot.program.syntax import COORDINATES, Node
from rcx_harness.robot.program.values import (
    Value,
    calculate,
    combine,
    compare,
    convert,
    integer,
    number,
    to_point,
)
from rcx_harness.robot.stored import COUNTS, Hand, Point, variable_number

__all__ = ["FUNCTIONS", "Scope", "Surroundings", "assign", "evaluate", "inputs_only", "is_true"]

_SCALE = 1000


class Surroundings(Protocol):
    """The parts of the controller that expressions read and assignments change; see Programs."""

    @property
    def config(self) -> RobotConfig:
        """Return the properties of the controller."""

    @property
    def memory(self) -> Memory:
        """Return the stored data."""

    @property
    def ports(self) -> Ports:
        """Return the general-purpose ports."""

    @property
    def now_us(self) -> int:
        """Return the time of the current controller cycle [us]."""

    @property
    def clock(self) -> datetime:
        """Return the date and the time of the controller."""

    @property
    def counted_us(self) -> int:
        """Return the time since power-on or the last RESET TCOUNTER [us]."""

    def arm(self, robot: int) -> Arm:
        """Return a robot by its number, 1 to 4."""

    def error_of(self, number: int) -> tuple[str, int] | None:
        """Return alarm number and line of the last error that ON ERROR of a task has handled."""


class Scope(Protocol):
    """The state of a task that expressions use; see RobotTask."""

    @property
    def integers(self) -> bool:
        """Return whether variables without a type character are integers."""

    @property
    def error(self) -> tuple[str, int] | None:
        """Return alarm number and line of the last error that ON ERROR has handled."""

    def variable(self, name: str) -> Value | None:
        """Return the value of a variable; None if the variable has no value yet."""

    def assign_variable(self, name: str, value: Value) -> None:
        """Assign a value to a variable; the value already has the type of the variable."""


def evaluate(node: Node, world: Surroundings, scope: Scope) -> Any:
    """Return the value of an expression.

    Raises:
        CommandError: the evaluation fails; the program gets the alarm with this number.
    """
    return _EVALUATORS[node.kind](node.args, world, scope)


def is_true(condition: Node, world: Surroundings, scope: Scope) -> bool:
    """Return whether a condition is true: any number but 0."""
    return number_of(evaluate(condition, world, scope), world.config) != 0


def inputs_only(node: Node) -> bool:
    """Return whether only inputs from the master can change the value."""
    for part in node.walk():
        if part.kind in ("variable", "point", "shift", "hand"):
            return False
        if part.kind == "port" and any(one.bank or one.output for one in part.args):
            return False
    return True


def assign(target: Node, source: Node, world: Surroundings, scope: Scope) -> None:
    """Assign the value of an expression to a variable, an output, a point, a shift or a hand.

    Raises:
        CommandError: the assignment fails; the program gets the alarm with this number.
    """
    value = evaluate(source, world, scope)
    config = world.config
    if target.kind == "port":
        write_ports(target.args, integer(value, config), world)
    elif target.kind == "variable":
        _assign_variable(target, value, world, scope)
    elif target.kind == "point":
        place = _place("points", target, world, scope)
        if not isinstance(value, Point):
            raise CommandError(config.program_type_alarm)
        world.memory.points[place] = value
    elif target.kind == "shift":
        place = _place("shifts", target, world, scope)
        shift = value.data[:4] if isinstance(value, Point) else value
        if not isinstance(shift, tuple):
            raise CommandError(config.program_type_alarm)
        x, y, z, r = shift
        world.memory.shifts[place] = (x, y, z, r)
    else:
        _assign_hand(_place("hands", target, world, scope), source, value, world)


def write_ports(ports: tuple[Port, ...], value: int, world: Surroundings) -> None:
    """Write a value to ports; of several bit ports, the first is the most significant bit."""
    for position, place in enumerate(reversed(ports)):
        world.ports.write(place, value >> position if len(ports) > 1 else value)


def _assign_variable(target: Node, value: Value, world: Surroundings, scope: Scope) -> None:
    name, *indices = target.args
    if name in COORDINATES and indices[0] is not None:
        _assign_coordinate(COORDINATES[name], indices[0], value, world, scope)
        return
    if (static := variable_number(name)) is not None and indices == [None]:
        world.memory.variables.assign(static, number_of(value, world.config))
        return
    key = _key(name, indices, world, scope)
    if key != name and scope.variable(f"DIM@{name}") is None:
        raise CommandError(world.config.program_type_alarm)
    scope.assign_variable(key, convert(name, value, world.config, integers=scope.integers))


def number_of(value: Value, config: RobotConfig) -> int | float:
    """Return the value if it is a number.

    Raises:
        CommandError: the value is a text or a point.
    """
    if isinstance(value, (int, float)):
        return value
    raise CommandError(config.program_type_alarm)


def _key(name: str, indices: list[Node | None], world: Surroundings, scope: Scope) -> str:
    """Return the name under which a variable or an array element is stored, such as `A%(3,1)`."""
    numbers = [integer(evaluate(one, world, scope), world.config) for one in indices if one]
    if not numbers:
        return name
    size = scope.variable(f"DIM@{name}")
    if isinstance(size, tuple) and (
        len(size) != len(numbers)
        or not all(0 <= one <= most for one, most in zip(numbers, size, strict=True))
    ):
        raise CommandError(world.config.program_type_alarm)
    return f"{name}({','.join(map(str, numbers))})"


# --- points, shifts and hands ---


def _place(kind: str, target: Node, world: Surroundings, scope: Scope) -> int:
    place = integer(evaluate(target.args[0], world, scope), world.config)
    if not 0 <= place < COUNTS[kind]:
        raise CommandError(world.config.undefined_point_alarm)
    return place


def _assign_coordinate(
    axis: int, target: Node | None, value: Value, world: Surroundings, scope: Scope
) -> None:
    """Assign one coordinate [mm or pulses] of a point or a shift."""
    if target is None or target.kind not in ("point", "shift"):
        raise CommandError(world.config.program_type_alarm)
    amount = number_of(value, world.config)
    if target.kind == "shift":
        place = _place("shifts", target, world, scope)
        shift = list(world.memory.shift(place))
        if axis >= len(shift):
            raise CommandError(world.config.no_axis_alarm)
        shift[axis] = integer(round(amount * _SCALE), world.config)
        x, y, z, r = shift
        world.memory.shifts[place] = (x, y, z, r)
        return
    place = _place("points", target, world, scope)
    point = world.memory.points.get(place) or Point(mm=isinstance(amount, float))
    data = list(point.data)
    data[axis] = round(amount * _SCALE) if point.mm else integer(amount, world.config)
    world.memory.points[place] = world.memory.changed(point, tuple(data))


def _assign_hand(place: int, source: Node, value: Value, world: Surroundings) -> None:
    if isinstance(value, Hand):
        world.memory.hands[1, place] = value
        return
    if source.kind != "data":
        raise CommandError(world.config.program_type_alarm)
    values, mm, on_r = source.args
    data = [round(value * _SCALE) if mm else round(value) for value in values[:3]]
    data += [0] * (3 - len(data))
    world.memory.hands[1, place] = Hand((data[0], data[1], data[2], int(on_r)))


# --- evaluators, one for each kind of node ---

Evaluator = Callable[[tuple[Any, ...], Surroundings, Scope], Any]


def _literal(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
    value: Value = args[0]
    return number(value, world.config) if isinstance(value, float) else value


def _port(args: tuple[Port, ...], world: Surroundings, scope: Scope) -> int:
    if len(args) == 1:
        return world.ports.read(args[0])
    value = 0
    for place in args:
        value = value << 1 | world.ports.read(place)
    return value


def _point(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Point:
    return world.memory.point(_place("points", Node("point", args), world, scope))


def _shift(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
    return world.memory.shift(_place("shifts", Node("shift", args), world, scope))


def _hand(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
    return world.memory.hand(1, _place("hands", Node("hand", args), world, scope))


def _data(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Point:
    return to_point(args[0], mm=args[1])


def _operation(kind: str) -> Evaluator:
    def run(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
        left, right = (evaluate(one, world, scope) for one in args)
        if kind in ("add", "subtract") and not isinstance(left, (int, float, str)):
            return combine(kind, left, right, world.config)
        return calculate(kind, left, right, world.config)

    return run


def _logic(combined: Callable[[int, int], int]) -> Evaluator:
    def run(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> int:
        left, right = (integer(evaluate(one, world, scope), world.config) for one in args)
        return combined(left, right)

    return run


def _not(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> int:
    return ~integer(evaluate(args[0], world, scope), world.config)


def _negative(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
    return calculate("subtract", 0, evaluate(args[0], world, scope), world.config)


def _compare(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> int:
    left, operator, right = args
    first, second = evaluate(left, world, scope), evaluate(right, world, scope)
    return compare(operator, first, second, world.config)


def _variable(args: tuple[Any, ...], world: Surroundings, scope: Scope) -> Value:
    name, *indices = args
    given = [one for one in indices if one is not None]
    if name in FUNCTIONS and not (given and scope.variable(f"DIM@{name}")):
        return FUNCTIONS[name](given, world, scope)
    if not given and (static := variable_number(name)) is not None:
        return world.memory.variables.value(static)
    value = scope.variable(_key(name, given, world, scope))
    if value is None:
        return "" if name.endswith("$") else 0
    return value


_EVALUATORS: dict[str, Evaluator] = {
    "number": _literal,
    "text": _literal,
    "port": _port,
    "point": _point,
    "shift": _shift,
    "hand": _hand,
    "data": _data,
    "variable": _variable,
    "compare": _compare,
    "not_": _not,
    "negative": _negative,
    "and_": _logic(lambda a, b: a & b),
    "or_": _logic(lambda a, b: a | b),
    "xor": _logic(lambda a, b: a ^ b),
    **{kind: _operation(kind) for kind in
       ("add", "subtract", "multiply", "divide", "modulo", "power")},
}  # fmt: skip


# --- functions of the language ---

Function = Callable[[list[Node], Surroundings, Scope], Value]


def _numbers(count: int, function: Callable[..., float]) -> Function:
    def run(nodes: list[Node], world: Surroundings, scope: Scope) -> Value:
        values = _arguments(nodes, count, world, scope)
        numbers = [number_of(value, world.config) for value in values]
        try:
            result = function(*numbers)
        except (ValueError, OverflowError, ZeroDivisionError):
            raise CommandError(world.config.program_type_alarm) from None
        return result if isinstance(result, int) else number(result, world.config)

    return run


def _texts(count: int, function: Callable[..., Value]) -> Function:
    def run(nodes: list[Node], world: Surroundings, scope: Scope) -> Value:
        text, *rest = _arguments(nodes, count, world, scope)
        if not isinstance(text, str):
            raise CommandError(world.config.program_type_alarm)
        try:
            return function(text, *(integer(one, world.config) for one in rest))
        except (ValueError, IndexError):
            raise CommandError(world.config.program_type_alarm) from None

    return run


def _arguments(nodes: list[Node], count: int, world: Surroundings, scope: Scope) -> Iterator[Value]:
    if len(nodes) != count:
        raise CommandError(world.config.program_type_alarm)
    return (evaluate(one, world, scope) for one in nodes)


def _str(nodes: list[Node], world: Surroundings, scope: Scope) -> str:
    (value,) = _arguments(nodes, 1, world, scope)
    plain = number_of(value, world.config)
    return str(plain) if isinstance(plain, int) else f"{plain:.7g}"


def _dist(nodes: list[Node], world: Surroundings, scope: Scope) -> float:
    """Return the distance between two points in X, Y and Z [mm]."""
    first, second = _arguments(nodes, 2, world, scope)
    if not isinstance(first, Point) or not isinstance(second, Point):
        raise CommandError(world.config.program_type_alarm)
    if not (first.mm and second.mm):
        raise CommandError(world.config.point_unit_alarm)
    return number(math.dist(first.data[:3], second.data[:3]) / _SCALE, world.config)


def _where(*, mm: bool) -> Function:
    def run(nodes: list[Node], world: Surroundings, scope: Scope) -> Value:
        if nodes:
            raise CommandError(world.config.program_type_alarm)
        return Point(world.arm(1).shown(mm=mm), mm=mm)

    return run


def _coordinate(axis: int) -> Function:
    def run(nodes: list[Node], world: Surroundings, scope: Scope) -> Value:
        (value,) = _arguments(nodes, 1, world, scope)
        if isinstance(value, Point):
            return number(value.data[axis] / _SCALE, world.config) if value.mm else value.data[axis]
        data = value.data[:3] if isinstance(value, Hand) else value
        if isinstance(data, tuple) and axis < len(data):
            return number(data[axis] / _SCALE, world.config)
        raise CommandError(world.config.program_type_alarm)

    return run


def _error_number(nodes: list[Node], world: Surroundings, scope: Scope) -> int:
    """Return the number of the last error as group * 65536 + category (&HGGGGCCCC)."""
    error = _error(nodes, world, scope)
    if error is None:
        return 0
    group, _, category = error[0].partition(".")
    return int(group) << 16 | int(category)


def _error_line(nodes: list[Node], world: Surroundings, scope: Scope) -> int:
    error = _error(nodes, world, scope)
    return error[1] if error else 0


def _error(nodes: list[Node], world: Surroundings, scope: Scope) -> tuple[str, int] | None:
    """Return the last error of this task, or of the task with the given number."""
    number = integer(evaluate(nodes[0], world, scope), world.config) if nodes else 0
    return world.error_of(number) if number else scope.error


def _counter(nodes: list[Node], world: Surroundings, scope: Scope) -> int:
    """Return TCOUNTER, the count since power-on or RESET TCOUNTER; 65535 is followed by 0."""
    return world.counted_us // (1000 * world.config.tcounter_ms) % 65536


def _timer(nodes: list[Node], world: Surroundings, scope: Scope) -> int:
    """Return TIMER, the seconds since midnight."""
    now = world.clock
    return (now.hour * 60 + now.minute) * 60 + now.second


def _clock(form: str) -> Function:
    def run(nodes: list[Node], world: Surroundings, scope: Scope) -> str:
        return world.clock.strftime(form)

    return run


def _chr(nodes: list[Node], world: Surroundings, scope: Scope) -> str:
    (value,) = _arguments(nodes, 1, world, scope)
    code = integer(value, world.config)
    if not 0 <= code <= 255:
        raise CommandError(world.config.program_type_alarm)
    return chr(code)


def _value_of(text: str) -> Value:
    text = text.strip()
    if text.upper().startswith("&H"):
        return int(text[2:], 16)
    if text.upper().startswith("&B"):
        return int(text[2:], 2)
    return float(text) if "." in text or "E" in text.upper() else int(text or "0")


FUNCTIONS: dict[str, Function] = {
    "ABS": _numbers(1, abs),
    "INT": _numbers(1, math.floor),
    "SQR": _numbers(1, math.sqrt),
    "SIN": _numbers(1, math.sin),
    "COS": _numbers(1, math.cos),
    "TAN": _numbers(1, math.tan),
    "ATN": _numbers(1, math.atan),
    "ATN2": _numbers(2, math.atan2),
    "RADDEG": _numbers(1, math.degrees),
    "DEGRAD": _numbers(1, math.radians),
    "LEN": _texts(1, len),
    "VAL": _texts(1, _value_of),
    "STR$": _str,
    "ORD": _texts(1, lambda text: ord(text[0])),
    "LEFT$": _texts(2, lambda text, count: text[: max(count, 0)]),
    "MID$": _texts(3, lambda text, first, count: text[max(first - 1, 0) :][: max(count, 0)]),
    "RIGHT$": _texts(2, lambda text, count: text[len(text) - min(max(count, 0), len(text)) :]),
    "DIST": _dist,
    "WHERE": _where(mm=False),
    "WHRXY": _where(mm=True),
    "ERR": _error_number,
    "ERL": _error_line,
    "TCOUNTER": _counter,
    "TIMER": _timer,
    "TIME$": _clock("%H:%M:%S"),
    "DATE$": _clock("%y/%m/%d"),
    "CHR$": _chr,
    **{name: _coordinate(axis) for name, axis in COORDINATES.items()},
}
