"""The order for a run of pytest with a mutant, and the result of the run; both are JSON files."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["VARIABLE", "Order"]

#: The environment variable with the path of the order's file.
VARIABLE = "RCX_MUTANT_ORDER"


@dataclass(frozen=True)
class Order:
    """An order for a run of pytest: the tests to run, and how.

    Attributes:
        folder: A temporary folder for all files that the run writes.
        tests: Identifiers of the tests, in their order. If None, all tests run, and the code that
            each of them executes is recorded.
        instead: Maps each replaced file (resolved path) to its changed copy.
        port: The TCP port from which the process receives further orders. Each order runs in a copy
            of the process. If 0, this order itself is executed.
        seconds: Limit for the processor time of a copy.
        sources: Source files to parse in advance.
    """

    folder: Path
    tests: tuple[str, ...] | None = None
    instead: Mapping[Path, Path] = field(default_factory=dict)
    port: int = 0
    seconds: float = 0.0
    sources: tuple[Path, ...] = ()

    def write(self) -> Path:
        """Write the order into its folder and return the file."""
        file = self.folder / "order.json"
        instead = {str(original): str(copy) for original, copy in self.instead.items()}
        content = vars(self) | {"folder": str(self.folder), "instead": instead}
        content["sources"] = list(map(str, self.sources))
        file.write_text(json.dumps(content), encoding="utf-8")
        return file

    @classmethod
    def read(cls, file: Path) -> Order:
        """Read an order that `write` has written."""
        found = json.loads(file.read_text(encoding="utf-8"))
        found["tests"] = None if found["tests"] is None else tuple(found["tests"])
        found["instead"] = {Path(one): Path(copy) for one, copy in found["instead"].items()}
        found["sources"] = tuple(map(Path, found["sources"]))
        return cls(**found | {"folder": Path(found["folder"])})

    def answer(self, content: Mapping[str, Any]) -> None:
        """Write the result of the run into the folder of the order."""
        text = json.dumps(content)
        (self.folder / "answer.json").write_text(text, encoding="utf-8")

    def answered(self) -> Any:
        """Return the result of the run; None if the run has not written a result."""
        try:
            return json.loads((self.folder / "answer.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
