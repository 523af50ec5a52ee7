"""The known faults of matiec: their table, and the places of a program that they concern.

The table is `faults.toml`. A place is reported only if the program can reach the fault: a FOR with
constant bounds that runs several times is not affected, for instance. A bound that is calculated
counts as affected, because it may have the wrong value in some scan.
"""

from __future__ import annotations

import mmap
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path

from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.detectors import DETECTORS
from structured_text.engines.matiec.hits import Sources
from structured_text.errors import COMMAND, InputError, place_text
from structured_text.language.dialects import rules_of
from structured_text.language.library import names_of
from structured_text.language.project import Project
from structured_text.language.syntax import Position
from structured_text.output.toml_files import load_toml

__all__ = [
    "Fault",
    "Place",
    "faults",
    "is_new",
    "places",
    "refuse_faults",
    "warnings",
    "why_builtin",
]

_TABLE = Path(__file__).with_name("faults.toml")
#: A name in the C code that matiec writes for FOR since it supports CONTINUE (June 2024).
_NEW = b"__do_increment"


@dataclass(frozen=True)
class Fault:
    """A fault of matiec.

    Attributes:
        name: Name of the fault in `faults.toml`.
        construct: The construct of the language that the fault concerns.
        effect: The behaviour of matiec, as a predicate.
        instead: What to write instead.
        refused: Whether the C code does not compile.
        versions: `all`, `new` (since June 2024) or `old` (before).
    """

    name: str
    construct: str
    effect: str
    instead: str
    refused: bool
    versions: str

    @property
    def who(self) -> str:
        """Return "matiec", with the affected versions if not all versions have the fault."""
        return {
            "all": "matiec",
            "new": "matiec since June 2024",
            "old": "matiec before June 2024",
        }[self.versions]


@dataclass(frozen=True)
class Place:
    """A place of a program that a fault concerns; `detail` names the part of the program."""

    fault: Fault
    file: Path
    at: Position
    detail: str = ""

    @property
    def text(self) -> str:
        """Return the construct, the effect and what to write instead, in one sentence."""
        detail = f" ({self.detail})" if self.detail else ""
        return (
            f"{self.fault.construct}{detail}: {self.fault.who} {self.fault.effect}; "
            f"{self.fault.instead}"
        )

    def __str__(self) -> str:
        """Return the place and its text as compilers print it."""
        return f"{place_text(self.file, self.at.line, self.at.column)}: {self.text}"


@cache
def faults() -> dict[str, Fault]:
    """Return the table of faults by name."""
    return {
        name: Fault(
            name,
            row["construct"],
            row["effect"],
            row["instead"],
            row["kind"] == "refused",
            row["versions"],
        )
        for name, row in load_toml(_TABLE).items()
    }


def places(project: Project, new: bool | None = None) -> list[Place]:
    """Return the places of a program that a fault of matiec concerns, by file and line.

    A library whose authors test it with matiec is left out; see `language.library`.

    Args:
        project: The checked program.
        new: Whether only faults of new matiec (True) or of old matiec (False) count; None for all.
    """
    left_out = {True: "old", False: "new", None: ""}[new]
    wanted = [
        fault
        for fault in faults().values()
        if fault.versions != left_out and fault.name in DETECTORS
    ]
    files = {str(file): file for file in project.files if names_of(file).tested != "matiec"}
    pous = [pou for pou in project.pous.values() if pou.file in files]
    counters = rules_of(project.dialect).counters
    sources = Sources(tuple(files.values()), pous, project.types, project.blocks, counters)
    found = {
        Place(fault, files[hit.file], hit.at, hit.detail)
        for fault in wanted
        for hit in DETECTORS[fault.name](sources)
    }
    return sorted(found, key=lambda one: (str(one.file), one.at, one.fault.name))


def warnings(found: Iterable[Place]) -> list[Place]:
    """Return the first place for each fault and file.

    Its detail lists the lines of the other places.
    """
    groups: dict[tuple[Path, str], list[Place]] = {}
    for one in found:
        groups.setdefault((one.file, one.fault.name), []).append(one)
    made = []
    for first, *others in groups.values():
        lines = sorted({one.at.line for one in others} - {first.at.line})
        detail = first.detail
        if lines:
            listed = ", ".join(map(str, lines))
            also = f"also {'line' if len(lines) == 1 else 'lines'} {listed}"
            detail = f"{detail}; {also}" if detail else also
        made.append(Place(first.fault, first.file, first.at, detail))
    return made


def why_builtin(found: list[Place]) -> str:
    """Return one line that says why a program does not run on matiec."""
    first = next((one for one in found if one.fault.refused), found[0])
    others = len(warnings(found)) - 1
    more = f" ({others} more: {COMMAND} check)" if others else ""
    return (
        f"{first.fault.construct} ({first.file.name}, line {first.at.line}): matiec "
        f"{first.fault.effect}{more}: running on the built-in engine"
    )


def refuse_faults(found: Iterable[Place]) -> None:
    """Raise InputError for the first place that matiec cannot compile."""
    for one in found:
        if one.fault.refused:
            detail = f" ({one.detail})" if one.detail else ""
            raise InputError(
                f"{one.fault.construct}{detail}: matiec {one.fault.effect}",
                file=one.file,
                line=one.at.line,
                column=one.at.column,
                hint=f"{one.fault.instead}, or use --engine builtin",
            )


def is_new(matiec: Matiec) -> bool:
    """Return whether the installed matiec is a version since June 2024."""
    return _contains(matiec.iec2c, matiec.iec2c.stat().st_mtime_ns)


@lru_cache(maxsize=8)
def _contains(program: Path, changed: int) -> bool:
    del changed
    with program.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as image:
        return image.find(_NEW) >= 0
