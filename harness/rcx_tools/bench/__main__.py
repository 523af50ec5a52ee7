"""Command `make bench` (`python -m rcx_tools.bench`): measure, print, and write out/bench.json.

The exit code is 0 if all targets are met, 1 if a target is missed, and 2 if a measurement is not
possible. Targets that cannot be met (see docs/explanation/timing.md) are listed separately.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path

from rich.console import Console

from rcx_tools.bench.figure import Figure, Options, as_table, store
from structured_text.errors import InputError
from structured_text.output.units import parse_us

__all__ = ["POINTS", "main"]

OUTPUT = Path("out/bench.json")
#: Width of the table if the output is not a terminal, for example a file.
_FILE_WIDTH = 140

#: The benchmarks. Each is a module of this package with a function `measure(options)`. The value is
#: its text in the help.
POINTS: dict[str, str] = {
    "handshake": "scans of commands and sequences, and their minimum (docs/explanation/timing.md)",
    "sizes": "bytes per instance on matiec and STruC++",
    "scan": "time for areas, idle blocks and handshakes on matiec and STruC++",
    "speed": "the run of make demo compared with real time, and the start of commands",
    "programs": "a cell with movements in the robot's program, compared with remote commands",
    "cyclic": "cyclic I/O in real time: packets, gaps, CPU, alone and under a flood",
    "editor": "the language server: diagnostics after a change, hover, completion",
    "language": "files of public repositories that the front end accepts (RCX_REPOSITORIES)",
    "guided": "scans until planted faults are found, guided compared with drawn storms",
    "suite": "the tests: time, the ten slowest, the same results in any order and processes",
}


def main(arguments: Sequence[str]) -> int:
    """Run the requested benchmarks and return the exit code (see the head of this module)."""
    parser = argparse.ArgumentParser(prog="make bench", description=__doc__)
    parser.add_argument("--only", default="", help=f"some of {', '.join(POINTS)}")
    parser.add_argument("--rpi", default="10ms,5ms,2ms,1ms", help="intervals of cyclic I/O")
    parser.add_argument("--for", default="10s", dest="duration", help="length of real-time runs")
    parser.add_argument("--quick", action="store_true", help="only a few samples")
    given = parser.parse_args(arguments)
    try:
        points = _points(given.only)
        options = Options(
            seconds=parse_us(given.duration) / 1e6,
            rpi_us=tuple(parse_us(text) for text in given.rpi.split(",")),
            quick=given.quick,
        )
        found = _measured(points, options)
    except InputError as error:
        Console(stderr=True).print(f"make bench: {error}", markup=False, highlight=False)
        return 2
    return 0 if all(one.met for one in found.values()) else 1


def _measured(points: Sequence[str], options: Options) -> dict[str, Figure]:
    """Run the benchmarks, print each result as soon as it is known, and save the results."""
    console = Console()
    if not console.is_terminal:
        console = Console(width=_FILE_WIDTH)
    every: dict[str, Figure] = {}
    for point in points:
        console.print(f"{point}: {POINTS[point]} ...", highlight=False)
        found = import_module(f"rcx_tools.bench.{point}").measure(options)
        store(found, OUTPUT)
        console.print(as_table(found))
        every |= found
    missed = [name for name, one in every.items() if one.missed]
    beyond = [name for name, one in every.items() if not one.met and not one.missed]
    console.print(f"written: {OUTPUT}", highlight=False)
    for what, names in (("out of reach", beyond), ("missed", missed)):
        if names:
            console.print(f"{what}: {', '.join(names)}", highlight=False)
    return every


def _points(only: str) -> list[str]:
    """Return the benchmarks that the user names, or all but the longest.

    Raises:
        InputError: a benchmark does not exist.
    """
    wanted = [text.strip() for text in only.split(",") if text.strip()]
    if not wanted:
        public = "RCX_LIBRARIES" in os.environ or "RCX_REPOSITORIES" in os.environ
        left_out = {"guided"} if public else {"guided", "language"}  # guided takes hours
        wanted = [one for one in POINTS if one not in left_out]
    for point in wanted:
        if point not in POINTS:
            raise InputError(f"there is no point {point!r} to measure", hint=", ".join(POINTS))
    return wanted


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
