"""The sources of a program: the user's files, and the library files that they need.

Files can change between two calls in the same process. Therefore each call lists the folders and
checks times of change. The lists and the selection of library files are cached by these times.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from structured_text.errors import InputError
from structured_text.language.dialects import chosen, dialect_of, rules_of
from structured_text.language.source import in_dialect, source_text
from structured_text.output.exported import RECORD, own_output, resolved
from structured_text.output.paths import real
from structured_text.output.reading import check_file
from structured_text.projects.diagrams.sfc.model import has_chart
from structured_text.projects.formats import in_folder, is_project
from structured_text.projects.model import Library
from structured_text.projects.needed import declared_names, needed

__all__ = [
    "INSTEAD",
    "Files",
    "SourceFiles",
    "check_library",
    "is_ax",
    "named_files",
    "not_declared",
    "source_files",
    "st_files",
]

#: One or several files or folders.
Files = str | Path | Sequence[str | Path]
#: Maps the resolved path of a file to another file that is read in its place, such as a mutant.
INSTEAD: dict[Path, Path] = {}

#: Folders of other tools, in addition to hidden folders. ST files in them do not belong to the
#: user.
_FOREIGN = ("__pycache__", "site-packages")

#: Cached lists of folders, by path: identity and times of a folder, and the files and folders in
#: it.
_NAMES: dict[str, tuple[tuple[int, ...], tuple[list[str], list[str]]]] = {}
#: Endings of sources. All but the first belong to Automation Studio.
_ENDINGS = (".st", ".var", ".typ", ".fun")
#: Resolution of the coarsest file system clock, that of FAT [ns].
_SETTLED_NS = 2_000_000_000

#: The file at the root of a SIMATIC AX project, and the number of folders that it may be above a
#: source.
_AX, _LEVELS = "apax.yml", 4

#: A file, its time of change [ns] and its size [bytes].
_Stamp = tuple[str, int, int]


@dataclass(frozen=True)
class SourceFiles:
    """The sources of a program: the user's own files and those of the library.

    Attributes:
        own: The user's ST files, and the extracts of the user's project files.
        lib: The files of the library that the own files need.
        folder: The folder of the library; None if there is none.
        notes: One line for each part of a project that is not read.
        declared: Names that the user's projects declare, in upper case. They are not taken from the
            library.
        missing: Libraries that the user's projects refer to, and that the user has not named.
    """

    own: tuple[Path, ...]
    lib: tuple[Path, ...]
    folder: Path | None
    notes: tuple[str, ...] = ()
    declared: frozenset[str] = frozenset()
    missing: tuple[Library, ...] = ()

    @property
    def all(self) -> list[Path]:
        """Return all files, the user's first, so that their errors are reported first."""
        return [*self.own, *self.lib]

    @property
    def dialect(self) -> str:
        """Return the dialect of the program (`language.dialects`)."""
        return dialect_of(self.own)

    @property
    def users(self) -> tuple[list[Path], list[Path]]:
        """Return the user's own files and the library's files.

        A file in the library's folder belongs to the library, even if the user has named it.
        """
        folder = real(self.folder) if self.folder is not None else None
        named = {file for file in self.own if folder in real(file).parents}
        return [file for file in self.own if file not in named], [*named, *self.lib]


def source_files(
    program: Files,
    library: Path | None,
    replace: Mapping[str, str | Path] | None = None,
    dialect: str | None = None,
    device: str = "",
) -> SourceFiles:
    """Find the files of a program, and the library files that it needs.

    Raise InputError if a file or folder is missing, a folder has no sources, or a project cannot be
    read. For a folder, the `.st` files are read (see `st_files`), or else its TwinCAT project. The
    library is searched with its subfolders; names that a project declares are not taken from it.
    `replace` has files with Structured Text for POUs of a project, by name. `dialect` is a name of
    `language.dialects`; without it, the format of a project decides. `device` names the device to
    read in a project with several devices.
    """
    named = named_files(program)
    projects = [file for file in named if is_project(file)]
    if replace and not projects:
        raise InputError(
            "--replace is for projects of PLC tools, and none is given",
            hint="change the .st file itself",
        )
    if device and not projects:
        raise InputError("--device is for projects of PLC tools, and none is given")
    own = [file for file in named if file not in projects]
    declared: frozenset[str] = frozenset()
    notes: tuple[str, ...] = ()
    said: tuple[tuple[str, Path], ...] = ()
    missing: tuple[Library, ...] = ()
    if projects:
        from structured_text.projects.open import project_sources

        instead = {name: Path(file) for name, file in (replace or {}).items()}
        made = project_sources(projects, instead, device)
        own, declared, notes = [*own, *made.paths], made.declared, made.notes
        said = made.dialects
        missing = made.libraries
    if library is not None:
        check_library(library)
    taken = frozenset(real(file) for file in own)
    own = list(dict.fromkeys(own))
    if INSTEAD:
        own = [INSTEAD.get(real(file), file) for file in own]
    spoken = _dialect(dialect, said, own)
    # matiec, with which OpenPLC and Beremiz compile, has no final scan of actions.
    own = [_plain(file, next(_stamped(os.fspath(file)), None), spoken != "openplc") for file in own]
    if spoken:
        own = [in_dialect(file, spoken) for file in own]
    seen = tuple(next(_stamped(os.fspath(file)), None) for file in own)
    parts: tuple[Path, ...] = ()
    if library is not None:
        parts = _needed(tuple(own), seen, _Folder.of(library), taken, declared)
    return SourceFiles(tuple(own), parts, library, notes, declared, missing)


@lru_cache(maxsize=256)
def _plain(file: Path, seen: _Stamp | None, final_scan: bool) -> Path:
    """Return a source without charts: their translation is in their place.

    The result is cached by the time of change. A file that cannot be read is reported later.
    """
    del seen
    try:
        text = source_text(file)
    except (InputError, OSError):
        return file
    if not has_chart(text):
        return file
    # Imported here because the reader of charts needs lark, which other programs do not need.
    from structured_text.projects.diagrams.sfc.text import with_charts

    return with_charts(file, final_scan=final_scan)


def _dialect(given: str | None, said: Sequence[tuple[str, Path]], own: Sequence[Path]) -> str:
    """Return the dialect of a program, or raise InputError.

    The user's choice comes first, then the formats of the project's files, then the `apax.yml` of
    SIMATIC AX. The result is empty if none of them gives a dialect.
    """
    if found := rules_of(given).name if given else chosen():
        return found
    tools: dict[str, Path] = {}
    for name, file in said:
        tools.setdefault(name, file)
    if len(tools) > 1:
        (name, file), (other, second), *_ = sorted(tools.items())
        raise InputError(
            f"the files are of two tools: {file} of {name}, {second} of {other}",
            hint=f"choose the tool whose behaviour the program gets: --dialect {name} or {other}",
        )
    if not tools and is_ax(own):
        return "ax"
    return next(iter(tools), "")


def is_ax(files: Iterable[Path]) -> bool:
    """Return whether a file is in a project of SIMATIC AX."""
    folders = {real(file).parent for file in files}
    places = {above for one in folders for above in (one, *one.parents[:_LEVELS])}
    return any((place / _AX).is_file() for place in places)


def check_library(folder: Path) -> None:
    """Raise InputError if the path of a library is not a folder."""
    if not folder.is_dir():
        raise InputError(
            f"--lib {folder} is not a folder",
            hint="name a folder, or leave out --lib to use the library in this package",
        )


@lru_cache(maxsize=64)
def _needed(
    own: tuple[Path, ...],
    seen: tuple[_Stamp | None, ...],
    library: _Folder,
    taken: frozenset[Path],
    declared: frozenset[str],
) -> tuple[Path, ...]:
    """Return the library files that `own` needs.

    The result is cached; `seen` and `library` are part of the cache key.
    """
    del seen
    found = [file for file, place in library.files() if place not in taken]
    return tuple(needed(own, not_declared(found, declared)))


def named_files(program: Files) -> list[Path]:
    """Return the named files, and the source files of the named folders, or raise InputError."""
    given = [program] if isinstance(program, (str, Path)) else list(program)
    if not given:
        raise InputError("no program is given")
    return list(dict.fromkeys(file for entry in given for file in _expand(Path(entry))))


def not_declared(library: Sequence[Path], declared: frozenset[str]) -> list[Path]:
    """Return the library files that declare none of the project's names."""
    if not declared:
        return list(library)
    return [file for file in library if not declared_names(file) & declared]


def st_files(folder: Path) -> list[Path]:
    """Return the ST files of a folder and its subfolders, sorted.

    Hidden files and folders (`.venv`, `.git`), `site-packages` and `__pycache__` inside the folder
    are omitted. Files that an export has written are omitted, too.
    """
    return [file for file, _ in _Folder.of(folder).files()]


class _Folder(NamedTuple):
    """The present content of a folder, used as a cache key.

    The key includes `place`, the resolved path, because relative paths depend on the working
    directory.
    """

    place: str
    stamps: tuple[_Stamp, ...]

    @classmethod
    def of(cls, folder: Path) -> _Folder:
        place = real(folder)
        above = [one for parent in place.parents for one in _stamped(f"{parent}{os.sep}{RECORD}")]
        return cls(os.fspath(place), (*above, *_listed(os.fspath(folder))))

    def files(self) -> tuple[tuple[Path, Path], ...]:
        """Return the user's ST files, each with its resolved path."""
        return _looked_at(self)


@lru_cache(maxsize=64)
def _looked_at(folder: _Folder) -> tuple[tuple[Path, Path], ...]:
    """Return the user's ST files in a folder, each with its resolved path.

    The result is cached until the content of the folder changes.
    """
    every = [Path(path) for path, _, _ in folder.stamps if not path.endswith(RECORD)]
    # The search is case-sensitive on all systems, as on Linux.
    every.sort(key=lambda file: file.parts)
    places = resolved(every)
    written = own_output(places)
    return tuple((file, place) for file, place in places.items() if file not in written)


def _listed(folder: str) -> list[_Stamp]:
    """Return the stamps of ST files and export records in a folder and its subfolders.

    A file without access has the time 0.
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
    """Return the paths of ST files and export records in a folder, and the paths of its subfolders.

    The paths are cached as long as the folder and its times are unchanged. A recently changed
    folder is not cached: because of the clock's resolution, a further change might not change its
    times.
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
            elif name == RECORD or os.path.normcase(name).endswith(_ENDINGS):
                files.append(entry.path)
    if max(times) < time.time_ns() - _SETTLED_NS:
        _NAMES[folder] = same, found
    return found


def _stamped(path: str) -> Iterator[_Stamp]:
    """Yield the stamp of a file; nothing if it does not exist."""
    with suppress(OSError):
        seen = os.stat(path)
        yield path, seen.st_mtime_ns, seen.st_size


def _is_users(file: Path, folder: Path) -> bool:
    """Return whether a file inside a folder belongs to the user, and not to another tool."""
    parts = file.relative_to(folder).parts
    return not any(part.startswith(".") or part in _FOREIGN for part in parts)


def _expand(path: Path) -> list[Path]:
    if path.is_dir():
        found = st_files(path) or _project_in(path)
        if not found:
            if any(path.rglob("*.st")):
                raise InputError(
                    "contains exported .st files only", file=path, hint="name a file to use it"
                )
            raise InputError("contains no .st file", file=path)
        return found
    if not os.path.lexists(path):
        raise InputError("no such file", file=path)
    check_file(path)
    return [path]


def _project_in(folder: Path) -> list[Path]:
    """Return the files of a TwinCAT project in a folder.

    Files that an export has written are included only if the user names the folder of the export.
    """
    found = in_folder(file for file in folder.rglob("*") if _is_users(file, folder))
    written = own_output(resolved(found))
    whole = (folder / RECORD).is_file()
    return [file for file in found if whole or file not in written]
