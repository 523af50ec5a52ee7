"""`rcx compare`: compare a recorded controller with the virtual one."""

from __future__ import annotations

import ipaddress
import json
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.options import check_ipv4, check_port, duration_us
from rcx_harness.cli.progress import progress_bar
from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.compare.fit import fit as fit_to
from rcx_harness.look.compare.recording import load
from rcx_harness.look.compare.replay import Happening, Replay
from rcx_harness.look.compare.robot_file import robot_file
from rcx_harness.look.compare.text import as_json, chart, fit_lines, lines
from rcx_harness.robot import EVENTS, RobotConfig
from rcx_harness.spec.wire import AREA_SIZES, check_size
from rcx_harness.trace.chart import Timeline, text_chart
from rcx_harness.trace.chart_svg import svg_chart
from structured_text.bench.outputs import check_outputs
from structured_text.errors import InputError, legible
from structured_text.output.files import NewFiles, replace_files

__all__ = ["compare"]

#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{\n  "begin_us": '


def compare(
    file: Annotated[Path, typer.Argument(help="A capture (pcapng, pcap) or a trace (jsonl).")],
    robot: Annotated[
        Path | None, typer.Option(help="Robot file of the virtual controller. Default: none.")
    ] = None,
    fit: Annotated[
        Path | None,
        typer.Option(help="Find the settings with which both agree, and write this robot file."),
    ] = None,
    events: Annotated[
        Path | None,
        typer.Option(help="Actions of people at the cell: a stimulus with robot = ... only."),
    ] = None,
    controller: Annotated[
        str | None, typer.Option(help="Address of the controller, if a capture has several.")
    ] = None,
    size: Annotated[
        int | None, typer.Option(help="Bytes of its areas, 48 or 256. Default: both are accepted.")
    ] = None,
    port: Annotated[int, typer.Option(help="TCP port of explicit messages.")] = PORT,
    tolerance: Annotated[
        str | None,
        typer.Option(
            help="Allowed difference in the time of an answer. Default: from the recording."
        ),
    ] = None,
    around: Annotated[
        str, typer.Option(help="Time that the chart shows before and after the first difference.")
    ] = "200ms",
    quiet: Annotated[bool, typer.Option("--quiet", help="Print no chart.")] = False,
    svg: Annotated[Path | None, typer.Option("--chart", help="Write the chart (SVG).")] = None,
    json_file: JsonFile = None,
) -> None:
    """Feed a recording to the virtual controller, and show where the real controller differs.

    With --fit the command finds the robot file with which both agree. It measures delays and tries
    every other setting that has an influence. It reports what the recording cannot decide, and
    differences that no setting explains. It only reads, and never overwrites a file.

    Exit code: 0 if both agree (with --fit: if every difference is explained), 1 if not, 2
    on bad input. A damaged recording is bad input, too; the part before the damage is compared.
    """
    check_outputs({"chart": svg}, None, file, robot, events)
    output = JsonOutput(json_file, _BEGINNING, [one for one in (file, robot, events) if one])
    check_port("--port", port)
    if size is not None:
        check_size(size)
    if controller is not None:
        check_ipv4("--controller", controller)
    around_us = duration_us("--around", around)
    config = RobotConfig() if robot is None else RobotConfig.load(robot)
    happenings = [] if events is None else _happenings(events)
    with NewFiles([] if fit is None else [fit], "name another file") as fitted:
        with progress_bar("reading", not sys.stdout.isatty() or output.printed) as progress:
            hosts = [] if controller is None else [ipaddress.IPv4Address(controller).packed]
            sizes = AREA_SIZES if size is None else (size,)
            recording = load(file, hosts, sizes, port, progress)
        if tolerance is not None:
            recording = replace(recording, tolerance_us=duration_us("--tolerance", tolerance))
        if config.size != recording.size:
            if robot is not None and config.size != RobotConfig.size:
                text = f"the recording has areas of {recording.size} bytes, not {config.size}"
                raise InputError(text, file=robot)
            config = replace(config, size=recording.size)
        replay = Replay(recording, happenings)
        found = None
        if fit is not None:
            with progress_bar("fitting", True) as progress:
                found = fit_to(replay, config, progress)
            config = found.config
        result = replay.run(config)
        drawn = None
        if result.first_us is not None:
            drawn = chart(replay, result, around_us, result.first_us)
        if found is not None and fit is not None:
            fitted.write(robot_file(found, robot, file.name))
        if svg is not None:
            title = f"{file.name}: recorded, and virtual (2)"
            replace_files({svg: svg_chart(drawn or Timeline(), title)})
        if not output.printed:
            if drawn is not None and not quiet:
                width = min(shutil.get_terminal_size((100, 24)).columns, 120)
                unicode = "utf" in (sys.stdout.encoding or "").lower()
                print(legible(text_chart(drawn, width, ascii_only=not unicode)))
                print("controller 1 is recorded, controller 2 is virtual\n")
            for line in [
                *lines(replay, result),
                *(["", *fit_lines(found, replay)] if found else []),
            ]:
                print(legible(line))
            if fit is not None:
                print(f"written: {fit}")
        output.write(f"{json.dumps(as_json(replay, result, found), indent=2)}\n")
        if recording.trouble is not None:
            raise recording.trouble
        if result.differences if found is None else found.left:
            raise typer.Exit(1)


def _happenings(path: Path) -> list[Happening]:
    """Return the robot events of a stimulus; raise InputError for entries of other kinds."""
    found = []
    for entry in Stimulus.load(path).entries:
        if entry.values or entry.hold or entry.release or entry.area is not None:
            hint = "use time and robot = ... only: the recording contains the PLC"
            raise InputError("has more than robot events", file=path, line=entry.line, hint=hint)
        for event, args in entry.events:
            if event not in EVENTS:
                hint = "leave it out: the recording contains the loss of the link"
                raise InputError(
                    f"{event!r} is not an event of a robot", file=path, line=entry.line, hint=hint
                )
            found.append(Happening(entry.t_us, event, args))
    return found
