"""The sources of a program: the user's files, and those of the library that they need."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from structured_text.errors import COMMAND, InputError
from structured_text.output.exported import RECORD, own_output, resolved
from structured_text.output.paths import real
from structured_text.output.reading import check_file
from structured_text.projects.formats import in_folder, is_project
from structured_text.projects.needed import declared_names, needed

__all__ = ["INSTEAD", "Files", "SourceFiles", "check_library", "named_files", "not_declared"]
__all__ += ["source_files", "st_files"]

#: One file or folder, or several.
Files = str | Path | Sequence[str | Path]
#: Files that are read instead of others, which are resolved: copies with a mistake in them
#: (`mutants`).
INSTEAD: dict[Path, Path] = {}

#: Folders of other tools, besides hidden ones: the ST files in them are not the user's.
_FOREIGN = ("__pycache__", "site-packages")

#: Folders that were looked into: which it was and when changed, the files in it and the folders.
_NAMES: dict[str, tuple[tuple[int, ...], tuple[list[str], list[str]]]] = {}
#: The coarsest clock of a file system, that of FAT [ns].
_SETTLED_NS = 2_000_000_000

#: A file, its time of change [ns] and its size.
_Stamp = tuple[str, int, int]


@dataclass(frozen=True)
class SourceFiles:
    """The sources of a program: the user's own and those of the library.

    Attributes:
        own: ST files, and what was taken out of project files.
        lib: Those files of the library that they need.
        folder: Of the library; None: there is none.
        notes: What of a project is not read, a line each.
        declared: Names that projects declare, in upper case: not taken from the library.
    """

    own: tuple[Path, ...]
    lib: tuple[Path, ...]
    folder: Path | None
    notes: tuple[str, ...] = ()
    declared: frozenset[str] = frozenset()

    @property
    def all(self) -> list[Path]:
        """The user's first, so that of several errors one of theirs is told."""
        return [*self.own, *self.lib]

    @property
    def users(self) -> tuple[list[Path], list[Path]]:
        """The user's files, and those of the library, also where they are named one by one."""
        folder = real(self.folder) if self.folder is not None else None
        named = {file for file in self.own if folder in real(file).parents}
        return [file for file in self.own if file not in named], [*named, *self.lib]


def source_files(
    program: Files,
    library: Path | None,
    replace: Mapping[str, str | Path] | None = None,
) -> SourceFiles:
    """Find the files of a program, and those of the library that it needs.

    Args:
        program: Files, also of projects, or folders whose `.st` files are
            taken, see `st_files`, or where there are none, whose TwinCAT project.
        library: Its folder, searched with its subfolders; None: there is none. What a project
            declares itself is not taken from it.
        replace: Files with Structured Text for POUs of a project, by name.

    Raises:
        InputError: a file or folder that is missing, a folder without sources, or a project that
            cannot be read.
    """
    named = named_files(program)
    projects = [file for file in named if is_project(file)]
    if replace and not projects:
        raise InputError(
            "--replace is for projects of PLC tools, and none is given",
            hint="change the .st file itself",
        )
    own = [file for file in named if file not in projects]
    declared: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    if projects:
        from structured_text.projects.open import project_sources

        instead = {name: Path(file) for name, file in (replace or {}).items()}
        made = project_sources(projects, instead)
        own, declared, notes = [*own, *made.paths], made.declared, made.notes
    if library is not None:
        check_library(library)
    taken = frozenset(real(file) for file in own)
    own = list(dict.fromkeys(own))
    if INSTEAD:
        own = [INSTEAD.get(real(file), file) for file in own]
    seen = tuple(next(_stamped(os.fspath(file)), None) for file in own)
    parts: tuple[Path, ...] = ()
    if library is not None:
        parts = _needed(tuple(own), seen, _Folder.of(library), taken, declared)
    return SourceFiles(tuple(own), parts, library, notes, declared)


def check_library(folder: Path) -> None:
    """Raise InputError if the folder of a library is no folder."""
    if not folder.is_dir():
        raise InputError(
            f"--lib {folder} is no folder",
            hint="it is the folder of the library; without --lib that of this package is taken",
        )


@lru_cache(maxsize=64)
def _needed(
    own: tuple[Path, ...],
    seen: tuple[_Stamp | None, ...],
    library: _Folder,
    taken: frozenset[Path],
    declared: frozenset[str],
) -> tuple[Path, ...]:
    """Files of a library that `own` need; looked at again where one of all has changed."""
    del seen
    found = [file for file, place in library.files() if place not in taken]
    return tuple(needed(own, not_declared(found, declared)))


def named_files(program: Files) -> list[Path]:
    """The files that are named, and those of the folders that are.

    Raises:
        InputError: a file or folder that is missing, or a folder without sources.
    """
    given = [program] if isinstance(program, (str, Path)) else list(program)
    if not given:
        raise InputError("no program is given")
    return list(dict.fromkeys(file for entry in given for file in _expand(Path(entry))))


def not_declared(library: Sequence[Path], declared: frozenset[str]) -> list[Path]:
    """Files of the library without those whose names a project declares itself."""
    if not declared:
        return list(library)
    return [file for file in library if not declared_names(file) & declared]


def st_files(folder: Path) -> list[Path]:
    """The ST files of a folder and of those below it, sorted.

    Hidden files and folders (`.venv`, `.git`), `site-packages` and `__pycache__` below it are
    left out; the folder itself may be in one. So is what an export has written.
    """
    return [file for file, _ in _Folder.of(folder).files()]


class _Folder(NamedTuple):
    """A folder as it is now: `place` tells one working directory from another."""

    place: str
    stamps: tuple[_Stamp, ...]

    @classmethod
    def of(cls, folder: Path) -> _Folder:
        place = real(folder)
        above = [one for parent in place.parents for one in _stamped(f"{parent}{os.sep}{RECORD}")]
        return cls(os.fspath(place), (*above, *_listed(os.fspath(folder))))

    def files(self) -> tuple[tuple[Path, Path], ...]:
        """The user's ST files, each with its resolved path."""
        return _looked_at(self)


@lru_cache(maxsize=64)
def _looked_at(folder: _Folder) -> tuple[tuple[Path, Path], ...]:
    """See `_Folder.files`; looked at again where a file has changed."""
    every = [Path(path) for path, _, _ in folder.stamps if not path.endswith(RECORD)]
    every.sort(key=lambda file: file.parts)  # as on Linux also where case is nothing
    places = resolved(every)
    written = own_output(places)
    return tuple((file, place) for file, place in places.items() if file not in written)


def _listed(folder: str) -> list[_Stamp]:
    """What is to be looked at in a folder and those below it: ST files, and what exports record.

    A file that cannot be looked at has the time 0.
    """
    found: list[_Stamp] = []
    with suppress(PermissionError):
        files, folders = _names(folder)
        for path in files:
            try:
                seen = os.stat(path)
            except OSError:
                found.append((path, 0, 0))
            else:
                found.append((path, seen.st_mtime_ns, seen.st_size))
        for path in folders:
            found += _listed(path)
    return found


def _names(folder: str) -> tuple[list[str], list[str]]:
    """Paths of the files in a folder that `_listed` looks at, and of the folders.

    They are known from before while it is the same folder with the times that it had then, and
    had had for long enough that whatever comes later gives it others.
    """
    seen = os.stat(folder)
    times = seen.st_mtime_ns, seen.st_ctime_ns
    same = seen.st_dev, seen.st_ino, *times
    known = _NAMES.get(folder)
    if known and known[0] == same:
        return known[1]
    files, folders = found = list[str](), list[str]()
    with os.scandir(folder) as entries:
        for entry in entries:
            name = entry.name
            if name.startswith(".") or name in _FOREIGN:
                continue
            if entry.is_dir(follow_symlinks=False):
                folders.append(entry.path)
            elif name == RECORD or os.path.normcase(name).endswith(".st"):
                files.append(entry.path)
    if max(times) < time.time_ns() - _SETTLED_NS:
        _NAMES[folder] = same, found
    return found


def _stamped(path: str) -> Iterator[_Stamp]:
    """A file that is there, with its time and size."""
    with suppress(OSError):
        seen = os.stat(path)
        yield path, seen.st_mtime_ns, seen.st_size


def _is_users(file: Path, folder: Path) -> bool:
    """Is this file below the folder one of the user's, and not of another tool?"""
    parts = file.relative_to(folder).parts
    return not any(part.startswith(".") or part in _FOREIGN for part in parts)


def _expand(path: Path) -> list[Path]:
    if path.is_dir():
        found = st_files(path) or _project_in(path)
        if not found:
            written = any(path.rglob("*.st"))
            hint = (
                f"one that `{COMMAND} export` has written is taken if you name the file"
                if written
                else ""
            )
            raise InputError("no .st files in this folder", file=path, hint=hint)
        return found
    if not os.path.lexists(path):
        raise InputError("no such file", file=path)
    check_file(path)
    return [path]


def _project_in(folder: Path) -> list[Path]:
    """A TwinCAT project in a folder; one that an export has written only in its own folder."""
    found = in_folder(file for file in folder.rglob("*") if _is_users(file, folder))
    written = own_output(resolved(found))
    whole = (folder / RECORD).is_file()
    return [file for file in found if whole or file not in written]
