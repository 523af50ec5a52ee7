"""Rename a name in all files.

A rename must not change what the program does. So a new name is refused if another name would hide
it, or would be hidden by it, anywhere where the old name is used.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Collection, Iterable, Iterator
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import Index, Occurrence
from structured_text.editor.lookup import Word, word_at
from structured_text.editor.names import Definition
from structured_text.editor.positions import from_editor, range_of, span, uri_of
from structured_text.editor.structure import tokens_of
from structured_text.editor.texts import Text, document, same_name
from structured_text.errors import InputError
from structured_text.language.lexer import KEYWORDS
from structured_text.language.standard import reserved
from structured_text.projects.formats import OBJECTS

__all__ = ["prepare", "rename"]

_NAME = re.compile(r"[^\W\d]\w*")
#: Names that bodies see without a path, besides those of their own POU.
_OPEN = ("function", "function_block", "program", "interface", "structure", "enumeration", "type")
_HEADS = ("ACTION", "METHOD", "PROPERTY")
_LOCAL = ("variable", "method", "action", "property")


def prepare(index: Index, path: Path | str, text: str, position: lsp.Position) -> lsp.Range | None:
    """Return the range of the name at a position that can be renamed; None without one."""
    whole, word = _at(index, path, text, position)
    if word is None or word.definition is None:
        return None
    return span(whole.lines, whole.at(word.begin), whole.at(word.end))


def rename(
    index: Index,
    path: Path | str,
    text: str,
    position: lsp.Position,
    name: str,
    library: Collection[Path] = (),
) -> lsp.WorkspaceEdit:
    """Return the edits of all files that give the name at a position another name.

    The index must be that of the current texts. `library` has files that are not changed.

    Raises:
        InputError: The name is not declared in the sources or in a file that cannot be changed, or
            the new name is not a name, is reserved, or clashes with another name.
    """
    _, word = _at(index, path, text, position)
    if word is None:
        raise InputError("there is no name here", hint="put the cursor on a name")
    if word.definition is None:
        raise InputError(f"{word.name} is not declared in these sources")
    found = word.definition
    family = index.family(found)
    _check_name(name)
    for one in family:
        _check_definition(index, one)
    uses = index.uses(family)
    _check_files(found, uses, library)
    _check_unknown(index, found)
    if not same_name(name, found.name):
        for one in family:
            for other in _clashes(index, one, name.upper(), uses):
                _refuse_clash(name, other)
    return lsp.WorkspaceEdit(dict(_edits(index, found, uses, name)))


def _at(
    index: Index, path: Path | str, text: str, position: lsp.Position
) -> tuple[Text, Word | None]:
    whole = document(text, str(path))
    return whole, word_at(index, path, whole, whole.offset(from_editor(whole.lines, position)))


# --- checks ---


def _check_name(name: str) -> None:
    if not _NAME.fullmatch(name):
        hint = "use letters, digits and _, and begin with a letter"
        raise InputError(f"{name!r} is not a name", hint=hint)
    if name.upper() in KEYWORDS or reserved(name.upper()):
        hint = "choose another name"
        raise InputError(f"{name} is a word of the language or its standard", hint=hint)


def _check_definition(index: Index, found: Definition) -> None:
    if found.key.partition(".")[0] in index.outside.registry.overloads:
        text = f"several functions are called {found.key.partition('.')[0]}"
        raise InputError(text, hint="rename them by hand")
    suffix = Path(found.file).suffix.lower()
    if found.kind == "list":
        text = f"the list of global variables {found.name} is named after its file"
        raise InputError(text, hint="rename the file")
    if suffix in OBJECTS and "." not in found.key:
        text = f"the file of {found.name} has the same name, which the project mentions"
        raise InputError(text, file=found.path, hint="rename it in TwinCAT")


def _check_files(found: Definition, uses: Iterable[Occurrence], library: Collection[Path]) -> None:
    fixed = {str(one) for one in library}
    for one in uses:
        if one.path in fixed:
            text = f"{found.name} is used in the library"
            if found.file == one.path:
                text = f"{found.name} is declared in the library"
            hint = "the library is not changed"
            raise InputError(text, file=one.path, line=one.at.line, hint=hint)
        if _is_read_only(one.path):
            text = f"{found.name} is used in a file that cannot be written"
            raise InputError(text, file=one.path, line=one.at.line, hint="make the file writable")


def _check_unknown(index: Index, found: Definition) -> None:
    """Raise InputError if a file with mistakes has the name at a place with an unknown meaning."""
    for path in {error.file for error in index.errors if error.file in index.files}:
        text = index.text(str(path))
        if found.name.upper() not in text.words:
            continue
        known = {one.at for one in index.occurrences(str(path))}
        before = ""
        for token in tokens_of(text):
            at = text.at(token.begin)
            # Without a path, a name behind a dot is another one. A head declares its name.
            other = before in _HEADS or (before == "." and _is_local(found))
            if not other and at not in known and same_name(token.text, found.name):
                raise InputError(
                    f"because of mistakes in the sources, the meaning of {token.text} is not known",
                    file=path,
                    line=at.line,
                    column=at.column,
                    hint="correct the mistakes first",
                )
            before = token.word


def _is_local(found: Definition) -> bool:
    section = found.section.kind if found.section is not None else ""
    return section in ("VAR", "VAR_TEMP", "VAR_STAT", "VAR_INST", "VAR_EXTERNAL")


def _is_read_only(path: str) -> bool:
    """Return whether a file has no right to write for anybody."""
    try:
        return not os.stat(path).st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH)
    except OSError:
        return False  # a text that has not been saved yet


def _refuse_clash(name: str, other: Definition) -> None:
    raise InputError(
        f"{name} is already declared there, or would be mixed up with the {other.kind}",
        file=other.path,
        line=other.at.line,
        column=other.at.column,
        hint="choose another name",
    )


def _clashes(
    index: Index, found: Definition, key: str, uses: Iterable[Occurrence]
) -> Iterator[Definition]:
    """Yield declarations of the new name that a declaration with this name would clash with."""
    names = index.names
    same = [one for one in names.all() if one.name.upper() == key]
    if not same:
        return
    owner = found.owner
    kin = {owner, *names.lineage(owner)}
    kin |= {one.key for one in names.all() if one.kind in _OPEN and owner in names.lineage(one.key)}
    files = {one.path for one in uses}
    for other in same:
        around = other.owner
        outside = "." not in other.key or other.key.startswith("@") or other.kind == "member"
        if around and around in kin:
            yield other
        elif found.kind == "field":
            continue
        elif outside:
            yield other
        elif _is_open(found) and other.kind in _LOCAL and other.file in files:
            yield other  # the local name would hide the new name
        elif other.kind in _LOCAL and _is_around(around, kin):
            yield other  # a variable of a method and one of its block


def _is_open(found: Definition) -> bool:
    """Return whether bodies of other POUs can use a name without a path."""
    return found.kind in (*_OPEN, "member") or found.key.startswith("@")


def _is_around(around: str, kin: Collection[str]) -> bool:
    """Return whether a declaration is inside one of some declarations, or one is inside of it."""
    return any(around.startswith(f"{one}.") or one.startswith(f"{around}.") for one in kin)


# --- edits ---


def _edits(
    index: Index, found: Definition, uses: Iterable[Occurrence], name: str
) -> Iterator[tuple[str, list[lsp.TextEdit]]]:
    """Yield the URI of each file and its edits."""
    edits: dict[str, list[lsp.TextEdit]] = {}
    for one in uses:
        text = index.text(one.path)
        if same_name(text.name_at(one.at), one.name):
            where = range_of(text.lines, one.at, len(text.name_at(one.at)))
            edits.setdefault(one.path, []).append(lsp.TextEdit(where, name))
        elif found.kind != "action":
            raise InputError(
                f"{found.name} is used in a part of the file that is not text",
                file=one.path,
                line=one.at.line,
                hint="rename it in the tool of the project",
            )
    for path in {one.path for one in uses}:
        if Path(path).suffix.lower() in OBJECTS and found.kind in _LOCAL[1:]:
            edits.setdefault(path, []).extend(_attributes(index.text(path), found.name, name))
    for path, changes in edits.items():
        changes.sort(key=lambda edit: (edit.range.start.line, edit.range.start.character))
        yield uri_of(path), changes


def _attributes(text: Text, old: str, name: str) -> Iterator[lsp.TextEdit]:
    """Yield the edits of the XML of TwinCAT, in which methods and actions have their names."""
    tags = rf"<(?:Method|Property|Action)\s[^>]*?\bName=\"({re.escape(old)})\""
    lines = rf"<LineIds\s+Name=\"\w+\.({re.escape(old)})(?=[\".])"
    for pattern in (tags, lines):
        for match in re.finditer(pattern, text.text):
            where = span(text.lines, text.at(match.start(1)), text.at(match.end(1)))
            yield lsp.TextEdit(where, name)
