"""All uses of a name in all files, and its uses in one file."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import DECLARATION, Index, Occurrence
from structured_text.editor.lookup import word_at
from structured_text.editor.names import Definition
from structured_text.editor.positions import from_editor, location, range_of
from structured_text.editor.resolving import WRITE
from structured_text.editor.texts import document, same_name

__all__ = ["highlights", "references"]


def references(
    index: Index,
    path: Path | str,
    text: str,
    position: lsp.Position,
    *,
    declared: bool = True,
) -> list[lsp.Location] | None:
    """Return the places of the name at a position in all files; None without a known name.

    `declared` includes its declarations. A method includes the methods that override it.
    """
    found = _definition(index, path, text, position)
    if found is None:
        return None
    return [
        location(one.path, index.text(one.path).lines, one.at, len(one.name))
        for one in _written(index, index.uses(index.family(found)))
        if declared or one.role != DECLARATION
    ]


def highlights(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> list[lsp.DocumentHighlight] | None:
    """Return the places of the name at a position in its file; None without a known name."""
    found = _definition(index, path, text, position)
    if found is None:
        return None
    whole = document(text, str(path))
    kinds = {WRITE: lsp.DocumentHighlightKind.Write, DECLARATION: lsp.DocumentHighlightKind.Text}
    return [
        lsp.DocumentHighlight(
            range_of(whole.lines, one.at, len(one.name)),
            kinds.get(one.role, lsp.DocumentHighlightKind.Read),
        )
        for one in index.placed(path, whole)
        if one.definition is found
    ]


def _definition(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> Definition | None:
    whole = document(text, str(path))
    word = word_at(index, path, whole, whole.offset(from_editor(whole.lines, position)))
    return None if word is None else word.definition


def _written(index: Index, found: Iterable[Occurrence]) -> list[Occurrence]:
    """Return the uses that the files have as text; those in drawings have no place."""
    return [one for one in found if same_name(index.text(one.path).name_at(one.at), one.name)]
