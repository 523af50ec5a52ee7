"""Places and expressions of the checked tree, for the detectors of faults."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.parser import parse
from structured_text.language.syntax import Position
from structured_text.language.types import Type
from structured_text.language.walk import nodes, statements

__all__ = ["Hit", "Sources", "expressions", "own_expressions"]


@dataclass(frozen=True)
class Sources:
    """The part of a project that is searched for faults: files, their POUs, types and blocks.

    `counters` is the rule of the program's dialect for CTU, CTD and CTUD (`dialects.toml`).
    """

    files: Sequence[Path]
    pous: Sequence[t.Pou]
    types: Mapping[str, Type]
    blocks: Collection[str]
    counters: str


class Hit(NamedTuple):
    """A place that a fault concerns: file, position, and a detail of the construct."""

    file: str
    at: Position
    detail: str


def expressions(pou: t.Pou) -> Iterator[tuple[Position, Any]]:
    """Yield each expression of a body with its position.

    An expression comes before the expressions inside it.
    """
    for one in statements(pou.body):
        for number, root in enumerate(own_expressions(one)):
            place: Position | None = None
            for node in nodes(root):
                if place is None:
                    place = _place(pou, one, number)
                yield place, node


def own_expressions(one: t.Statement) -> list[Any]:
    """Return the expressions of a statement, without expressions of the statements inside it."""
    if isinstance(one, t.If):
        return [condition for condition, _ in one.branches]
    if isinstance(one, t.Case):
        return [one.selector]
    if isinstance(one, t.For):
        return [one.start, one.end, one.step]
    if isinstance(one, (t.While, t.Repeat)):
        return [one.condition]
    return [one]


def _place(pou: t.Pou, one: t.Statement, number: int) -> Position:
    """Return the position of the statement, ELSIF or UNTIL that contains an expression."""
    if (isinstance(one, t.If) and number) or isinstance(one, t.Repeat):
        try:
            declarations = parse(Path(pou.file)).declarations
        except InputError:
            return one.at  # the text was extracted from a project or translated from a chart
        for node in nodes(declarations):
            if isinstance(one, t.Repeat):
                if isinstance(node, s.Repeat) and node.at == one.at:
                    return _at(node.condition, one.at)
            elif isinstance(node, s.If) and node.at == one.at and number < len(node.branches):
                return _at(node.branches[number][0], one.at)
    return one.at


def _at(expression: Any, otherwise: Position) -> Position:
    found: Position = getattr(expression, "at", otherwise)
    return found
