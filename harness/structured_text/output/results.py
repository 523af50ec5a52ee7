"""Saved results of earlier runs of a check, by key."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Mapping
from itertools import count
from pathlib import Path
from typing import Any

from structured_text.output.files import replace_files

__all__ = ["Results", "digest", "move_aside", "read_entry"]


def digest(root: Path, files: Iterable[Path]) -> str:
    """Return a hash of the names and the contents of some files."""
    found = hashlib.sha256()
    for file in sorted(files):
        found.update(file.relative_to(root).as_posix().encode())
        found.update(hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()[:16]


def read_entry(line: bytes) -> dict[str, Any] | None:
    """Return the entry of a line; None if the line is damaged."""
    try:
        entry = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return entry if isinstance(entry, dict) and isinstance(entry.get("key"), str) else None


def move_aside(file: Path) -> Path:
    """Rename a damaged file to a free name, and return the new path.

    Raise OSError if it cannot be renamed.
    """
    names = (file.with_name(f"{file.name}.damaged{number or ''}") for number in count())
    aside = next(name for name in names if not name.exists())
    return file.rename(aside)


def _any(entry: Mapping[str, Any]) -> bool:
    return True


class Results:
    """Results by key, saved as JSON lines.

    If a key occurs in several lines, the last line counts.

    With `fresh`, earlier results are deleted. `is_whole` returns whether an entry is complete.

    Attributes:
        notice: A line for the user if the file was damaged: it was renamed, and its valid lines
            were copied to a new file.
    """

    def __init__(
        self,
        file: Path,
        *,
        fresh: bool = False,
        is_whole: Callable[[Mapping[str, Any]], bool] = _any,
    ) -> None:
        self._file = file
        self._known: dict[str, dict[str, Any]] = {}
        self.notice = ""
        file.parent.mkdir(parents=True, exist_ok=True)
        if fresh:
            file.unlink(missing_ok=True)
        if file.exists():
            self._read(is_whole)

    def _read(self, is_whole: Callable[[Mapping[str, Any]], bool]) -> None:
        *lines, last = self._file.read_bytes().split(b"\n")
        taken, damaged = [], 0
        for number, line in enumerate([*lines, last] if last else lines):
            entry = read_entry(line)
            if entry is not None and is_whole(entry):
                self._known[entry["key"]] = entry
                taken.append(line + b"\n")
            # A process that was killed may have left an incomplete last line.
            elif number < len(lines):
                damaged += 1
        if damaged:
            aside = move_aside(self._file)
            which = "1 line is" if damaged == 1 else f"{damaged} lines are"
            self.notice = f"{self._file}: {which} damaged; the file is now {aside}, "
            self.notice += "and missing results are computed again"
        if damaged or last:
            replace_files({self._file: b"".join(taken)})

    def get(self, key: str) -> dict[str, Any] | None:
        """Return the saved entry of a key; None if there is none."""
        return self._known.get(key)

    def add(self, entry: Mapping[str, Any]) -> None:
        """Save an entry; it contains `key`."""
        self._known[str(entry["key"])] = dict(entry)
        with self._file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry) + "\n")
