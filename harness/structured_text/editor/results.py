"""The notes of all programs, and the diagnostics that an editor must get after a change."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from lsprotocol import types

from structured_text.editor.diagnostics import Note, diagnostic
from structured_text.editor.documents import Documents
from structured_text.output.paths import real

__all__ = ["Results"]

#: A kind of notes: a program, and what has found the notes.
_Kind = tuple[object, str]


class Results:
    """The notes by program and kind, and what the editor already shows.

    Notes of a slow check remain while the text changes. They move with the text of their line, and
    disappear if this line has changed.
    """

    def __init__(self, documents: Documents, source: str) -> None:
        self._documents, self._source = documents, source
        self._notes: dict[_Kind, dict[Path, list[tuple[Note, str]]]] = {}
        self._shown: dict[Path, list[types.Diagnostic]] = {}

    def put(self, program: object, kind: str, notes: Iterable[Note]) -> None:
        """Replace all notes of a kind."""
        found: dict[Path, list[tuple[Note, str]]] = {}
        texts: dict[Path, list[str]] = {}
        for note in notes:
            file = real(note.file)
            if file not in texts:
                texts[file] = self._documents.text(file).split("\n")
            lines = texts[file]
            line = lines[note.line - 1] if 0 < note.line <= len(lines) else ""
            found.setdefault(file, []).append((note, line))
        self._notes[program, kind] = found

    def add(self, program: object, kind: str, note: Note) -> None:
        """Add a note; it replaces an earlier one with the same file and code."""
        known = self._notes.get((program, kind), {})
        every = [one for notes in known.values() for one, _ in notes]
        same = (real(note.file), note.code)
        others = [one for one in every if (real(one.file), one.code) != same]
        self.put(program, kind, [*others, note])

    def forget(self, program: object, kind: str) -> None:
        """Remove all notes of a kind."""
        self._notes.pop((program, kind), None)

    def changes(self) -> Iterator[tuple[Path, list[types.Diagnostic]]]:
        """Yield each file whose diagnostics differ from those that the editor shows."""
        files = {file for notes in self._notes.values() for file in notes} | self._shown.keys()
        for file in sorted(files):
            now = self._diagnostics(file)
            if now != self._shown.get(file, []):
                yield file, now
            if now:
                self._shown[file] = now
            else:
                self._shown.pop(file, None)

    def _diagnostics(self, file: Path) -> list[types.Diagnostic]:
        lines = self._documents.text(file).split("\n")
        notes = [
            moved
            for (_, kind), found in self._notes.items()
            for note, text in found.get(file, ())
            if (moved := note if kind == "errors" else _moved(note, text, lines)) is not None
        ]
        notes.sort(key=lambda one: (one.line, one.column))
        every = [diagnostic(one, lines, self._source) for one in notes]
        return [one for number, one in enumerate(every) if one not in every[:number]]


def _moved(note: Note, text: str, lines: Sequence[str]) -> Note | None:
    """Return a note at the present line of its text; None if the line does not exist any more."""
    if 0 < note.line <= len(lines) and lines[note.line - 1] == text:
        return note
    places = [number for number, line in enumerate(lines, 1) if line == text]
    if not places:
        return None
    return replace(note, line=min(places, key=lambda number: abs(number - note.line)))
