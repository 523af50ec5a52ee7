"""The text that features show for a declared name: its declaration, its pins, its comment."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import Any

from structured_text.editor.comments import comment_of
from structured_text.editor.index import Index
from structured_text.editor.names import Definition
from structured_text.editor.texts import Text, same_name
from structured_text.language import syntax as s
from structured_text.language.parser import ACTION
from structured_text.language.printer import expression_text, spec_text
from structured_text.language.standard import FUNCTIONS, Signature
from structured_text.language.types import BlockType, EnumType
from structured_text.language.values import describe

__all__ = [
    "PIN_SECTIONS",
    "comment",
    "declaration",
    "head",
    "pins_of",
    "signature_text",
    "spec_shown",
    "standard_pins",
]

#: The sections with the pins of a block or function, in the order in which a call shows them.
PIN_SECTIONS = ("VAR_IN_OUT", "VAR_INPUT", "VAR_OUTPUT")
_SPACE = re.compile(r"\s+")


def spec_shown(spec: Any) -> str:
    """Return a type as written, on one line."""
    if isinstance(spec, s.NamedSpec):
        length = "" if spec.length is None else f"[{expression_text(spec.length)}]"
        return f"{spec.name.text}{length}"
    if isinstance(spec, s.SubrangeSpec):
        low, high = expression_text(spec.low), expression_text(spec.high)
        return f"{spec.base.name.text} ({low}..{high})"
    if isinstance(spec, s.ArraySpec):
        bounds = ", ".join(map(_bounds, spec.dimensions))
        return f"ARRAY [{bounds}] OF {spec_shown(spec.element)}"
    if isinstance(spec, s.PointerSpec):
        word = spec.kind if spec.kind == "REF_TO" else f"{spec.kind} TO"
        return f"{word} {spec_shown(spec.target)}"
    return "STRUCT" if isinstance(spec, s.StructSpec) else spec_text(spec)


def _bounds(one: s.Range) -> str:
    low, high = expression_text(one.low), expression_text(one.high)
    return low if low == "*" else f"{low}..{high}"


def comment(index: Index, definition: Definition) -> str:
    """Return the comment of a declaration; empty if it has none."""
    text = index.text(definition.file)
    if not same_name(text.name_at(definition.at), definition.name):
        return ""
    return comment_of(text, definition.at)


def declaration(index: Index, definition: Definition) -> str:
    """Return the declaration of a variable or field as written, with its initial value."""
    text = index.text(definition.file)
    node = definition.node
    if not same_name(text.name_at(definition.at), definition.name):
        return f"{definition.name} : {spec_shown(node.spec)}"
    last = node.names[-1]
    begin = text.offset(last.at) + len(last.text)
    end = text.plain.find(";", begin)
    written = _without_comments(text, begin, end if end >= 0 else begin)
    if isinstance(node.spec, s.StructSpec):
        written = " : STRUCT"
    return f"{definition.name} {written.strip()}"


def _without_comments(text: Text, begin: int, end: int) -> str:
    found = []
    for first, last in text.comments:
        if begin <= first < end:
            found.append(text.code[begin:first])
            begin = last
    return _SPACE.sub(" ", " ".join((*found, text.code[begin:end])))


def head(index: Index, definition: Definition) -> str:
    """Return the first line of the declaration of any name."""
    node, kind = definition.node, definition.kind
    if kind in ("variable", "field"):
        return declaration(index, definition)
    if kind == "member":
        return _member(index, definition)
    if kind in ("structure", "enumeration", "type"):
        extends = f" EXTENDS {node.extends.text}" if node.extends is not None else ""
        return f"TYPE {node.name.text}{extends} : {spec_shown(node.spec)}"
    if kind == "list":
        return f"VAR_GLOBAL {node.name.text}"
    if kind == "instance":
        return f"PROGRAM {node.name.text} : {node.program.text}"
    words = [one for one in getattr(node, "words", ()) if one != ACTION]
    result = getattr(node, "result", None)
    parts = [kind.upper(), *words, node.name.text]
    if getattr(node, "extends", None):
        bases = node.extends if isinstance(node.extends, tuple) else (node.extends,)
        parts += ["EXTENDS", ", ".join(one.text for one in bases)]
    if getattr(node, "implements", ()):
        parts += ["IMPLEMENTS", ", ".join(one.text for one in node.implements)]
    return " ".join(parts) + (f" : {spec_shown(result)}" if result is not None else "")


def _member(index: Index, definition: Definition) -> str:
    kind = index.outside.declarations.types.get(definition.owner)
    owner = index.names.get(definition.owner)
    shown = f"{owner.name}#{definition.name}" if owner is not None else definition.name
    if isinstance(kind, EnumType):
        return f"{shown} = {kind.value_of(definition.name)}"
    return shown


def pins_of(index: Index, key: str, sections: Iterable[str] = PIN_SECTIONS) -> Iterator[Definition]:
    """Yield the pins of a block, function or method, with those of its bases, by section."""
    lines = [index.names.inside(one) for one in reversed(index.names.lineage(key))]
    for section in sections:
        for line in lines:
            for one in line:
                if one.section is not None and one.section.kind == section:
                    yield one


def standard_pins(block: BlockType) -> list[str]:
    """Return the pins of a block of the standard, as their declarations."""
    return [f"{one.name} : {describe(one.type)}" for one in block.variables]


def signature_text(name: str, signature: Signature | None = None) -> str:
    """Return a function of the standard with its inputs and its result."""
    signature = signature or FUNCTIONS[name]
    pins = ", ".join(f"{pin} : {_group(signature, kind)}" for pin, kind in signature.pins)
    more = ", ..." if signature.extensible else ""
    return f"{name}({pins}{more}) : {_group(signature, signature.result)}"


def _group(signature: Signature, kind: str) -> str:
    """Return the type of a pin; several types if the pin takes them."""
    if kind != "T":
        return kind
    return signature.group[0] if len(signature.group) == 1 else "ANY"
