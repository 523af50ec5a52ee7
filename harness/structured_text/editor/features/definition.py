"""Go to the definition of a name, to the type of a variable, and to implementations."""

from __future__ import annotations

from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import DECLARATION, Index
from structured_text.editor.lookup import Word, word_at
from structured_text.editor.names import Definition, spec_name
from structured_text.editor.positions import from_editor, location
from structured_text.editor.texts import document, same_name

__all__ = ["definition", "implementations", "place_of", "type_definition"]


def definition(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> lsp.Location | None:
    """Return the declaration of the name at a position; None if it has none in the sources.

    At the declaration of a variable itself, it is the declaration of the variable's type, so that
    a second step leads from an instance to its block.
    """
    word = _word(index, path, text, position)
    if word is None or word.definition is None:
        return None
    found = word.definition
    if word.occurrence is not None and word.occurrence.role == DECLARATION:
        found = _type(index, found) or found
    return place_of(index, found)


def type_definition(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> lsp.Location | None:
    """Return the declaration of the type or block of the variable at a position, or None."""
    word = _word(index, path, text, position)
    found = None if word is None or word.definition is None else _type(index, word.definition)
    return None if found is None else place_of(index, found)


def implementations(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> list[lsp.Location]:
    """Return the blocks of an interface, or the methods that implement or override a method."""
    word = _word(index, path, text, position)
    if word is None or word.definition is None:
        return []
    found = word.definition
    if found.kind in ("interface", "function_block"):
        others = [
            one
            for one in index.names.all()
            if one.kind == "function_block" and found.key in index.names.lineage(one.key)[1:]
        ]
    else:
        others = [one for one in index.family(found) if one is not found]
    return [place_of(index, one) for one in others]


def place_of(index: Index, found: Definition) -> lsp.Location:
    """Return the place of a declared name; for a name in the XML around the text, its line."""
    text = index.text(found.file)
    at = found.at
    if not same_name(text.name_at(at), found.name) and 0 < at.line <= len(text.lines):
        at = at._replace(column=text.lines[at.line - 1].find(found.name) + 1 or 1)
    return location(found.file, text.lines, at, len(found.name))


def _word(index: Index, path: Path | str, text: str, position: lsp.Position) -> Word | None:
    whole = document(text, str(path))
    return word_at(index, path, whole, whole.offset(from_editor(whole.lines, position)))


def _type(index: Index, found: Definition) -> Definition | None:
    """Return the declaration of the type of a variable, field, property or function."""
    node = found.node
    spec = getattr(node, "spec", None) or getattr(node, "result", None)
    if found.kind == "instance":
        return index.names.get(node.program.key)
    if found.kind in ("member", "structure", "enumeration"):
        return None
    return index.names.get(spec_name(spec)) if spec is not None else None
