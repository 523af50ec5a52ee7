"""`rcx prove`: prove properties of a program, or find runs that break them."""

from __future__ import annotations

import json
import sys
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.junit_option import Junit, junit_file, properties_suite
from rcx_harness.cli.options import (
    Device,
    Dialect,
    Lib,
    Replace,
    Sources,
    counted,
    duration_us,
    replacements,
)
from structured_text.errors import InputError
from structured_text.language.dialects import using

__all__ = ["prove"]

if TYPE_CHECKING:
    from structured_text.prove.user import Result

#: Width of the output [columns] if it is not a terminal.
_WIDE = 200
#: The results of a proof that do not cause exit code 1.
_GOOD = ("proved", "noted")
#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{"inputs": '


def prove(
    files: Sources,
    lib: Lib = None,
    replace: Replace = None,
    dialect: Dialect = None,
    device: Device = "",
    limit: Annotated[str, typer.Option(help="Time for each property.")] = "60s",
    scan: Annotated[
        str, typer.Option(help="Scan period in the runs that break a property.")
    ] = "10ms",
    out: Annotated[
        Path, typer.Option(help="Folder for the stimulus files and charts of such runs.")
    ] = Path("out/prove"),
    overflow: Annotated[
        bool, typer.Option("--overflow", help="Also require that arithmetic stays within its type.")
    ] = False,
    no_robot: Annotated[
        bool, typer.Option("--no-robot", help="Check the program alone: no areas, no controller.")
    ] = False,
    robot: Annotated[
        list[Path] | None,
        typer.Option(help="Not allowed, because a proof holds for every answer of the robot."),
    ] = None,
    against: Annotated[
        list[Path] | None,
        typer.Option(help="Old version: prove that the outputs are the same. Repeatable."),
    ] = None,
    output: Annotated[
        list[str] | None,
        typer.Option(help="Output that counts with --against; * is allowed. Repeatable."),
    ] = None,
    without: Annotated[
        list[str] | None,
        typer.Option("--except", help="Output that does not count; * is allowed. Repeatable."),
    ] = None,
    relate: Annotated[
        list[str] | None,
        typer.Option(help="Renamed variable, as Main.New=Main.Old. Repeatable."),
    ] = None,
    drawn_runs: Annotated[
        int, typer.Option("--runs", min=0, help="Random runs of both versions.")
    ] = 20,
    drawn_seed: Annotated[int, typer.Option("--seed", min=0, help="Seed of the random runs.")] = 1,
    json_file: JsonFile = None,
    junit: Junit = None,
) -> None:
    """Prove properties of a program for every run, every answer of the robot and every input.

    Arithmetic that may exceed the range of its type is noted.

    With --against, prove that two versions of a program have the same outputs.

    Exit code: 0 if all is proved or noted, 1 if anything is refuted or unknown, 2 on bad input.
    """
    if robot:
        raise InputError(
            "a proof takes no robot file, because it holds for every answer of the robot",
            hint="leave --robot out, or use rcx explore --robot",
        )
    limit_us, scan_us = duration_us("--limit", limit), duration_us("--scan", scan)
    for option, value in (("--limit", limit_us), ("--scan", scan_us)):
        if not value:
            raise InputError(f"{option} of 0 s is too short", hint=f"use {option} 10ms or longer")
    wishes = _wishes(against, output, without, relate, overflow=overflow)
    replaced = replacements(replace)
    sources = source_files(list(files), lib, replaced, dialect, device)
    earlier = source_files(list(against), lib, None, dialect, device).all if against else []
    written = JsonOutput(json_file, _BEGINNING, [*sources.all, *earlier])
    report = junit_file(junit, json_file, [*sources.all, *earlier])
    try:
        from rcx_harness.verify.prove.user import Settings
        from rcx_harness.verify.prove.user import prove as prove_program
    except ModuleNotFoundError as error:
        if error.name != "z3":
            raise
        hint = "pip install 'rcx-harness[prove]'"
        raise InputError("rcx prove needs the solver z3", hint=hint) from None
    console = Console(stderr=True)
    with console.status("reading ...") as status:

        def tell(text: str) -> None:
            status.update(text)
            if not console.is_terminal:
                print(text, file=sys.stderr, flush=True)

        settings = Settings(
            scan_us,
            limit_us / 1e6,
            out,
            overflow=overflow,
            robot=not no_robot,
            tell=tell,
            lib=lib,
            replace=replaced,
            device=device,
        )
        with using(dialect):
            if against:
                from rcx_harness.verify.prove.against import Versions, compare
                from structured_text.prove.against.compare import Wishes

                versions = Versions(
                    against, files, lib, robot=not no_robot, replace=replaced, device=device
                )
                given = Wishes(
                    **wishes,
                    scan_us=scan_us,
                    limit_s=limit_us / 1e6,
                    out=out,
                    runs=drawn_runs,
                    seed=drawn_seed,
                    tell=tell,
                )
                compared = compare(versions, given)
                results, inputs = compared.results, compared.inputs
            else:
                results, inputs = prove_program(files, settings)
    report.write([properties_suite(results)])
    with written.apart():
        _print(results, [*inputs, *([] if no_robot else ["and the robot"])])
        report.say()
    rows = json.dumps([asdict(one) for one in results], indent=1)
    written.write(f'{_BEGINNING}{json.dumps(inputs)}, "properties": {rows}}}\n')
    if any(one.status not in _GOOD for one in results):
        raise typer.Exit(1)


def _wishes(
    against: list[Path] | None,
    output: list[str] | None,
    without: list[str] | None,
    relate: list[str] | None,
    *,
    overflow: bool,
) -> dict[str, Any]:
    """Return the outputs and relations of a comparison, or raise InputError."""
    for option, value in (("--output", output), ("--except", without), ("--relate", relate)):
        if value and not against:
            raise InputError(f"{option} needs --against", hint="name the old version")
    if overflow and against:
        raise InputError("--overflow is not for --against", hint="prove it without --against, too")
    related = {}
    for text in relate or ():
        new, equals, old = text.partition("=")
        if not (new and equals and old):
            raise InputError(
                f"--relate {text} is not a pair", hint="write --relate Main.New=Main.Old"
            )
        related[new] = old
    return {"outputs": output or (), "without": without or (), "related": related}


def _print(results: list[Result], inputs: list[str]) -> None:
    print(f"inputs, with any value in each scan: {', '.join(inputs) or 'none'}")
    table = Table("status", "s", "where", "what", box=None, pad_edge=False)
    colours = {"proved": "green", "refuted": "red", "unknown": "yellow", "noted": "cyan"}
    for one in results:
        status = f"[{colours[one.status]}]{one.status}[/]"
        table.add_row(status, f"{one.seconds:.1f}", _escaped(one.at), _escaped(one.says))
    console = Console()
    if not console.is_terminal:
        console.width = _WIDE
    console.print(table)
    for one in results:
        if one.status != "proved":
            print(f"{one.status}: {one.name}: {one.note}")
            if one.command:
                print(f"  {one.command}")
    count = {status: sum(one.status == status for one in results) for status in colours}
    print(
        f"{counted(len(results), 'property').replace('propertys', 'properties')}: "
        + ", ".join(f"{number} {one}" for one, number in count.items() if number or one != "noted")
        + ("; unknown is not proved" if count["unknown"] else "")
    )


def _escaped(text: str) -> str:
    return text.replace("[", r"\[")
