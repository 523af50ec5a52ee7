"""Seeded bugs from a table: each with the tests that must find it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from pathlib import Path

from rcx_tools.evidence.mutants.python import function_at
from rcx_tools.evidence.mutants.tables import entry_at
from structured_text.errors import InputError
from structured_text.mutants.mutant import Mutant, mutant_of
from structured_text.mutants.text import Edit, Span
from structured_text.output.toml_files import load_toml

__all__ = ["Bug", "bugs"]

_KEYS = ("file", "what", "before", "after", "tests")


@dataclass(frozen=True)
class Bug:
    """One row of the table; `before` occurs once in `file`, and `after` replaces it."""

    file: str
    what: str
    before: str
    after: str
    tests: tuple[str, ...]

    @property
    def of_library(self) -> bool:
        """Return whether it changes Structured Text, which every test of its row may run."""
        return self.file.endswith(".st")

    def mutant(self, root: Path) -> Mutant:
        """Return the mutant of the file with the bug.

        Raises:
            InputError: `before` does not occur exactly once in the file, nothing is changed, or a
                path of tests does not exist.
        """
        file = root / self.file
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        times = text.count(self.before)
        if times != 1 or self.before == self.after:
            raise InputError(
                f"the seeded bug {self.what!r}: `before` stands {times} times in {self.file}",
                hint="give text that stands there once, and another one instead",
            )
        for tests in self.tests:
            if not (root / tests).exists():
                told = f"the seeded bug {self.what!r}: there is no {tests}"
                raise InputError(told, hint="name files of tests, or folders of them")
        start = text.index(self.before)
        edit = Edit(Span(start, start + len(self.before)), self.after)
        entry = entry_at if file.suffix == ".toml" else partial(function_at, path=self.file)
        pou = file.stem if self.of_library else entry(text, start)
        return mutant_of(self.file, pou, "seeded", text, (edit,))


def bugs(file: Path) -> list[Bug]:
    """Return the rows of a table; none if the file does not exist.

    Raises:
        InputError: invalid TOML, or an incomplete row.
    """
    rows = load_toml(file).get("bug", []) if file.is_file() else []
    found = []
    for number, row in enumerate(rows, 1):
        if set(row) != set(_KEYS) or not row["tests"]:
            raise InputError(
                f"seeded bug {number} has {', '.join(row)}",
                file=file,
                hint=f"it needs {', '.join(_KEYS)}, each once, and some tests",
            )
        found.append(Bug(**{**row, "tests": tuple(row["tests"])}))
    return found
