"""What `rcx export` has written, known again: neither read nor taken for the user's."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path, PurePosixPath

__all__ = ["MARK", "RECORD", "digest", "is_in_record", "own_output", "record", "recorded"]

#: Stands at the head of each file that is exported by itself.
MARK = "Written by `rcx export`; change the sources, not this file."

#: In a folder that is exported: which files of it are, and what was in them.
RECORD = "rcx-export.json"

_ABOUT = "Files that `rcx export` wrote here; it replaces and removes those that are unchanged."
_HEAD = 1000


def digest(data: bytes) -> str:
    """What a file's contents are known by."""
    return hashlib.sha256(data).hexdigest()


def record(contents: Mapping[str, bytes]) -> bytes:
    """The text of the record of some files, by their paths below its folder."""
    files = {path: digest(data) for path, data in sorted(contents.items())}
    return (json.dumps({"about": _ABOUT, "files": files}, indent=1) + "\n").encode()


def recorded(folder: Path) -> dict[str, str]:
    """Digests by path of what was exported into a folder; empty where nothing was."""
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


def is_in_record(file: Path, known: dict[Path, dict[str, str]]) -> bool:
    """Whether the record of a folder above a file names it.

    Args:
        file: The file, its path resolved.
        known: Records that were read, by folder; more are added.
    """
    for folder in file.parents:
        if folder not in known:
            known[folder] = recorded(folder)
        if known[folder] and file.relative_to(folder).as_posix() in known[folder]:
            return True
    return False


def own_output(files: Iterable[Path]) -> set[Path]:
    """Which of some ST files an export has written."""
    known: dict[Path, dict[str, str]] = {}
    return {one for one in files if is_in_record(one.resolve(), known) or _is_marked(one)}


def _is_marked(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            return MARK.encode() in stream.read(_HEAD)
    except OSError:
        return False
