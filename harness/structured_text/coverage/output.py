"""The coverage report on the disk: pages, lcov and Cobertura, and a table as text.

A new report replaces an earlier one, but never other files.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.coverage.formats import cobertura, tracefile
from structured_text.coverage.html import pages
from structured_text.coverage.measure import FileResult, measure
from structured_text.coverage.parts import Merged
from structured_text.coverage.report import summary, total
from structured_text.errors import COMMAND, InputError
from structured_text.output.files import replace_files
from structured_text.output.paths import real

__all__ = ["ENGINE", "Outcome", "check_fail_under", "check_folder", "conclude", "write_report"]

#: The reason why coverage needs the built-in engine, as part of a message.
ENGINE = "coverage is counted by the built-in engine"

#: Marks at the beginning of each file of a report. Files without such a mark are not overwritten.
_MARKS = (f"{COMMAND} coverage".encode(), f"TN:{COMMAND}_coverage".encode())
_HEAD = 200


@dataclass(frozen=True)
class Outcome:
    """The text to print about the coverage, and whether the coverage meets the requirements."""

    text: str
    passed: bool


def check_fail_under(option: str, given: float | str) -> float:
    """Return the required percentage, or raise InputError."""
    try:
        percent = float(given)
    except ValueError:
        percent = -1
    if not 0 <= percent <= 100:
        raise InputError(f"{option} is {given}", hint="give a percentage from 0 to 100")
    return percent


def conclude(
    merged: Merged,
    home: Path,
    folder: Path,
    *,
    fail_under: float | None = None,
    lost: Sequence[str] = (),
    width: int = 100,
) -> Outcome:
    """Write the report on the counts, or raise InputError.

    The name of `home` is the title of the report, and displayed paths are relative to it.
    `fail_under` is the required percentage of statements and branches together; `lost` names the
    processes that ended without saving their counts.
    """
    results = measure(merged, home)
    found = total(results)
    lines = [f"{one} died: its counts are missing" for one in lost]
    lines += [
        f"not counted: the {one} engine counts no coverage" for one in sorted(merged.elsewhere)
    ]
    changed = [result.path for result in results if result.changed]
    lines += [f"{path} was changed since it was compiled: run again" for path in changed]
    passed = not changed
    if not found.total:
        lines.append("nothing was counted: no program with statements was built")
        return Outcome("\n".join(lines), passed=passed and fail_under is None)
    files = write_report(results, folder, real(home).name, home)
    names = [os.path.relpath(one) if one.is_relative_to(Path.cwd()) else str(one) for one in files]
    told = f"coverage of statements and branches: {found.shown}"
    if fail_under is not None:
        passed = passed and 100 * found.covered >= fail_under * found.total
        told += f", {'as' if passed else 'FAIL:'} at least {fail_under:g} % is demanded"
    table = summary(results, width)
    return Outcome("\n".join([table, "", *lines, told, f"written: {', '.join(names)}"]), passed)


def check_folder(folder: Path) -> None:
    """Refuse a folder in which a report could not be written.

    Raise InputError if it is a file, or contains an index.html or a similar file that is not from a
    report.
    """
    if os.path.exists(folder) and not os.path.isdir(folder):
        raise InputError(
            "is not a folder", file=folder, hint="name another folder for the coverage report"
        )
    for name in ("index.html", "coverage.lcov", "mcdc.lcov", "coverage.xml"):
        _check(folder / name)


def write_report(
    results: Sequence[FileResult], folder: Path, title: str, home: Path, *, absolute: bool = False
) -> list[Path]:
    """Write index.html, a page per file, coverage.lcov, mcdc.lcov (with MC/DC) and coverage.xml.

    The folder is created, and superfluous pages of an earlier report are removed. Paths of source
    files are relative to `home`; with `absolute`, lcov gets absolute paths. Raise InputError if an
    existing file is not from a report, or a file cannot be written.

    Returns:
        The first page, and the files for other tools.
    """
    made: dict[Path, bytes | str] = {
        folder / name: text for name, text in pages(results, title).items()
    }
    others = [folder / name for name in ("coverage.lcov", "coverage.xml")]
    above = home if absolute else None
    made[others[0]] = tracefile(results, above)
    made[folder / "mcdc.lcov"] = tracefile(results, above, mcdc=True)
    made[others[1]] = cobertura(results, home)
    for file in made:
        _check(file)
    replace_files(made)
    for file in sorted({*folder.glob("*.html")} - {*made}):
        if _is_ours(file):
            file.unlink(missing_ok=True)
    return [folder / "index.html", *others]


def _check(file: Path) -> None:
    if os.path.exists(file) and not _is_ours(file):
        raise InputError(
            "already exists and is not a coverage report; nothing was written",
            file=file,
            hint="name another folder, or remove this file",
        )


def _is_ours(file: Path) -> bool:
    try:
        with file.open("rb") as stream:
            head = stream.read(_HEAD)
    except OSError:
        return False
    return not head or any(mark in head for mark in _MARKS)
