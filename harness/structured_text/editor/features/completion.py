"""Completion: members, pins, values of enumerations, names in scope, keywords, whole calls."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.context import Context, context
from structured_text.editor.index import Index
from structured_text.editor.lookup import Callee, callee_of, type_of
from structured_text.editor.names import LIST, Definition
from structured_text.editor.pins import Pin, call_snippet, pins_of_callee
from structured_text.editor.positions import from_editor
from structured_text.editor.texts import Text, document
from structured_text.editor.writing import comment, head, signature_text
from structured_text.language.declare import Scope
from structured_text.language.scalars import ELEMENTARY
from structured_text.language.standard import BLOCKS, FUNCTIONS
from structured_text.language.types import (
    BlockType,
    EnumType,
    InterfaceType,
    StructType,
    Type,
)
from structured_text.language.values import describe

__all__ = ["TRIGGERS", "completion", "resolved"]

#: Characters behind which an editor should ask for completion by itself.
TRIGGERS = (".", "#", "(", ",", "=", " ")
_Kind = lsp.CompletionItemKind
_KINDS = {
    "action": _Kind.Method,
    "enumeration": _Kind.Enum,
    "field": _Kind.Field,
    "function": _Kind.Function,
    "function_block": _Kind.Class,
    "interface": _Kind.Interface,
    "list": _Kind.Module,
    "member": _Kind.EnumMember,
    "method": _Kind.Method,
    "program": _Kind.Module,
    "property": _Kind.Property,
    "structure": _Kind.Struct,
    "type": _Kind.Struct,
    "variable": _Kind.Variable,
}
_TYPES = ("structure", "enumeration", "type", "function_block", "interface")
#: The keywords that can stand at each part of a source.
_KEYWORDS = {
    "body": (
        *("IF", "THEN", "ELSIF", "ELSE", "END_IF", "CASE", "OF", "END_CASE", "FOR", "TO", "BY"),
        *("DO", "END_FOR", "WHILE", "END_WHILE", "REPEAT", "UNTIL", "END_REPEAT", "EXIT"),
        *("RETURN", "CONTINUE", "AND", "OR", "XOR", "NOT", "MOD", "TRUE", "FALSE"),
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL"),
    ),
    "declaration": ("AT", "END_VAR", "CONSTANT", "RETAIN", "TRUE", "FALSE"),
    "type": ("STRUCT", "END_STRUCT", "ARRAY", "END_TYPE"),
    "outside": (
        *("PROGRAM", "FUNCTION_BLOCK", "FUNCTION", "TYPE", "VAR_GLOBAL", "INTERFACE"),
        *("CONFIGURATION", "END_PROGRAM", "END_FUNCTION_BLOCK", "END_FUNCTION"),
    ),
}
_OF_TYPES = ("ARRAY", "STRING", "WSTRING", "POINTER TO", "REFERENCE TO", "REF_TO")
#: First letters of `sort_text`: what fits best comes first.
_FIRST, _NEXT, _OTHERS, _LAST = "0", "1", "2", "3"


def completion(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> list[lsp.CompletionItem] | None:
    """Return what can stand at a position, in a text that may be unfinished.

    None inside of a comment or text.
    """
    whole = document(text, str(path))
    offset = whole.offset(from_editor(whole.lines, position))
    if offset and whole.code[offset - 1] != whole.plain[offset - 1]:
        return None
    here = context(whole, offset)
    found: dict[tuple[str, object], lsp.CompletionItem] = {}
    for item in _Items(index, whole, offset, here).items():
        found.setdefault((item.label, item.kind), item)
    return list(found.values())


def resolved(index: Index, item: lsp.CompletionItem) -> lsp.CompletionItem:
    """Add declaration and comment to an item, once the editor shows it."""
    found = index.names.get(str(item.data)) if item.data else None
    if found is not None:
        said = "\n\n".join(
            filter(None, (f"```iecst\n{head(index, found)}\n```", comment(index, found)))
        )
        item.documentation = lsp.MarkupContent(lsp.MarkupKind.Markdown, said)
    return item


class _Items:
    """The items for a place of the cursor."""

    def __init__(self, index: Index, text: Text, offset: int, here: Context) -> None:
        self._index, self._text, self._offset, self._here = index, text, offset, here
        self._scope: Scope = index.scope(here.owner)
        rest = text.plain[offset:].lstrip(" \t")
        self._is_called = rest.startswith("(")
        self._end = "" if rest.startswith(";") else ";"

    def items(self) -> Iterator[lsp.CompletionItem]:
        """Yield the items."""
        here = self._here
        if here.prefix:
            yield from self._members(self._named(here.prefix), _FIRST)
        elif here.base:
            yield from self._inside(here.base)
        elif here.is_type:
            yield from self._types()
        elif here.spec:
            yield from self._initial()
        elif here.part == "body":
            yield from self._body()
        else:
            yield from self._keywords()

    def _initial(self) -> Iterator[lsp.CompletionItem]:
        """Yield what can stand in an initial value: fields and their values, and constants."""
        kind = self._declared(self._here.spec)
        for field in filter(None, self._here.fields):
            kind = dict(_fields(kind)).get(field, (field, None))[1]
        if self._here.fields and not self._here.fields[-1]:
            for number, (key, (name, of)) in enumerate(_fields(kind)):
                found = self._index.names.member(getattr(kind, "name", "").upper(), key)
                item = self._plain(name, describe(of) if of else "", _Kind.Field, found)
                item.insert_text, item.sort_text = f"{name} := ", f"{_FIRST}{number:05}"
                yield item
            return
        yield from self._values(kind)
        yield from self._globals()

    def _declared(self, name: str) -> Type | None:
        return self._named(name) or self._scope.declarations.blocks.get(name.upper())

    def _named(self, name: str) -> Type | None:
        if name.upper() == "BOOL":
            return ELEMENTARY["BOOL"]
        return self._scope.declarations.type_named(name.upper())

    # --- behind a dot ---

    def _inside(self, base: str) -> Iterator[lsp.CompletionItem]:
        key = base.upper()
        if key.isidentifier() and self._scope.symbol(key) is None:
            listed = self._index.names.inside(f"{LIST}{key}")
            if listed:
                yield from (self._item(one, _FIRST) for one in listed)
                return
            kind = self._named(base)
            if isinstance(kind, EnumType):
                yield from self._members(kind, _FIRST, bare=True)
                return
        own = key.partition("^")[0] in ("THIS", "SUPER")
        yield from self._of_type(type_of(self._index, self._here.owner, base), own=own)

    def _of_type(self, kind: Type | None, *, own: bool) -> Iterator[lsp.CompletionItem]:
        if isinstance(kind, StructType):
            for name, field in kind.fields:
                found = self._index.names.member(kind.name.upper(), name.upper())
                yield self._plain(name, describe(field), _Kind.Field, found)
        elif isinstance(kind, BlockType):
            pins = ("VAR_INPUT", "VAR_OUTPUT", *(("VAR", "VAR_IN_OUT") if own else ()))
            for pin in kind.variables:
                if pin.section in pins and "." not in pin.name:
                    found = self._index.names.member(kind.name.upper(), pin.name.upper())
                    yield self._plain(pin.name, describe(pin.type), _Kind.Field, found)
        if isinstance(kind, (BlockType, InterfaceType)):
            yield from self._methods(kind.name.upper(), _FIRST, own=own)

    def _methods(self, owner: str, rank: str, *, own: bool) -> Iterator[lsp.CompletionItem]:
        for key in self._index.names.lineage(owner):
            for one in self._index.names.inside(key):
                hidden = {"PRIVATE", "PROTECTED"} & set(getattr(one.node, "words", ()))
                if one.kind in ("method", "action", "property") and (own or not hidden):
                    yield self._item(one, rank)

    # --- values ---

    def _values(self, kind: Type | None) -> Iterator[lsp.CompletionItem]:
        """Yield the members of an enumeration, or TRUE and FALSE."""
        if isinstance(kind, EnumType):
            yield from self._members(kind, _FIRST)
        elif kind == ELEMENTARY["BOOL"]:
            for word in ("TRUE", "FALSE"):
                yield lsp.CompletionItem(word, kind=_Kind.Keyword, sort_text=f"{_FIRST}{word}")

    def _members(
        self, kind: Type | None, rank: str, *, bare: bool = False
    ) -> Iterator[lsp.CompletionItem]:
        if not isinstance(kind, EnumType):
            return
        strict = "strict" in kind.attributes and not bare and not self._here.prefix
        for number, name in enumerate(kind.members):
            found = self._index.names.member(kind.name.upper(), name.upper())
            item = self._plain(
                name, f"{kind.name} = {kind.value_of(name)}", _Kind.EnumMember, found
            )
            item.sort_text = f"{rank}{number:05}"
            item.insert_text = f"{kind.name}.{name}" if strict else None
            yield item

    # --- bodies ---

    def _body(self) -> Iterator[lsp.CompletionItem]:
        here = self._here
        wanted = self._wanted()
        yield from self._values(wanted)
        if here.is_argument and here.call is not None:
            yield from self._pins(here.call.callee, here.call.given)
        if here.is_start:
            yield from self._calls()
        yield from self._variables()
        yield from self._globals()
        yield from self._functions()
        yield from self._keywords()

    def _wanted(self) -> Type | None:
        here = self._here
        if here.call is not None and here.call.active:
            callee = self._callee(here.call.callee)
            return None if callee is None else self._pin_type(callee, here.call.active)
        return type_of(self._index, here.owner, here.other) if here.other else None

    def _callee(self, written: str) -> Callee | None:
        return callee_of(self._index, self._here.owner, written)

    def _pin_type(self, callee: Callee, pin: str) -> Type | None:
        resolver = self._index.resolver(self._scope, [])
        return resolver.pin_types(callee.key, callee.block).get(pin)

    def _pins(self, written: str, given: Iterable[str]) -> Iterator[lsp.CompletionItem]:
        callee = self._callee(written)
        pins = pins_of_callee(self._index, callee) if callee is not None else []
        for number, pin in enumerate(pins):
            if pin.name.upper() not in given:
                item = self._plain(
                    pin.name, pin.text.partition(pin.name)[2], _Kind.Field, pin.definition
                )
                item.insert_text = f"{pin.name} {pin.sign} "
                item.sort_text = f"{_FIRST}{number:05}"
                yield item

    def _calls(self) -> Iterator[lsp.CompletionItem]:
        """Yield whole calls of the instances of blocks in scope."""
        if self._is_called:
            return
        pou = self._scope.pou
        for symbols in (pou.symbols, pou.owner.symbols if pou.owner is not None else {}):
            for symbol in symbols.values():
                if isinstance(symbol.type, BlockType) and symbol.name.isidentifier():
                    key = symbol.type.name.upper()
                    callee = Callee(key, symbol.type, self._index.names.get(key))
                    pins = pins_of_callee(self._index, callee)
                    yield self._snippet(symbol.name, pins, f"call of {symbol.type.name}")

    def _snippet(
        self, name: str, pins: list[Pin], detail: str, *, named: bool = True, value: bool = False
    ) -> lsp.CompletionItem:
        snippet = call_snippet(name, pins, named=named)
        return lsp.CompletionItem(
            f"{name}(...)",
            kind=_Kind.Snippet,
            detail=detail,
            filter_text=name,
            sort_text=f"{_OTHERS if value else _NEXT}{name}",
            insert_text=snippet + ("" if value else self._end),
            insert_text_format=lsp.InsertTextFormat.Snippet,
        )

    def _variables(self) -> Iterator[lsp.CompletionItem]:
        pou, names = self._scope.pou, self._index.names
        keys = [pou.name.upper()]
        tables = [pou.symbols]
        if pou.owner is not None:
            keys.append(pou.owner.name.upper())
            tables.append(pou.owner.symbols)
        for key, table in zip(keys, tables, strict=True):
            for symbol in table.values():
                if symbol.name.isidentifier() and table.get(symbol.name.upper()) is symbol:
                    found = names.member(key, symbol.name.upper())
                    item = self._plain(symbol.name, describe(symbol.type), _Kind.Variable, found)
                    item.sort_text = f"{_NEXT}{symbol.name}"
                    yield item
        if pou.result is not None and pou.result.name.isidentifier():
            item = self._plain(pou.result.name, describe(pou.result.type), _Kind.Variable, None)
            item.sort_text = f"{_NEXT}{pou.result.name}"
            yield item
        block = self._scope.block
        if block is not None:
            yield from self._methods(block.name.upper(), _NEXT, own=True)

    def _globals(self) -> Iterator[lsp.CompletionItem]:
        declarations, names = self._scope.declarations, self._index.names
        for list_key, variables in declarations.lists.items():
            owner = names.get(f"{LIST}{list_key}")
            if owner is not None:
                yield self._item(owner, _OTHERS)
            for name, key in variables.items():
                found = names.get(f"{LIST}{list_key}.{name}")
                if found is not None and key not in declarations.qualified:
                    yield self._item(found, _OTHERS)
        configuration = self._scope.registry.configuration
        if configuration is not None:
            for one in names.inside(f"{LIST}{configuration.node.name.key}"):
                if one.kind == "variable":
                    yield self._item(one, _OTHERS)

    def _functions(self) -> Iterator[lsp.CompletionItem]:
        for one in self._index.names.all():
            if one.kind == "function":
                yield self._item(one, _OTHERS)
        for name in FUNCTIONS:
            item = lsp.CompletionItem(
                name, kind=_Kind.Function, detail=signature_text(name), sort_text=f"{_LAST}{name}"
            )
            yield item

    def _types(self) -> Iterator[lsp.CompletionItem]:
        for one in self._index.names.all():
            if one.kind in _TYPES and "." not in one.key:
                yield self._item(one, _NEXT)
        for name in (*ELEMENTARY, *_OF_TYPES):
            yield lsp.CompletionItem(name, kind=_Kind.Keyword, sort_text=f"{_OTHERS}{name}")
        for name in BLOCKS:
            yield lsp.CompletionItem(name, kind=_Kind.Class, sort_text=f"{_LAST}{name}")

    def _keywords(self) -> Iterator[lsp.CompletionItem]:
        for word in _KEYWORDS[self._here.part]:
            yield lsp.CompletionItem(word, kind=_Kind.Keyword, sort_text=f"{_LAST}{word}")

    # --- items ---

    def _item(self, found: Definition, rank: str) -> lsp.CompletionItem:
        """Return the item of a declared name; a function or method is a whole call."""
        if found.kind in ("function", "method", "action") and not self._is_called:
            pins = pins_of_callee(self._index, Callee(found.key, None, found))
            value = found.kind == "function"
            item = self._snippet(found.name, pins, head(self._index, found), value=True)
            if not value and self._here.is_start and not self._here.base:
                item.insert_text = f"{item.insert_text}{self._end}"
            item.label, item.kind = found.name, _KINDS[found.kind]
        else:
            item = lsp.CompletionItem(found.name, kind=_KINDS.get(found.kind))
            item.detail = self._detail(found)
        item.sort_text, item.data = f"{rank}{found.name}", found.key
        return item

    def _detail(self, found: Definition) -> str | None:
        if found.kind not in ("variable", "field"):
            return None
        return head(self._index, found).partition(" ")[2].lstrip(": ")

    def _plain(
        self, name: str, detail: str, kind: lsp.CompletionItemKind, found: Definition | None
    ) -> lsp.CompletionItem:
        said = comment(self._index, found) if found is not None else ""
        return lsp.CompletionItem(
            name,
            kind=kind,
            detail=detail.lstrip(" :=>") if detail.startswith((" :", " =>")) else detail,
            documentation=said or None,
            sort_text=f"{_FIRST}{name}",
            data=found.key if found is not None else None,
        )


def _fields(kind: Type | None) -> Iterator[tuple[str, tuple[str, Type | None]]]:
    """Yield key, name and type of what an initial value of a type can give."""
    if isinstance(kind, StructType):
        for name, of in kind.fields:
            yield name.upper(), (name, of)
    elif isinstance(kind, BlockType):
        for pin in kind.variables:
            if pin.section in ("VAR_INPUT", "VAR_OUTPUT"):
                yield pin.name.upper(), (pin.name, pin.type)
