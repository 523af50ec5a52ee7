"""The programs of a workspace: their files, with the texts that the editor shows."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from structured_text.editor.checker import Checker
from structured_text.editor.documents import Documents
from structured_text.editor.index import Index
from structured_text.editor.settings import Settings
from structured_text.errors import InputError
from structured_text.language import cache
from structured_text.language import syntax as s
from structured_text.language.load import read_file
from structured_text.language.parser import read_text
from structured_text.language.source import source_text
from structured_text.output.paths import real
from structured_text.projects.diagrams.sfc.model import has_chart
from structured_text.projects.formats import OBJECTS, PLCPROJ, in_folder, is_project
from structured_text.projects.needed import needed
from structured_text.projects.sources import SourceFiles, not_declared, source_files, st_files

__all__ = ["Find", "Program", "Programs", "find_sources"]

#: A function that finds the sources of a program, and the library files that it needs.
Find = Callable[[Sequence[Path], Settings], SourceFiles]

_ROOT = re.compile(r"^\s*(?:PROGRAM|CONFIGURATION)\s+(\w+)", re.IGNORECASE | re.MULTILINE)


def find_sources(program: Sequence[Path], settings: Settings) -> SourceFiles:
    """Find the sources of a program; only the setting `lib` names a library."""
    lib = Path(settings.lib) if settings.lib else None
    return source_files(program, lib, settings.replace, settings.dialect or None, settings.device)


class Program:
    """A program: its sources, and the checker that keeps what it knows of them."""

    def __init__(
        self, given: Sequence[Path], settings: Settings, find: Find, documents: Documents
    ) -> None:
        self.given, self.settings = list(given), settings
        self._checker = Checker()
        self._index: Index | None = None
        self._checked = -1
        self._find, self._documents = find, documents
        self._found: SourceFiles | None = None
        self._library: list[Path] = []
        self._read: dict[Path, tuple[object, s.Source]] = {}

    def forget(self) -> None:
        """Look for the files again at the next use: files have been added, removed or changed."""
        self._found = None
        self._checked = -1

    def check(self) -> tuple[SourceFiles, list[InputError]]:
        """Return the sources and their errors; raise InputError if no sources are found."""
        self._index, self._checked = None, self._documents.changes
        sources = self.sources()
        return sources, self._checker.check(sources.all, self.read)

    def index(self, *, current: bool = True) -> Index | None:
        """Return the index of names, or None if the sources cannot be read.

        If it need not be current, the index may be that of the text before the last changes.
        """
        if self._checked < 0 or (current and self._checked != self._documents.changes):
            self.check()
        if self._index is None:
            self._index = self._checker.index(self._documents.text)
        return self._index

    def named(self, path: Path) -> Path:
        """Return the path of a file as the sources name it."""
        wanted = real(path)
        every = self._found.all if self._found is not None else []
        return next((Path(str(file)) for file in every if real(file) == wanted), path)

    def sources(self) -> SourceFiles:
        """Return the sources with the texts of open documents, or raise InputError."""
        if self._found is None or any(map(_is_project, self.given)):
            self._found = self._find(self.given, self.settings)
            folder = self._found.folder
            library = st_files(folder) if folder is not None else []
            self._library = not_declared(library, self._found.declared)
        found = self._found
        shown = self._documents.shown
        own = tuple(_without_charts(shown(file)) for file in found.own)
        if own == found.own and not any(file in self._documents for file in found.lib):
            return found
        lib = found.lib
        if found.folder is not None:
            taken = {real(file) for file in found.own}
            parts = [shown(file) for file in self._library if real(file) not in taken]
            lib = tuple(needed(own, parts))
        return replace(found, own=own, lib=lib)

    def read(self, file: Path) -> s.Source:
        """Parse a source; a file is parsed again only if it has changed."""
        if getattr(file, "lines", None) is not None:
            return read_text(source_text(file), file)
        state = cache.file_state(str(file))
        known = self._read.get(file)
        if known is None or known[0] != state:
            known = self._read[file] = state, read_file(file)
        return known[1]


class Programs:
    """The programs of a workspace, by the sources that they are made of."""

    def __init__(self, folders: Sequence[Path], settings: Settings, find: Find) -> None:
        self.folders = [real(folder) for folder in folders]
        self.settings = settings
        self.documents = Documents()
        self._find = find
        self._programs: dict[tuple[Path, ...], Program] = {}
        self._given: dict[Path, tuple[Path, ...]] = {}

    def forget(self) -> None:
        """Look for all files again: files have been added, removed or changed."""
        self._given.clear()
        for program in self._programs.values():
            program.forget()

    def of(self, path: Path) -> Program:
        """Return the program that a document belongs to."""
        path = real(path)
        given = self._given.get(path)
        if given is None:
            given = self._given[path] = tuple(self._sources_of(path))
        if given not in self._programs:
            self._programs[given] = Program(given, self.settings, self._find, self.documents)
        return self._programs[given]

    def _sources_of(self, path: Path) -> list[Path]:
        """Return the files and folders of the program that a document belongs to.

        These are the files of the settings. Without settings, the program of a project file is the
        project around it. The program of another file is the largest folder of the workspace
        around it in which no program is declared twice: a folder with several examples is several
        programs.
        """
        folder = next((one for one in self.folders if one in path.parents), None)
        if self.settings.files:
            return list(map(Path, self.settings.files))
        around = [one for one in path.parents if folder in (one, *one.parents)] if folder else []
        if _is_project(path):
            return _project_of(path, around)
        for one in reversed(around):
            files = st_files(one)
            if path in map(real, files) and not _twice(files):
                return [one]
        return [path]


def _project_of(path: Path, around: Sequence[Path]) -> list[Path]:
    """Return the TwinCAT project that a file belongs to; the file itself if there is none."""
    if path.suffix.lower() not in (PLCPROJ, *OBJECTS):
        return [path]
    for folder in around:
        projects = sorted(one for one in folder.iterdir() if one.suffix.lower() == PLCPROJ)
        if projects:
            return projects
    found = in_folder(file for file in (around or [path.parent])[-1].rglob("*"))
    return found if path in found else [path]


def _twice(files: Iterable[Path]) -> bool:
    """Return whether several files declare a program or configuration of the same name."""
    names = Counter(name for file in files for name in set(_roots(file)))
    return any(number > 1 for number in names.values())


def _roots(file: Path) -> Iterator[str]:
    try:
        text = source_text(file)
    except (InputError, OSError):
        return
    for found in _ROOT.finditer(text):
        yield found[1].upper()


def _is_project(path: Path) -> bool:
    try:
        return is_project(path)
    except InputError:
        return False


def _without_charts(file: Path) -> Path:
    """Return an open document with statements in place of its charts."""
    lines = getattr(file, "lines", None)
    if not lines or not has_chart(source_text(file)):
        return file
    from structured_text.projects.diagrams.sfc.text import with_charts

    return with_charts(file)
