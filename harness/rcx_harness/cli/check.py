"""`rcx check`: check sources for mistakes, and for constructs that other compilers refuse."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import replace as replace_source
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from rcx_harness.cell.sources import blame_lib, library_names, source_files
from rcx_harness.cli.findings import (
    JSON_BEGINNING,
    SARIF_BEGINNING,
    Finding,
    as_json,
    as_sarif,
)
from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.options import (
    Device,
    Dialect,
    Lib,
    Replace,
    Sources,
    counted,
    interval_us,
    replacements,
)
from rcx_harness.cli.refused_text import grouped
from rcx_harness.watch.source_findings import source_findings
from structured_text.errors import InputError, legible
from structured_text.export.refused import Tool, refused, tools
from structured_text.language.checked import analysed, load
from structured_text.language.load import first_errors
from structured_text.language.portability import LintFinding, lint
from structured_text.language.project import Project
from structured_text.language.unread import unread_bodies
from structured_text.output.files import replace_files
from structured_text.projects.sources import SourceFiles

if TYPE_CHECKING:
    from structured_text.engines.matiec.faults import Place

__all__ = ["check"]

#: Name endings of robot programs, and of files with all data of a controller.
_ROBOT_FILES = (".pgm", ".all")


def check(
    files: Sources,
    lib: Lib = None,
    replace: Replace = None,
    dialect: Dialect = None,
    device: Device = "",
    lint_only: Annotated[
        bool, typer.Option("--lint", help="Check the portability rules only, for every file.")
    ] = False,
    stubs: Annotated[
        Path | None,
        typer.Option(help="Write the missing interfaces, as ST files, into this folder."),
    ] = None,
    tool: Annotated[
        str | None,
        typer.Option(
            "--for",
            help=f"List what this tool refuses: {', '.join(tools())}.",
            autocompletion=lambda: [(name, one.title) for name, one in tools().items()],
        ),
    ] = None,
    strict: Annotated[
        bool, typer.Option("--strict", help="Exit with 1 on warnings and uncertain refusals, too.")
    ] = False,
    rpi: Annotated[
        str, typer.Option(help="Packet interval, for warnings of pins Timeout and Margin.")
    ] = "10ms",
    json_file: JsonFile = None,
    sarif: Annotated[
        Path | None,
        typer.Option(help="Write the findings to this file as SARIF, for code scanning."),
    ] = None,
) -> None:
    """Check ST sources: syntax, types, portability, calls; also with matiec if it is installed.

    Each block of a robot must be called once per scan, between FB_ReadArea and FB_WriteArea. Common
    first mistakes, such as a pin Connected that is not wired, are warnings; each names the section
    of docs/how-to/first-mistakes.md that explains it.

    Robot programs (.PGM) and files with all data of a controller (.ALL) are checked, too: all
    statements, blocks, labels, ports and tasks.

    With --stubs DIR the command writes the interface of each type, block and function of a library
    that is not given, as far as your files show it, and checks your files with these interfaces.

    With --for NAME the command lists the kinds of constructs that this PLC tool refuses in your
    files, and those that it may refuse because no public document answers the question.

    Exit code: 0 if there are at most warnings, 1 if a rule of the library or of its calls is broken
    or the tool of --for is known to refuse something, 2 on an error in the sources.
    """
    if tool is not None and tool not in tools():
        raise InputError(f"--for {tool}: no such tool", hint=f"use {', '.join(tools())}")
    if tool is not None and lint_only:
        raise InputError("--for and --lint exclude each other")
    if stubs is not None and lint_only:
        raise InputError("--stubs and --lint exclude each other")
    if json_file is not None and json_file == sarif:
        raise InputError("--json and --sarif name the same file", file=sarif)
    rpi_us = interval_us("--rpi", rpi)
    written = JsonOutput(json_file, JSON_BEGINNING, files or ())
    log = JsonOutput(sarif, SARIF_BEGINNING, files or ())
    findings: list[Finding] = []
    summary = ""
    with written.apart(), log.apart():
        programs = [file for file in files or () if file.suffix.lower() in _ROBOT_FILES]
        others = [file for file in files or () if file not in programs]
        if programs:
            # Import here: the module loads the virtual controller, which only robot programs need.
            from rcx_harness.cli.robot_files import check_robot_files

            findings, summary = check_robot_files(programs)
            if summary:
                print(summary)
        if (summary or not programs) and (others or not programs):
            named = others or files
            given = _Given(named, lib, replace, dialect, device, lint_only, stubs, tool, rpi_us)
            found, summary = _checked(given)
            findings += found
            if summary:
                print(summary)
    written.write(as_json(findings, summary))
    log.write(as_sarif(findings, Path.cwd()))
    if code := _exit_code(findings, strict):
        raise typer.Exit(code)


def _exit_code(findings: Sequence[Finding], strict: bool) -> int:
    levels = {finding.level for finding in findings}
    if "error" in levels:
        return 2
    return int("rule" in levels or (strict and "warning" in levels))


class _Given(NamedTuple):
    """The sources and options of a check."""

    files: list[Path]
    lib: Path | None
    replace: list[str] | None
    dialect: str | None
    device: str
    lint_only: bool
    stubs: Path | None
    tool: str | None
    rpi_us: int


def _checked(given: _Given) -> tuple[list[Finding], str]:
    """Check Structured Text, and print the findings.

    Return the findings, and the sentence that sums them up; it is empty after errors.
    """
    lib, lint_only = given.lib, given.lint_only
    # With --lint each file is checked separately, so a call may name folders with several programs.
    sources = source_files(
        given.files, lib, replacements(given.replace), given.dialect, given.device
    )
    for note in sources.notes:
        print(legible(f"note: {note}"))
    if given.stubs is not None:
        sources = _with_stubs(sources, given.stubs)
    project, errors = (None, []) if lint_only else analysed(sources.all, sys.maxsize)
    if errors:
        from structured_text.projects.missing import by_library

        errors = first_errors(by_library(errors, sources.missing, sources.declared))
        errors = [blame_lib(error, lib) for error in errors]
        for error in errors:
            print(f"error: {error}", file=sys.stderr)
        return [Finding.of_error(error) for error in errors], ""
    if given.tool is not None and project is not None:
        program = None if given.replace else given.files
        return _refused(tools()[given.tool], sources, project, program)
    prefix = library_names(lib).prefix
    faulty: list[Place] = []
    if lint_only:
        _, library = sources.users
        checked = lint(sources.own, library, sources.lib, binding=True, prefix=prefix)
        found = [(finding, "portability") for finding in checked]
    else:
        assert project is not None
        faulty = _faults(project)
        faults = [
            (LintFinding(one.file, one.at, one.text, strict=False), "matiec-fault")
            for one in faulty
        ]
        every = [*source_findings(sources, project, prefix, given.rpi_us), *faults]
        found = sorted(dict.fromkeys(every), key=lambda one: (str(one[0].file), one[0].at))
    for finding, _ in found:
        print(legible(str(finding)))
    strict = sum(finding.strict for finding, _ in found)
    broken, files_read = counted(strict, "broken rule"), counted(len(sources.own), "file")
    findings = [Finding.of_lint(finding, rule) for finding, rule in found]
    if lint_only:
        return findings, f"{files_read} checked for portability: {broken}"
    warnings = counted(len(findings) - strict, "warning")
    return findings, (
        f"{files_read} checked with the library: no errors, {broken}, {warnings}"
        f"{_compile(sources, project, faulty)}"
    )


def _with_stubs(sources: SourceFiles, folder: Path) -> SourceFiles:
    """Write an interface file for each missing name, and return the sources with the new files.

    Raise InputError if a file already exists, because it may be the user's.
    """
    from structured_text.projects.stubs.write import infer_stubs

    found = infer_stubs(sources.all, sources.missing, sources.declared)
    there = [folder / name for name in found.texts if os.path.lexists(folder / name)]
    if there:
        others = f", and {counted(len(there) - 1, 'more file')}" if len(there) > 1 else ""
        raise InputError(
            f"already exists{others}; nothing was written",
            file=there[0],
            hint=f"name {folder} as a source, too, or another folder for --stubs",
        )
    files = {folder / name: text for name, text in found.texts.items()}
    replace_files(files)
    if files:
        print(f"written: {counted(len(files), 'interface')} in {folder}; check it with the program")
    else:
        print("nothing is missing: no interface was written")
    return replace_source(sources, own=(*sources.own, *files))


def _refused(
    tool: Tool, sources: SourceFiles, project: Project, program: list[Path] | None
) -> tuple[list[Finding], str]:
    """Print the constructs that a tool refuses or may refuse, and return them."""
    found = refused(tool, sources, project, program)
    for line in grouped(found):
        print(legible(line))
    if tool.note:
        print(f"note: {tool.note}; rcx export {tool.export} writes them")
    certain = sum(one.certain for one in found)
    findings = [
        Finding.of_lint(
            LintFinding(one.file, one.at, one.text, one.certain),
            "refused" if one.certain else "may-be-refused",
        )
        for one in found
    ]
    return findings, (
        f"{counted(len(sources.own), 'file')} checked for {tool.title}: "
        f"{certain or 'nothing'} refused, {len(found) - certain or 'nothing'} that may be refused"
    )


def _faults(project: Project | None) -> list[Place]:
    """Return the known faults of matiec that affect the program; empty if it does not compile."""
    if project is None or project.uses:
        return []
    from structured_text.engines.matiec.faults import places, warnings

    return warnings(places(project))


def _compile(sources: SourceFiles, project: Project | None, faulty: Sequence[Place]) -> str:
    """If matiec supports the form of the sources, compile them with matiec as well."""
    if project is not None and project.uses:
        return "; not portable: it runs on the built-in engine only"
    if any(one.fault.refused for one in faulty):
        return "; matiec cannot compile it: it runs on the built-in engine only"
    from structured_text.engines.matiec.build import find_matiec
    from structured_text.engines.native.toolchain import find_c_compiler

    matiec, compiler = find_matiec(), find_c_compiler()
    if matiec is None or compiler is None:
        return "; matiec not found, compiled by the front end only"
    if project is None or not any(pou.kind == "PROGRAM" for pou in project.pous.values()):
        return "; no PROGRAM among them, nothing for matiec to compile"
    if unread_bodies(sources.all):
        return "; matiec does not compile bodies in other languages"
    from structured_text.engines.matiec.program import MatiecProgram

    try:
        MatiecProgram.build(load(sources.all), matiec, compiler).close()
    except InputError as error:
        return f"; the built-in engine runs it, matiec does not: {error}"
    from structured_text.engines.matiec.faults import is_new

    other = "old" if is_new(matiec) else "new"
    if any(one.fault.versions != other for one in faulty):
        return "; matiec compiles them too, with the faults above: use the built-in engine"
    return "; matiec compiles them too"
