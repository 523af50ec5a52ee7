"""`rcx judge`: judge a recording of a controller and its PLC."""

from __future__ import annotations

import ipaddress
import json
import shutil
import sys
from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cli.json_file import JsonFile, JsonOutput
from rcx_harness.cli.options import check_ipv4, check_port, duration_us
from rcx_harness.cli.progress import progress_bar
from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.judge.judge import Judgement, JudgeOptions
from rcx_harness.look.judge.judge import judge as judge_file
from rcx_harness.look.judge.text import as_json, summary
from rcx_harness.spec.wire import AREA_SIZES, check_size
from rcx_harness.trace.chart import text_chart
from rcx_harness.trace.chart_svg import svg_chart
from structured_text.bench.outputs import check_outputs
from structured_text.errors import legible
from structured_text.output.files import replace_files

__all__ = ["judge"]

#: The first bytes of each JSON file that this command writes.
_BEGINNING = '{\n  "file": '


def judge(
    file: Annotated[Path, typer.Argument(help="A capture (pcapng, pcap) or a trace (jsonl).")],
    controller: Annotated[
        list[str] | None,
        typer.Option(help="Only this controller, by its address; may be repeated."),
    ] = None,
    size: Annotated[
        int | None, typer.Option(help="Bytes of its areas, 48 or 256. Default: both are accepted.")
    ] = None,
    port: Annotated[int, typer.Option(help="TCP port of explicit messages.")] = PORT,
    tolerance: Annotated[
        str,
        typer.Option(
            help="Time by which two changes of dedicated inputs may be closer than 100 ms."
        ),
    ] = "1ms",
    begin: Annotated[
        str, typer.Option("--from", help="Print events and draw the chart from this time on.")
    ] = "0s",
    duration: Annotated[
        str | None, typer.Option("--for", help="Time to show from --from on. Default: to the end.")
    ] = None,
    quiet: Annotated[
        bool, typer.Option("--quiet", help="Print no events, only the summary.")
    ] = False,
    show: Annotated[bool, typer.Option("--show", help="Print the timing chart.")] = False,
    chart: Annotated[Path | None, typer.Option(help="Write the timing chart (SVG).")] = None,
    trace: Annotated[
        Path | None, typer.Option(help="Write the connections as a trace (JSON lines).")
    ] = None,
    json_file: JsonFile = None,
) -> None:
    """Judge a recording of a PLC and its controllers: who broke a rule of the wire, and when.

    It follows the cyclic connections of a capture. It prints every remote command and dedicated
    signal in plain language, lost packets, and a table of response times. It only reads.

    Exit code: 0 without a violation, 1 with violations, 2 on bad input. A damaged or
    truncated file is bad input, too; the part before the damage is judged.
    """
    check_outputs({"trace": trace, "chart": chart}, None, file)
    output = JsonOutput(json_file, _BEGINNING, [file])
    check_port("--port", port)
    if size is not None:
        check_size(size)
    for host in controller or []:
        check_ipv4("--controller", host)
    from_us = duration_us("--from", begin)
    options = JudgeOptions(
        file=file,
        hosts=[ipaddress.IPv4Address(host).packed for host in controller or []],
        sizes=AREA_SIZES if size is None else (size,),
        port=port,
        tolerance_us=duration_us("--tolerance", tolerance),
        from_us=from_us,
        until_us=None if duration is None else from_us + duration_us("--for", duration),
        trace=trace,
    )
    silent = quiet or output.printed
    with progress_bar("reading", silent or not sys.stdout.isatty()) as progress:
        result = judge_file(options, (lambda line: None) if silent else print, progress)
    if chart is not None:
        replace_files({chart: svg_chart(result.timeline, file.name)})
    if not output.printed:
        _print(result, show=show, silent=silent)
    output.write(f"{json.dumps(as_json(result), indent=2)}\n")
    if result.capture is not None and (trouble := result.capture.trouble()):
        raise trouble
    if result.count:
        raise typer.Exit(1)


def _print(result: Judgement, *, show: bool, silent: bool) -> None:
    if show:
        width = min(shutil.get_terminal_size((100, 24)).columns, 120)
        unicode = "utf" in (sys.stdout.encoding or "").lower()
        print(legible(text_chart(result.timeline, width, ascii_only=not unicode)))
    if result.chart_end_us is not None:
        end = f"{result.chart_end_us / 1e6:.3f}s"
        print(f"the chart is full and ends at {end}; use --from {end} for the rest")
    elif not silent:
        print()
    for line in summary(result):
        print(legible(line))
