"""The outline of a file: POUs, types, methods, and the variables of their sections."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import Index
from structured_text.editor.positions import span
from structured_text.editor.structure import Region, Token, scanned, tokens_of
from structured_text.editor.texts import Text, document

__all__ = ["outline"]

_Kind = lsp.SymbolKind
_KINDS = {
    "FUNCTION_BLOCK": _Kind.Class,
    "CLASS": _Kind.Class,
    "FUNCTION": _Kind.Function,
    "PROGRAM": _Kind.Module,
    "INTERFACE": _Kind.Interface,
    "METHOD": _Kind.Method,
    "ACTION": _Kind.Method,
    "PROPERTY": _Kind.Property,
    "CONFIGURATION": _Kind.Package,
    "RESOURCE": _Kind.Package,
    "NAMESPACE": _Kind.Namespace,
}


def outline(index: Index, path: Path | str, text: str) -> list[lsp.DocumentSymbol]:
    """Return the declarations of a file, each inside of the one around it."""
    del index  # the outline follows the text while somebody is typing
    whole = document(text, str(path))
    tokens = tokens_of(whole)
    return list(_Outline(whole, tokens).symbols(scanned(tokens)[0]))


class _Outline:
    def __init__(self, text: Text, tokens: Sequence[Token]) -> None:
        self._text, self._tokens = text, tokens

    def symbols(self, regions: Sequence[Region]) -> Iterator[lsp.DocumentSymbol]:
        """Yield the symbols of some regions; sections yield their variables."""
        for one in regions:
            if one.is_section:
                yield from self._variables(one)
            elif one.kind == "TYPE":
                yield from self._types(one)
            elif one.name is not None:
                children = list(self.symbols(one.inside))
                yield self._symbol(
                    one.name, _KINDS[one.kind], one.begin, one.end, one.kind, children
                )

    def _symbol(
        self,
        name: Token,
        kind: lsp.SymbolKind,
        begin: int,
        end: int,
        detail: str,
        children: Sequence[lsp.DocumentSymbol] = (),
    ) -> lsp.DocumentSymbol:
        text = self._text
        where = span(text.lines, text.at(name.begin), text.at(name.end))
        whole = span(text.lines, text.at(begin), text.at(max(end, name.end)))
        return lsp.DocumentSymbol(name.text, kind, whole, where, detail, children=list(children))

    def _variables(
        self, region: Region, kind: lsp.SymbolKind = _Kind.Variable
    ) -> Iterator[lsp.DocumentSymbol]:
        """Yield the variables of a section, or the fields of a structure."""
        constant = any(
            one.word == "CONSTANT" for one in self._tokens[region.first + 1 : region.first + 4]
        )
        kind = _Kind.Constant if constant else kind
        for names, colon, last in _declarations(self._tokens, region.first + 1, region.last):
            detail = self._between(self._tokens[colon].end, self._tokens[last].begin)
            for name in names:
                end = self._tokens[last].end
                yield self._symbol(name, kind, name.begin, end, detail)

    def _between(self, begin: int, end: int) -> str:
        return " ".join(self._text.plain[begin:end].split())

    def _types(self, region: Region) -> Iterator[lsp.DocumentSymbol]:
        number = region.first + 1
        inner = iter(region.inside)
        while number < region.last:
            colon = _next(self._tokens, number, region.last, ":")
            if colon is None or colon + 1 >= len(self._tokens):
                return
            name = self._tokens[number]
            word = self._tokens[colon + 1].word
            struct = next(inner, None) if word in ("STRUCT", "UNION") else None
            last = struct.last if struct is not None else colon
            end = _next(self._tokens, last, region.last, ";")
            stop = end if end is not None else last
            children: list[lsp.DocumentSymbol] = []
            kind = _Kind.Struct
            if struct is not None:
                children = list(self._variables(struct, _Kind.Field))
            elif word == "(":
                kind = _Kind.Enum
                children = list(self._members(colon + 1, stop))
            detail = self._between(self._tokens[colon].end, self._tokens[stop].begin)
            detail = word if struct is not None else detail
            yield self._symbol(name, kind, name.begin, self._tokens[stop].end, detail, children)
            number = stop + 1
            while number < region.last and self._tokens[number].text == ";":
                number += 1

    def _members(self, first: int, last: int) -> Iterator[lsp.DocumentSymbol]:
        for number in range(first, last):
            token = self._tokens[number + 1]
            if self._tokens[number].text in ("(", ",") and token.is_word:
                yield self._symbol(token, _Kind.EnumMember, token.begin, token.end, "")


def _next(tokens: Sequence[Token], number: int, last: int, sign: str) -> int | None:
    return next((k for k in range(number, last + 1) if tokens[k].text == sign), None)


def _declarations(
    tokens: Sequence[Token], first: int, last: int
) -> Iterator[tuple[list[Token], int, int]]:
    """Yield the names of each declaration, and the numbers of its colon and last token."""
    number = first
    while number < last:
        colon = _next(tokens, number, last, ":")
        if colon is None:
            return
        end = _next(tokens, colon, last - 1, ";")
        stop = end if end is not None else last - 1
        yield _names(tokens[number:colon]), colon, stop
        number = stop + 1


def _names(before: Sequence[Token]) -> list[Token]:
    """Return the names before a colon; words such as CONSTANT, and an address, are left out."""
    names: list[Token] = []
    for token in before:
        if token.word == "AT":
            break
        if token.text == ",":
            continue
        if names and not _is_behind_comma(before, token):
            names = []
        if token.is_word:
            names.append(token)
    return names


def _is_behind_comma(before: Sequence[Token], token: Token) -> bool:
    place = before.index(token)
    return place > 0 and before[place - 1].text == ","
