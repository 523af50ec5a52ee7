"""Hover: the declaration of the name under the cursor, its comment and the pins of its block."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.context import context
from structured_text.editor.index import Index
from structured_text.editor.lookup import Word, callee_of, type_of, word_at
from structured_text.editor.names import Definition, spec_name
from structured_text.editor.positions import from_editor, span
from structured_text.editor.texts import Text, document
from structured_text.editor.writing import (
    PIN_SECTIONS,
    comment,
    declaration,
    head,
    pins_of,
    signature_text,
    standard_pins,
)
from structured_text.language.calls import pin_of
from structured_text.language.standard import BLOCKS, FUNCTIONS
from structured_text.language.types import BlockType
from structured_text.language.values import describe

__all__ = ["Extra", "hover"]

#: A function that returns further Markdown for a name, or an empty text.
Extra = Callable[[Definition], str]
_CALLED = ("function", "function_block", "program", "method")


def hover(
    index: Index,
    path: Path | str,
    text: str,
    position: lsp.Position,
    extra: Extra | None = None,
) -> lsp.Hover | None:
    """Return what is known about the name at a position; None without a known name.

    `extra` adds text for a declared name.
    """
    whole = document(text, str(path))
    offset = whole.offset(from_editor(whole.lines, position))
    word = word_at(index, path, whole, offset)
    if word is None:
        return None
    if word.definition is None:
        parts = _standard(word.name.upper()) or _standard_pin(index, whole, word)
    else:
        parts = _declared(index, word.definition)
        parts += [extra(word.definition)] if extra is not None else []
    shown = "\n\n".join(filter(None, parts))
    if not shown:
        return None
    content = lsp.MarkupContent(lsp.MarkupKind.Markdown, shown)
    return lsp.Hover(content, span(whole.lines, whole.at(word.begin), whole.at(word.end)))


def _declared(index: Index, definition: Definition) -> list[str]:
    lines = [head(index, definition)]
    if definition.section is not None:
        kept = definition.section.qualifier
        lines.insert(0, f"{definition.section.kind} {kept}".strip())
    name = definition.key if definition.kind in _CALLED else ""
    if definition.kind == "variable":
        name = spec_name(definition.node.spec)
    if definition.kind == "structure":
        lines += [f"  {declaration(index, one)};" for one in index.names.inside(definition.key)]
    pins = _pins(index, name) if name else []
    return [_code([*lines, *pins]), comment(index, definition)]


def _pins(index: Index, key: str) -> list[str]:
    """Return the pins of a block, function or method; empty for another name."""
    found = index.names.get(key)
    if found is None and key in BLOCKS:
        return [f"  {one};" for one in standard_pins(BLOCKS[key])]
    if found is None or found.kind not in _CALLED:
        return []
    lines = []
    for section in PIN_SECTIONS:
        pins = [f"  {declaration(index, one)};" for one in pins_of(index, key, (section,))]
        lines += [section, *pins] if pins else []
    return lines


def _standard(name: str) -> list[str]:
    """Return the pins of a block or function of the standard."""
    if name in BLOCKS:
        return [_code([f"FUNCTION_BLOCK {name}", *_pins_of_standard(name)])]
    return [_code([signature_text(name)])] if name in FUNCTIONS else []


def _standard_pin(index: Index, text: Text, word: Word) -> list[str]:
    """Return the pin of a block of the standard that a name in a call or behind a dot is."""
    here = context(text, word.begin)
    kind = None
    if here.base:
        kind = type_of(index, here.owner, here.base)
    elif here.call is not None and text.plain[word.end :].lstrip()[:2] in (":=", "=>"):
        callee = callee_of(index, here.owner, here.call.callee)
        kind = callee.block if callee is not None else None
    pin = pin_of(kind, word.name) if isinstance(kind, BlockType) else None
    return [] if pin is None else [_code([pin.section, f"{pin.name} : {describe(pin.type)}"])]


def _pins_of_standard(name: str) -> list[str]:
    return [f"  {one};" for one in standard_pins(BLOCKS[name])]


def _code(lines: list[str]) -> str:
    return "\n".join(("```iecst", *lines, "```"))
