"""Seeded bugs in any file, each with the tests that must find it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rcx_tools.evidence import broken
from rcx_tools.evidence.mutants.python import function_at
from rcx_tools.evidence.mutants.tables import entry_at
from structured_text.errors import InputError
from structured_text.mutants.mutant import Mutant, mutant_of
from structured_text.mutants.text import Edit, Span

__all__ = ["Bug", "bugs"]


@dataclass(frozen=True)
class Bug(broken.Bug):
    """One row of the table of bugs. `file` is a path in the repository."""

    tests: tuple[str, ...]

    @property
    def of_library(self) -> bool:
        """Return whether the bug is in Structured Text.

        Every test in the row of the bug may execute Structured Text.
        """
        return self.file.endswith(".st")

    def mutant(self, root: Path) -> Mutant:
        """Return the mutant of the file with the bug.

        Raises:
            InputError: the bug cannot be inserted, or a path of tests does not exist.
        """
        self.check(root)
        for tests in self.tests:
            if not (root / tests).exists():
                told = f"the seeded bug {self.name!r}: there is no {tests}"
                raise InputError(told, hint="name files of tests, or folders of them")
        text = (root / self.file).read_text(encoding="utf-8")
        start = text.index(self.old)
        edit = Edit(Span(start, start + len(self.old)), self.new)
        if self.of_library:
            pou = Path(self.file).stem
        elif self.file.endswith(".toml"):
            pou = entry_at(text, start)
        else:
            pou = function_at(text, start, self.file)
        return mutant_of(self.file, pou, "seeded", text, (edit,))


def bugs(file: Path) -> list[Bug]:
    """Return the rows of a table of bugs. If the file does not exist, return no rows.

    Raises:
        InputError: See `broken.bugs`.
    """
    return broken.bugs([file] if file.is_file() else [], Bug)
