"""The places of a POU that operators examine: each statement and expression, with its context."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, get_args

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Scope
from structured_text.language.expression_checker import ExpressionChecker
from structured_text.language.types import Type
from structured_text.mutants.text import SourceText

__all__ = ["Body", "Place", "places", "statements"]


@dataclass(frozen=True)
class Place:
    """A node in a POU.

    Attributes:
        node: A statement, an argument or an expression.
        written: It is a variable that the statement assigns, or a block that it calls.
        alone: It is the only statement of its branch.
        denied: It is the operand of a NOT.
    """

    node: Any
    written: bool = False
    alone: bool = False
    denied: bool = False


class Body:
    """The POU that is mutated: its syntax, its text, and the meaning of its names."""

    def __init__(self, pou: s.Pou | s.Method, source: SourceText, scope: Scope) -> None:
        self.pou = pou
        self.source = source
        self.scope = scope
        self._expressions = ExpressionChecker(scope)

    def type_of(self, node: Any) -> Type | None:
        """Return the type of an expression; None if it has no type by itself."""
        try:
            return self._expressions.infer(node)
        except InputError:
            return None

    def type_name(self, node: Any) -> str:
        """Return the name of the type of an expression, or ""."""
        return getattr(self.type_of(node), "name", "")

    def symbols(self) -> list[t.Symbol]:
        """Return the variables of the POU in order of declaration."""
        return list(self.scope.pou.symbols.values())


def places(body: Body) -> Iterator[Place]:
    """Yield every statement and expression, each before those inside it."""
    yield from _statements(body.pou.body)


def statements(body: Body) -> Iterator[Any]:
    """Yield every statement, each before those inside it."""
    kinds = get_args(s.Statement)
    yield from (place.node for place in places(body) if isinstance(place.node, kinds))


def _statements(statements: tuple[s.Statement, ...]) -> Iterator[Place]:
    for node in statements:
        yield Place(node, alone=len(statements) == 1)
        if isinstance(node, s.Assign):
            yield from _expression(node.target, written=True)
            yield from _expression(node.value)
        elif isinstance(node, s.AssignChain):
            for target in node.targets:
                yield from _expression(target, written=True)
            yield from _expression(node.value)
        elif isinstance(node, s.Latch):
            yield from _expression(node.target, written=True)
            yield from _expression(node.value, written=node.op == "REF")
        elif isinstance(node, s.CallStatement):
            yield from _expression(node.callee, written=True)
            for argument in node.arguments:
                yield Place(argument)
                yield from _expression(argument.value, written=argument.output)
        elif isinstance(node, s.If):
            for condition, inner in node.branches:
                yield from _expression(condition)
                yield from _statements(inner)
            yield from _statements(node.otherwise)
        elif isinstance(node, s.Case):
            yield from _expression(node.selector)
            for branch in node.branches:
                yield from _statements(branch.body)
            yield from _statements(node.otherwise)
        elif isinstance(node, s.While):
            yield from _expression(node.condition)
            yield from _statements(node.body)
        elif isinstance(node, s.Repeat):
            yield from _statements(node.body)
            yield from _expression(node.condition)
        elif isinstance(node, s.For):
            yield from _expression(node.counter, written=True)
            for part in (node.start, node.end, node.step):
                if part is not None:
                    yield from _expression(part)
            yield from _statements(node.body)


def _expression(node: Any, *, written: bool = False, denied: bool = False) -> Iterator[Place]:
    yield Place(node, written=written, denied=denied)
    if isinstance(node, s.Field):
        yield from _expression(node.base, written=True)
    elif isinstance(node, s.Index):
        yield from _expression(node.base, written=True)
        for index in node.indices:
            yield from _expression(index)
    elif isinstance(node, (s.Part, s.Dereference)):
        yield from _expression(node.base, written=True)
    elif isinstance(node, (s.Call, s.Invoke)):
        for argument in node.arguments:
            yield from _expression(argument.value)
    elif isinstance(node, s.Unary):
        yield from _expression(node.operand, denied=node.op == "NOT")
    elif isinstance(node, s.Binary):
        yield from _expression(node.left)
        yield from _expression(node.right)
