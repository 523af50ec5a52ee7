"""The options for coverage, and the functions with which commands measure and report it."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from structured_text.engines.builtin.collector import Collector
from structured_text.errors import InputError

__all__ = ["CoverFailUnder", "Coverage", "CoverageOut", "concluded", "requested_collector"]

if TYPE_CHECKING:
    from structured_text.coverage.output import Outcome

#: Default folder of the coverage report.
_FOLDER = Path("out/coverage")

#: The option that measures coverage.
Coverage = Annotated[
    bool,
    typer.Option("--coverage", help="Measure the coverage of statements, branches and MC/DC."),
]
#: The option for the folder of the report.
CoverageOut = Annotated[
    Path | None, typer.Option(help="Folder of the coverage report. Default: out/coverage.")
]
#: The option for the required coverage.
CoverFailUnder = Annotated[
    str | None,
    typer.Option(help="Exit code 1 if less of the statements and branches is covered [%]."),
]


def requested_collector(
    *, coverage: bool, folder: Path | None, fail_under: str | None, library: bool = False
) -> Collector | None:
    """Return the collector that the options request; None without coverage.

    Raises:
        InputError: an option of coverage is given without --coverage, a percentage is wrong, or the
            report cannot be written into the folder.
    """
    if not coverage:
        given = {
            "--coverage-out": folder,
            "--coverage-library": library,
            "--cover-fail-under": fail_under,
        }
        for option, value in given.items():
            if value not in (None, False):
                raise InputError(f"{option}: no coverage is counted", hint="add --coverage")
        return None
    from structured_text.coverage.output import check_fail_under, check_folder

    if fail_under is not None:
        check_fail_under("--cover-fail-under", fail_under)
    check_folder(folder or _FOLDER)
    return Collector(library=library)


def concluded(collector: Collector, folder: Path | None, fail_under: str | None) -> Outcome:
    """Write the coverage report and return its summary."""
    from structured_text.coverage.output import conclude
    from structured_text.coverage.parts import merge, part_of

    return conclude(
        merge([part_of(collector)]),
        Path.cwd(),
        folder or _FOLDER,
        fail_under=None if fail_under is None else float(fail_under),
        width=shutil.get_terminal_size((100, 24)).columns,
    )
