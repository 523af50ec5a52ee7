"""Statements as the operations of rungs: calls, coils and assignments, each with its condition.

An IF becomes the conditions of the statements inside. All conditions of an IF are evaluated before
its statements. If a statement changes a variable of a later condition, or if there are more than
two branches, variables that are added to the POU hold the conditions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field

from structured_text.export.ladder import effects
from structured_text.export.ladder.power import (
    FALSE,
    TRUE,
    Leaf,
    Power,
    negated,
    parallel,
    power_of,
    series,
)
from structured_text.export.ladder.types import Pin, Scope
from structured_text.language import syntax as s
from structured_text.language.printer import expression_text

__all__ = ["Call", "Given", "Operation", "Operations", "Put", "RefusedError", "Send", "Store"]

#: An IF with more branches gets variables for its conditions.
_MOST_INLINE = 2


class RefusedError(Exception):
    """A statement cannot be a rung.

    Attributes:
        message: The reason.
        at: Its place in the text of the POU.
        moved: Whether the statement can stand in a block of its own, which gets its variables.
    """

    def __init__(self, message: str, at: s.Position, *, moved: bool = True) -> None:
        super().__init__(message)
        self.message, self.at, self.moved = message, at, moved


@dataclass(frozen=True)
class Operation:
    """What an operation reads and writes, by the upper-case names of whole variables."""

    reads: frozenset[str] = field(default=frozenset(), kw_only=True)
    writes: frozenset[str] = field(default=frozenset(), kw_only=True)


@dataclass(frozen=True)
class Given:
    """A pin of a call with its value: contacts or the text of an expression; None without one."""

    pin: Pin
    value: Power | str | None = None


@dataclass(frozen=True)
class Call(Operation):
    """A call of an instance of a block."""

    instance: str
    block: str
    pins: tuple[Given, ...]


@dataclass(frozen=True)
class Send(Operation):
    """The assignment of an output pin of the call before it to a variable."""

    pin: str
    target: str
    boolean: bool


@dataclass(frozen=True)
class Put(Operation):
    """The assignment of a Boolean expression to a variable.

    `storage` is `set` or `reset` if the variable is only changed while the expression is TRUE.
    """

    target: str
    power: Power
    storage: str = ""


@dataclass(frozen=True)
class Store(Operation):
    """The assignment of any other expression, which is only executed while `enable` is TRUE."""

    target: str
    value: str
    enable: Power = TRUE


class Operations:
    """The translation of the statements of a POU.

    Attributes:
        added: The names of the variables that are added to the POU, all of them BOOL.
    """

    def __init__(self, scope: Scope, fresh: Callable[[str], str]) -> None:
        self._scope, self._fresh = scope, fresh
        self.added: list[str] = []

    def of(self, statement: s.Statement) -> list[Operation]:
        """Return the operations of a statement, or raise RefusedError."""
        before = list(self.added)
        try:
            return list(self._statement(statement, TRUE, frozenset()))
        except RefusedError:
            self.added = before
            raise

    def _statement(
        self, node: s.Statement, enable: Power, read: frozenset[str]
    ) -> Iterator[Operation]:
        if isinstance(node, s.Assign):
            yield self._assign(node, enable, read)
        elif isinstance(node, s.CallStatement):
            if enable != TRUE:
                text = "a block that is called under a condition cannot be a rung"
                raise RefusedError(text, node.at, moved=False)
            yield from self._call(node)
        elif isinstance(node, s.If):
            yield from self._if(node, enable, read)
        else:
            if isinstance(node, s.Return):
                raise RefusedError("RETURN ends the whole POU", node.at, moved=False)
            word = type(node).__name__.upper()
            raise RefusedError(f"{word} cannot be a rung", node.at)

    # --- assignments ---

    def _assign(self, node: s.Assign, enable: Power, read: frozenset[str]) -> Operation:
        self._check(node)
        target, spec = expression_text(node.target), self._scope.spec_of(node.target)
        name = effects.root(node.target)
        own = effects.read(node.target) - {name} | effects.read(node.value) | read
        reads, writes = frozenset(own), frozenset({name})
        if enable != TRUE and not (
            effects.has_fixed_place(node.target) and effects.always_defined(node.value)
        ):
            text = f"the value or the place of {target} may be undefined without its condition"
            raise RefusedError(text, node.at)
        if self._scope.is_boolean(spec):
            power = power_of(node.value)
            if enable == TRUE:
                return Put(target, power, reads=reads, writes=writes)
            if power in (TRUE, FALSE):
                storage = "set" if power == TRUE else "reset"
                return Put(target, enable, storage, reads=reads, writes=writes)
            held = parallel(series(enable, power), series(negated(enable), Leaf(target)))
            return Put(target, held, reads=reads | writes, writes=writes)
        if enable != TRUE and not self._scope.is_elementary(spec):
            kind = "an enumeration" if self._scope.is_enumeration(spec) else "not elementary"
            text = f"{target} is {kind}, and MOVE with a condition is not for its type"
            raise RefusedError(text, node.at)
        value = expression_text(node.value)
        return Store(target, value, enable, reads=reads, writes=writes)

    def _check(self, node: s.Statement | s.Expression) -> None:
        for call in effects.calls(node):
            name = call.function.key if isinstance(call, s.Call) else ""
            outputs = any(given.output for given in call.arguments)
            if not name or outputs or self._scope.changes_variables(name):
                text = "a function that changes variables cannot be in a rung"
                raise RefusedError(text, call.at)

    # --- calls ---

    def _call(self, node: s.CallStatement) -> Iterator[Operation]:
        spec = self._scope.spec_of(node.callee)
        block = self._scope.block(spec)
        if not isinstance(node.callee, s.Name) or not block:
            text = "only a call of an instance with a name can be a rung"
            raise RefusedError(text, node.at, moved=False)
        instance, own = node.callee.text, node.callee.key
        values: dict[str, s.Argument] = {}
        order = [pin for pin in self._scope.pins(block) if pin.section != "VAR_OUTPUT"]
        sends: list[Send] = []
        reads, writes = {own}, {own}
        for number, given in enumerate(node.arguments):
            self._check(given.value)
            name = order[number].name if given.name is None else given.name.text
            pin = self._scope.pin(block, name)
            if pin is None:
                text = f"{name} is not a pin of {instance} in every tool"
                raise RefusedError(text, given.at, moved=False)
            if given.output:
                sends.append(self._send(pin, own, given.value))
                continue
            values[pin.name.upper()] = given
            reads |= effects.read(given.value)
            if pin.section == "VAR_IN_OUT":
                writes.add(effects.root(given.value))
        pins = tuple(
            Given(pin, self._value(pin, values.get(pin.name.upper())))
            for pin in self._scope.pins(block)
        )
        name = self._scope.block_name(block)
        yield Call(instance, name, pins, reads=frozenset(reads), writes=frozenset(writes))
        yield from sends

    def _value(self, pin: Pin, given: s.Argument | None) -> Power | str | None:
        if given is None:
            return None
        if pin.section == "VAR_INPUT" and self._scope.is_boolean(pin.spec):
            power = power_of(given.value)
            return power if power not in (TRUE, FALSE) else expression_text(given.value)
        return expression_text(given.value)

    def _send(self, pin: Pin, instance: str, target: s.Expression) -> Send:
        name = effects.root(target)
        return Send(
            pin.name,
            expression_text(target),
            self._scope.is_boolean(pin.spec),
            reads=frozenset({instance}) | effects.read(target) - {name},
            writes=frozenset({name}),
        )

    # --- IF ---

    def _if(self, node: s.If, enable: Power, read: frozenset[str]) -> Iterator[Operation]:
        ways: list[tuple[Power, s.Expression | None, Sequence[s.Statement]]] = []
        for number, (condition, body) in enumerate(node.branches):
            self._check(condition)
            if (number or enable != TRUE) and not effects.always_defined(condition):
                text = "a condition may be undefined without the conditions before it"
                raise RefusedError(text, condition.at)
            ways.append((power_of(condition), condition, body))
        if node.otherwise:
            ways.append((TRUE, None, node.otherwise))
        before = list(self.added)
        inline = self._inline(ways, enable, read)
        if len(ways) <= _MOST_INLINE and not _is_disturbed(inline):
            yield from (operation for way in inline for operation in way)
            return
        self.added = before
        yield from self._latched(ways, enable, read)

    def _inline(
        self,
        ways: Iterable[tuple[Power, s.Expression | None, Sequence[s.Statement]]],
        enable: Power,
        read: frozenset[str],
    ) -> list[list[Operation]]:
        """Return the operations of each branch, with the whole condition at each of them."""
        found, others = [], enable
        for power, condition, body in ways:
            read = read | (effects.read(condition) if condition is not None else frozenset())
            way: list[Operation] = []
            for statement in body:
                way += self._statement(statement, series(others, power), read)
            found.append(way)
            others = series(others, negated(power))
        return found

    def _latched(
        self,
        ways: Iterable[tuple[Power, s.Expression | None, Sequence[s.Statement]]],
        enable: Power,
        read: frozenset[str],
    ) -> Iterator[Operation]:
        """Yield the conditions of all branches, then their operations."""
        others, bodies = enable, []
        for power, condition, body in ways:
            name = self._fresh("Branch")
            self.added.append(name)
            read = read | (effects.read(condition) if condition is not None else frozenset())
            yield Put(name, series(others, power), reads=read, writes=frozenset({name.upper()}))
            others = series(others, Leaf(name, negated=True))
            read = read | {name.upper()}
            bodies.append((name, body))
        for name, body in bodies:
            for statement in body:
                yield from self._statement(statement, Leaf(name), frozenset({name.upper()}))


def _is_disturbed(ways: Iterable[Iterable[Operation]]) -> bool:
    """Return whether an operation reads a variable that an operation before it has written.

    This is too strict for the value of an assignment. It is exact for the conditions.
    """
    written: set[str] = set()
    for operation in (operation for way in ways for operation in way):
        if operation.reads & written:
            return True
        written |= operation.writes
    return False
