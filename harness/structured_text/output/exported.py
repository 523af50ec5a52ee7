"""Recognition of exported files, which commands must not take for the user's sources."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

from structured_text.errors import COMMAND, DISTRIBUTION
from structured_text.output.paths import real

__all__ = [
    "MARK",
    "RECORD",
    "digest",
    "is_marked",
    "own_output",
    "record",
    "recorded",
    "release",
    "resolved",
]

#: The mark at the beginning of an export that is a single file.
MARK = f"Written by `{COMMAND} export`; change the sources, not this file."

#: Name of the record in an export folder. It has the exported files and the digests of their
#: contents.
RECORD = f"{COMMAND}-export.json"

_ABOUT = (
    f"Files that `{COMMAND} export` wrote here; it replaces and removes those that are unchanged."
)
_HEAD = 1000
#: The files and digests of each record, by its folder.
_Records = dict[Path, dict[str, str]]


def release() -> str:
    """Return the version of this package; 0 for a copy that is not installed."""
    # This import is here because it is slow and rarely needed.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(DISTRIBUTION)
    except PackageNotFoundError:
        return "0"


def digest(data: bytes) -> str:
    """Return the hash of a file's contents."""
    return hashlib.sha256(data).hexdigest()


def record(contents: Mapping[str, bytes]) -> bytes:
    """Return the record of exported files; `contents` has their data by path in the folder."""
    files = {path: digest(data) for path, data in sorted(contents.items())}
    return (json.dumps({"about": _ABOUT, "files": files}, indent=1) + "\n").encode()


def recorded(folder: Path) -> dict[str, str]:
    """Return the digests in a folder's record, by path of the file.

    The result is empty without a valid record.
    """
    try:
        found = json.loads((folder / RECORD).read_bytes())
    except (OSError, ValueError, RecursionError):
        return {}
    if not isinstance(found, dict) or found.get("about") != _ABOUT:
        return {}
    files = found.get("files")
    if not isinstance(files, dict):
        return {}
    return {
        path: str(value)
        for path, value in files.items()
        if not PurePosixPath(path).is_absolute() and ".." not in PurePosixPath(path).parts
    }


def resolved(files: Iterable[Path]) -> dict[Path, Path]:
    """Return the resolved path of each file; each folder is resolved only once."""
    folders: dict[Path, Path] = {}
    found = {}
    for file in files:
        folder = file.parent
        if folder not in folders:
            folders[folder] = real(folder)
        place = folders[folder] / file.name
        found[file] = real(place) if place.is_symlink() else place
    return found


def own_output(files: Mapping[Path, Path]) -> set[Path]:
    """Return the ST files that an export has written.

    `files` maps ST files to their resolved paths.
    """
    known: dict[Path, _Records] = {}
    return {one for one, place in files.items() if _is_recorded(place, known) or is_marked(one)}


def _is_recorded(file: Path, known: dict[Path, _Records]) -> bool:
    """Return whether a folder above a file has a record that names the file.

    `known` is the cache of `_records`.
    """
    records = _records(file.parent, known)
    return any(file.relative_to(folder).as_posix() in records[folder] for folder in records)


def _records(folder: Path, known: dict[Path, _Records]) -> _Records:
    """Return the records of a folder and of the folders above it.

    `known` caches the records that have been read.
    """
    if folder not in known:
        above = _records(folder.parent, known) if folder.parent != folder else {}
        names = recorded(folder)
        known[folder] = {**above, folder: names} if names else above
    return known[folder]


def is_marked(file: Path, mark: str = MARK) -> bool:
    """Return whether the head of a file has the mark of an export."""
    try:
        with file.open("rb") as stream:
            return mark.encode() in stream.read(_HEAD)
    except OSError:
        return False
