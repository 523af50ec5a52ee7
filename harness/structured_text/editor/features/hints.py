"""Inlay hints: the inputs that a call omits, with the values that they have.

An omitted input of a function or method has its initial value. An omitted input of a block keeps
its last value. This is its initial value only if nothing else writes the input, so that otherwise
there is no hint.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.context import callee_before
from structured_text.editor.index import Index
from structured_text.editor.lookup import Callee, callee_of
from structured_text.editor.pins import Pin, pins_of_callee
from structured_text.editor.positions import from_editor, to_editor
from structured_text.editor.structure import Region, Token, key_of, scanned, tokens_of
from structured_text.editor.texts import Text, document
from structured_text.language.scalars import ANY_BIT, ANY_CHARS, ANY_INT, ANY_REAL
from structured_text.language.types import ElementaryType, EnumType

__all__ = ["hints"]

#: Number of inputs that a hint shows; the others are in its tooltip.
_SHOWN = 4
#: An assignment to a pin of an instance: its path and the pin.
_ASSIGNED = re.compile(r"(\w+(?:\^|\[[^\]]*\]|\.\w+)*)\s*\.\s*(\w+)\s*:=")


@dataclass(frozen=True)
class _Call:
    """A call in a text.

    Attributes:
        owner: The key of the POU or method around it.
        callee: The text of what is called.
        open: The number of the token of its opening parenthesis.
        close: The number of the token of its closing parenthesis.
        names: The upper-case names of the given pins.
        places: The number of arguments without names.
    """

    owner: str
    callee: str
    open: int
    close: int
    names: frozenset[str]
    places: int


def hints(index: Index, path: Path | str, text: str, where: lsp.Range) -> list[lsp.InlayHint]:
    """Return a hint for each call in a range that omits inputs."""
    whole = document(text, str(path))
    begin = whole.offset(from_editor(whole.lines, where.start))
    end = whole.offset(from_editor(whole.lines, where.end))
    tokens = tokens_of(whole)
    calls = list(_calls(whole, tokens))
    written = _written(whole)
    found = []
    for one in calls:
        close = tokens[one.close].begin
        if begin <= close <= end:
            label = _omitted(index, one, calls, written)
            if label:
                found.append(_hint(label, to_editor(whole.lines, whole.at(close))))
    return found


def _hint(omitted: list[str], position: lsp.Position) -> lsp.InlayHint:
    more = ["..."] if len(omitted) > _SHOWN else []
    label = ", ".join((*omitted[:_SHOWN], *more))
    tooltip = "This call omits:\n" + "\n".join(omitted)
    return lsp.InlayHint(position, label, lsp.InlayHintKind.Parameter, None, tooltip, True)


def _omitted(
    index: Index, call: _Call, calls: list[_Call], written: dict[str, set[str]]
) -> list[str]:
    callee = callee_of(index, call.owner, call.callee)
    if callee is None or (callee.definition is None and callee.block is None):
        return []
    inputs = [one for one in pins_of_callee(index, callee) if one.section == "VAR_INPUT"]
    given = set(call.names)
    if callee.block is not None:
        same = [one for one in calls if (one.owner, one.callee) == (call.owner, call.callee)]
        given |= {name for one in same for name in one.names}
        given |= written.get(_key(call.callee), set())
        if any(one.places for one in same):
            return []  # a call of a block without names gives all inputs
    else:
        inputs = inputs[call.places :]
    rest = [one for one in inputs if one.name.upper() not in given]
    shown = ((one, one.default or _initial(index, callee, one)) for one in rest)
    return [f"{one.name} := {value}" for one, value in shown if value]


def _written(text: Text) -> dict[str, set[str]]:
    """Return the upper-case names of the pins that statements write, by their instance."""
    found: dict[str, set[str]] = {}
    for match in _ASSIGNED.finditer(text.plain):
        found.setdefault(_key(match[1]), set()).add(match[2].upper())
    return found


def _key(path: str) -> str:
    return "".join(path.split()).upper()


def _initial(index: Index, callee: Callee, pin: Pin) -> str:
    """Return the value of an input without an initial value; empty for arrays and the like."""
    pou = index.outside.declarations.pous.get(callee.key)
    symbol = pou.symbols.get(pin.name.upper()) if pou is not None else None
    if symbol is not None and isinstance(symbol.type, EnumType):
        return symbol.type.member_of(symbol.initial) or ""
    kind = (
        symbol.type.name if symbol is not None and isinstance(symbol.type, ElementaryType) else ""
    )
    value = symbol.initial if symbol is not None else None
    name = kind or pin.type
    if name == "BOOL":
        return "TRUE" if value else "FALSE"
    if name in (*ANY_INT, *ANY_BIT):
        return str(value or 0)
    if name in ANY_REAL:
        return str(value or 0.0)
    if name in ANY_CHARS:
        return "''" if not value else ""
    return "T#0s" if name == "TIME" and not value else ""


def _calls(text: Text, tokens: list[Token]) -> Iterator[_Call]:
    """Yield the complete calls of a text."""
    owners = list(_owners(scanned(tokens)[0]))
    waiting: list[int] = []
    for number, token in enumerate(tokens):
        if token.text == "(":
            waiting.append(number)
        elif token.text == ";":
            waiting.clear()
        elif token.text == ")" and waiting:
            first = waiting.pop()
            callee = callee_before(text, tokens, first)
            owner = next((key for begin, end, key in owners if begin <= first <= end), "")
            if callee and owner:
                names, places = _arguments(tokens[first + 1 : number])
                yield _Call(owner, callee, first, number, names, places)


def _arguments(inside: list[Token]) -> tuple[frozenset[str], int]:
    names: set[str] = set()
    places = depth = 0
    begins = True
    for number, token in enumerate(inside):
        if begins and not depth:
            ahead = inside[number + 1].text if number + 1 < len(inside) else ""
            if ahead in (":=", "=>"):
                names.add(token.word)
            else:
                places += 1
        depth += (token.text in ("(", "[")) - (token.text in (")", "]"))
        begins = token.text == "," and not depth
    return frozenset(names), places


def _owners(regions: list[Region], above: str = "") -> Iterator[tuple[int, int, str]]:
    """Yield first and last token of the bodies of POUs and methods, the innermost first."""
    for one in regions:
        if one.is_section or one.kind == "TYPE":
            yield one.first, one.last, ""
            continue
        key = key_of(one, above)
        yield from _owners(one.inside, key)
        if key:
            yield one.first, one.last, key
