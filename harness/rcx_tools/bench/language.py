"""Share of the files of public Structured Text libraries that the front end accepts.

The person who measures fetches the libraries. `RCX_LIBRARIES` names their folders or project files,
separated as in PATH. This repository contains nothing of them. Each entry is one library: its files
are checked together, because they use each other. In a project of one file (PLCopen XML) each
declaration counts as a file.

If matiec is available, random calls of POUs that it also accepts are compared (`agreement`).
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console

from rcx_tools.bench.agreement import compared
from rcx_tools.bench.figure import Figure, Options, at_least, at_most, shown
from structured_text.engines.matiec.build import find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.load import analyse
from structured_text.projects.formats import is_project
from structured_text.projects.open import project_sources
from structured_text.projects.sources import named_files

__all__ = ["CALLS", "LEAST", "Share", "accepted", "measure", "sources_of"]

#: Required share of accepted files in each library [%].
LEAST = 95.0
#: Number of compared random calls, over all libraries.
CALLS = 100_000
_VARIABLE = "RCX_LIBRARIES"
#: Names and numbers in a message; they are removed to group messages by reason.
_NAMES = re.compile(r"'[^']*'|\b\w*\d\w*\b|\b[A-Z_]\w*\b")
_SHOWN = 10


@dataclass(frozen=True)
class Share:
    """The result for a library.

    Attributes:
        files: Number of files.
        refused: Files with errors.
        reasons: Each reason with its number of occurrences.
    """

    files: int
    refused: frozenset[Path]
    reasons: tuple[tuple[str, int], ...]

    @property
    def percent(self) -> float:
        """Return the share of files without an error [%]."""
        return 100.0 * (self.files - len(self.refused)) / self.files


def sources_of(entry: Path) -> list[Path]:
    """Return the sources of a library: its files, and the declarations of its project.

    Raises:
        InputError: there are none, or the project cannot be read.
    """
    files = named_files(entry)
    projects = [file for file in files if is_project(file)]
    made = project_sources(projects, {}).paths if projects else ()
    return [*(file for file in files if file not in projects), *made]


def accepted(files: Sequence[Path]) -> Share:
    """Check the files of a library together.

    Raises:
        InputError: there are no files.
    """
    if not files:
        raise InputError("no files to measure", hint=f"look at {_VARIABLE}")
    _, errors = analyse(files)
    refused = frozenset(file for file in files if any(_is_in(file, error) for error in errors))
    reasons = Counter(_NAMES.sub("…", error.message) for error in errors)
    return Share(len(files), refused, tuple(reasons.most_common()))


def _is_in(file: Path, error: InputError) -> bool:
    """Return whether an error is in this file, or in this declaration of it."""
    if error.file != str(file):
        return False
    lines = [line.at for line in getattr(file, "lines", None) or ()]
    return not lines or min(lines) <= (error.line or 0) <= max(lines)


def measure(options: Options) -> dict[str, Figure]:
    """Measure each library of `RCX_LIBRARIES`, and print why files are refused.

    Raises:
        InputError: the variable is not set, or a library has no sources.
    """
    entries = [Path(part) for part in os.environ.get(_VARIABLE, "").split(os.pathsep) if part]
    if not entries:
        hint = f"set {_VARIABLE} to folders or projects of ST, separated by {os.pathsep!r}"
        raise InputError("no libraries to measure", hint=hint)
    console = Console(highlight=False, markup=False)
    figures: dict[str, Figure] = {}
    libraries: list[list[Path]] = []
    for entry in entries:
        files = sources_of(entry)
        share = accepted(files)
        name = entry.stem if entry.is_file() else entry.name
        console.print(f"{name}: {share.files - len(share.refused)} of {share.files} files")
        for reason, times in share.reasons[:_SHOWN]:
            console.print(f"  {times} x {reason}")
        figures[f"language {name}"] = at_least(share.percent, "% of files", LEAST)
        libraries.append([file for file in files if file not in share.refused])
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        console.print("calls are not compared: matiec or a C compiler is not found")
        return figures
    found = compared(libraries, matiec, compiler, 1000 if options.quick else CALLS)
    console.print(f"{found.calls} calls of {found.pous} functions and blocks compared")
    for text in found.differences:
        console.print(f"  {text}")
    figures["language calls"] = shown(found.calls, "calls", "matiec")
    figures["language differences"] = at_most(len(found.differences), "functions", 0, "matiec")
    return figures
