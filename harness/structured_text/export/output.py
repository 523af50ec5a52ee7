"""What an export consists of, and how it comes onto the disk without harm to what is there."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.output.exported import MARK, RECORD, digest, is_marked, record, recorded
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["Missing", "Output", "Written", "write", "write_export"]


@dataclass(frozen=True)
class Missing:
    """A declaration that a target does not carry, or not all of it.

    Attributes:
        what: Its kind and name.
        why: What is missing, or what to do instead.
        file: Where it is declared.
        line: Line in that file.
        replaced: It is the library's, and other blocks of the library stand for it.
    """

    what: str
    why: str
    file: Path
    line: int
    replaced: bool = False

    def __str__(self) -> str:
        return f"{self.file}:{self.line}: {self.what}: {self.why}"


@dataclass(frozen=True)
class Output:
    """The result of an exporter.

    Attributes:
        files: Text by path: one with the path `""` for a single file, else below a folder.
        missing: What the target does not carry.
        newline: How the target's tools end a line.
        inputs: What it was made from; never written over.
        notes: What to know of it besides, one line each.
        recorded: A folder of it gets a record, by which a later export knows its own files.
        mark: Stands at the head of each of its files that has no record, by which it is known.
    """

    files: dict[str, str]
    missing: tuple[Missing, ...] = ()
    newline: str = "\n"
    inputs: frozenset[Path] = frozenset()
    notes: tuple[str, ...] = ()
    recorded: bool = False
    mark: str = MARK

    @property
    def left_out(self) -> tuple[str, ...]:
        """What is missing and why, without the places."""
        return tuple(f"{one.what}: {one.why}" for one in self.missing)


@dataclass(frozen=True)
class Written:
    """What writing an export has done.

    Attributes:
        files: The files written, without the record of them.
        removed: Files of an earlier export that this one no longer has.
        kept: Those of them that have been changed since.
    """

    files: list[Path]
    removed: list[Path]
    kept: list[Path]


def write(output: Output, place: Path, *, force: bool = False) -> list[Path]:
    """The files that `write_export` has written."""
    return write_export(output, place, force=force).files


def write_export(output: Output, place: Path, *, force: bool = False) -> Written:
    """Write an export to a file, or to a folder that is made where it is missing.

    Args:
        output: What to write.
        place: The file; or the folder, where the export has several.
        force: Write over an earlier export; a file without its mark, unless it is empty, stays.
            In a folder with a record: take the place of the earlier export, of which what has been
            changed since stays, or write beside files of others, of which none is written over.

    Raises:
        InputError: a file is there already, is an input, has a file in place of its folder, or
            cannot be written. What was there is as it was, then.
    """
    paths = {path: place / path if path else place for path in output.files}
    inputs = {real(file) for file in output.inputs}
    for file in paths.values():
        if real(file) in inputs:
            raise InputError("would be overwritten, but it is an input", file=file)
        for folder in file.parents:
            if os.path.exists(folder) and not os.path.isdir(folder):
                raise InputError("is a file", file=folder, hint="name a folder")
        if os.path.isdir(file):
            raise InputError("is there already", file=file, hint="name a file")
    contents = {
        path: text.replace("\n", output.newline).encode() for path, text in output.files.items()
    }
    if output.recorded and "" not in paths:
        return _write_folder(contents, place, force=force)
    for file in paths.values():
        if os.path.exists(file) and not force:
            raise InputError("is there already", file=file, hint="--force writes over it")
        if os.path.isfile(file) and os.path.getsize(file) and not is_marked(file, output.mark):
            raise InputError("is no export's; nothing was written", file=file, hint="move it away")
    replace_files({paths[path]: data for path, data in contents.items()})
    return Written(list(paths.values()), [], [])


def _write_folder(contents: Mapping[str, bytes], place: Path, *, force: bool) -> Written:
    """Write the files of a folder with a record of them, and remove those of an earlier export."""
    earlier = recorded(place)
    _check_folder(contents, place, earlier, force=force)
    files = {place / path: data for path, data in contents.items()}
    replace_files({**files, place / RECORD: record(contents)})
    removed, kept = [], []
    for path, known in earlier.items():
        file = place / path
        if path in contents or not file.is_file():
            continue
        if file.is_symlink() or digest(file.read_bytes()) != known:
            kept.append(file)
        else:
            file.unlink()
            removed.append(file)
            _remove_empty(file.parent, place)
    return Written(list(files), removed, kept)


def _check_folder(
    contents: Mapping[str, bytes], place: Path, earlier: Mapping[str, str], *, force: bool
) -> None:
    """Refuse to write over, or without being asked to beside, what is the user's.

    Raises:
        InputError: a file of the user's would be written over, or the folder is not empty.
    """
    if not force and earlier:
        raise InputError("has an earlier export", file=place, hint="--force takes its place")
    if not force and os.path.isdir(place) and any(place.iterdir()):
        hint = "name an empty folder or a new one; --force writes beside them, over none"
        raise InputError("has files that no export wrote", file=place, hint=hint)
    if not earlier and os.path.exists(place / RECORD):
        raise InputError("is no record of an export", file=place / RECORD, hint="move it away")
    for path, data in contents.items():
        file = place / path
        if not os.path.exists(file):
            continue
        found = digest(file.read_bytes())
        if found not in (earlier.get(path), digest(data)):
            said = "was changed since it was exported" if path in earlier else "is no export's"
            raise InputError(f"{said}; nothing was written", file=file, hint="move it away")


def _remove_empty(folder: Path, place: Path) -> None:
    while folder != place and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
