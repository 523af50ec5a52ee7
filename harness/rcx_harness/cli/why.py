"""`rcx why`: the chain of causes from what waits to who has to act."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.options import Lib, duration_us
from rcx_harness.cli.progress import progress_bar
from rcx_harness.look.why.chain import chains
from rcx_harness.look.why.facts import Facts
from rcx_harness.look.why.recorded import facts_of_trace
from rcx_harness.look.why.text import as_json, lines
from structured_text.errors import InputError, legible

__all__ = ["why"]

#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{\n  "file": '


def why(
    files: Annotated[
        list[Path] | None,
        typer.Argument(help="A trace (JSON lines). With --snapshot: the program's files."),
    ] = None,
    at: Annotated[str | None, typer.Option(help="The time to explain. Default: the end.")] = None,
    snapshot: Annotated[
        Path | None, typer.Option(help="Values copied from an HMI or a watch table (TOML).")
    ] = None,
    capture: Annotated[
        Path | None, typer.Option(help="A network capture (pcapng, pcap) instead of a trace.")
    ] = None,
    lib: Lib = None,
    json_file: JsonFile = None,
) -> None:
    """Explain why the robot stands: the chain of causes, and who has to act.

    Each step has its time, its signal or variable, and the section of the manual. Values that were
    not recorded are unknown and never guessed.

    Exit code: 1 if something waits, 0 if nothing waits or the robot works, 2 on bad input.
    """
    given = files or []
    source = _source(given, snapshot, capture)
    read = [*given, *(file for file in (snapshot, capture) if file)]
    output = JsonOutput(json_file, _BEGINNING, read)
    at_us = None if at is None else duration_us("--at", at)
    if snapshot is not None:
        if at is not None:
            raise InputError("--at has no meaning with --snapshot, which has one time only")
        facts, t_us = _of_snapshot(given, snapshot, lib), None
    else:
        with progress_bar("reading", output.printed or not sys.stdout.isatty()) as progress:
            take = facts_of_trace if capture is None else _captured
            facts = take(source, at_us, progress)
        t_us = facts.last_us if at_us is None else at_us
    found = chains(facts, t_us)
    if not output.printed:
        print("in the snapshot" if t_us is None else f"at {t_us / 1e6:.3f} s")
        for line in lines(found):
            print(legible(line))
    output.write(f"{json.dumps(as_json(source.as_posix(), t_us, found), indent=2)}\n")
    if any(chain.cause.stands for chain in found):
        raise typer.Exit(1)


def _source(files: list[Path], snapshot: Path | None, capture: Path | None) -> Path:
    """Return the file with the values; raise InputError for options that exclude each other."""
    hint = "write rcx why TRACE, rcx why FILES --snapshot VALUES.toml, or rcx why --capture FILE"
    if snapshot is not None and capture is not None:
        raise InputError("--snapshot and --capture exclude each other", hint=hint)
    if snapshot is not None:
        if not files:
            raise InputError("--snapshot needs the files of the program", hint=hint)
        return snapshot
    if capture is not None:
        if files:
            raise InputError(f"--capture reads its own file, but {files[0]} is given", hint=hint)
        return capture
    if len(files) != 1:
        raise InputError(f"{len(files)} files are given, and not one trace", hint=hint)
    return files[0]


def _captured(file: Path, until_us: int | None, progress: Callable[[float], None]) -> Facts:
    from rcx_harness.look.why.captured import facts_of_capture

    return facts_of_capture(file, until_us, progress)


def _of_snapshot(files: list[Path], snapshot: Path, lib: Path | None) -> Facts:
    from rcx_harness.cell.compiled import Compiled
    from rcx_harness.cell.sources import source_files
    from rcx_harness.look.why.snapshot import facts_of_snapshot

    compiled = Compiled(source_files(files, lib), "builtin")
    try:
        return facts_of_snapshot(snapshot, compiled.program)
    finally:
        compiled.leave()
