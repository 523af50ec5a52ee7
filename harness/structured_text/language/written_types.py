"""The types of variables and parts of variables in declarations, for SIZEOF and bounds of arrays.

The declarations are not complete yet. Therefore a variable may have to be looked up in the source.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Protocol

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.registry import Declared, Registry
from structured_text.language.scalars import ELEMENTARY
from structured_text.language.tree import Symbol
from structured_text.language.types import ArrayType, BlockType, Type, members

__all__ = ["type_of"]


class Resolving(Protocol):
    """The part of `resolve.Types` that this module uses."""

    registry: Registry
    globals: dict[str, Symbol]
    blocks: dict[str, BlockType]
    sections: list[tuple[s.Section, Declared]]
    under_way: set[str]

    @property
    def local(self) -> Mapping[str, Symbol]:
        """Return the variables of the POU that is being declared."""

    def type_named(self, key: str) -> Type | None:
        """Return the type of the sources with this upper-case name."""

    def resolve(self, spec: s.TypeSpec, where: Declared, owner: str = "") -> tuple[Type, Any]:
        """Return the type of a specification, and its initial value."""


def type_of(types: Resolving, node: s.Expression | s.Call | s.Invoke) -> Type | None:
    """Return the type of a variable, part of a variable or type that a path names, or None."""
    if isinstance(node, s.Name):
        symbol = types.local.get(node.key) or types.globals.get(node.key)
        if symbol is not None:
            return symbol.type
        sections = [*types.sections, *((section, one) for _, section, one in _lists(types))]
        found = _declared(types, sections, node.key) or types.type_named(node.key)
        return found or types.blocks.get(node.key) or ELEMENTARY.get(node.key)
    if isinstance(node, s.Field):
        base = node.base
        if isinstance(base, s.Name) and base.key not in types.local:
            listed = [(section, one) for key, section, one in _lists(types) if key == base.key]
            if listed:
                return _declared(types, listed, node.name.key)
        of = type_of(types, base)
        fields = members(of) if of is not None else ()
        return next((kind for name, kind in fields if name.upper() == node.name.key), None)
    if isinstance(node, s.Index):
        of = type_of(types, node.base)
        return of.element if isinstance(of, ArrayType) else None
    return None


def _lists(types: Resolving) -> Iterator[tuple[str, s.Section, Declared]]:
    """Yield upper-case name and section of each list of globals, with its declaration."""
    for one in types.registry.lists:
        assert isinstance(one.node, s.GlobalList)
        yield one.node.name.key, one.node.section, one


def _declared(
    types: Resolving, sections: list[tuple[s.Section, Declared]], key: str
) -> Type | None:
    """Return the type of a variable that is not declared yet; None if there is none."""
    for section, declared in sections:
        for variable in section.variables:
            if key in (name.key for name in variable.names) and key not in types.under_way:
                types.under_way.add(key)
                try:
                    return types.resolve(variable.spec, declared)[0]
                except InputError:
                    return None
                finally:
                    types.under_way.discard(key)
    return None
