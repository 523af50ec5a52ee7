"""Traversal of a program, as it is written (`syntax`) or checked (`tree`).

The nodes of both trees are frozen data classes, with tuples for sequences. Their fields are in the
order of the text.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import fields, is_dataclass
from functools import cache
from typing import Any, TypeVar

from structured_text.language import syntax as s
from structured_text.language import tree as t

__all__ = [
    "bodies",
    "calls_of",
    "declared",
    "nodes",
    "parts",
    "root_of",
    "statements",
    "targets",
    "written",
]

#: Types of those fields of syntax nodes that contain no code.
_PLAIN = (
    *(
        "str",
        "bool",
        "int",
        "Position",
        "Path",
        "Scalar",
        "tuple[str, ...]",
        "tuple[Any, ...]",
        "Any",
    ),
    *("tuple[InputError, ...]", "Type", "ReferenceType", "BlockType", "Symbol", "Pou"),
)
#: Types of fields with names of declarations, callees or members. A node of such a type can also be
#: a `Variable`.
_NAMES = ("Name", "Name | None", "tuple[Name, ...]", "tuple[Namespace, ...]")
#: Type variable for a statement of the parsed or of the checked tree.
_One = TypeVar("_One", s.Statement, t.Statement)


def parts(node: Any) -> Iterator[Any]:
    """Yield the nodes directly inside a node, except names that are not variables."""
    kind: Any = type(node)
    for one in node if kind is tuple else [getattr(node, name) for name in _fields(kind) or ()]:
        kind = type(one)
        if kind is tuple:
            yield from parts(one)
        elif _fields(kind) is not None:
            yield one


def nodes(root: Any, without: Container[type[Any]] = (), *, names: bool = False) -> Iterator[Any]:
    """Yield a node, or the nodes of a tuple, and all nodes inside, parents first.

    Kinds in `without` are left out, with all nodes inside them. With `names`, also yield names that
    are not variables.
    """
    waiting = [root]
    while waiting:
        one = waiting.pop()
        kind: Any = type(one)
        if kind is tuple:
            waiting += one[::-1]
        elif (inner := _fields(kind, names)) is not None and (kind not in without or one is root):
            yield one
            waiting += [getattr(one, name) for name in reversed(inner)]


@cache
def _fields(kind: type[Any], names: bool = False) -> tuple[str, ...] | None:
    """Return the fields of a kind of node that contain code; None for other classes."""
    if not is_dataclass(kind):
        return None
    plain = _PLAIN if names else (*_PLAIN, *_NAMES)
    return tuple(one.name for one in fields(kind) if one.type not in plain)


def declared(sections: Iterable[s.Section]) -> Iterator[tuple[s.Section, s.VarDecl, s.Name]]:
    """Yield each variable of some sections, with its section and its declaration."""
    for section in sections:
        for one in section.variables:
            for name in one.names:
                yield section, one, name


def bodies(one: _One) -> list[tuple[_One, ...]]:
    """Return the bodies of a statement; for IF and CASE every branch, including empty ones."""
    branches: Any = getattr(one, "branches", None)
    if branches is not None:
        inner: list[Any] = [
            way.body if isinstance(way, s.CaseBranch) else way[1] for way in branches
        ]
        return [*inner, getattr(one, "otherwise", ())]
    if isinstance(one, (s.Try, t.Try)):
        return [one.body, one.handler, one.last]
    return [one.body] if hasattr(one, "body") else []


def statements(body: Iterable[_One]) -> Iterator[_One]:
    """Yield the statements of a body and all nested ones, in the order of the text."""
    for one in body:
        yield one
        for body_of_one in bodies(one):
            yield from statements(body_of_one)


def calls_of(body: Iterable[t.Statement]) -> Iterator[t.CallBlock]:
    """Yield the calls of blocks in a body."""
    return (one for one in statements(body) if isinstance(one, t.CallBlock))


def targets(one: t.Statement) -> Iterator[t.Variable]:
    """Yield the variables that a statement itself may write."""
    if isinstance(one, t.Assign):
        yield one.target
    elif isinstance(one, t.For):
        yield one.counter
    elif isinstance(one, t.Try):
        if one.code is not None:
            yield one.code
    elif isinstance(one, t.CallBlock):
        for _, variable in (*one.in_outs, *one.outputs):
            yield variable


def root_of(variable: t.Expression) -> t.Symbol | None:
    """Return the declared variable that an access begins with; None behind a pointer or call."""
    while isinstance(variable, (t.Member, t.Index)):
        variable = variable.base
    return variable.symbol if isinstance(variable, t.Use) else None


def written(pou: t.Pou) -> set[str]:
    """Return names and addresses, in upper case, of the variables that a body may write."""
    found = set()
    inside = [one.target for one in nodes(pou.body) if isinstance(one, t.Assigned)]
    for variables in (inside, *map(targets, statements(pou.body))):
        for variable in variables:
            symbol = root_of(variable)
            if symbol is not None:
                found.add(symbol.name.upper())
                if symbol.address is not None:
                    found.add(symbol.address.upper())
    return found
