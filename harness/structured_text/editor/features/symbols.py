"""Search for declared names in all files of a project."""

from __future__ import annotations

from collections.abc import Iterator

from lsprotocol import types as lsp

from structured_text.editor.features.definition import place_of
from structured_text.editor.index import Index
from structured_text.editor.names import LIST, Definition

__all__ = ["symbols"]

#: Most symbols of an answer; an editor asks again with more letters.
_MOST = 200
_Kind = lsp.SymbolKind
_KINDS = {
    "action": _Kind.Method,
    "configuration": _Kind.Package,
    "enumeration": _Kind.Enum,
    "field": _Kind.Field,
    "function": _Kind.Function,
    "function_block": _Kind.Class,
    "instance": _Kind.Object,
    "interface": _Kind.Interface,
    "list": _Kind.Module,
    "member": _Kind.EnumMember,
    "method": _Kind.Method,
    "program": _Kind.Module,
    "property": _Kind.Property,
    "structure": _Kind.Struct,
    "task": _Kind.Event,
    "type": _Kind.Struct,
    "variable": _Kind.Variable,
}


def symbols(index: Index, query: str) -> list[lsp.WorkspaceSymbol]:
    """Return the declared names that contain the letters of a query in their order.

    Names that begin with the query come first, and names of files before what is inside of them.
    """
    wanted = query.upper()
    every = [one for one in index.names.all() if _contains(one.name.upper(), wanted)]
    every.sort(key=lambda one: _rank(one, wanted))
    return list(_shown(index, every[:_MOST]))


def _rank(one: Definition, wanted: str) -> tuple[bool, bool, int, str]:
    name = one.name.upper()
    return not name.startswith(wanted), wanted not in name, one.key.count("."), name


def _shown(index: Index, found: list[Definition]) -> Iterator[lsp.WorkspaceSymbol]:
    for one in found:
        owner = one.owner.lstrip(LIST) or None
        yield lsp.WorkspaceSymbol(
            place_of(index, one), one.name, _KINDS[one.kind], container_name=owner
        )


def _contains(name: str, wanted: str) -> bool:
    letters = iter(name)
    return all(letter in letters for letter in wanted)
