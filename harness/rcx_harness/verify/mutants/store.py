"""What is known from earlier runs: outcomes by mutant and tests, and the run of the original."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["Baseline", "Results", "digest"]


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


@dataclass(frozen=True)
class Baseline:
    """The run of the original.

    Attributes:
        ran: The POUs that each test has run, in the order of the tests.
        seconds: Processor time of each test.
        failed: Tests that fail with the original; they judge nothing.
        builders: Tests that were the first to build a program: with these, all are compiled.
        states: Of each file of tests, by its path, as it was.
    """

    ran: dict[str, frozenset[str]]
    seconds: dict[str, float]
    failed: tuple[str, ...]
    builders: tuple[str, ...]
    states: dict[str, str]

    @classmethod
    def read(cls, file: Path, library: str) -> Baseline | None:
        """What was kept for this state of the library, if anything."""
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        if found.get("library") != library:
            return None
        ran = {node: frozenset(pous) for node, pous in found["ran"].items()}
        failed, builders = tuple(found["failed"]), tuple(found["builders"])
        return cls(ran, found["seconds"], failed, builders, found["states"])

    def holds(self, node: str, state: str) -> bool:
        """Whether a test was run from a file in this state."""
        return node in self.seconds and self.states.get(node.partition("::")[0]) == state

    def write(self, file: Path, library: str) -> None:
        """Keep it."""
        content = {
            "library": library,
            "ran": {node: sorted(pous) for node, pous in self.ran.items()},
            "seconds": self.seconds,
            "failed": self.failed,
            "builders": self.builders,
            "states": self.states,
        }
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(content), encoding="utf-8")
