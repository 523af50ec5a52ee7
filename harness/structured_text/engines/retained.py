"""The variables that keep their values over a warm start: those declared in VAR RETAIN."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.language.project import Project
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
)

__all__ = ["retained"]


def retained(project: Project) -> tuple[str, ...]:
    """Return the paths of all retained variables; a retained block gives those of its variables.

    Pointers and references are left out, because the start of the program sets them.
    """
    found = [
        path
        for name, block in project.instances.items()
        for path in _inside(name, block, whole=False)
    ]
    for variable in project.globals.values():
        if variable.retain or isinstance(variable.type, BlockType):
            found += _paths(variable.name, variable.type, whole=variable.retain)
    return tuple(found)


def _inside(path: str, block: BlockType, *, whole: bool) -> Iterator[str]:
    for variable in block.variables:
        if variable.section in ("VAR_IN_OUT", "VAR_EXTERNAL") or variable.address is not None:
            continue
        keeps = whole or variable.retain
        if keeps or isinstance(variable.type, BlockType):
            yield from _paths(f"{path}.{variable.name}", variable.type, whole=keeps)


def _paths(path: str, kind: Type, *, whole: bool) -> Iterator[str]:
    if isinstance(kind, BlockType):
        yield from _inside(path, kind, whole=whole)
    elif _is_value(kind):
        yield path


def _is_value(kind: Type) -> bool:
    if isinstance(kind, ArrayType):
        return _is_value(kind.element)
    if isinstance(kind, StructType):
        return all(_is_value(field) for _, field in kind.fields)
    return isinstance(kind, (ElementaryType, EnumType))
