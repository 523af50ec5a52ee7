"""Seeded bugs in copies of blocks. The search must find each bug with a shortest trace."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rcx_tools.evidence.broken import BUGS, Bug, bugs
from rcx_tools.evidence.explore.search import LIBRARY

__all__ = ["SEEDED", "Seeded"]


@dataclass(frozen=True)
class Seeded(Bug):
    """A seeded bug, the model that must find it, and the rule that it breaks in the model."""

    model: str
    rule: str

    @property
    def block(self) -> str:
        """Return the name of the changed block."""
        return Path(self.file).stem

    def library(self, folder: Path, library: Sequence[Path] = LIBRARY) -> list[Path]:
        """Write the changed file into a folder, and return the library with this file."""
        (original,) = (file for file in library if file.stem == self.block)
        copy = Path(shutil.copy(original, folder))
        bug = replace(self, file=copy.name)
        bug.check(folder)
        bug.put_into(folder)
        return [copy if file == original else file for file in library]


SEEDED = tuple(bugs([BUGS / "explore.toml"], Seeded))
