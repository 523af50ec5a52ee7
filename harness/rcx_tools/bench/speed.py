"""Speed of `make demo` compared with real time, and CPU time of commands (medians)."""

from __future__ import annotations

import resource
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from statistics import median

from rcx_harness import Cell
from rcx_harness.cell.sources import default_lib
from rcx_tools.bench.figure import Figure, Options, at_least, missing, shown
from structured_text.engines.load import why_not

__all__ = ["measure"]

_EXAMPLE, _EXAMPLE_S = default_lib().parent / "examples/01_power_up", 3
#: Target for the speed of a run, as a multiple of real time.
_LEAST = {"matiec": 300, "builtin": 50}
_COMMANDS = ("--version", "--help", f"check {_EXAMPLE}", f"run {_EXAMPLE}")


def measure(options: Options) -> dict[str, Figure]:
    """Measure the run on both engines, and the commands with a warm cache."""
    runs = 1 if options.quick else 9
    found: dict[str, Figure] = {}
    for engine, least in _LEAST.items():
        name, unit = f"simulation_{engine}", "x real time"
        if why := why_not(engine):
            found[name] = missing(unit, f">= {least}", why)
            continue
        with Cell.build(_EXAMPLE, engine=engine, robot=_EXAMPLE / "robot.toml") as cell:
            run = partial(_run, cell, cell.snapshot())
            times = [_taken(run, resource.RUSAGE_SELF) for _ in range(runs)]
        found[name] = at_least(_EXAMPLE_S / median(times), unit, least, f"{_EXAMPLE_S} s of it")
    for words in _COMMANDS:
        command = [sys.executable, "-m", "rcx_harness", *words.split(" ", 1)]
        call = partial(subprocess.run, command, stdout=subprocess.DEVNULL, check=True)
        times = [_taken(call, resource.RUSAGE_CHILDREN) for _ in range(runs + 1)]
        found[f"start_{words.split()[0].strip('-')}"] = shown(median(times[1:]), "s", "warm cache")
    return found


def _run(cell: Cell, start: object) -> None:
    """Run the example from power-on to its last command."""
    cell.restore(start)
    cell["Main.CellSafe"] = True
    cell.run("500ms")
    cell["Main.Start"] = True
    cell.run(_EXAMPLE_S * 1_000_000 - 500_000)


def _taken(work: Callable[[], object], who: int) -> float:
    """Return the CPU time that some work takes in this process or in its child processes [s]."""
    before = resource.getrusage(who)
    work()
    after = resource.getrusage(who)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
