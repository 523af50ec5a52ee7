"""Semantic tokens: the colours of names by their meaning, and of words, numbers and comments."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from lsprotocol import types as lsp

from structured_text.editor.index import DECLARATION, Index, Occurrence
from structured_text.editor.positions import units
from structured_text.editor.resolving import WRITE
from structured_text.editor.texts import Text, document
from structured_text.language.lexer import KEYWORDS
from structured_text.language.scalars import ELEMENTARY
from structured_text.language.standard import BLOCKS, FUNCTIONS, conversion, overload

__all__ = ["LEGEND", "tokens"]

_TYPES = (
    *("namespace", "type", "class", "enum", "interface", "struct", "parameter", "variable"),
    *("property", "enumMember", "function", "method", "macro", "keyword", "comment", "string"),
    "number",
)
_MODIFIERS = ("declaration", "readonly", "modification", "defaultLibrary")
#: The types and modifiers that the numbers in the tokens refer to.
LEGEND = lsp.SemanticTokensLegend(_TYPES, _MODIFIERS)
_KINDS = {
    "action": "method",
    "configuration": "namespace",
    "enumeration": "enum",
    "field": "property",
    "function": "function",
    "function_block": "class",
    "instance": "variable",
    "interface": "interface",
    "list": "namespace",
    "member": "enumMember",
    "method": "method",
    "program": "namespace",
    "property": "property",
    "structure": "struct",
    "task": "variable",
    "type": "type",
    "variable": "variable",
}
_PINS = ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
_WORD = re.compile(
    r"(?P<typed>[^\W\d]\w*#[-+]?[\d#][\w.:#+-]*)"
    r"|(?P<name>[^\W\d][\w\u0300-\u036f]*)"
    r"|(?P<number>(?:16|8|2)#\w+|\d[\d_]*(?:\.\d[\d_]*)?(?:[eE][-+]?\d+)?)"
    r"|(?P<address>%[A-Za-z]*[\d.]+|%[IQMiqm]\*)"
)
_OBJECT_WORDS = frozenset(
    (
        *("METHOD", "END_METHOD", "PROPERTY", "END_PROPERTY", "INTERFACE", "END_INTERFACE", "GET"),
        *("END_GET", "SET", "END_SET", "EXTENDS", "IMPLEMENTS", "THIS", "SUPER", "PUBLIC"),
        *("PRIVATE", "PROTECTED", "INTERNAL", "ABSTRACT", "FINAL", "OVERRIDE", "CLASS"),
        *("END_CLASS", "NAMESPACE", "END_NAMESPACE", "USING", "POINTER", "REFERENCE", "REF_TO"),
    )
)


class _Token(NamedTuple):
    begin: int
    end: int
    kind: str
    modifiers: int = 0


def tokens(index: Index, path: Path | str, text: str) -> lsp.SemanticTokens:
    """Return the semantic tokens of a file; see `LEGEND`."""
    whole = document(text, str(path))
    found = {token.begin: token for token in _words(whole)}
    found |= {token.begin: token for token in _skipped(whole)}
    for one in index.placed(path, whole):
        token = _named(whole, one)
        found[token.begin] = token
    return lsp.SemanticTokens(_encoded(whole, sorted(found.values())))


def _named(text: Text, one: Occurrence) -> _Token:
    definition = one.definition
    kind = _KINDS[definition.kind]
    section = definition.section
    if section is not None and section.kind in _PINS:
        kind = "parameter"
    modifiers = _bit("declaration") if one.role == DECLARATION else 0
    modifiers |= _bit("modification") if one.role == WRITE else 0
    if kind == "enumMember" or (section is not None and section.qualifier == "CONSTANT"):
        modifiers |= _bit("readonly")
    begin = text.offset(one.at)
    return _Token(begin, begin + len(text.name_at(one.at)), kind, modifiers)


def _bit(modifier: str) -> int:
    return 1 << _MODIFIERS.index(modifier)


def _words(text: Text) -> Iterator[_Token]:
    """Yield keywords, numbers and names of the standard."""
    library = _bit("defaultLibrary")
    before = ""
    for match in _WORD.finditer(text.plain):
        begin, end = match.span()
        word = match.group().upper()
        if match.lastgroup != "name":
            yield _Token(begin, end, "number")
        elif before == ".":
            pass
        elif word in KEYWORDS or word in _OBJECT_WORDS:
            yield _Token(begin, end, "keyword")
        elif word in ELEMENTARY:
            yield _Token(begin, end, "type", library)
        elif word in BLOCKS:
            yield _Token(begin, end, "class", library)
        elif word in FUNCTIONS or conversion(word) or overload(word):
            yield _Token(begin, end, "function", library)
        rest = text.plain[end : end + 1]
        before = rest


def _skipped(text: Text) -> Iterator[_Token]:
    """Yield comments, texts and pragmas, each line of them by itself."""
    comments = {begin for begin, _ in text.comments}
    for begin, end in text.skipped:
        first = text.code[begin]
        kind = "comment" if begin in comments else "macro" if first == "{" else "string"
        while begin < end:
            stop = text.code.find("\n", begin, end)
            stop = end if stop < 0 else stop
            if stop > begin:
                yield _Token(begin, stop, kind)
            begin = stop + 1


def _encoded(text: Text, found: list[_Token]) -> list[int]:
    """Return the tokens as numbers: each position is relative to the token before it."""
    numbers: list[int] = []
    line = column = 0
    for token in found:
        at = text.at(token.begin)
        here = at.line - 1
        start = units(text.lines[here][: at.column - 1])
        size = units(text.text[token.begin : token.end])
        numbers += (
            here - line,
            start - (column if here == line else 0),
            size,
            _TYPES.index(token.kind),
            token.modifiers,
        )
        line, column = here, start
    return numbers
