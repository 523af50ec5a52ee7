"""The saved data of the last test run without a mutant."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

__all__ = ["Baseline"]


@dataclass(frozen=True)
class Baseline:
    """The test run without a mutant.

    Attributes:
        ran: The POUs that each test has run, in the order of the tests.
        seconds: Processor time of each test.
        failed: Tests that fail without a mutant. They cannot kill a mutant.
        builders: Tests that were the first to build a program. Together these tests compile all
            programs.
        states: Hash of each test file, by path.
        exhaustive: Tests that `make test` leaves out.
    """

    ran: dict[str, frozenset[str]]
    seconds: dict[str, float]
    failed: tuple[str, ...]
    builders: tuple[str, ...]
    states: dict[str, str]
    exhaustive: frozenset[str] = frozenset()

    @classmethod
    def read(cls, file: Path, library: str) -> Baseline | None:
        """Return the saved run for this state of the library, or None."""
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
        if found.get("library") != library or "names" not in found:
            return None
        names = found["names"]
        ran = {node: frozenset(names[k] for k in pous) for node, pous in found["ran"].items()}
        failed, builders = tuple(found["failed"]), tuple(found["builders"])
        exhaustive = frozenset(found.get("exhaustive", ()))
        return cls(ran, found["seconds"], failed, builders, found["states"], exhaustive)

    def holds(self, node: str, state: str) -> bool:
        """Return whether a test has been run with its file in this state."""
        return node in self.seconds and self.states.get(node.partition("::")[0]) == state

    def write(self, file: Path, library: str) -> None:
        """Save the data of the test run."""
        names = sorted(frozenset().union(*self.ran.values()))
        places = {name: place for place, name in enumerate(names)}
        content = {
            "library": library,
            "names": names,
            "ran": {node: sorted(places[one] for one in pous) for node, pous in self.ran.items()},
            "seconds": self.seconds,
            "failed": self.failed,
            "builders": self.builders,
            "states": self.states,
            "exhaustive": sorted(self.exhaustive),
        }
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(content), encoding="utf-8")
