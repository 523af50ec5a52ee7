"""`rcx export`: the library in the file formats of PLC tools."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cell.exports import export as make
from rcx_harness.cell.sources import library_names
from structured_text.errors import legible
from structured_text.export import TARGETS
from structured_text.export.output import write_export

__all__ = ["EPILOG", "export"]

EPILOG = "Targets:\n\n" + "\n".join(f"- {name}: {one.about}" for name, one in TARGETS.items())


def export(
    target: Annotated[
        str,
        typer.Argument(
            help=f"One of: {', '.join(TARGETS)}.",
            autocompletion=lambda: [(name, one.about) for name, one in TARGETS.items()],
        ),
    ],
    program: Annotated[
        list[Path] | None, typer.Option(help="Add your ST file, or a folder of them.")
    ] = None,
    lib: Annotated[
        Path | None,
        typer.Option(help="Folder of the library. Default: the library in this package."),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="File or folder to write. Default: rcx3 with a suffix."),
    ] = None,
    needed: Annotated[
        bool,
        typer.Option("--needed", help="Export only the part of the library that --program needs."),
    ] = False,
    prefix: Annotated[
        str | None,
        typer.Option(help="Prefix for the library's names, such as RCX_. Default: none."),
    ] = None,
    ladder: Annotated[
        bool,
        typer.Option(
            "--ladder",
            help="Write the bodies of the programs and blocks in --program as ladder (plcopen).",
        ),
    ] = False,
    allow_missing: Annotated[
        bool, typer.Option("--allow-missing", help="Write even if a part cannot be exported.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace an earlier export.")] = False,
) -> None:
    """Write the library for a PLC tool; `docs/how-to/export.md` shows the state of each.

    Exit code: 0; 1 if a part cannot be exported (nothing is written without
    `--allow-missing`); 2 on errors in the sources or if the output exists.
    """
    output = make(target, lib, program or [], only_needed=needed, prefix=prefix, ladder=ladder)
    place = Path(f"{library_names(lib).file}{TARGETS[target].ending}") if out is None else out
    for one in output.missing:
        print(legible(f"not carried: {one}"))
    for note in output.notes:
        print(legible(f"note: {note}"))
    if not allow_missing and any(not one.replaced for one in output.missing):
        print("rcx: nothing was written; --allow-missing writes the rest", file=sys.stderr)
        raise typer.Exit(1)
    done = write_export(output, place, force=force)
    for file in done.removed:
        print(f"removed: {file} (from the earlier export)")
    for file in done.kept:
        print(f"kept: {file} (from the earlier export, changed since then)")
    several = len(done.files) > 1
    print(f"written: {place}" + (f" ({len(done.files)} files)" if several else ""))
