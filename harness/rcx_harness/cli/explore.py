"""`rcx explore`: all states of a small program, within a bound."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console

from rcx_harness.cell.sources import source_files
from rcx_harness.cli.farm import FarmOptions, WorkersOrNone
from rcx_harness.cli.options import (
    Device,
    Dialect,
    Lib,
    Sources,
    counted,
    duration_us,
    with_options,
)
from rcx_harness.spec.wire import SIZE, check_size
from structured_text.errors import InputError
from structured_text.output.console import quoted
from structured_text.output.units import format_us

__all__ = ["explore"]

if TYPE_CHECKING:
    from rcx_harness.verify.explore.cells import CellSettings
    from rcx_harness.verify.explore.user import Explored, Settings
    from rcx_harness.verify.storm.demands import Demands
    from structured_text.explore.search import Result
    from structured_text.farm import Farm

#: The type of a function for progress: its arguments are the numbers of expanded and known states.
Report = Callable[[int, int], None]

#: Time between two lines of progress if the output is not a terminal [s].
_PATIENCE_S = 30.0


@dataclass(frozen=True, kw_only=True)
class Options(FarmOptions):
    """The options of `rcx explore`."""

    files: Sources
    lib: Lib = None
    dialect: Dialect = None
    device: Device = ""
    inputs: Annotated[
        list[str] | None,
        typer.Option(
            "--input", help="An input: Main.Start, or Main.Mode=1,2 with its possible values."
        ),
    ] = None
    always: Annotated[
        list[str] | None,
        typer.Option(help='Condition that must hold after every scan: "NOT (A AND B)".'),
    ] = None
    properties: Annotated[
        list[Path] | None,
        typer.Option(help="Required properties and the operator's inputs: .toml; repeatable."),
    ] = None
    no_robot: Annotated[
        bool, typer.Option("--no-robot", help="Check the program alone: no areas, no controller.")
    ] = False
    faults: Annotated[
        str, typer.Option(help="Possible faults: some of link,alarm,abnormal; or none.")
    ] = "link,alarm,abnormal"
    scan: Annotated[str, typer.Option(help="Scan period.")] = "100ms"
    bound: Annotated[
        int,
        typer.Option(
            min=0, max=10**9, help="Largest number of states to continue from; 0: no limit."
        ),
    ] = 20_000
    depth: Annotated[
        int, typer.Option(min=0, max=10**9, help="Largest number of scans; 0: no limit.")
    ] = 0
    robot: Annotated[
        list[Path] | None,
        typer.Option(
            help=(
                "Robot file (TOML): explore with this controller, its robot programs and their "
                "times; repeat it for several robots."
            )
        ),
    ] = None
    stimulus: Annotated[
        Path | None,
        typer.Option(help="With --robot: stimulus (TOML) that runs before the exploration begins."),
    ] = None
    begin: Annotated[
        str | None,
        typer.Option(help="With --robot: start of the exploration. Default: end of the stimulus."),
    ] = None
    size: Annotated[int, typer.Option(help="Bytes of the areas, 48 or 256.")] = SIZE
    m: Annotated[int, typer.Option(help="First byte of the area from the robot.")] = 0
    n: Annotated[int, typer.Option(help="First byte of the area to the robot.")] = 0
    out: Annotated[
        Path, typer.Option(help="Folder for the stimulus file and the chart of a broken rule.")
    ] = Path("out/explore")
    workers: WorkersOrNone = None


@with_options(Options)
def explore(given: Options) -> None:
    """Visit all states of a small program with a small controller, in every order of events.

    With --robot the command visits all states of a cell: the controller of this robot file with
    its robot programs and their times.

    Each state is checked against the rules of the wire, the contract of the blocks, assertions in
    comments, --always and --properties.

    Exit code: 0 if no rule is broken, 1 if a rule is broken, 2 on bad input.
    """
    from structured_text.output.replays import check

    # Check the output files first, because an exploration can take hours before it writes them.
    for name in ("broken.toml", "broken.svg"):
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

        finish = _cell(given, report, farm) if given.robot else _program(given, report, farm)
    if finish():
        raise typer.Exit(1)


def _program(given: Options, report: Report, farm: Farm) -> Callable[[], bool]:
    """Explore a program with the small controller; return a function that prints the result."""
    from rcx_harness.verify.explore.replay import replay
    from rcx_harness.verify.explore.user import explore as explore_program

    for name in ("stimulus", "begin"):
        if getattr(given, name) is not None:
            raise InputError(f"--{name} needs --robot", hint="name the robot file, too")
    settings = _settings(given)
    settings = type(settings)(**vars(settings) | {"report": report})
    sources = source_files(list(given.files), given.lib, device=given.device)
    found = explore_program(sources, settings, farm)

    def finish() -> bool:
        _print(found, settings)
        broken = found.result.broken
        if broken is None:
            return False
        stimulus, shown = replay(sources, found, settings, given.out)
        more = " --no-robot" if given.no_robot else ""
        more += f" --size {given.size}" if given.size != SIZE else ""
        more += "".join(f" --{one} {k}" for one, k in (("m", given.m), ("n", given.n)) if k)
        _tell(given, stimulus, settings.scan_us, len(broken.path) * settings.scan_us, more)
        if not shown:
            print("  (rcx run goes the same way; what it does not know, it does not judge)")
        return True

    return finish


def _cell(given: Options, report: Report, farm: Farm) -> Callable[[], bool]:
    """Explore a cell with its robot programs; return a function that prints the result."""
    from rcx_harness.verify.explore.cells import FAULTS, explore_cell, replay_cell

    settings = _cell_settings(given, report)
    found = explore_cell(settings, farm)

    def finish() -> bool:
        _print_left_out(found.inputs, found.scan_us)
        print(f"  begin: the scan at {format_us(found.first_us)}, after the good run")
        print("  controller: as in the robot file, with its programs and its times")
        print("  faults: at most one before a scan, and then no input changes")
        _print_faults(FAULTS, settings.faults)
        _print_result(found.result, found.first_us, found.scan_us)
        broken = found.result.broken
        if broken is None:
            return False
        stimulus, shown = replay_cell(settings, found, given.out)
        more = "".join(f" --robot {quoted(str(one))}" for one in given.robot or ())
        more += f" --size {given.size}" if given.size != SIZE else ""
        more += "".join(f" --{one} {k}" for one, k in (("m", given.m), ("n", given.n)) if k)
        ends_us = found.first_us + len(broken.path) * found.scan_us
        _tell(given, stimulus, found.scan_us, ends_us, more)
        if not shown:
            print("  (the replay did NOT fail)")
        return True

    return finish


def _tell(given: Options, stimulus: Path, scan_us: int, ends_us: int, more: str) -> None:
    """Print the command that replays a run."""
    lib = f" --lib {quoted(str(given.lib))}" if given.lib is not None else ""
    lib += f" --device {quoted(given.device)}" if given.device else ""
    files = " ".join(quoted(str(one)) for one in given.files)
    more += "".join(f" --properties {quoted(str(one))}" for one in given.properties or ())
    print(
        f"  rcx run {files}{lib} --scan {_short(scan_us)}"
        f" --for {_short(ends_us)} --engine builtin{more}"
        f" --stimulus {quoted(str(stimulus))}"
    )


def _short(time_us: int) -> str:
    return f"{time_us}us" if time_us % 1000 else f"{time_us // 1000}ms"


def _settings(given: Options) -> Settings:
    from rcx_harness.verify.explore.controller import FAULTS
    from rcx_harness.verify.explore.user import Settings
    from rcx_harness.verify.storm.demands import Demands

    scan_us = _scan_us(given)
    check_size(given.size)
    faults = _faults(given, FAULTS)
    demands = Demands.load(given.properties or [])
    return Settings(
        inputs=_inputs(given, demands),
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


def _cell_settings(given: Options, report: Report) -> CellSettings:
    from rcx_harness.cell.stimulus import Stimulus
    from rcx_harness.verify.explore.cells import FAULTS, CellSettings
    from rcx_harness.verify.explore.controller import FAULTS as ALL
    from rcx_harness.verify.storm.cells import CellsOf
    from rcx_harness.verify.storm.demands import Demands

    if given.always:
        hint = "write it as [[always]] in a file of --properties"
        raise InputError("--always cannot be combined with --robot", hint=hint)
    options: dict[str, Any] = {
        "robot": given.robot,
        "lib": given.lib,
        "engine": "builtin",
        "scan": given.scan,
    }
    options |= {"m": given.m, "n": given.n}
    options |= {"size": given.size} if given.size != SIZE else {}
    scan_us = _scan_us(given)
    entries = Stimulus.load(given.stimulus).entries if given.stimulus is not None else []
    ends_us = max((part.t_us + scan_us for one in entries for part in one.parts()), default=0)
    begin_us = ends_us if given.begin is None else duration_us("--begin", given.begin)
    demands = given.properties or []
    return CellSettings(
        CellsOf.of(
            given.files,
            {name: value for name, value in options.items() if value is not None},
            demands,
            given.stimulus,
        ),
        inputs=_inputs(given, Demands.load(demands)),
        faults=frozenset(_faults(given, ALL)) & frozenset(FAULTS),
        begin_us=begin_us,
        states=given.bound,
        depth=given.depth,
        report=report,
    )


def _scan_us(given: Options) -> int:
    scan_us = duration_us("--scan", given.scan)
    if not scan_us:
        raise InputError("--scan of 0 s is too short", hint="use --scan 10ms or longer")
    return scan_us


def _faults(given: Options, known: Collection[str]) -> list[str]:
    faults = [] if given.faults == "none" else [one.strip() for one in given.faults.split(",")]
    for one in faults:
        if one not in known:
            raise InputError(
                f"--faults {one}: no such fault", hint=f"use {', '.join(known)}, or none"
            )
    return faults


def _inputs(given: Options, demands: Demands) -> dict[str, list[str]]:
    """Return the values of each input; `--input` has priority over the properties file."""
    inputs: dict[str, list[str]] = {}
    for text in given.inputs or []:
        path, has_values, values = text.partition("=")
        if path.strip().upper() in (one.upper() for one in inputs):
            raise InputError(f"--input {path} is given twice", hint="give all values in one")
        inputs[path.strip()] = values.split(",") if has_values else []
    known = {path.upper() for path in inputs}
    for path, several in _touched(demands).items():
        if path.upper() not in known:
            inputs[path] = several
    return inputs


def _touched(demands: Demands) -> dict[str, list[str]]:
    """Return the inputs that the properties file gives to the operator, with their values."""
    inputs: dict[str, list[str]] = {path: [] for path in (*demands.buttons, *demands.switches)}
    for path, several in demands.values.items():
        inputs[path] = [str(one).lower() if isinstance(one, bool) else str(one) for one in several]
    return inputs


def _print(found: Explored, settings: Settings) -> None:
    from rcx_harness.verify.explore.controller import FAULTS

    _print_left_out(found.inputs, settings.scan_us)
    for path in found.left:
        print(f"  {path} keeps its initial value (--input {path} changes it)")
    if settings.robot:
        print("  controller: answers as in the manual, one answer before a scan, after any time")
        print("  data: responses are 0; nothing moves, no positions, no program of the robot's own")
        _print_faults(FAULTS, settings.faults)
    _print_result(found.result, 0, settings.scan_us)


def _print_left_out(inputs: Mapping[str, Sequence[str]], scan_us: int) -> None:
    print("what is explored, and what is left out:")
    print(f"  time: each scan exactly {format_us(scan_us)} after the last")
    for path, values in inputs.items():
        print(f"  input {path}: {', '.join(values)}; at most one input changes before a scan")


def _print_faults(known: Mapping[str, str], explored: Collection[str]) -> None:
    for fault, about in known.items():
        if fault not in explored:
            print(f"  not explored: {about}")


def _print_result(result: Result, first_us: int, scan_us: int) -> None:
    figures = (
        f"{counted(result.states, 'state')}, {counted(result.transitions, 'scan')} judged, "
        f"up to {counted(result.depth, 'scan')} from the start"
    )
    if result.broken is not None:
        when = format_us(first_us + (len(result.broken.path) - 1) * scan_us)
        print(f"BROKEN in scan {len(result.broken.path)}, at {when} ({figures}):")
        for rule in result.broken.rules:
            print(f"  {rule}")
        for number, choice in enumerate(result.broken.path, 1):
            print(f"  scan {number}: {choice.tell()}")
    elif result.complete:
        print(f"explored to the end: {figures}; no rule is broken")
    else:
        print(f"BOUND REACHED: {figures}; none breaks a rule, further states are unknown")
