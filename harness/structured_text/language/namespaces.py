"""Gives declarations of the same name in several namespaces different names.

All declarations of a program share one table of names. A name in a source denotes the declaration
in the source's own namespace, else the declaration in a namespace that the source uses.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from structured_text.language import syntax as s

__all__ = ["separated"]


def separated(sources: Sequence[s.Source]) -> list[s.Source]:
    """Return the sources in which no two namespaces declare the same name."""
    owners: dict[str, list[str]] = {}
    for source in sources:
        space = _own(source)
        for node in source.declarations:
            if isinstance(node, (s.Pou, s.TypeDecl, s.Interface)):
                known = owners.setdefault(node.name.key, [])
                if space not in known:
                    known.append(space)
    several = {key: spaces for key, spaces in owners.items() if len(spaces) > 1 and all(spaces)}
    if not several:
        return list(sources)
    return [_renamed(source, several) for source in sources]


def _own(source: s.Source) -> str:
    """Return the namespace that a source declares; empty if the source has no NAMESPACE."""
    return next((one.name.key for one in source.namespaces if not one.used), "")


def _renamed(source: s.Source, several: dict[str, list[str]]) -> s.Source:
    own = _own(source)
    used = [one.name.key for one in source.namespaces if one.used]
    names: dict[str, str] = {}
    for key, spaces in several.items():
        parents = [one for one in spaces if own == one or own.startswith(f"{one}.")]
        meant = max(parents, key=len) if parents else next((u for u in used if u in spaces), "")
        number = spaces.index(meant) if meant else 0
        if number:
            names[key] = f"__{number + 1}"
    if not names:
        return source
    declarations = tuple(_with_names(one, names) for one in source.declarations)
    return replace(source, declarations=declarations)


def _with_names(node: Any, names: dict[str, str]) -> Any:
    """Return a node in which each name gets the suffix that `names` has for this name."""
    if type(node) is tuple:  # isinstance would also accept a Position, which is a tuple
        return tuple(_with_names(one, names) for one in node)
    if isinstance(node, s.Name):
        suffix = names.get(node.key.rpartition(".")[2], "")
        return replace(node, text=node.text + suffix) if suffix else node
    if isinstance(node, s.Literal):
        prefix, sign, rest = node.text.partition("#")
        suffix = names.get(prefix.upper(), "") if sign else ""
        return replace(node, text=f"{prefix}{suffix}#{rest}") if suffix else node
    if not is_dataclass(node) or isinstance(node, (s.Position, type)):
        return node
    changed = {}
    for field in fields(node):
        before = getattr(node, field.name)
        if (field.init and isinstance(before, tuple)) or is_dataclass(before):
            after = _with_names(before, names)
            if after is not before:
                changed[field.name] = after
    return replace(node, **changed) if changed else node
