"""`rcx why`: the chain of causes from what waits to who has to act."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.options import duration_us
from rcx_harness.cli.progress import progress_bar
from rcx_harness.look.why.chain import chains
from rcx_harness.look.why.recorded import facts_of_trace
from rcx_harness.look.why.text import as_json, lines
from structured_text.errors import legible

__all__ = ["why"]

#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{\n  "file": '


def why(
    file: Annotated[Path, typer.Argument(help="A trace (JSON lines) of rcx run, serve or scan.")],
    at: Annotated[str | None, typer.Option(help="The time to explain. Default: the end.")] = None,
    json_file: JsonFile = None,
) -> None:
    """Explain why the robot stands: the chain of causes, and who has to act.

    Each step has its time, its signal or variable, and the section of the manual. Values that were
    not recorded are unknown and never guessed.

    Exit code: 1 if something waits, 0 if nothing waits or the robot works, 2 on bad input.
    """
    output = JsonOutput(json_file, _BEGINNING, [file])
    at_us = None if at is None else duration_us("--at", at)
    with progress_bar("reading", output.printed or not sys.stdout.isatty()) as progress:
        facts = facts_of_trace(file, at_us, progress)
    t_us = facts.last_us if at_us is None else at_us
    found = chains(facts, t_us)
    if not output.printed:
        print(f"at {t_us / 1e6:.3f} s")
        for line in lines(found):
            print(legible(line))
    output.write(f"{json.dumps(as_json(file.as_posix(), t_us, found), indent=2)}\n")
    if any(chain.cause.stands for chain in found):
        raise typer.Exit(1)
