"""What is known from earlier runs of a check: outcomes by key."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

__all__ = ["Results", "digest"]


def digest(root: Path, files: Iterable[Path]) -> str:
    """A hash of the names and contents of files."""
    found = hashlib.sha256()
    for file in sorted(files):
        found.update(file.relative_to(root).as_posix().encode())
        found.update(hashlib.sha256(file.read_bytes()).digest())
    return found.hexdigest()[:16]


class Results:
    """Outcomes by key, kept as JSON lines, the latest one last.

    Args:
        file: Where they are kept.
        fresh: Forget what is there.
    """

    def __init__(self, file: Path, *, fresh: bool = False) -> None:
        self._file = file
        self._known: dict[str, dict[str, Any]] = {}
        file.parent.mkdir(parents=True, exist_ok=True)
        if fresh:
            file.unlink(missing_ok=True)
        if file.exists():
            content = file.read_text(encoding="utf-8")
            if content and not content.endswith("\n"):
                file.write_text(content + "\n", encoding="utf-8")
            for line in content.splitlines():
                if line.endswith("}"):  # not one that was cut off
                    found = json.loads(line)
                    self._known[found["key"]] = found

    def get(self, key: str) -> dict[str, Any] | None:
        """What is known under a key."""
        return self._known.get(key)

    def add(self, entry: Mapping[str, Any]) -> None:
        """Keep an outcome; `key` is among its entries."""
        self._known[str(entry["key"])] = dict(entry)
        with self._file.open("a", encoding="utf-8") as stream:
            stream.write(json.dumps(entry) + "\n")
