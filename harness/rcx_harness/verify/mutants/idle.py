"""Statements that do nothing: what is no mistake to leave out."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.verify.mutants.text import children
from rcx_harness.verify.mutants.walk import Body

__all__ = ["changes_nothing"]


def changes_nothing(node: s.Assign, body: Body) -> bool:
    """Whether a variable of a function gets the value that it has at the start of every call.

    It does where the value is that of its declaration, and nothing before it in the function
    writes to the variable. The library has such lines for compilers that ask for them.
    """
    if body.pou.kind != "FUNCTION" or not isinstance(node.target, s.Name):
        return False
    symbol = body.scope.symbol(node.target.key)
    if symbol is None or symbol.section not in ("VAR", "RESULT"):
        return False
    declared = any(
        declaration.initial is not None
        and node.target.key in {one.key for one in declaration.names}
        for section in body.pou.sections
        for declaration in section.variables
    )
    return not declared and not _written_before(body.pou.body, node, node.target.key)


def _written_before(statements: tuple[Any, ...], node: s.Assign, key: str) -> bool:
    """Whether the variable may have been written when the statement is reached."""
    for statement in statements:
        if statement is node:
            return False
        if not any(one is node for one in _inside(statement)):
            if _writes(statement, key):
                return True
        elif isinstance(statement, (s.If, s.Case)):
            inner = next(branch for branch in _branches(statement) if _holds(branch, node))
            return _written_before(inner, node, key)
        else:  # in a loop what comes after it may have been before
            return True
    return True


def _branches(statement: s.If | s.Case) -> Iterator[tuple[Any, ...]]:
    if isinstance(statement, s.If):
        yield from (inner for _, inner in statement.branches)
    else:
        yield from (branch.body for branch in statement.branches)
    yield statement.otherwise


def _holds(branch: tuple[Any, ...], node: s.Assign) -> bool:
    return any(one is node for statement in branch for one in _inside(statement))


def _inside(node: Any) -> Iterator[Any]:
    yield node
    for child in children(node):
        yield from _inside(child)


def _writes(statement: Any, key: str) -> bool:
    return any(
        isinstance(one, s.Assign) and isinstance(one.target, s.Name) and one.target.key == key
        for one in _inside(statement)
    )
