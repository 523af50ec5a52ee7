"""Unit tests in Structured Text, run as one test of pytest. `rcx mutants` uses this test."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rcx_harness.cell.sources import source_files
from rcx_harness.testing.suites import FRAMEWORK
from structured_text.projects.sources import Files
from structured_text.testing.suites.results import Results
from structured_text.testing.suites.run import LONGEST, run_suites
from structured_text.testing.suites.text import results_text

__all__ = ["check_suites"]


def check_suites(
    program: Files,
    *,
    lib: str | Path | None = None,
    scan: str | None = None,
    longest: str = LONGEST,
    only: Sequence[str] = (),
) -> Results:
    """Run the unit tests of a program, as `rcx test` does, and return their results.

    Args:
        program: A project, ST files, or a folder.
        lib: Folder of the library; None: the library of this package.
        scan: Period of the scan; default: the task's, or 10 ms.
        longest: Virtual time limit. Unfinished tests are stopped after this time.
        only: Names of tests, suites, or `suite.test`, with `*`; only these tests run.

    Raises:
        AssertionError: A test has failed or not finished; the text lists all of them.
        InputError: The sources contain an error, or nothing is selected.
    """
    sources = source_files(program, lib)
    results = run_suites(sources, FRAMEWORK, scan=scan, longest=longest, only=only)
    if not results.passed:
        raise AssertionError(results_text(results))
    return results
