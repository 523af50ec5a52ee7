"""`rcx export`: the library in the file formats of PLC tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.export import TARGETS
from rcx_harness.export import export as make
from rcx_harness.export.output import write

__all__ = ["EPILOG", "export"]

EPILOG = "Targets:\n\n" + "\n".join(f"- {name}: {one.about}" for name, one in TARGETS.items())


def export(
    target: Annotated[str, typer.Argument(help=f"One of: {', '.join(TARGETS)}.")],
    program: Annotated[
        list[Path] | None, typer.Option(help="Add your ST file, or a folder of them.")
    ] = None,
    lib: Annotated[
        Path | None, typer.Option(help="Folder of the library. Default: that of this package.")
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Where to write. Default: rcx3 with a suffix."),
    ] = None,
    needed: Annotated[
        bool, typer.Option("--needed", help="Only the part of the library that --program needs.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Write over what is there.")] = False,
) -> None:
    """Write the library for a PLC tool; `docs/export.md` says what was checked with which.

    Exit code: 0, or 2 on errors in the sources and where the output exists.
    """
    output = make(target, lib, program or [], only_needed=needed)
    place = Path(TARGETS[target].default) if out is None else out
    files = write(output, place, force=force)
    for line in output.left_out:
        print(f"not carried: {line}")
    print(f"written: {place}" + (f" ({len(files)} files)" if len(files) > 1 else ""))
