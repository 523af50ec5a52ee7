"""`rcx import`: the Structured Text of a project, one declaration per file."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import Device, counted
from structured_text.errors import InputError, legible
from structured_text.language.dialects import rules_of
from structured_text.language.source import source_text
from structured_text.output.files import replace_files
from structured_text.output.paths import real
from structured_text.projects.diagrams.sfc.text import with_charts
from structured_text.projects.formats import is_project
from structured_text.projects.model import Project
from structured_text.projects.open import read_project
from structured_text.projects.sources import named_files
from structured_text.projects.texts import st_texts

__all__ = ["import_"]


def import_(
    files: Annotated[
        list[Path],
        typer.Argument(
            help="PLCopen XML, a TwinCAT folder or .plcproj, .L5X, .scl.", metavar="FILES..."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder to write into.")],
    device: Device = "",
    force: Annotated[
        bool, typer.Option("--force", help="Overwrite files of the same names.")
    ] = False,
) -> None:
    """Write the Structured Text of a project as .st files, one for each declaration.

    An .st file with a chart (INITIAL_STEP) is written with the statements of the chart.

    You do not need it to run a project: `rcx run` and `rcx check` read the project itself.

    Exit code: 0; 1 if a body is in another language: its file has the interface, and a comment in
    place of the body; 2 on bad input or if a file exists.
    """
    named = named_files(files)
    charts: dict[str, str] = {}
    origins: dict[str, Path] = {}
    for file in named:
        if is_project(file):
            continue
        chart = with_charts(file) if file.suffix.lower() == ".st" else file
        if chart is not file:
            _check_target(file, out, origins)
            charts[file.name] = source_text(chart)
        else:
            raise InputError(
                "is already Structured Text, or is not a project that can be read",
                file=file,
                hint="name a PLCopen .xml, a TwinCAT folder or .plcproj, an .L5X or an .scl",
            )
    projects = [file for file in named if is_project(file)]
    project = read_project(projects, device) if projects else Project()
    written = st_texts(project)
    for name in written:
        if name.casefold() in origins:
            raise InputError(
                f"the project also writes a file {name}",
                file=origins[name.casefold()],
                hint="import the file and the project into different folders",
            )
    texts = {**charts, **written}
    there = [out / name for name in texts if os.path.exists(out / name)]
    if there and not force:
        others = f", and {counted(len(there) - 1, 'more file')}" if len(there) > 1 else ""
        raise InputError(
            f"already exists{others}; nothing was written",
            file=there[0],
            hint="name another folder, or overwrite them with --force",
        )
    replace_files({out / name: text for name, text in texts.items()})
    for note in project.notes:
        print(legible(f"note: {note}"))
    foreign = [(unit, one) for unit in project.units for one in unit.piece.foreign()]
    for unit, (name, body) in foreign:
        says = f"not carried: {unit.file}:{body.at}: the body of {name} {body.says}"
        print(legible(says))
    print(f"written: {counted(len(texts), 'file')} in {out}")
    spoken = dict.fromkeys(name for name, _ in project.dialects if not rules_of(name).is_standard)
    if len(spoken) == 1:
        # An .st file does not name the PLC tool that it comes from, so the command needs --dialect.
        print(f"run it as the project: rcx run {out} --dialect {next(iter(spoken))}")
    if foreign:
        raise typer.Exit(1)


def _check_target(file: Path, out: Path, origins: dict[str, Path]) -> None:
    """Raise InputError if the translation of a chart would overwrite an input or another one."""
    first = origins.setdefault(file.name.casefold(), file)
    if first is not file:
        hint = "rename one of them, or import them into different folders"
        raise InputError(f"has the same name as {first}", file=file, hint=hint)
    if real(out / file.name) == real(file):
        raise InputError("would be overwritten", file=file, hint="name another folder with -o")
