"""Reports on declarations that a target does not support."""

from __future__ import annotations

from collections.abc import Sequence

from structured_text.export.output import Missing
from structured_text.export.parts import Part
from structured_text.language import syntax as s
from structured_text.language.walk import declared

__all__ = ["lost_configuration", "missing", "reaching_out", "retain"]

_NAMED = 3


def missing(part: Part, why: str, *, of: str = "", at: s.Position | None = None) -> Missing:
    """Return the report that a declaration is not supported.

    If `of` is given, the report is about this item inside the declaration; `at` is its position.
    """
    what = f"{part.kind} {part.name}"
    what = f"{of} of {what}" if of else what
    return Missing(what, why, part.file, (at or part.node.at).line)


def lost_configuration(part: Part, todo: str, *, without_globals: bool = False) -> Missing:
    """Return the report that a CONFIGURATION is not supported, with all names that it declares."""
    node = part.node
    assert isinstance(node, s.Configuration)
    found = [(f"TASK {one.name.text}", one.at) for one in node.tasks]
    found += [(f"PROGRAM {one.name.text}", one.at) for one in node.programs]
    if not without_globals:
        names = (name for _, _, name in declared(node.globals))
        found += [(f"VAR_GLOBAL {name.text}", name.at) for name in names]
    listed = ", ".join(f"{what} (line {at.line})" for what, at in found)
    return missing(part, f"{listed}: {todo}")


def reaching_out(node: s.Pou, tool: str) -> str:
    """Return the reason why a POU with global or located variables cannot be exported, or ""."""
    found = [
        name.text
        for section, one, name in declared(node.sections)
        if section.kind in ("VAR_EXTERNAL", "VAR_GLOBAL") or one.address is not None
    ]
    if not found:
        return ""
    return f"has global or located variables ({_listed(found)}); declare it again in {tool}"


def retain(part: Part) -> set[str]:
    """Return the upper-case names of a POU's retained variables."""
    assert isinstance(part.node, s.Pou)
    return {
        name.key
        for section, _, name in declared(part.node.sections)
        if section.qualifier == "RETAIN"
    }


def _listed(names: Sequence[str]) -> str:
    shown = ", ".join(names[:_NAMED])
    more = len(names) - _NAMED
    return f"{shown} and {more} more" if more > 0 else shown
