"""`rcx run`: build the cell, run it, write the requested files, and report the result."""

from __future__ import annotations

import os
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from rcx_harness.cell import EVENTS, Cell
from rcx_harness.cell.build import several
from rcx_harness.cell.sources import blame_lib, source_files
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli import no_robot
from rcx_harness.cli.cell_options import CellOptions
from rcx_harness.cli.connect import Teller, confirm, no_connection
from rcx_harness.cli.coverage_options import (
    Coverage,
    CoverageOut,
    CoverFailUnder,
    concluded,
    requested_collector,
)
from rcx_harness.cli.options import (
    check_ipv4,
    check_port,
    choices,
    config_data,
    config_instance,
    counted,
    duration_us,
    host_port,
    replacements,
    with_options,
)
from rcx_harness.cli.progress import RunProgress
from rcx_harness.cli.stopped_programs import busy_programs, program_errors, stopped_program_count
from rcx_harness.spec.wire import TO_MASTER, TO_ROBOT
from rcx_harness.trace import Record, Scan
from rcx_harness.trace.bare import heard
from rcx_harness.trace.chart import Timeline, text_chart
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.trace.explaining import shown_errors
from rcx_harness.trace.scale import scaled_svg, scaled_text
from rcx_harness.trace.view.networks import DrawnProgram
from rcx_harness.trace.view.page import View
from rcx_harness.trace.wave import Wave
from rcx_harness.watch.block_errors import BlockErrors
from rcx_harness.watch.safety_source import safety_inputs
from structured_text.bench import Bench
from structured_text.bench import stimulus as stimuli
from structured_text.bench.outputs import check_outputs
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.errors import InputError, legible
from structured_text.output.console import draws
from structured_text.output.files import replace_files
from structured_text.output.units import format_us, parse_us
from structured_text.projects.sources import SourceFiles

__all__ = ["EPILOG", "RunOptions", "run"]

if TYPE_CHECKING:
    from rcx_harness.cell.elsewhere import Elsewhere
    from structured_text.coverage.output import Outcome

EPILOG = "Events of a stimulus:\n\n" + "\n".join(f"- {one}: {EVENTS[one]}" for one in EVENTS)

#: The time between two progress reports [s of real time].
_REPORT_S = 0.25
_SLICES = 400
#: The greatest number of block errors that are shown.
_MOST_ERRORS = 5
#: The default time-out in real time: a number of packet intervals, but at least a time in us.
_PATIENT_INTERVALS, _PATIENT_US = 32, 320_000
_MOST_SHOWN = 20
#: Byte of SI(00) in the area to the robot (manual chapter 5, 2).
_SI_00 = 32
_SHORTEST_LINE_US = 1_000


@dataclass(frozen=True)
class RunOptions(CellOptions):
    """The options that `rcx run` has in addition to the options of a cell."""

    no_robot: Annotated[
        bool, typer.Option("--no-robot", help="Run the program alone: no areas, no controller.")
    ] = False
    duration: Annotated[str, typer.Option("--for", help="Virtual time to run.")] = "5s"
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="With --link enip: run in real time, with cyclic I/O."),
    ] = False
    panel: Annotated[
        int | None,
        typer.Option(
            help="With --realtime: TCP port on 127.0.0.1 of a page for the program's RCX_PANEL "
            "variables; 0: any free one. Ctrl-C ends the run."
        ),
    ] = None
    connect: Annotated[
        str | None,
        typer.Option(help="Drive an external controller in real time: HOST[:PORT]."),
    ] = None
    yes: Annotated[
        bool,
        typer.Option(
            "--yes", help="With --connect: confirm that the cell is clear; a robot may move."
        ),
    ] = False
    input_instance: Annotated[
        int, typer.Option(help="With --connect: assembly from the controller.")
    ] = TO_MASTER
    output_instance: Annotated[
        int, typer.Option(help="With --connect: assembly to the controller.")
    ] = TO_ROBOT
    config_instance: Annotated[
        str, typer.Option(help="With --connect: configuration instance, a number or none.")
    ] = "none"
    config_data: Annotated[
        str,
        typer.Option(help="With --connect: data for the configuration instance, in hexadecimal."),
    ] = ""
    address: Annotated[
        str, typer.Option("--from", help="With --connect: local address for the connection.")
    ] = ""
    stimulus: Annotated[
        Path | None, typer.Option(help="Stimulus: inputs and events at given times (TOML).")
    ] = None
    properties: Annotated[
        list[Path] | None,
        typer.Option(help="Required properties, as in rcx campaign: .toml, .py; repeatable."),
    ] = None
    seed: Annotated[int, typer.Option(help="Seed of the random numbers.", min=0, max=2**63 - 1)] = 0
    trace: Annotated[Path | None, typer.Option(help="Write the trace (JSON lines).")] = None
    chart: Annotated[Path | None, typer.Option(help="Write the timing chart (SVG).")] = None
    vcd: Annotated[Path | None, typer.Option(help="Write a wave file (VCD).")] = None
    view: Annotated[
        Path | None, typer.Option(help="Write a page for a browser (HTML), as rcx view does.")
    ] = None
    watch: Annotated[
        list[str] | None,
        typer.Option(help="Variables to show, e.g. Main.Step,Main.Hmi.*; may be repeated."),
    ] = None
    positions: Annotated[
        str,
        typer.Option(
            help="Show the position of the robot in pulses or mm.",
            autocompletion=choices("pulses", "mm"),
        ),
    ] = ""
    scale: Annotated[
        str,
        typer.Option(help="Time axis of the charts: events, time (to scale), or a line, as 500ms."),
    ] = "events"
    show: Annotated[
        bool, typer.Option("--show/--no-show", help="Print the timing chart at the end.")
    ] = False
    coverage: Coverage = False
    coverage_out: CoverageOut = None
    coverage_library: Annotated[
        bool,
        typer.Option(
            "--coverage-library", help="Also measure the coverage of the library's blocks."
        ),
    ] = False
    cover_fail_under: CoverFailUnder = None

    @property
    def outputs(self) -> dict[str, Path | None]:
        """Return the output files by kind."""
        return {"trace": self.trace, "chart": self.chart, "vcd": self.vcd, "view": self.view}

    @property
    def live(self) -> bool:
        """Whether the run is in real time, over a network with its own jitter."""
        return self.realtime or self.connect is not None

    def where(self) -> Elsewhere | None:
        """Return the controller of `--connect`, if given."""
        if self.connect is None:
            if (self.input_instance, self.output_instance) != (TO_MASTER, TO_ROBOT):
                hint = "leave them out, or name a controller with --connect"
                raise InputError("--input-instance, --output-instance need --connect", hint=hint)
            return None
        if self.robot:
            hint = "leave --robot out: the external controller has its own properties"
            raise InputError("--robot is for a virtual controller", hint=hint)
        if self.address:
            check_ipv4("--from", self.address)
        from rcx_harness.cell.elsewhere import Elsewhere
        from rcx_harness.enip.originator.client import PORT

        host, port = host_port("--connect", self.connect, PORT)
        return Elsewhere(
            host,
            port,
            self.input_instance,
            self.output_instance,
            config_instance(self.config_instance),
            config_data(self.config_data),
            self.address,
            Teller(),
        )

    def of_cell(self) -> dict[str, Any]:
        """Return the arguments of `Cell.build`; an option that is not given has its default."""
        return super().of_cell() | {"seed": self.seed, **self._further()}

    def _further(self) -> dict[str, Any]:
        given: dict[str, Any] = {"connect": self.where(), "link": self._link()}
        given |= {"timeout": self._timeout(), "trace": self.trace, "watch": self.watch}
        given["positions"] = self.positions
        return {name: value for name, value in given.items() if value not in (None, [])}

    def bench(self, files: SourceFiles, **more: Any) -> Bench:
        """Build a bench with the program, without a robot.

        `more` are arguments of `Bench.build` in addition to the options.
        """
        given = {"engine": self.engine, "scan": self.scan, "trace": self.trace}
        return Bench.build(files, **{**given, "watch": self.watch or (), **more})

    @property
    def line_us(self) -> int | None:
        """Return the time of a line of a chart to scale; 0: chosen to fit; None: events only."""
        if self.scale in ("events", "time"):
            return None if self.scale == "events" else 0
        try:
            line_us = parse_us(self.scale)
        except InputError:
            line_us = 0
        if line_us < _SHORTEST_LINE_US:
            raise InputError(
                f"--scale is {self.scale!r}", hint="use events, time, or at least 1ms, as 500ms"
            )
        return line_us

    def _link(self) -> str:
        """Return the name of the cell's link.

        In real time the network is real and has its own jitter.
        """
        if not self.live:
            return self.link
        if self.connect is None and self.link != "enip":
            raise InputError("--realtime needs a real network", hint="add --link enip")
        if parse_us(self.jitter):
            raise InputError(
                "--jitter is for virtual time: in real time the network has its own jitter",
                hint="remove --jitter",
            )
        return "enip-realtime"  # with --connect the cell ignores this link

    def _timeout(self) -> str | int | None:
        """Return the connection time-out.

        In real time it is longer, because this computer may be late.
        """
        if self.timeout is None and self.live:
            return max(_PATIENT_INTERVALS * parse_us(self.rpi), _PATIENT_US)
        return self.timeout


@dataclass(frozen=True)
class _Outcome:
    """The result of a run, after which the cell is closed."""

    cell: Bench
    duration_us: int
    notice: str
    timeline: Timeline
    ever_connected: bool
    silence: str  # reason why no packet of an external controller arrived
    coverage: Outcome | None


@with_options(RunOptions)
def run(options: RunOptions) -> None:
    """Run a program in a virtual cell.

    With --no-robot the program runs alone and needs no areas. With --connect it drives an external
    controller: rcx serve, or a real one. Ctrl-C ends the run; zeros are sent before the connection
    is closed.

    Exit code: 0 without a violation; 1 with violations, with a robot program that an error has
    stopped, or with too little coverage; 2 on bad input, and with --connect if no packet came from
    the controller.
    """
    collector = _collector(options)
    _check_panel(options)
    if (where := options.where()) is not None:
        confirm(where, yes=options.yes)
    with RunProgress() as progress, counting(collector) if collector else nullcontext():
        outcome = _run(options, progress, collector)
    _print_outcome(options, outcome)
    if options.connect is not None and not outcome.ever_connected:
        raise no_connection(outcome.silence)
    covered = outcome.coverage is None or outcome.coverage.passed
    if outcome.cell.violations or _stopped_programs(outcome) or not covered:
        raise typer.Exit(1)


def _stopped_programs(outcome: _Outcome) -> int:
    """Return how often an error has stopped a robot program in the run."""
    return stopped_program_count(outcome.cell) if isinstance(outcome.cell, Cell) else 0


def _collector(options: RunOptions) -> Collector | None:
    """Return the coverage collector, if coverage is requested."""
    if options.coverage and options.engine not in ("auto", "builtin"):
        from structured_text.coverage.output import ENGINE

        raise InputError(ENGINE, hint=f"leave out --engine {options.engine}, or --coverage")
    return requested_collector(
        coverage=options.coverage,
        folder=options.coverage_out,
        fail_under=options.cover_fail_under,
        library=options.coverage_library,
    )


def _run(
    options: RunOptions, progress: Callable[[int, int], None], collector: Collector | None
) -> _Outcome:
    """Run the program; `progress` is called with the elapsed and the total virtual time [us]."""
    end_us = duration_us("--for", options.duration)
    if not end_us:
        raise InputError("a run of 0 s shows nothing", hint="use --for 5s")
    line_us = options.line_us
    replaced = replacements(options.replace)
    files = source_files(
        list(options.files), options.lib, replaced, options.dialect, options.device
    )
    check_outputs(options.outputs, files, *several(options.robot), options.stimulus)
    kind: type[stimuli.Stimulus] = no_robot.Stimulus if options.no_robot else Stimulus
    stimulus = kind.load(options.stimulus) if options.stimulus is not None else None
    late = stimulus.late(end_us) if stimulus is not None else ""
    connected = False
    made: Bench
    given: dict[str, Any] = {}
    try:
        if options.no_robot:
            made = options.bench(files)
        else:
            given = options.of_cell()
            made = Cell.build(list(options.files), **given)
    except InputError as error:
        raise blame_lib(error, options.lib) from None
    with made as cell:
        for text in cell.mistakes:
            print(legible(text), file=sys.stderr)
        timeline, safe, errors = Timeline(cell.trace), _Safe(), _errors_of(cell)
        cell.trace.listen(heard(timeline.take))
        if isinstance(cell, Cell):
            cell.trace.listen(safe.take)
        view = _view(cell, files) if options.view is not None else None
        if options.properties:
            from rcx_harness.verify.properties import judge_run
            from rcx_harness.verify.storm.demands import Demands

            judge_run(cell, Demands.load(options.properties).properties)
        if stimulus is not None:
            stimulus.schedule(cell)
        wave = None
        if options.vcd is not None:
            robots = len(cell.robots) if isinstance(cell, Cell) else 0
            wave = Wave(options.vcd, robots, cell.trace)
        try:
            if wave is not None:
                cell.trace.listen(heard(wave.take))
            reported = 0.0
            with _panel(options, cell):
                for number in range(1, _SLICES + 1):
                    cell.run(end_us * number // _SLICES - cell.now_us)
                    connected = connected or (isinstance(cell, Cell) and cell.connected)
                    if time.monotonic() - reported >= _REPORT_S:
                        reported = time.monotonic()
                        progress(cell.now_us, end_us)
        except KeyboardInterrupt:
            if options.connect is None and options.panel is None:
                raise
            # Ctrl-C ends the run; the connection is closed and all files are written
            end_us = cell.now_us
        finally:
            if wave is not None:
                wave.close()
        if isinstance(cell, Cell):
            timeline.explain(shown_errors(cell.program))
        if options.chart is not None:
            title = _title(options, cell)
            if line_us is None:
                chart = svg_chart(timeline, title)
            else:
                chart = scaled_svg(timeline, title, line_us)
            replace_files({options.chart: chart})
        if options.view is not None and view is not None:
            replace_files({options.view: view.page(_title(options, cell))})
        unsafe = safe.told(cell, files, options) if connected else ""
    ended = [f"note: {text}" for text in errors.texts(_MOST_ERRORS)] if errors else []
    about = [line for line in cell.notice.splitlines() if line not in cell.mistakes]
    notice = "\n".join(filter(None, (*about, late, unsafe, *ended)))
    coverage = None
    if collector is not None:
        coverage = concluded(collector, options.coverage_out, options.cover_fail_under)
    silence = given["connect"].tell.last if options.connect is not None else ""
    return _Outcome(cell, end_us, notice, timeline, connected, silence, coverage)


def _view(cell: Bench, files: SourceFiles) -> View:
    """Return the page of a run, which takes its records from now on.

    It has the networks of the program, with the variables that show what was energised.
    """
    drawn = DrawnProgram(cell.program, files.own)
    view = View(drawn.header(cell.trace.header), drawn.groups)
    cell.trace.listen(heard(lambda record: view.take(drawn.filled(record))))
    return view


def _errors_of(cell: Bench) -> BlockErrors | None:
    """Return an object that collects the errors of a cell's blocks in each scan from now on."""
    if not isinstance(cell, Cell):
        return None
    errors = BlockErrors(cell.program)

    def take(record: Record) -> None:
        if isinstance(record, Scan):
            errors.scan(record.t_us)

    cell.trace.listen(take)
    return errors


class _Safe:
    """Observes whether SI(00), the emergency stop input, was ever ON in a run."""

    def __init__(self) -> None:
        self._ever = False

    def take(self, record: Record) -> None:
        """Process the next record of the run's trace."""
        if not self._ever and isinstance(record, Scan):
            self._ever = bool(record.si[_SI_00] & 1)

    def told(self, cell: Bench, files: SourceFiles, options: RunOptions) -> str:
        """Return a hint about how to end the emergency stop; empty if SI(00) was ON in the run."""
        names = [] if self._ever else safety_inputs(*files.users)
        left = [name for name in names if cell[name] is False]
        if not left:
            return ""
        given = ", ".join(f'"{name}" = true' for name in left)
        beside = [file for file in dict.fromkeys(_beside(files)) if file != options.stimulus]
        where = f"; there is one beside the program: --stimulus {beside[0]}" if beside else ""
        are = "is" if len(left) == 1 else "are"
        return (
            f"note: SI(00) was OFF in the whole run, so the robot stayed in emergency stop: "
            f"{' and '.join(left)} {are} FALSE; set it in a stimulus, "
            f'at = [{{ time = "100ms", set = {{ {given} }} }}]{where}'
        )


def _beside(files: SourceFiles) -> Iterator[Path]:
    """Yield the stimulus files in the folders of a program."""
    for file in files.users[0]:
        found = file.parent / "stimulus.toml"
        if found.is_file():
            yield found


def _check_panel(options: RunOptions) -> None:
    """Raise InputError if the options do not allow a page for the program's panels."""
    if options.panel is None:
        return
    check_port("--panel", options.panel or 1)
    if options.connect is not None:
        hint = "leave --connect out: a page in a browser must not operate a robot that may be real"
        raise InputError("--panel is for a virtual controller", hint=hint)
    if not options.realtime:
        raise InputError(
            "--panel needs a run in real time", hint="add --link enip --realtime, and --for 10m"
        )


@contextmanager
def _panel(options: RunOptions, cell: Bench) -> Iterator[None]:
    """Serve the page of `--panel` while the program runs."""
    if options.panel is None or not isinstance(cell, Cell):
        yield
        return
    try:
        from rcx_harness.serve.panel.plate import plates_of
        from rcx_harness.serve.panel.server import PanelServer
    except ModuleNotFoundError:
        hint = "pip install aiohttp"
        raise InputError("the page needs the library aiohttp", hint=hint) from None
    plates = plates_of(cell.program)

    def exchange() -> None:
        for plate in plates:
            plate.exchange()
        cell.at(cell.now_us + cell.timing.scan_us, exchange)

    cell.at(cell.now_us, exchange)
    with PanelServer(plates, options.panel) as server:
        print(f"panel: {server.address}")
        print("Ctrl-C ends it. This is a simulation: no robot moves.", flush=True)
        yield


def _title(options: RunOptions, cell: Bench) -> str:
    names = ", ".join(path.name for path in options.files)
    if not isinstance(cell, Cell):
        return f"{names}: scan {cell.trace.header['scan_us'] / 1000:g} ms"
    return f"{names}: scan {cell.timing.scan_us / 1000:g} ms, RPI {cell.timing.rpi_us / 1000:g} ms"


def _print_outcome(options: RunOptions, outcome: _Outcome) -> None:
    """Print the chart (if requested), the violations and the summary."""
    cell, violations = outcome.cell, outcome.cell.violations
    if options.show:
        width = min(shutil.get_terminal_size((100, 24)).columns, 120)
        plain = not draws(sys.stdout.encoding)
        line_us = options.line_us
        if line_us is None:
            print(legible(text_chart(outcome.timeline, width, ascii_only=plain)))
        else:
            text = scaled_text(outcome.timeline, width, ascii_only=plain, line_us=line_us)
            print(legible(text))
    if watched := cell.watched():
        print("watched, at the end:")
        print(legible("\n".join(f"  {path} = {value}" for path, value in watched.items())))
    if outcome.notice:
        print(legible(outcome.notice))
    if not isinstance(cell, Cell):
        pass
    elif not cell.matched:
        print("no connection: the areas of PLC and robot differ in size")
    elif not outcome.ever_connected and options.connect is None:
        print("no connection in the whole run")
    if isinstance(cell, Cell):
        for text in (*program_errors(cell), *busy_programs(cell)):
            print(legible(text))
    for violation in violations[:_MOST_SHOWN]:
        print(legible(f"violation at {format_us(violation.t_us)}: {violation.text}"))
    rest = len(violations) - _MOST_SHOWN
    if rest > 0:
        print(f"... and {counted(rest, 'further violation')}")
    counts = [counted(cell.scans, "scan")]
    if isinstance(cell, Cell):
        counts.append(counted(cell.cycles, "controller cycle"))
        counts.append(counted(cell.commands, "remote command"))
    counts.append(counted(len(violations), "violation"))
    if stopped := _stopped_programs(outcome):
        counts.append(counted(stopped, "stopped robot program"))
    engine = cell.trace.header["engine"]
    print(f"{outcome.duration_us / 1e6:g} s on the {engine} engine: {', '.join(counts)}")
    written = [path for path in options.outputs.values() if path is not None]
    if written:
        print("written: " + ", ".join(os.fspath(path) for path in written))
    if outcome.coverage is not None:
        print(f"\n{outcome.coverage.text}")
