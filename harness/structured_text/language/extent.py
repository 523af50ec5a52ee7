"""The sizes of variables, known before any variable is created.

A kilobyte of declarations can describe more variables than any computer can store. Each type is
therefore measured once, from the sizes of its parts, and refused if it is too large.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from structured_text.language.registry import ConsequenceError, Declared
from structured_text.language.scalars import ANY_STRING, string_length
from structured_text.language.syntax import Position
from structured_text.language.tree import Symbol
from structured_text.language.types import ArrayType, BlockType, ElementaryType, StructType, Type
from structured_text.language.values import array_length
from structured_text.output.limits import MOST_BLOCKS, MOST_ELEMENTS, MOST_NESTED

__all__ = ["Extents"]

#: Characters of a STRING that count as one element of the program's size.
_CHARACTERS = 8
_SHOWN = 60
_HINT = "make arrays smaller, or declare fewer of them"
#: Sections whose variables have no storage in the POU that declares them.
_ELSEWHERE = ("VAR_IN_OUT", "VAR_EXTERNAL")


class _Extent(NamedTuple):
    """The size of a variable of a type.

    Attributes:
        elements: Number of plain variables, plus one for each array, structure and block, and one
            for every eight characters of a STRING.
        blocks: Instances of function blocks.
        levels: Nesting depth of arrays, structures and blocks.
    """

    elements: int
    blocks: int = 0
    levels: int = 0


class Extents:
    """The sizes of all types of a project; `resolve.Types` uses it to refuse large types."""

    def __init__(self) -> None:
        # The keys are the identities of types, because comparing large types takes long.
        self._known: dict[int, tuple[Type, _Extent]] = {}
        self._refused: dict[int, BlockType] = {}
        self._made = 0

    def check(self, kind: Type, name: str, where: Declared, at: Position) -> None:
        """Raise InputError if a single variable of a type exceeds the limit of a program.

        The types inside this type have been checked before.
        """
        parts = kind.variables if isinstance(kind, BlockType) else ()
        if any(id(part.type) in self._refused for part in parts):
            raise ConsequenceError(f"a part of {name} is too large")
        _check(self._of(kind), name, where, at)

    def refuse(self, block: BlockType) -> None:
        """Register a block that is too large; an empty block takes its place.

        Types that contain the block are refused as well.
        """
        self._refused[id(block)] = block

    def check_all(self, blocks: Iterable[Type], symbols: Iterable[Symbol], where: Declared) -> None:
        """Raise InputError if a program has too many variables in all."""
        stored = (one.type for one in symbols if one.section not in _ELSEWHERE)
        _check(self._whole([*blocks, *stored]), "the program", where, where.node.at)

    def make(self, length: int, where: Declared, at: Position) -> None:
        """Count a list of initial values; raise InputError if the lists together are too large."""
        if self._made > MOST_ELEMENTS:
            raise ConsequenceError("the arrays before this one are too many")
        self._made += length
        if self._made > MOST_ELEMENTS:
            text = f"the arrays up to here have more than {MOST_ELEMENTS:,} elements"
            raise where.error(text, at, _HINT)

    def _of(self, kind: Type) -> _Extent:
        known = self._known.get(id(kind))
        if known is None:
            known = self._known[id(kind)] = kind, self._measured(kind)
        return known[1]

    def _measured(self, kind: Type) -> _Extent:
        if isinstance(kind, ElementaryType):
            more = string_length(kind) // _CHARACTERS if kind.name in ANY_STRING else 0
            return _Extent(1 + more)
        if isinstance(kind, ArrayType):
            element, length = self._of(kind.element), array_length(kind)
            return _Extent(1 + element.elements * length, element.blocks * length, _up(element))
        if isinstance(kind, StructType):
            return self._whole(field for _, field in kind.fields)
        if isinstance(kind, BlockType):
            found = self._whole(one.type for one in kind.variables if one.section not in _ELSEWHERE)
            return found._replace(blocks=found.blocks + 1)
        return _Extent(1)

    def _whole(self, parts: Iterable[Type]) -> _Extent:
        found = _Extent(1)
        for part in parts:
            found = _sum(found, self._of(part))
        return found._replace(levels=_up(found))


def _up(inner: _Extent) -> int:
    return inner.levels + 1


def _sum(one: _Extent, other: _Extent) -> _Extent:
    return _Extent(
        one.elements + other.elements, one.blocks + other.blocks, max(one.levels, other.levels)
    )


def _check(found: _Extent, name: str, where: Declared, at: Position) -> None:
    name = f"{name:.{_SHOWN}}"
    if found.levels > MOST_NESTED:
        text = f"{name} has more than {MOST_NESTED} nested arrays, structures and blocks"
        raise where.error(text, at, "use fewer levels")
    for number, most, what in (
        (found.elements, MOST_ELEMENTS, "elements"),
        (found.blocks, MOST_BLOCKS, "instances of function blocks"),
    ):
        if number > most:
            text = f"{name} has {number:,} {what}, and a program has at most {most:,}"
            raise where.error(text, at, _HINT)
