"""The documents that an editor shows: their texts replace the contents of the files."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language.source import Extract, Line, source_text
from structured_text.output.limits import PROJECT
from structured_text.output.paths import real
from structured_text.output.reading import SHOWN, file_bytes, text_of
from structured_text.projects.formats import is_project

__all__ = ["Documents"]


class Documents:
    """The open documents, by their resolved paths.

    Attributes:
        changes: The number of changes so far.
    """

    def __init__(self) -> None:
        self.changes = 0
        self._texts: dict[Path, str] = {}
        self._uris: dict[Path, str] = {}
        self._shown: dict[tuple[Path, str], Path] = {}

    def put(self, path: Path, uri: str, text: str) -> None:
        """Take over the text of a document."""
        key = real(path)
        self.changes += 1
        text = text.replace("\r\n", "\n").replace("\r", "\n")
        self._texts[key], self._uris[key] = text, uri
        self._shown = {one: shown for one, shown in self._shown.items() if one[0] != key}
        if _is_project(path):
            SHOWN[key] = text.encode()

    def drop(self, path: Path) -> None:
        """Forget a document that the editor has closed."""
        key = real(path)
        self.changes += 1
        self._texts.pop(key, None)
        SHOWN.pop(key, None)

    def __contains__(self, path: Path) -> bool:
        """Return whether a file is open in the editor."""
        return real(path) in self._texts

    @property
    def paths(self) -> list[Path]:
        """Return the paths of the open documents."""
        return list(self._texts)

    def uri(self, path: Path) -> str:
        """Return the name of a file in messages to the editor, as the editor has written it."""
        key = real(path)
        return self._uris.get(key) or key.as_uri()

    def text(self, path: Path) -> str:
        """Return the text of a file as the editor shows it, or of the file; empty if unreadable."""
        key = real(path)
        if key in self._texts:
            return self._texts[key]
        with suppress(InputError):
            if _is_project(path):
                return text_of(file_bytes(key, PROJECT), key)
            return source_text(key)
        return ""

    def shown(self, file: Path) -> Path:
        """Return a source with the text that the editor shows; a closed file as it is.

        Extracts of project files are returned unchanged: they are made of the shown text already.
        """
        if not self._texts or getattr(file, "lines", None) is not None:
            return file
        if file.name not in {key.name for key in self._texts}:
            return file  # the paths of a large project are not resolved again for each change
        key = real(file)
        text = self._texts.get(key)
        if text is None:
            return file
        dialect: str = getattr(file, "dialect", "")
        name = key, dialect
        if name not in self._shown:
            lines = text.split("\n")
            if lines[-1] == "":
                del lines[-1]
            made = tuple(Line(line, at) for at, line in enumerate(lines, 1))
            self._shown[name] = Extract.make(Path(os.fspath(file)), made, dialect=dialect)
        return self._shown[name]


def _is_project(path: Path) -> bool:
    try:
        return is_project(path)
    except InputError:
        return False
