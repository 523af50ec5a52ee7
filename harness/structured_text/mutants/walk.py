"""The nodes of a POU that operators examine: each statement and expression, with its context."""

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
from structured_text.language.walk import bodies, parts
from structured_text.mutants.text import SourceText

__all__ = ["Body", "Place", "places", "statements"]

#: Fields with a variable that the syntax node writes or calls, or that is the base of a member or
#: element.
_WRITTEN = ("callee", "counter", "base")


@dataclass(frozen=True)
class Place:
    """A node in a POU.

    Attributes:
        node: A statement or an expression.
        written: Whether the node is a variable that the statement assigns, or a block instance that
            the statement calls.
        alone: Whether the node is the only statement of its branch.
        denied: Whether the node is the operand of a NOT.
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
        """Return the type of an expression; None if only the context gives it a type."""
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
    """Yield every statement and expression; outer nodes come before the nodes inside them."""
    yield from _inside(body.pou)


def statements(body: Body) -> Iterator[Any]:
    """Yield every statement; outer statements come before the statements inside them."""
    kinds = get_args(s.Statement)
    yield from (place.node for place in places(body) if isinstance(place.node, kinds))


def _inside(node: Any) -> Iterator[Place]:
    alone = [body[0] for body in bodies(node) if len(body) == 1]
    denied = isinstance(node, s.Unary) and node.op == "NOT"
    for one, written in _parts(node):
        yield Place(one, written, any(one is single for single in alone), denied)
        yield from _inside(one)


def _parts(node: Any) -> Iterator[tuple[Any, bool]]:
    """Yield the statements and expressions directly in a node, and whether each is written."""
    if isinstance(node, (s.Pou, s.Method, s.CaseBranch)):
        yield from ((one, False) for one in node.body)
    elif isinstance(node, (s.Assign, s.AssignChain, s.Latch)):
        bound = isinstance(node, s.Latch) and node.op == "REF"
        yield from ((one, bound or one is not node.value) for one in parts(node))
    elif isinstance(node, (s.Call, s.Invoke)):
        yield from ((argument.value, False) for argument in node.arguments)
    else:
        first = next((getattr(node, name) for name in _WRITTEN if hasattr(node, name)), None)
        for one in parts(node):
            if isinstance(one, s.CaseBranch):
                yield from _parts(one)
            elif isinstance(one, s.Argument):
                yield one.value, one.output
            else:
                yield one, one is first
