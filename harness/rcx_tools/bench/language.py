"""Share of the files of public Structured Text that the front end accepts.

You fetch the sources yourself, because this repository does not contain them.

- `RCX_REPOSITORIES` names the folder with the checkouts of `repositories`. For each repository the
  bench prints the numbers of accepted files, of files that lack a library, of files that show a gap
  of the front end, and of other refused files. It ranks the reasons by the number of files.
- `RCX_LIBRARIES` names folders or project files, separated as in PATH. Each entry is one library:
  its files are checked together, because they use each other.

In a project of one file (PLCopen XML) each declaration counts as a file.

If matiec is available, two comparisons follow: random calls of the POUs that matiec also accepts
(`agreement`), and random calls of a program for each row of the table of dialects (`dialect_rows`).
The second comparison needs no sources.
"""

from __future__ import annotations

import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from rcx_tools.bench.agreement import compared
from rcx_tools.bench.dialect_rows import compared_rows
from rcx_tools.bench.figure import Figure, Options, at_least, at_most, shown
from rcx_tools.bench.refusals import Kind, Refusals, classified, references
from rcx_tools.bench.repositories import DIALECTS, REPOSITORIES, Repository, how_to_get
from structured_text.engines.matiec.build import Matiec, find_matiec
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.load import analyse
from structured_text.language.source import in_dialect
from structured_text.projects.formats import is_project
from structured_text.projects.open import project_sources
from structured_text.projects.sources import named_files

__all__ = [
    "CALLS",
    "LEAST",
    "MOST",
    "Result",
    "Share",
    "accepted",
    "measure",
    "result",
    "sources_of",
]

#: Least share of accepted files in each library [%].
LEAST = 95.0
#: Largest permitted share of files with a gap of the front end, in a repository [%].
MOST = 2.0
#: Number of random calls that are compared, over all libraries together.
CALLS = 100_000
_VARIABLE = "RCX_LIBRARIES"
_FOLDER = "RCX_REPOSITORIES"
#: Pattern of names and numbers in a message. They are replaced to group messages by reason.
_NAMES = re.compile(r"'[^']*'|\b\w*\d\w*\b|\b[A-Z_]\w*\b")
_SHOWN = 10


@dataclass(frozen=True)
class Share:
    """The result for a library from `RCX_LIBRARIES`.

    Attributes:
        files: Number of files.
        refused: Number of files with errors.
        reasons: Maps each reason to its number of occurrences.
    """

    files: int
    refused: frozenset[Path]
    reasons: tuple[tuple[str, int], ...]

    @property
    def percent(self) -> float:
        """Return the share of files without an error [%]."""
        return 100.0 * (self.files - len(self.refused)) / self.files


@dataclass
class Result:
    """The result for a repository from `RCX_REPOSITORIES`.

    Attributes:
        files: The measured files of the repository.
        refusals: The refused files.
    """

    files: list[Path] = field(default_factory=list)
    refusals: Refusals = field(default_factory=Refusals)

    @property
    def accepted(self) -> list[Path]:
        """Return the files in which the front end finds no error."""
        return [file for file in self.files if file not in self.refusals.files]

    def percent(self, kind: Kind) -> float:
        """Return the share of the files that are refused for a reason of this kind [%]."""
        return 100.0 * self.refusals.count(kind) / max(1, len(self.files))


def sources_of(entry: Path) -> list[Path]:
    """Return the sources of a library: its files, or the declarations of its project.

    Raises:
        InputError: there are no sources, or the project cannot be read.
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
    """Return whether an error is in a file, or inside a declaration of a project."""
    if error.file != str(file):
        return False
    lines = [line.at for line in getattr(file, "lines", None) or ()]
    return not lines or min(lines) <= (error.line or 0) <= max(lines)


def result(repository: Repository, root: Path) -> Result:
    """Check the programs of a repository, and classify the refused files.

    Raises:
        InputError: a checkout lacks expected files.
    """
    libraries = references(repository.folder(root))
    found = Result()
    for entries in repository.programs(root):
        files, refusals = _program(entries, libraries, repository)
        known = set(found.files)  # a library that several programs use is counted once
        found.files += [file for file in files if file not in known]
        found.refusals.merge(refusals)
    return found


def _program(
    entries: Sequence[Path], libraries: frozenset[str], repository: Repository
) -> tuple[list[Path], Refusals]:
    """Check the files of a program together.

    A project that cannot be read counts as one refused file.
    """
    try:
        named = named_files(entries)
        projects = [file for file in named if is_project(file)]
        made = project_sources(projects, {}, repository.device).paths if projects else ()
    except InputError as error:
        at = Path(error.file or entries[0])
        return [at], classified([at], {at: [error]}, libraries, repository.reviewed)
    files = [*(file for file in named if file not in projects), *made]
    if dialect := DIALECTS.get(repository.tool):
        files = [in_dialect(file, dialect) for file in files]
    _, errors = analyse(files, every=True)
    places: dict[str, list[Path]] = {}
    for file in files:
        places.setdefault(str(file), []).append(file)
    refused: dict[Path, list[InputError]] = {}
    for one in errors:
        for file in places.get(one.file or "", []):
            if _is_in(file, one):
                refused.setdefault(file, []).append(one)
    return files, classified(files, refused, libraries, repository.reviewed)


def measure(options: Options) -> dict[str, Figure]:
    """Measure the repositories and libraries of the user, and print why files are refused.

    Raises:
        InputError: neither variable is set and matiec is not found, a library has no sources, or a
            checkout is at another commit.
    """
    entries = [Path(part) for part in os.environ.get(_VARIABLE, "").split(os.pathsep) if part]
    root = os.environ.get(_FOLDER, "")
    matiec, compiler = find_matiec(), find_c_compiler()
    console = Console(highlight=False, markup=False)
    if not entries and not root:
        hint = (
            f"set {_VARIABLE} to folders or projects of ST, separated by {os.pathsep!r}; or "
            f"{_FOLDER} to a folder with these repositories:\n{how_to_get()}"
        )
        if matiec is None or compiler is None:
            raise InputError("no libraries to measure", hint=hint)
        console.print(f"no libraries to measure: {hint}")
        return _rows(matiec, compiler, options, console)
    figures: dict[str, Figure] = {}
    libraries: list[list[Path]] = []
    if root:
        for repository, measured in _repositories(Path(root), console):
            gaps = measured.percent(Kind.GAP)
            figures[f"language {repository.name}"] = (
                shown(gaps, "% of files", f"beyond: {repository.beyond}")
                if repository.beyond
                else at_most(gaps, "% of files", MOST)
            )
            libraries.append(measured.accepted)
    for entry in entries:
        files = sources_of(entry)
        share = accepted(files)
        name = entry.stem if entry.is_file() else entry.name
        console.print(f"{name}: {share.files - len(share.refused)} of {share.files} files")
        for reason, times in share.reasons[:_SHOWN]:
            console.print(f"  {times} x {reason}")
        figures[f"language {name}"] = at_least(share.percent, "% of files", LEAST)
        libraries.append([file for file in files if file not in share.refused])
    if matiec is None or compiler is None:
        console.print("calls are not compared: matiec or a C compiler is not found")
        return figures
    found = compared(libraries, matiec, compiler, 1000 if options.quick else CALLS)
    console.print(f"{found.calls} calls of {found.pous} functions and blocks compared")
    for text in found.differences:
        console.print(f"  {text}")
    figures["language calls"] = shown(found.calls, "calls", "matiec")
    figures["language differences"] = at_most(len(found.differences), "functions", 0, "matiec")
    return figures | _rows(matiec, compiler, options, console)


def _rows(matiec: Matiec, compiler: str, options: Options, console: Console) -> dict[str, Figure]:
    """Compare random calls for each row of the table of dialects, and print each result."""
    compared, different, alone = [], [], 0
    for one in compared_rows(matiec, compiler, 1000 if options.quick else CALLS):
        console.print(one.text, soft_wrap=True)
        if one.calls:
            compared.append(one.calls)
        else:
            alone += 1
        if one.difference:
            different.append(one)
    return {
        "language rows": shown(len(compared), "rows of dialects", f"{alone} on one engine only"),
        "language calls of a row": shown(min(compared), "calls at least", "matiec"),
        "language rows that differ": at_most(len(different), "rows of dialects", 0, "matiec"),
    }


def _repositories(root: Path, console: Console) -> Iterator[tuple[Repository, Result]]:
    """Yield the results of the repositories in a folder.

    Print each result, and a table of all results.
    """
    table = Table(box=box.SIMPLE)
    for title in (
        "repository",
        "tool",
        "files",
        "accepted",
        *(kind.value for kind in Kind),
        "gaps",
    ):
        table.add_column(title, justify="left" if title in ("repository", "tool") else "right")
    for repository in REPOSITORIES:
        if not repository.folder(root).is_dir():
            console.print(f"{repository.name}: not in {root}")
            continue
        found = result(repository, root)
        refusals = found.refusals
        counts = {kind: refusals.count(kind) for kind in Kind}
        console.print(
            f"{repository.name}: {len(found.accepted)} of {len(found.files)} files, "
            + ", ".join(f"{kind.value} {count}" for kind, count in counts.items())
        )
        for kind, reasons in refusals.reasons.items():
            for reason, times in reasons.most_common(_SHOWN):
                example = refusals.examples[reason].removeprefix(f"{repository.folder(root)}/")
                console.print(f"  {kind.value}: {times} x {example}")
        table.add_row(
            repository.name,
            repository.tool,
            str(len(found.files)),
            str(len(found.accepted)),
            *(str(count) for count in counts.values()),
            f"{found.percent(Kind.GAP):.1f} %",
        )
        yield repository, found
    console.print(table)
