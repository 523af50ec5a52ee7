"""`rcx format`: lay out Structured Text as the library is laid out."""

from __future__ import annotations

import difflib
import sys
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.options import counted
from structured_text.editor.format.files import FileLayout, layout_of, write_layout
from structured_text.errors import InputError, legible
from structured_text.projects.sources import named_files

__all__ = ["format_"]

#: Name endings of robot programs, and of files with all data of a controller.
_ROBOT_FILES = (".pgm", ".all")


def format_(
    files: Annotated[
        list[Path], typer.Argument(help="ST files, or folders, whose ST files are formatted.")
    ],
    check: Annotated[
        bool, typer.Option("--check", help="Write nothing; list the files that would change.")
    ] = False,
    diff: Annotated[
        bool, typer.Option("--diff", help="Write nothing; print the lines that would change.")
    ] = False,
) -> None:
    """Format ST files in the layout of the library: indentation, spaces, columns, capitals.

    Line breaks inside of statements, blank lines and all comments remain. Before a file is written,
    the new text is read again. It must have the same words, comments and syntax tree. Encoding and
    line ends stay as they are.

    Files that are not plain Structured Text, such as projects of PLC tools and robot programs, are
    named and left out. A file with a syntax error is named and stays as it is; all other files are
    formatted.

    Exit code: 0, or 1 if --check finds a file that would change, or 2 on an error in a file.
    """
    layouts: list[FileLayout] = []
    failed = 0
    for file in named_files(files):
        try:
            layout = _read(file)
            layouts.append(layout)
            _report(layout, check, diff)
        except InputError as error:
            failed += 1
            print(f"error: {error}", file=sys.stderr)
    changed = sum(layout.changes for layout in layouts)
    omitted = sum(bool(layout.omitted) for layout in layouts)
    done = "would be formatted" if check or diff else "formatted"
    parts = [
        f"{counted(changed, 'file')} {done}",
        f"{len(layouts) - changed - omitted or 'no'} unchanged",
    ]
    parts += [f"{omitted} left out"] if omitted else []
    parts += [f"{counted(failed, 'file')} with errors"] if failed else []
    print(", ".join(parts))
    if failed:
        raise typer.Exit(2)
    if check and changed:
        raise typer.Exit(1)


def _read(file: Path) -> FileLayout:
    if file.suffix.lower() in _ROBOT_FILES:
        return FileLayout(file, "", "", b"", "it is a robot program")
    return layout_of(file)


def _report(layout: FileLayout, check: bool, diff: bool) -> None:
    """Write a file, or print what would change."""
    name = legible(str(layout.file))
    if layout.omitted:
        print(f"left out: {name}: {layout.omitted}")
        return
    if not layout.changes:
        return
    if not (check or diff):
        write_layout(layout)
        print(f"formatted: {name}")
        return
    if check:
        print(f"would be formatted: {name}")
    if diff:
        before, after = layout.before.splitlines(), layout.after.splitlines()
        for line in difflib.unified_diff(before, after, name, name, lineterm=""):
            print(legible(line))
