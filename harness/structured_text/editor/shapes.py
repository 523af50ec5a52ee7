"""The interface of a source: all that other sources, and the bodies in it, can see of it.

Two sources with the same interface differ only in their bodies and in positions. The language
server compares interfaces to find out what must be checked again after a change.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import cache
from typing import Any

from structured_text.language import syntax as s
from structured_text.language.registry import last_name
from structured_text.language.walk import nodes

__all__ = ["Shape", "Unit", "shape_of", "words_of"]

_WORD = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True)
class Unit:
    """The interface of a declaration.

    Attributes:
        shape: The syntax of the interface, without positions.
        names: The names that it declares for other sources, in upper case.
        words: All names in it, in upper case.
        calls: The functions that its body calls, in upper case. They decide the order in which
            declarations are resolved.
    """

    shape: Any
    names: frozenset[str]
    words: frozenset[str]
    calls: tuple[str, ...]


@dataclass(frozen=True)
class Shape:
    """The interface of a source.

    Attributes:
        units: The declarations, in order.
        rest: Namespaces and entries of VAR_CONFIG, without positions.
        positions: All positions in the interface.
    """

    units: tuple[Unit, ...]
    rest: Any
    positions: tuple[s.Position, ...]


def shape_of(source: s.Source) -> Shape:
    """Return the interface of a source."""
    every: list[s.Position] = []
    units = tuple(_unit(node, every) for node in source.declarations)
    words: set[str] = set()
    rest = _shape((source.namespaces, source.entries), every, words)
    return Shape(units, rest, tuple(every))


def words_of(source: s.Source) -> frozenset[str]:
    """Return all names in the declarations and bodies of a source, in upper case."""
    words: set[str] = set()
    _shape(source.declarations, [], words, with_bodies=True)
    return frozenset(words)


def _unit(node: s.Declaration, positions: list[s.Position]) -> Unit:
    words: set[str] = set()
    shape = _shape(node, positions, words)
    calls: tuple[str, ...] = ()
    if isinstance(node, s.Pou):
        called = (last_name(one.function) for one in nodes(node.body) if isinstance(one, s.Call))
        calls = tuple(dict.fromkeys(called))
    return Unit(shape, frozenset(_declared(node)), frozenset(words), calls)


def _declared(node: s.Declaration) -> Iterator[str]:
    """Yield the names by which other sources can reach a declaration or a part of it."""
    yield node.name.key
    sections: tuple[s.Section, ...] = ()
    if isinstance(node, s.TypeDecl):
        if isinstance(node.spec, s.EnumSpec):
            yield from (name.key for name in node.spec.members)
    elif isinstance(node, s.GlobalList):
        sections = (node.section,)
    elif isinstance(node, s.Configuration):
        sections = node.globals
    for section in sections:
        for variable in section.variables:
            yield from (name.key for name in variable.names)


def _shape(
    node: Any, positions: list[s.Position], words: set[str], *, with_bodies: bool = False
) -> Any:
    """Return a node as nested tuples, without positions and, if not wanted, without bodies."""
    kind: Any = type(node)
    if kind is s.Position:
        positions.append(node)
        return None
    if kind is tuple:
        return tuple([_shape(one, positions, words, with_bodies=with_bodies) for one in node])
    if kind is s.Name or kind is s.Literal:
        words.update(_WORD.findall(node.text.upper()))
        positions.append(node.at)
        return node.text if kind is s.Name else (node.kind, node.text)
    if (names := _fields(kind)) is None:
        return node
    found: list[Any] = [kind]
    for name in names:
        value = getattr(node, name)
        if name == "body" and not with_bodies and kind in (s.Pou, s.Method):
            found.append(bool(value))  # an ABSTRACT method may not have statements
        else:
            found.append(_shape(value, positions, words, with_bodies=with_bodies))
    return tuple(found)


@cache
def _fields(kind: type[Any]) -> tuple[str, ...] | None:
    return tuple(one.name for one in fields(kind)) if is_dataclass(kind) else None
