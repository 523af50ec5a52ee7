"""One run from the command line: build the cell, let time pass, write what was asked for."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from rcx_harness.cell import Cell
from rcx_harness.cell.build import Areas, Robots, blame_lib, check_outputs, several, source_files
from rcx_harness.cell.clock import Duration
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.errors import InputError
from rcx_harness.output.files import replace_files
from rcx_harness.robot import Violation
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.trace.wave import Wave
from rcx_harness.units import parse_us

__all__ = ["Outcome", "RunOptions", "run"]

#: Reports on the way come this often [s of real time].
_REPORT_S = 0.25
_SLICES = 400
#: Default time-out in real time: the longer of so many intervals and of this time.
_PATIENT_INTERVALS, _PATIENT_US = 32, 320_000


@dataclass(frozen=True)
class RunOptions:
    """What `rcx run` was asked for; the fields bear the names of its options."""

    files: list[Path]
    lib: Path | None = None
    scan: str | None = None
    duration: str = "5s"
    engine: str = "auto"
    link: str = "direct"
    realtime: bool = False
    size: int | None = None
    m: Areas = 0
    n: Areas = 0
    robot: Robots = None
    stimulus: Path | None = None
    seed: int = 0
    rpi: str = "10ms"
    jitter: str = "0ms"
    timeout: str | None = None
    phases: str | dict[str, Duration] = "zero"
    on_loss: str = "hold"
    trace: Path | None = None
    chart: Path | None = None
    vcd: Path | None = None
    watch: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class Outcome:
    """What came of a run."""

    engine: str
    notice: str
    scans: int
    cycles: int
    commands: int
    duration_us: int
    violations: list[Violation]
    timeline: Timeline
    matched: bool
    ever_connected: bool
    written: list[Path]


def run(options: RunOptions, progress: Callable[[int, int], None] | None = None) -> Outcome:
    """Run a program in a cell.

    Args:
        options: What to run, for how long, what to write.
        progress: Called now and then with the virtual time so far and in all [us].

    Raises:
        InputError: anything wrong with the input or the outputs.
    """
    try:
        duration_us = parse_us(options.duration)
    except InputError as error:
        raise InputError(f"--for: {error.message}", hint=error.hint) from None
    if not duration_us:
        raise InputError("a run of 0 s shows nothing", hint="use --for 5s")
    outputs = {"trace": options.trace, "chart": options.chart, "vcd": options.vcd}
    files = source_files(list(options.files), options.lib)
    check_outputs(outputs, files, *several(options.robot), options.stimulus)
    stimulus = Stimulus.load(options.stimulus) if options.stimulus is not None else None
    late = stimulus.late(duration_us) if stimulus is not None else ""
    timeline = Timeline()
    connected = False
    try:
        made = Cell.build(
            list(options.files),
            lib=options.lib,
            scan=options.scan,
            engine=options.engine,
            link=_link(options),
            size=options.size,
            m=options.m,
            n=options.n,
            robot=options.robot,
            rpi=options.rpi,
            jitter=options.jitter,
            timeout=_timeout(options),
            phases=options.phases,
            on_loss=options.on_loss,
            seed=options.seed,
            trace=options.trace,
            watch=options.watch,
        )
    except InputError as error:
        raise blame_lib(error, options.lib) from None
    with made as cell:
        cell.trace.listen(timeline.take)
        if stimulus is not None:
            stimulus.schedule(cell)
        wave = Wave(options.vcd, len(cell.robots)) if options.vcd is not None else None
        try:
            if wave is not None:
                cell.trace.listen(wave.take)
            reported = 0.0
            for number in range(1, _SLICES + 1):
                cell.run(duration_us * number // _SLICES - cell.now_us)
                connected = connected or cell.connected
                if progress is not None and time.monotonic() - reported >= _REPORT_S:
                    reported = time.monotonic()
                    progress(cell.now_us, duration_us)
        finally:
            if wave is not None:
                wave.close()
        if options.chart is not None:
            chart = svg_chart(timeline, _title(options, cell))
            replace_files({options.chart: chart.encode()})
        return Outcome(
            cell.program.engine,
            "\n".join(filter(None, (cell.notice, late))),
            cell.scans,
            cell.cycles,
            cell.commands,
            duration_us,
            cell.violations,
            timeline,
            cell.matched,
            connected,
            [path for path in outputs.values() if path is not None],
        )


def _link(options: RunOptions) -> str:
    """The cell's link; in real time the network is a real one and has its own jitter."""
    if not options.realtime:
        return options.link
    if options.link != "enip":
        raise InputError("only a real network runs in real time", hint="add --link enip")
    if parse_us(options.jitter):
        raise InputError(
            "in real time the jitter is what it is", hint="leave --jitter or --realtime out"
        )
    return "enip-realtime"


def _timeout(options: RunOptions) -> str | int | None:
    """In real time this computer may be late without the link being lost."""
    if options.timeout is None and options.realtime:
        return max(_PATIENT_INTERVALS * parse_us(options.rpi), _PATIENT_US)
    return options.timeout


def _title(options: RunOptions, cell: Cell) -> str:
    names = ", ".join(path.name for path in options.files)
    return f"{names}: scan {cell.timing.scan_us / 1000:g} ms, RPI {cell.timing.rpi_us / 1000:g} ms"
