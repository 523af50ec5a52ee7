"""`rcx test`: run the unit tests that a program has in Structured Text."""

from __future__ import annotations

import sys
from contextlib import nullcontext
from dataclasses import dataclass
from typing import Annotated

import typer

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.coverage_options import (
    Coverage,
    CoverageOut,
    CoverFailUnder,
    concluded,
    requested_collector,
)
from rcx_harness.cli.junit_option import Junit
from rcx_harness.cli.options import (
    Device,
    Dialect,
    Lib,
    Replace,
    Sources,
    replacements,
    with_options,
)
from rcx_harness.cli.progress import progress_bar
from rcx_harness.testing.suites import FRAMEWORK
from structured_text.engines.builtin.collector import counting
from structured_text.errors import legible
from structured_text.output.junit import JunitFile
from structured_text.testing.suites.junit_suites import junit_suites
from structured_text.testing.suites.run import LONGEST, run_suites
from structured_text.testing.suites.text import results_text

__all__ = ["test_"]


@dataclass(frozen=True)
class Options:
    """The options of `rcx test`."""

    files: Sources
    only: Annotated[
        list[str] | None,
        typer.Option(help="Run only this test, suite or Suite.Test; * is allowed. Repeatable."),
    ] = None
    junit: Junit = None
    duration: Annotated[
        str, typer.Option("--for", help="Virtual time after which unfinished tests are stopped.")
    ] = LONGEST
    scan: Annotated[
        str | None, typer.Option(help="Period of the scan. Default: that of the task, or 10ms.")
    ] = None
    lib: Lib = None
    replace: Replace = None
    dialect: Dialect = None
    device: Device = ""
    coverage: Coverage = False
    coverage_out: CoverageOut = None
    cover_fail_under: CoverFailUnder = None


@with_options(Options)
def test_(given: Options) -> None:
    """Run the unit tests of a program: TcUnit suites, in virtual time, without TwinCAT.

    Suites are blocks that extend FB_TestSuite; a program calls RUN or RUN_IN_SEQUENCE. Leave the
    library TcUnit itself out: its interface is built in. Files with TEST blocks, as STruC++ has
    them, run as well.

    Exit code: 0 if all tests have passed, 1 if a test has failed or not finished, or with too
    little coverage, 2 on bad input.
    """
    collector = requested_collector(
        coverage=given.coverage, folder=given.coverage_out, fail_under=given.cover_fail_under
    )
    sources = source_files(
        given.files, given.lib, replacements(given.replace), given.dialect, given.device
    )
    junit = JunitFile(given.junit, sources.all)
    if collector is not None:
        collector.leave_out(FRAMEWORK.folder)
    with (
        progress_bar("testing", shown=True) as progress,
        counting(collector) if collector else nullcontext(),
    ):
        results = run_suites(
            sources,
            FRAMEWORK,
            scan=given.scan,
            longest=given.duration,
            only=given.only or (),
            progress=progress,
        )
    junit.write(junit_suites(results), results.duration_us / 1e6)
    for note in sources.notes:
        if f"library {FRAMEWORK.namespace} is" not in note:  # the interface of TcUnit is built in
            print(legible(f"note: {note}"))
    print(legible(results_text(results)))
    junit.say()
    covered = True
    if collector is not None:
        outcome = concluded(collector, given.coverage_out, given.cover_fail_under)
        print(f"\n{outcome.text}")
        covered = outcome.passed
    if not (results.passed and covered):
        sys.stdout.flush()
        raise typer.Exit(1)
