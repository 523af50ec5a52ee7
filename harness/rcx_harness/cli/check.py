"""`rcx check`: are these sources right, and will they compile elsewhere too."""

from __future__ import annotations

import sys
from pathlib import Path

from rcx_harness.cell.build import SourceFiles, blame_lib, source_files
from rcx_harness.engine.frontend import check as check_sources
from rcx_harness.engine.frontend import load
from rcx_harness.engine.frontend.parser import parse
from rcx_harness.engine.frontend.syntax import Pou
from rcx_harness.engine.load import find_c_compiler, find_matiec
from rcx_harness.engine.matiec.program import MatiecProgram
from rcx_harness.engine.portability import LintFinding, lint
from rcx_harness.watch.calls_source import call_findings

__all__ = ["check"]


def check(files: list[Path], lib: Path | None, lint_only: bool = False) -> int:
    """Check sources and print what is found, one line each.

    Args:
        files: The user's files or folders; those below `lib` are held to the library's rules.
        lib: Folder of the library; None for that of this package.
        lint_only: Check nothing but the portability rules, each file by itself, and let them
            bind every file; so that folders with several programs can be checked at once.

    Returns:
        0 if all is well, 1 if a rule of the library or of its use is broken, 2 on errors in the
        sources.

    Raises:
        InputError: a file that is missing, or an error that only matiec finds.
    """
    sources = source_files(files, lib)
    errors = [] if lint_only else check_sources(sources.all)
    for error in errors:
        print(f"error: {blame_lib(error, lib)}", file=sys.stderr)
    if errors:
        return 2
    users, library = sources.users
    findings = lint(sources.own, library, sources.lib, binding=lint_only)
    if not lint_only:
        called = call_findings(users, library)
        findings += [LintFinding(one.file, one.at, one.text, one.certain) for one in called]
    for finding in findings:
        print(finding)
    strict = sum(finding.strict for finding in findings)
    broken, files_read = _count(strict, "broken rule"), _count(len(sources.own), "file")
    if lint_only:
        print(f"{files_read} checked for portability: {broken}")
    else:
        warnings = _count(len(findings) - strict, "warning")
        print(
            f"{files_read} checked with the library: no errors, {broken}, {warnings}"
            f"{_compile(sources)}"
        )
    return 1 if strict else 0


def _compile(sources: SourceFiles) -> str:
    """Compile with matiec too, if there is something to run."""
    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        return "; matiec not found, compiled by the front end only"
    declared = [entry for file in sources.own for entry in parse(file).declarations]
    if not any(isinstance(one, Pou) and one.kind == "PROGRAM" for one in declared):
        return "; no PROGRAM among them, nothing for matiec to compile"
    MatiecProgram.build(load(sources.all), matiec, compiler).close()
    return "; matiec compiles them too"


def _count(number: int, what: str) -> str:
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"
