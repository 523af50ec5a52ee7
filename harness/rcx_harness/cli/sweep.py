"""`rcx sweep`: every fault at every moment of a good run."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table

from rcx_harness.cli.campaign_options import VerifyOptions
from rcx_harness.cli.failure_classes import write_replay
from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.junit_option import Junit, junit_file, moments_suite
from rcx_harness.cli.options import counted, duration_us, with_options
from rcx_harness.verify.storm.cells import Cells
from rcx_harness.verify.storm.course import Course
from rcx_harness.verify.storm.sweep import Inject, Shown, Sweep, injects, pieces, ranges, told
from rcx_harness.verify.storm.written import check_folder, file_name
from structured_text.errors import InputError
from structured_text.output.junit import JunitFile

__all__ = ["sweep"]

#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{"inject": '
_AFTER_US = 1_000_000


@dataclass(frozen=True)
class SweepOptions(VerifyOptions):
    """The options of `rcx sweep`."""

    stimulus: Annotated[Path | None, typer.Option(help="Stimulus of the good run (TOML).")] = None
    inject: Annotated[
        str,
        typer.Option(
            help=(
                "Faults to inject, separated by commas: events as in a stimulus (at each "
                "controller; link_down@2 at the second), inputs as Main.CellSafe=false."
            )
        ),
    ] = "emergency_stop,link_down,power_cycle"
    hold: Annotated[str, typer.Option(help="Duration of faults that do not end at once.")] = "500ms"
    duration: Annotated[
        str | None,
        typer.Option("--for", help="Length of the good run. Default: 1 s after the last entry."),
    ] = None
    every: Annotated[int, typer.Option(help="Inject at every N-th scan only.", min=1)] = 1
    seed: Annotated[int, typer.Option(help="Seed of the good run.", min=0, max=2**63 - 1)] = 0
    out: Annotated[Path, typer.Option(help="Folder for results and replays.")] = Path("out/sweep")
    json_file: JsonFile = None
    junit: Junit = None


@with_options(SweepOptions)
def sweep(options: SweepOptions) -> None:
    """Inject a fault at every scan of a good run, and report when the cell does not recover.

    Runs are judged as in rcx campaign, by the rules and by --properties. The first moment of each
    class is written as a stimulus of rcx run, with its chart. Ctrl-C keeps the finished runs; the
    same call continues.

    Exit code: 0 if the cell recovers from all moments, 1 if not, 2 on bad input.
    """
    if options.stimulus is None:
        raise InputError("--stimulus is missing", hint="name the stimulus of a good run")
    check_folder(options.out)
    read = [*(options.robot or ()), *(options.properties or ()), options.stimulus]
    written = JsonOutput(options.json_file, _BEGINNING, read)
    junit = junit_file(options.junit, options.json_file, [*options.files, *read])
    with written.apart():
        text, failed = _swept(options, options.stimulus, junit)
    written.write(text)
    if failed:
        raise typer.Exit(1)


def _swept(options: SweepOptions, stimulus: Path, junit: JunitFile) -> tuple[str, bool]:
    """Run the sweep and print the failures; return them as JSON, and whether a run has failed."""
    of = options.cells(stimulus)
    cells = of.make()
    cell = cells.cell(options.seed)
    Course(cell, cells.demands)
    hold_us = duration_us("--hold", options.hold)
    if not hold_us:
        raise InputError("--hold of 0 s injects nothing", hint="use --hold 500ms")
    names = [name.strip() for name in options.inject.split(",") if name.strip()]
    if not names:
        raise InputError("--inject names nothing", hint="use --inject emergency_stop,link_down")
    what = injects(names, len(cell.robots), hold_us)
    for one in what:
        for path in one.values:
            cell[path] = cell[path]
    scan_us, scans = cell.timing.scan_us, _scans(options, cells)
    cell.close()
    if cells.notice:
        print(cells.notice)
    if cells.demands.recovery is None:
        print("no [recover]: it is not checked whether the cell works again")
    kept = options.results(of, options.out, f"seed {options.seed}")
    farm, work = options.farm(Console(stderr=True)), Sweep(of, options.seed)
    found: dict[tuple[str, str], dict[int, str]] = {}
    by_name = {one.name: one for one in what}
    try:
        items = pieces(what, scans, options.every)
        for item, failing in farm.run(work, items, kept=kept, title="pieces of the run"):
            for scan, kinds in failing.items():
                for kind, text in kinds.items():
                    found.setdefault((item.inject.name, kind), {})[scan] = text
        shown = [Shown(by_name[name], min(scans), kind) for (name, kind), scans in found.items()]
        replays = [replay for _, replay in farm.run(work, shown, kept=kept, title="classes")]
    except KeyboardInterrupt:
        print(f"finished results are in {options.out}; the same call continues")
        raise
    moments = range(0, scans, options.every)
    print(
        f"{counted(len(moments), 'moment')} of {scans * scan_us / 1e6:g} s, "
        f"{counted(len(what), 'fault')} at each"
    )
    if not found:
        recovers = cells.demands.recovery is not None
        print("the cell recovers from all of them" if recovers else "no rule was broken")
    else:
        _print(found, scan_us, options.every)
    written: list[str] = []
    commands: dict[tuple[str, str], str] = {}
    for (name, kind), replay in zip(found, replays, strict=True):
        if replay is not None:
            print(f"\n{name}, {kind}:\n  {replay.told}")
            written.append(file_name(f"{name} {kind}", written))
            commands[name, kind] = write_replay(options, cells, replay, options.out, written[-1])
    if junit.wanted:
        junit.write([moments_suite(by_name, moments, scan_us, found, commands)])
        junit.say()
    return _as_json(options, what, found, commands, len(moments)), bool(found)


def _scans(options: SweepOptions, cells: Cells) -> int:
    """Return the number of scans in the good run."""
    last = cells.demands.start[-1].t_us if cells.demands.start else 0
    length_us = last + _AFTER_US
    if options.duration is not None:
        length_us = duration_us("--for", options.duration)
    scan_us = cells.cell(options.seed).timing.scan_us
    if length_us < scan_us:
        raise InputError("--for is shorter than a scan", hint="use --for 5s")
    return length_us // scan_us


def _print(found: dict[tuple[str, str], dict[int, str]], scan_us: int, every: int) -> None:
    table = Table("injected", "what fails", "moments", "after scan", box=None, pad_edge=False)
    for (name, kind), scans in found.items():
        places = told(ranges(list(scans), every), scan_us)
        table.add_row(name, kind.replace("[", r"\["), str(len(scans)), places)
    console = Console()
    if not console.is_terminal:
        console.width = 200
    console.print(table)


def _as_json(
    options: SweepOptions,
    what: list[Inject],
    found: dict[tuple[str, str], dict[int, str]],
    commands: dict[tuple[str, str], str],
    moments: int,
) -> str:
    classes: list[dict[str, Any]] = [
        {
            "inject": name,
            "kind": kind,
            "moments": len(scans),
            "scans": ranges(list(scans), options.every),
            "text": scans[min(scans)],
            "command": commands.get((name, kind), ""),
        }
        for (name, kind), scans in found.items()
    ]
    names, shown = json.dumps([one.name for one in what]), json.dumps(classes, indent=1)
    return f'{_BEGINNING}{names}, "moments": {moments}, "classes": {shown}}}\n'
