"""`rcx demo`: the first example against the virtual robot, its chart and its page."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from rcx_harness.cell.sources import default_lib
from rcx_harness.cli.run import run
from structured_text.projects.sources import st_files

__all__ = ["demo"]

_EXAMPLE = "01_power_up"


def demo(
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder for page, trace, chart and wave file.")
    ] = Path("out/demo"),
) -> None:
    """Run the first example against the virtual robot: its timing chart, and a page to look at.

    Exit code: the exit code of `rcx run`.
    """
    example = default_lib().parent / "examples" / _EXAMPLE
    run(
        files=st_files(example),
        stimulus=example / "stimulus.toml",
        robot=[example / "robot.toml"],
        scan="10ms",
        duration="3s",
        show=True,
        trace=out / "trace.jsonl",
        chart=out / "chart.svg",
        vcd=out / "wave.vcd",
        view=out / "view.html",
        positions="pulses",
    )
    print(f"open in a browser: {out / 'view.html'}")
