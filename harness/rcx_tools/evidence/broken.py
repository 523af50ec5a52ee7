"""Copies of the library, either unchanged or with a seeded bug that a check must find.

The bugs are in tables below `tests/tools/evidence`. Each bug is a `[[bug]]` with `name`, `file`,
`old` and `new`, and with additional fields for the check that searches for it.
"""

from __future__ import annotations

import shutil
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, fields
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeVar

from rcx_tools.evidence.results import ROOT
from structured_text.errors import InputError
from structured_text.output.toml_files import line_of, load_toml

__all__ = ["BUGS", "Bug", "broken_library", "bugs", "library_copy"]

_LIBRARY = ROOT / "plc" / "lib"
#: Folder with the tables of the bugs that exploration and campaign must find.
BUGS = ROOT / "tests" / "tools" / "evidence" / "bugs"


@dataclass(frozen=True)
class Bug:
    """One row of a table of bugs: `new` replaces `old`, which must occur exactly once in `file`."""

    name: str
    file: str
    old: str
    new: str

    def check(self, folder: Path) -> None:
        """Check that the bug can be inserted.

        Raises:
            InputError: `old` does not occur exactly once in the file.
        """
        file = folder / self.file
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        times = text.count(self.old)
        if times != 1 or self.old == self.new:
            raise InputError(
                f"the seeded bug {self.name!r}: `old` stands {times} times in {self.file}",
                hint="`old` must occur exactly once, and `new` must differ from it",
            )

    def put_into(self, folder: Path) -> None:
        """Insert the bug into a copy of the library."""
        file = folder / self.file
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(self.old, self.new), encoding="utf-8")


_Bug = TypeVar("_Bug", bound=Bug)


def bugs(files: Iterable[Path], kind: type[_Bug]) -> list[_Bug]:
    """Read the bugs in tables.

    Args:
        files: The tables.
        kind: The class of a row. Its fields are the required keys; lists become tuples.

    Raises:
        InputError: invalid TOML, an incomplete row, or a duplicate name.
    """
    found: dict[str, _Bug] = {}
    keys = [one.name for one in fields(kind)]
    for file in files:
        for number, row in enumerate(load_toml(file).get("bug", []), 1):
            if set(row) != set(keys) or [] in row.values():
                text = f"seeded bug {number} has {', '.join(row)}"
                hint = f"it needs {', '.join(keys)}, none of them empty"
                raise InputError(text, file=file, line=line_of(file, "bug", number), hint=hint)
            if row["name"] in found:
                text = f"a second seeded bug {row['name']!r}"
                raise InputError(text, file=file, line=line_of(file, "bug", number))
            made: Any = {key: tuple(v) if isinstance(v, list) else v for key, v in row.items()}
            found[row["name"]] = kind(**made)
    return list(found.values())


@contextmanager
def library_copy() -> Iterator[Path]:
    """Yield a copy of the library, so that changes during a long check have no effect."""
    with TemporaryDirectory() as folder:
        yield Path(shutil.copytree(_LIBRARY, Path(folder) / "lib"))


@contextmanager
def broken_library(file: str, old: str, new: str) -> Iterator[Path]:
    """Yield a copy of the library in which `new` replaces `old` in one file.

    Raises:
        InputError: `old` does not occur exactly once in the file.
    """
    bug = Bug(f"of {file}", file, old, new)
    with library_copy() as lib:
        bug.check(lib)
        bug.put_into(lib)
        yield lib
