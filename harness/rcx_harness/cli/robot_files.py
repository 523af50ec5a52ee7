"""The part of `rcx check` for robot programs: files `.PGM` and `.ALL`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from pathlib import Path

from rcx_harness.cli.findings import Finding
from rcx_harness.cli.options import counted
from rcx_harness.robot.program import Program, read_program, text_of
from rcx_harness.robot.program.all_file import read_all
from rcx_harness.robot.program.checks import endless_loops, problems
from structured_text.errors import InputError, legible

__all__ = ["check_robot_files"]

#: The size of the areas for the checks. A program file does not contain it, so the larger size is
#: used.
_SIZE = 256


def check_robot_files(files: Sequence[Path]) -> tuple[list[Finding], str]:
    """Check robot programs, and print all errors and warnings with their lines.

    Returns:
        The findings, and the sentence that sums them up; the sentence is empty if there are errors.
    """
    findings = []
    for file in files:
        for error, certain in _findings(file):
            kind = "error" if certain else "warning"
            print(legible(f"{kind}: {error}"), file=sys.stderr if certain else sys.stdout)
            findings.append(Finding.of_error(error, "robot-program", kind))
    if any(finding.level == "error" for finding in findings):
        return findings, ""
    return findings, (
        f"{counted(len(files), 'file')} of robot programs checked: no errors, "
        f"{counted(len(findings), 'warning')}"
    )


def _findings(file: Path) -> Iterator[tuple[InputError, bool]]:
    """Yield each finding of a file, and whether the finding is an error."""
    if file.suffix.lower() == ".pgm":
        yield from _of_program(file, text_of(file), 0, ())
        return
    content = read_all(file)
    names = [source.name for source in content.programs]
    for source in content.programs:
        yield from _of_program(file, source.text, source.offset, names)
    for text in content.passed_over:
        yield InputError(f"skipped: {text}", file=file), False


def _of_program(
    file: Path, text: str, offset: int, names: Sequence[str]
) -> Iterator[tuple[InputError, bool]]:
    if not text.strip():
        yield InputError("the program has no statement", file=file, line=offset + 1), True
        return
    program, errors = read_program(text)
    if program is not None:
        errors = problems(program, _SIZE, names)
    for error in errors:
        line = (error.line or 0) + offset
        yield InputError(error.message, file=file, line=line, hint=error.hint), True
    if program is not None:
        yield from ((error, False) for error in _warnings(file, program, offset))


def _warnings(file: Path, program: Program, offset: int) -> Iterator[InputError]:
    for line in endless_loops(program):
        yield InputError(
            "this loop never ends and has no wait",
            file=file,
            line=line + offset,
            hint="add a WAIT or a DELAY; the controller goes on with its other tasks",
        )
