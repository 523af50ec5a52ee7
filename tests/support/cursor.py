"""Small projects in Structured Text with a marked cursor, for the tests of the editor."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from lsprotocol import types as lsp

from structured_text.editor.index import Index, build
from structured_text.editor.positions import from_editor, uri_of
from structured_text.language.parser import read_text

__all__ = ["FOLDER", "MARK", "Place", "at_cursor", "edited", "index_of", "marked"]

#: The mark of the cursor in a text.
MARK = "|"
FOLDER = Path("/project")


@dataclass(frozen=True)
class Place:
    """An indexed project, and a cursor in the text of one of its files."""

    index: Index
    path: Path
    text: str
    position: lsp.Position

    @property
    def args(self) -> tuple[Index, Path, str, lsp.Position]:
        """Return the arguments of a feature."""
        return self.index, self.path, self.text, self.position


def index_of(**files: str) -> Index:
    """Return the index of files, by the name of each file without its ending."""
    texts = {FOLDER / f"{name}.st": text for name, text in files.items()}
    return build(list(texts), lambda path: read_text(texts[path], path), _of(texts))


def _of(texts: Mapping[Path, str]) -> Callable[[Path], str]:
    return lambda path: texts[path]


def marked(text: str) -> tuple[str, lsp.Position]:
    """Return a text without its mark, and the position of the mark."""
    before, _, behind = text.partition(MARK)
    line = before.rpartition("\n")[2]
    return before + behind, lsp.Position(before.count("\n"), len(line))


def at_cursor(text: str, typed: str | None = None, **others: str) -> Place:
    """Return the place of the mark in the file `Main`, in a project with further files.

    With `typed`, the project has `text`, and the editor has the newer text `typed` with the mark.
    """
    plain, position = marked(text if typed is None else typed)
    index = index_of(Main=marked(text)[0], **others)
    return Place(index, FOLDER / "Main.st", plain, position)


def edited(index: Index, edit: lsp.WorkspaceEdit, file: str) -> str:
    """Return the text of a file after an edit of a project."""
    text = index.text(file)
    result = text.text
    for one in reversed((edit.changes or {}).get(uri_of(file), [])):
        begin, end = (
            text.offset(from_editor(text.lines, place))
            for place in (one.range.start, one.range.end)
        )
        result = result[:begin] + one.new_text + result[end:]
    return result
