"""The meaning of the name at the cursor, from the index or, in a newer text, from the text."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from structured_text.editor.context import context, expression_of, first_of_path
from structured_text.editor.index import Index, Occurrence
from structured_text.editor.names import Definition
from structured_text.editor.structure import tokens_of
from structured_text.editor.texts import Text, same_name
from structured_text.language import syntax as s
from structured_text.language.standard import BLOCKS, FUNCTIONS
from structured_text.language.types import BlockType, Type

__all__ = ["Callee", "Word", "callee_of", "type_of", "word_at"]


@dataclass(frozen=True)
class Word:
    """A name in a text and what it means.

    Attributes:
        name: The name as written.
        begin: Its first offset.
        end: The offset behind it.
        definition: The declared name; None for an unknown name and for names of the standard.
        occurrence: The entry of the index, if the text agrees with the index here.
    """

    name: str
    begin: int
    end: int
    definition: Definition | None
    occurrence: Occurrence | None = None


@dataclass(frozen=True)
class Callee:
    """What a call executes.

    Attributes:
        key: The key of the block, function or method.
        block: The type of the instance; None for functions and methods.
        definition: The declaration; None for a block or function of the standard.
    """

    key: str
    block: BlockType | None
    definition: Definition | None


def word_at(index: Index, path: Path | str, text: Text, offset: int) -> Word | None:
    """Return the name at an offset and its meaning; None if there is no name."""
    span = text.word(offset)
    if span is None:
        return None
    begin, end = span
    name = text.plain[begin:end]
    known = index.at(path, text.at(begin), text)
    if known is not None:
        return Word(name, begin, end, known.definition, known)
    return Word(name, begin, end, _meaning(index, text, begin, end))


def _meaning(index: Index, text: Text, begin: int, end: int) -> Definition | None:
    """Return the meaning of a name that is not in the index at this place."""
    name = text.plain[begin:end]
    here = context(text, begin)
    ahead = tokens_of(text, end, text.offset(text.at(end)._replace(column=1 << 20)))
    if here.call is not None and ahead and ahead[0].text in (":=", "=>") and not here.base:
        callee = callee_of(index, here.owner, here.call.callee)
        return index.names.member(callee.key, name.upper()) if callee is not None else None
    if here.prefix:
        return index.names.get(f"{here.prefix.upper()}.{name.upper()}")
    before = tokens_of(text, 0, end)
    first = first_of_path(before, len(before) - 1)
    written = text.plain[before[first].begin : end] if first < len(before) else name
    found: list[tuple[Definition, s.Name, str]] = []
    node = expression_of(written)
    if node is None:
        return index.names.get(name.upper())
    index.resolver(index.scope(here.owner), found).expression(node)
    for definition, used, _ in reversed(found):
        if same_name(used.text, name):
            return definition
    return index.names.get(name.upper()) if not here.base else None


def type_of(index: Index, owner: str, written: str) -> Type | None:
    """Return the type of an expression in a POU; None if it has none."""
    node = expression_of(written)
    return None if node is None else index.resolver(index.scope(owner), []).kind(node)


def callee_of(index: Index, owner: str, written: str) -> Callee | None:
    """Return what a call in a POU executes; None if that is unknown."""
    node: Any = expression_of(written)
    if node is None:
        return None
    resolver = index.resolver(index.scope(owner), [])
    found = resolver.called(node)
    if found is not None:
        return Callee(found.key, None, found)
    kind = resolver.kind(node)
    if isinstance(kind, BlockType):
        key = kind.name.upper()
        standard = BLOCKS.get(key) is kind
        return Callee(key, kind, None if standard else index.names.get(key))
    if isinstance(node, s.Name) and node.key in FUNCTIONS:
        return Callee(node.key, None, None)
    return None
