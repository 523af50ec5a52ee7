"""Statements that cannot be rungs, as a function block in Structured Text that a rung calls.

The block gets the variables that the statements use. A variable that they change is VAR_IN_OUT and
keeps its name. A value that they only read is VAR_INPUT; `Servo.Done` becomes the pin `Servo_Done`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from structured_text.export.ladder import effects
from structured_text.export.ladder.operations import Call, Given, RefusedError
from structured_text.export.ladder.pieces import Piece
from structured_text.export.ladder.types import Pin, Scope
from structured_text.language import syntax as s
from structured_text.language.printer import expression_text, spec_text
from structured_text.language.walk import nodes, statements

__all__ = ["OwnBlock", "own_block"]


@dataclass(frozen=True)
class OwnBlock:
    """A block for some statements.

    Attributes:
        name: The name of the block.
        head: The text of its declaration, from FUNCTION_BLOCK to the last END_VAR.
        body: The text of its statements.
        call: The call of its instance.
    """

    name: str
    head: str
    body: str
    call: Call


@dataclass(frozen=True)
class _Use:
    """A variable in the statements, and the pin that replaces it."""

    path: s.Variable
    pin: str


def own_block(
    pieces: Sequence[Piece], scope: Scope, block: str, instance: str, fresh: Callable[[str], str]
) -> OwnBlock:
    """Return the block for statements that follow each other, or raise RefusedError."""
    found = _Collected(scope, fresh)
    for piece in pieces:
        found.add(piece.node)
    pins = found.pins()
    head = "\n".join([f"FUNCTION_BLOCK {block}", *_sections(pins)])
    first, last = pieces[0], pieces[-1]
    body = _replaced(first.source, first.begin, last.end, found.uses)
    given = tuple(Given(pin, path) for pin, path in pins)
    changed = {pin.name.upper() for pin, _ in pins if pin.section == "VAR_IN_OUT"}
    call = Call(
        instance,
        block,
        given,
        reads=frozenset(found.read),
        writes=frozenset({instance.upper(), *changed}),
    )
    return OwnBlock(block, head, body, call)


class _Collected:
    """The variables of statements."""

    def __init__(self, scope: Scope, fresh: Callable[[str], str]) -> None:
        self._scope, self._fresh = scope, fresh
        self.read: set[str] = set()
        self._changed: dict[str, str] = {}
        self._found: list[s.Variable] = []
        self.uses: list[_Use] = []

    def add(self, node: s.Statement) -> None:
        for inner in statements((node,)):
            self._statement(inner)
        for path in effects.paths(node):
            if effects.root(path) in self._scope.variables:
                self._found.append(path)
                self.read.add(effects.root(path))

    def _statement(self, node: s.Statement) -> None:
        if isinstance(node, s.Return):
            raise RefusedError("RETURN ends the whole POU", node.at, moved=False)
        if isinstance(node, s.CallStatement):
            text = "a block that is called under a condition cannot be a rung"
            raise RefusedError(text, node.at, moved=False)
        if isinstance(node, s.Case):
            labels = [label for branch in node.branches for label in branch.labels]
            names = (path for label in labels for path in effects.paths(label))
            if any(effects.root(name) in self._scope.variables for name in names):
                text = "a CASE with a constant of the POU cannot be moved"
                raise RefusedError(text, node.at, moved=False)
        for call in nodes(node):
            if isinstance(call, s.Call) and self._scope.changes_variables(call.function.key):
                text = "a function that changes variables cannot be moved"
                raise RefusedError(text, call.at, moved=False)
        for target in _targets(node):
            name = effects.root(target)
            if self._scope.block(self._scope.variables.get(name)) or name in self._scope.bound:
                text = f"{expression_text(target)} cannot be passed to a block in every tool"
                raise RefusedError(text, node.at, moved=False)
            self._changed.setdefault(name, _root_name(target).text)

    def pins(self) -> list[tuple[Pin, str]]:
        """Return the pins with the variables at them: VAR_IN_OUT, then VAR_INPUT."""
        pins: list[tuple[Pin, str]] = []
        for key, name in self._changed.items():
            pins.append((self._pin(name, "VAR_IN_OUT", self._scope.variables[key]), name))
        names: dict[str, str] = {}
        for path in self._found:
            if effects.root(path) in self._changed:
                continue
            part = _fixed_part(path)
            text = expression_text(part)
            if text.upper() not in names:
                is_name = isinstance(part, s.Name)
                name = text if is_name else self._fresh(text.replace(".", "_"))
                names[text.upper()] = name
                pins.append((self._pin(name, "VAR_INPUT", self._scope.spec_of(part)), text))
            if not isinstance(part, s.Name):
                self.uses.append(_Use(part, names[text.upper()]))
        return pins

    def _pin(self, name: str, section: str, spec: s.TypeSpec | None) -> Pin:
        if not isinstance(spec, s.NamedSpec) or spec.length or self._scope.block(spec):
            text = f"{name} has a type without a name and cannot be passed to a block"
            raise RefusedError(text, self._found[0].at, moved=False)
        return Pin(name, section, spec)


def _targets(node: s.Statement) -> Iterator[s.Variable]:
    if isinstance(node, s.Assign):
        yield node.target
    elif isinstance(node, s.For):
        yield node.counter
    for call in nodes(node):
        if isinstance(call, s.Call):
            for given in call.arguments:
                if given.output and isinstance(given.value, (s.Name, s.Field, s.Index)):
                    yield given.value


def _root_name(path: s.Variable) -> s.Name:
    found = path
    while not isinstance(found, s.Name):
        found = found.base  # type: ignore[union-attr]
    return found


def _fixed_part(path: s.Variable) -> s.Variable:
    """Return the part of a path before its first index."""
    steps: list[s.Variable] = [path]
    while not isinstance(steps[-1], s.Name):
        steps.append(steps[-1].base)  # type: ignore[union-attr]
    part = steps.pop()
    while steps and isinstance(steps[-1], s.Field):
        part = steps.pop()
    return part


def _sections(pins: Sequence[tuple[Pin, str]]) -> Iterator[str]:
    for section in ("VAR_IN_OUT", "VAR_INPUT"):
        own = [pin for pin, _ in pins if pin.section == section]
        if own:
            yield f"  {section}"
            yield from (f"    {pin.name} : {spec_text(pin.spec)};" for pin in own)
            yield "  END_VAR"


def _replaced(source: str, begin: int, end: int, uses: Sequence[_Use]) -> str:
    """Return a part of the source with the names of pins in place of the variables."""
    lines = source.splitlines(keepends=True)
    starts = [0]
    for line in lines:
        starts.append(starts[-1] + len(line))
    places = {}
    for use in uses:
        at = _root_name(use.path).at
        start = starts[at.line - 1] + at.column - 1
        places[start] = (len(expression_text(use.path)), use.pin)
    text, done = [], begin
    for start, (length, pin) in sorted(places.items()):
        text += [source[done:start], pin]
        done = start + length
    return "".join([*text, source[done:end]]).strip("\n")
