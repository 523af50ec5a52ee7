"""The result of an export, and its writing without damage to existing files.

A folder of an export contains a record with a hash of each file. A later export reads the record,
and replaces only files that have not changed since an export wrote them. A single file has a mark
at its head instead.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError, place_text
from structured_text.output.exported import MARK, RECORD, digest, is_marked, record, recorded
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["Missing", "Output", "Written", "write", "write_export"]


@dataclass(frozen=True)
class Missing:
    """A declaration that a target does not support, or not completely.

    Attributes:
        what: Kind and name of the declaration.
        why: The reason, or advice for the user.
        file: The file that declares it.
        replaced: Whether the declaration belongs to the library and other blocks of the library
            replace it.
    """

    what: str
    why: str
    file: Path
    line: int
    replaced: bool = False

    def __str__(self) -> str:
        return f"{place_text(self.file, self.line)}: {self.what}: {self.why}"


@dataclass(frozen=True)
class Output:
    """The result of an exporter.

    Attributes:
        files: Text by path: the path `""` for a single file, else paths in a folder.
        missing: Declarations that the target does not support.
        newline: The line end of the target's tools.
        inputs: The source files; they are never overwritten.
        notes: Further notes, one line each.
        recorded: Whether an exported folder gets a record, by which a later export recognizes its
            files.
        mark: The text at the head of each file without a record; a later export recognizes the file
            by this mark.
    """

    files: dict[str, str]
    missing: tuple[Missing, ...] = ()
    newline: str = "\n"
    inputs: frozenset[Path] = frozenset()
    notes: tuple[str, ...] = ()
    recorded: bool = False
    mark: str = MARK


@dataclass(frozen=True)
class Written:
    """The result of writing an export.

    Attributes:
        files: The files written, without the record.
        removed: Files of an earlier export that the new export does not have.
        kept: Files of an earlier export that the new export does not have, but that were changed
            and are therefore not removed.
    """

    files: list[Path]
    removed: list[Path]
    kept: list[Path]


def write(output: Output, place: Path, *, force: bool = False) -> list[Path]:
    """Write an export and return the files written."""
    return write_export(output, place, force=force).files


def write_export(output: Output, place: Path, *, force: bool = False) -> Written:
    """Write an export to a file, or to a folder that is created if it is missing.

    Args:
        output: The export.
        place: The file, or the folder for an export of several files.
        force: Overwrite an earlier export. A file without the mark of an export is overwritten only
            if it is empty. In a folder with a record, replace the earlier export except for files
            that were changed since. In a folder without a record, add the new files, and overwrite
            no existing file.

    Raises:
        InputError: A file exists already, is an input, stands in place of a folder, or cannot be
            written. In this case nothing has changed on the disk.
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
            raise InputError("already exists", file=file, hint="name a file")
    contents = {
        path: text.replace("\n", output.newline).encode() for path, text in output.files.items()
    }
    if output.recorded and "" not in paths:
        return _write_folder(contents, place, force=force)
    for file in paths.values():
        if os.path.exists(file) and not force:
            raise InputError("already exists", file=file, hint="use --force to overwrite it")
        if os.path.isfile(file) and os.path.getsize(file) and not is_marked(file, output.mark):
            raise InputError(
                "was not written by an export; nothing was written", file=file, hint="move it away"
            )
    replace_files({paths[path]: data for path, data in contents.items()})
    return Written(list(paths.values()), [], [])


def _write_folder(contents: Mapping[str, bytes], place: Path, *, force: bool) -> Written:
    """Write a folder's files with a record of them, and remove files of an earlier export."""
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
    """Refuse to overwrite the user's files, or to write beside them without `force`.

    Raises:
        InputError: A file of the user would be overwritten, or the folder is not empty.
    """
    if not force and earlier:
        raise InputError("contains an earlier export", file=place, hint="use --force to replace it")
    if not force and os.path.isdir(place) and any(place.iterdir()):
        hint = "name an empty or new folder, or use --force to keep them and add the export"
        raise InputError("contains files that no export wrote", file=place, hint=hint)
    if not earlier and os.path.exists(place / RECORD):
        raise InputError("is not a record of an export", file=place / RECORD, hint="move it away")
    for path, data in contents.items():
        file = place / path
        if not os.path.exists(file):
            continue
        found = digest(file.read_bytes())
        if found not in (earlier.get(path), digest(data)):
            said = (
                "was changed since it was exported"
                if path in earlier
                else "was not written by an export"
            )
            raise InputError(f"{said}; nothing was written", file=file, hint="move it away")


def _remove_empty(folder: Path, place: Path) -> None:
    while folder != place and not any(folder.iterdir()):
        folder.rmdir()
        folder = folder.parent
