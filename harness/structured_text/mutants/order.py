"""What a run of pytest is to do with a mutant, as a file, and what it answers, as another."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

__all__ = ["VARIABLE", "Order"]

#: Names the file of the order in the environment of the run.
VARIABLE = "RCX_MUTANT_ORDER"


@dataclass(frozen=True)
class Order:
    """What to run.

    Attributes:
        folder: A temporary one, for all that the run writes.
        tests: Identifiers of the tests, in their order; None: all, and note what each runs.
        instead: Copies with a mistake, by the resolved files that they stand for.
        port: Take further orders there, and do each of them in a copy of the process; 0: do this.
        seconds: Processor time that such a copy may take.
        sources: Files to read before.
    """

    folder: Path
    tests: tuple[str, ...] | None = None
    instead: Mapping[Path, Path] = field(default_factory=dict)
    port: int = 0
    seconds: float = 0.0
    sources: tuple[Path, ...] = ()

    def write(self) -> Path:
        """Write it into its folder."""
        file = self.folder / "order.json"
        instead = {str(original): str(copy) for original, copy in self.instead.items()}
        content = vars(self) | {"folder": str(self.folder), "instead": instead}
        content["sources"] = list(map(str, self.sources))
        file.write_text(json.dumps(content), encoding="utf-8")
        return file

    @classmethod
    def read(cls, file: Path) -> Order:
        """What `write` has written."""
        found = json.loads(file.read_text(encoding="utf-8"))
        found["tests"] = None if found["tests"] is None else tuple(found["tests"])
        found["instead"] = {Path(one): Path(copy) for one, copy in found["instead"].items()}
        found["sources"] = tuple(map(Path, found["sources"]))
        return cls(**found | {"folder": Path(found["folder"])})

    def answer(self, content: Mapping[str, Any]) -> None:
        """Say what came of it."""
        text = json.dumps(content)
        (self.folder / "answer.json").write_text(text, encoding="utf-8")

    def answered(self) -> Any:
        """What the run has said; None where it came to no end."""
        try:
            return json.loads((self.folder / "answer.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None
