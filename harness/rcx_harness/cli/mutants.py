"""`rcx mutants`: small mistakes in a program, as a check of its tests."""

from __future__ import annotations

import json
import os
import sys
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.farm import FarmOptions
from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.junit_option import Junit, junit_file, mutants_suite
from rcx_harness.cli.options import Dialect, Lib, with_options
from structured_text.coverage.output import check_fail_under
from structured_text.errors import InputError
from structured_text.output.reading import check_file

__all__ = ["mutants"]

_BEGINNING = '{"mutants": '
_SHOWN = 20
_REASONS = Path("mutants.toml")
_ROWS = "mutants-without-reason.toml"


@dataclass(frozen=True)
class Options(FarmOptions):
    """The options of `rcx mutants`."""

    files: Annotated[list[Path], typer.Argument(help="ST files of the program, or folders.")]
    lib: Lib = None
    dialect: Dialect = None
    minutes: Annotated[
        float | None,
        typer.Option(help="Time after which no new mutant begins; the next call continues."),
    ] = None
    fail_under: Annotated[
        str,
        typer.Option(help="Exit code 1 if fewer of the mutants without a reason are killed [%]."),
    ] = "100"
    reasons: Annotated[
        Path, typer.Option(help="File of survivors that no test can find, with the reason (TOML).")
    ] = _REASONS
    folder: Annotated[Path, typer.Option(help="Folder for the results of earlier calls.")] = Path(
        ".rcx"
    )
    fresh: Annotated[bool, typer.Option("--fresh", help="Ignore the results of earlier calls.")] = (
        False
    )
    show: Annotated[int, typer.Option(help="Number of survivors to print; 0: all.", min=0)] = _SHOWN
    json_file: JsonFile = None
    junit: Junit = None
    word: Annotated[list[str] | None, typer.Option(hidden=True)] = None


@with_options(Options)
def mutants(given: Options) -> None:
    """Put small mistakes into a program, one at a time, and report which of them its tests find.

    `rcx mutants plc -- pytest`: the command after `--` runs the tests. Each mistake is made in
    a copy; only the tests that execute its statement are run.

    Exit code: 0 if enough mutants are killed, 1 if not, 2 on bad input or failing tests.
    """
    if not given.word:
        hint = f"write rcx mutants {given.files[0]} -- pytest"
        raise InputError("no command for the tests is given", hint=hint)
    percent = check_fail_under("--fail-under", given.fail_under)
    if given.minutes is not None and not given.minutes >= 0:
        raise InputError(f"--minutes is {given.minutes:g}", hint="give 0 or more")
    output = JsonOutput(given.json_file, _BEGINNING, [given.reasons])
    junit = junit_file(given.junit, given.json_file, [given.reasons])
    _check_outputs(given)
    started = time.monotonic()

    from structured_text.mutants.judging import Judging, is_outcome
    from structured_text.mutants.report import Reasons, write_rows
    from structured_text.mutants.sessions import PytestCommand
    from structured_text.mutants.user import UserMutants
    from structured_text.output.results import Results

    reasons = Reasons(given.reasons)
    outputs = [given.junit, None if output.printed else given.json_file]
    written = [file for file in outputs if file is not None]
    sources, run = source_files(given.files, given.lib), PytestCommand.of(given.word, Path.cwd())
    work = UserMutants(sources, run, written)
    console = Console(stderr=True)
    with console.status("running the tests with the unchanged program ..."):
        tests = work.baseline()
    until = None if given.minutes is None else started + 60 * given.minutes
    results = Results(given.folder / "mutants.jsonl", fresh=given.fresh, is_whole=is_outcome)
    if results.notice:
        print(results.notice, file=sys.stderr)
    judging, farm = Judging(console, results, until), given.farm(console)
    try:
        verdicts = work.judged(tests, judging, farm, reasons)
    except KeyboardInterrupt:
        print(f"finished results are in {given.folder}; the same call continues")
        raise
    found = verdicts.figures
    rows = given.folder / _ROWS
    write_rows(rows, found["survivors"])
    junit.write([mutants_suite(verdicts)])
    with output.apart():
        _print(found, given.show or sys.maxsize, rows)
        junit.say()
    output.write(f"{_BEGINNING}{json.dumps(found, indent=1)}}}\n")
    if found["score_without_reasons"] < percent:
        raise typer.Exit(1)


def _check_outputs(given: Options) -> None:
    """Raise InputError if an output would overwrite a file of the user."""
    if given.reasons != _REASONS or os.path.lexists(given.reasons):
        check_file(given.reasons)
    if os.path.exists(given.folder) and not os.path.isdir(given.folder):
        raise InputError("is not a folder", file=given.folder, hint="give another --folder")


def _print(found: Mapping[str, Any], show: int, rows: Path) -> None:
    table = Table("file", "mutants", "killed", "survive", "killed [%]", box=None, pad_edge=False)
    for column in table.columns[1:]:
        column.justify = "right"
    for name, one in found["score_by_folder"].items():
        survive = one["mutants"] - one["killed"]
        table.add_row(name, *map(str, (one["mutants"], one["killed"], survive, one["score"])))
    Console().print(table, highlight=False)
    unreached = {(one["file"], one["line"], one["after"]) for one in found["unreached"]}
    unexplained = [row for row in found["survivors"] if not row["reason"]]
    for row in unexplained[:show]:
        more = ""
        if (row["file"], row["line"], row["after"]) in unreached:
            more = ", and no test runs this line"
        print(f"{row['file']}:{row['line']}: {row['operator']} survives{more}")
        for sign, text in (("-", row["before"]), ("+", row["after"] or "(nothing)")):
            print("\n".join(f"  {sign} {line}" for line in text.splitlines()))
    if len(unexplained) > show:
        print(f"... and {len(unexplained) - show} more survive: --show 0 shows all")
    for row in found["rows_without_a_survivor"]:
        print(f"a test now finds it, so its reason can be deleted: {row}")
    for row in found["rows_without_a_mutant"]:
        print(f"there is no such mutant, so its reason can be deleted: {row}")
    if unexplained:
        print(f"rows for mutants that no test can find: {rows}")
    print(_sum(found, len(unexplained)))


def _sum(found: Mapping[str, Any], unexplained: int) -> str:
    explained = found["survivors_with_a_reason"]
    parts = [f"{found['killed']} of {found['mutants']} mutants killed"]
    if found["timed_out"]:
        parts.append(f"{found['timed_out']} of these by tests that do not end")
    parts.append(f"{unexplained} survive")
    if explained:
        parts.append(f"{explained} more with a reason")
    if found["not_run"]:
        parts.append(f"{found['not_run']} NOT RUN YET (the next call continues)")
    if found["not_compiling"]:
        parts.append(f"{found['not_compiling']} do not compile and are not counted")
    return f"{', '.join(parts)}: {found['score_without_reasons']:.1f} %"
