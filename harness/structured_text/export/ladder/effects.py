"""The variables that statements read and write, by the upper-case names of whole variables."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from structured_text.language import syntax as s
from structured_text.language.walk import nodes, parts

__all__ = ["always_defined", "calls", "has_fixed_place", "paths", "read", "root"]

#: Operators that fail for some values.
_PARTIAL = ("/", "MOD", "**")
_PATH = (s.Name, s.Field, s.Index, s.Part, s.Dereference)


def root(variable: Any) -> str:
    """Return the upper-case name of the variable that a path begins with; empty if none."""
    while not isinstance(variable, s.Name):
        variable = getattr(variable, "base", None)
        if variable is None:
            return ""
    return variable.key


def read(node: Any) -> frozenset[str]:
    """Return the names in an expression, without those of functions and fields."""
    return frozenset(found.key for found in nodes(node) if isinstance(found, s.Name))


def calls(node: Any) -> Iterator[s.Call | s.Invoke]:
    """Yield the calls in an expression or in statements."""
    return (found for found in nodes(node) if isinstance(found, (s.Call, s.Invoke)))


def always_defined(node: s.Expression) -> bool:
    """Return whether an expression has a value for all values of its variables.

    Such an expression may be evaluated although its value is not needed. A function may fail for
    some values.
    """
    return has_fixed_place(node) and not any(
        isinstance(found, (s.Call, s.Invoke))
        or (isinstance(found, s.Binary) and found.op in _PARTIAL)
        for found in nodes(node)
    )


def has_fixed_place(node: Any) -> bool:
    """Return whether all indices of arrays are literals."""
    return all(
        isinstance(index, s.Literal)
        for found in nodes(node)
        if isinstance(found, s.Index)
        for index in found.indices
    )


def paths(node: Any) -> Iterator[s.Variable]:
    """Yield each variable with its fields and indices, and those in the indices."""
    if not isinstance(node, _PATH):
        for inner in parts(node):
            yield from paths(inner)
        return
    yield node
    while isinstance(node, _PATH) and not isinstance(node, s.Name):
        if isinstance(node, s.Index):
            yield from paths(node.indices)
        node = node.base
