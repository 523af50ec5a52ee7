"""`rcx explore`: all states of a small program, within a bound."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.farm import FarmOptions, WorkersOrNone
from rcx_harness.cli.options import Lib, Sources, counted, duration_us, with_options
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError
from structured_text.output.console import quoted
from structured_text.output.units import format_us

__all__ = ["explore"]

if TYPE_CHECKING:
    from rcx_harness.verify.explore.user import Explored, Settings
    from rcx_harness.verify.storm.demands import Demands

#: Between two lines of progress where there is no terminal [s].
_PATIENCE_S = 30.0


@dataclass(frozen=True, kw_only=True)
class Options(FarmOptions):
    """The options of `rcx explore`."""

    files: Sources
    lib: Lib = None
    inputs: Annotated[
        list[str] | None,
        typer.Option("--input", help="Main.Start, or Main.Mode=1,2: values that it may have."),
    ] = None
    always: Annotated[
        list[str] | None,
        typer.Option(help='Holds after every scan, in the program\'s names: "NOT (A AND B)".'),
    ] = None
    properties: Annotated[
        list[Path] | None,
        typer.Option(help="What you demand, and what the operator touches: .toml; repeatable."),
    ] = None
    no_robot: Annotated[
        bool, typer.Option("--no-robot", help="The program alone: no areas, no controller.")
    ] = False
    faults: Annotated[
        str, typer.Option(help="What may go wrong: some of link,alarm,abnormal; or none.")
    ] = "link,alarm,abnormal"
    scan: Annotated[str, typer.Option(help="Time from one scan to the next.")] = "100ms"
    bound: Annotated[
        int, typer.Option(min=0, max=10**9, help="Go on from so many states at most; 0: from all.")
    ] = 20_000
    depth: Annotated[
        int, typer.Option(min=0, max=10**9, help="Go no further than so many scans; 0: any number.")
    ] = 0
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE
    m: Annotated[int, typer.Option(help="Where the area from the robot begins.")] = 0
    n: Annotated[int, typer.Option(help="Where the area to the robot begins.")] = 0
    out: Annotated[
        Path, typer.Option(help="Folder for the stimulus file and the chart of what is found.")
    ] = Path("out/explore")
    workers: WorkersOrNone = None


@with_options(Options)
def explore(given: Options) -> None:
    """Go through all states of a small program, with a small controller in every order of events.

    Judged by the rules of the wire, the contract of the blocks, assertions in comments, and what
    --always and --properties demand.

    Exit code: 0 if no rule is broken, 1 if one is, 2 on bad input.
    """
    from rcx_harness.verify.explore.replay import replay
    from rcx_harness.verify.explore.user import explore as explore_program
    from structured_text.output.replays import check

    for name in ("broken.toml", "broken.svg"):  # hours of work come before they are written
        check(given.out / name)
    console = Console(stderr=True)
    farm = given.farm(console)
    with console.status("reading ...") as status:
        told = time.monotonic()

        def report(done: int, known: int) -> None:
            nonlocal told
            text = f"{done:,} of {known:,} known states"
            status.update(text)
            if not console.is_terminal and time.monotonic() - told > _PATIENCE_S:
                told = time.monotonic()
                print(text, file=sys.stderr, flush=True)

        settings = _settings(given)
        settings = type(settings)(**vars(settings) | {"report": report})
        found = explore_program(source_files(list(given.files), given.lib), settings, farm)
    _print(found, settings)
    broken = found.result.broken
    if broken is None:
        return
    stimulus, shown = replay(given.files, given.lib, found, settings, given.out)
    lib = f" --lib {quoted(str(given.lib))}" if given.lib is not None else ""
    files = " ".join(quoted(str(one)) for one in given.files)
    scans = len(broken.path)
    more = " --no-robot" if given.no_robot else ""
    more += f" --size {given.size}" if given.size != SIZE else ""
    more += "".join(f" --{one} {k}" for one, k in (("m", given.m), ("n", given.n)) if k)
    more += "".join(f" --properties {quoted(str(one))}" for one in given.properties or ())
    print(
        f"  rcx run {files}{lib} --scan {_short(settings.scan_us)}"
        f" --for {_short(scans * settings.scan_us)} --engine builtin{more}"
        f" --stimulus {quoted(str(stimulus))}"
    )
    if not shown:
        print("  (rcx run goes the same way; what it does not know, it does not judge)")
    raise typer.Exit(1)


def _short(time_us: int) -> str:
    return f"{time_us}us" if time_us % 1000 else f"{time_us // 1000}ms"


def _settings(given: Options) -> Settings:
    from rcx_harness.verify.explore.controller import FAULTS
    from rcx_harness.verify.explore.user import Settings
    from rcx_harness.verify.storm.demands import Demands

    scan_us = duration_us("--scan", given.scan)
    if not scan_us:
        raise InputError("--scan of 0 s is too short", hint="use --scan 10ms or longer")
    check_size(given.size)
    faults = [] if given.faults == "none" else [one.strip() for one in given.faults.split(",")]
    for one in faults:
        if one not in FAULTS:
            raise InputError(f"--faults {one}", hint=f"it can be {', '.join(FAULTS)}, or none")
    inputs: dict[str, list[str]] = {}
    for text in given.inputs or []:
        path, has_values, values = text.partition("=")
        if path.strip().upper() in (one.upper() for one in inputs):
            raise InputError(f"--input {path} is given twice", hint="give all values in one")
        inputs[path.strip()] = values.split(",") if has_values else []
    demands = Demands.load(given.properties or [])
    known = {path.upper() for path in inputs}
    for path, several in _touched(demands).items():
        if path.upper() not in known:
            inputs[path] = several
    return Settings(
        inputs=inputs,
        always=tuple(given.always or ()),
        properties=demands.properties,
        faults=frozenset(faults),
        scan_us=scan_us,
        size=given.size,
        m=given.m,
        n=given.n,
        robot=not given.no_robot,
        states=given.bound,
        depth=given.depth,
    )


def _touched(demands: Demands) -> dict[str, list[str]]:
    """Return the operator's inputs with their values; a BOOL needs no values."""
    inputs: dict[str, list[str]] = {path: [] for path in (*demands.buttons, *demands.switches)}
    for path, several in demands.values.items():
        inputs[path] = [str(one).lower() if isinstance(one, bool) else str(one) for one in several]
    return inputs


def _print(found: Explored, settings: Settings) -> None:
    from rcx_harness.verify.explore.controller import FAULTS

    print("what is explored, and what is left out:")
    print(f"  time: each scan {format_us(settings.scan_us)} after the last, none earlier or later")
    for path, values in found.inputs.items():
        print(f"  input {path}: {', '.join(values)}; at most one input changes before a scan")
    for path in found.left:
        print(f"  {path} stays as it begins (--input {path} changes it)")
    if settings.robot:
        print("  controller: answers as the manual says, one thing before a scan, after any time")
        print("  data: responses are 0; nothing moves, no positions, no program of the robot's own")
    for fault, about in FAULTS.items():
        if settings.robot and fault not in settings.faults:
            print(f"  not explored: {about}")
    result = found.result
    figures = (
        f"{counted(result.states, 'state')}, {counted(result.transitions, 'scan')} judged, "
        f"up to {counted(result.depth, 'scan')} from the start"
    )
    if result.broken is not None:
        when = format_us((len(result.broken.path) - 1) * settings.scan_us)
        print(f"BROKEN in scan {len(result.broken.path)}, at {when} ({figures}):")
        for rule in result.broken.rules:
            print(f"  {rule}")
        for number, choice in enumerate(result.broken.path, 1):
            print(f"  scan {number}: {choice.tell()}")
    elif result.complete:
        print(f"explored to the end: {figures}; no rule is broken")
    else:
        print(f"BOUND REACHED: {figures}; none breaks a rule, of further ones nothing is known")
