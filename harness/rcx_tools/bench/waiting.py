"""Where people wait: start of commands, tests of a project, cells; and what serving holds.

CPU time, medians and the best of all, with what is kept of earlier runs (a warm cache). The
project is that of `rcx new`.
"""

from __future__ import annotations

import os
import re
import resource
import shutil
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from statistics import median

from rcx_harness import Cell
from rcx_harness.cell.build import default_lib
from rcx_harness.engine.load import why_not
from rcx_harness.new import new_project
from rcx_tools.bench.figure import OUT_OF_REACH, Figure, Options, at_most, missing
from rcx_tools.bench.processes import PROC, children, keeping, running

__all__ = ["measure"]

_PROJECT, _KEPT = Path("out/waiting"), Path("out/waiting_kept")
_EXAMPLE = os.fspath(default_lib().parent / "examples/01_power_up")
_RCX = (sys.executable, "-m", "rcx_harness")
#: Commands, and how long each may take [s].
_STARTS: dict[str, tuple[tuple[str, ...], float]] = {
    "version": (("--version",), 0.15),
    "help": (("--help",), 0.15),
    "check": (("check", _EXAMPLE), 0.5),
    "run": (("run", _EXAMPLE), 0.7),
}
_RUNS, _CELLS, _TESTS = 9, 30, 500
_FIRST_MIB, _FURTHER_MIB, _SETTLED_S = 60, 40, 20


def measure(options: Options) -> dict[str, Figure]:
    """Start, tests, cells, memory; with `quick` a few of each."""
    runs, tests = (1, 10) if options.quick else (_RUNS, _TESTS)
    for folder in (_PROJECT, _KEPT):
        shutil.rmtree(folder, ignore_errors=True)
    new_project(_PROJECT)
    found: dict[str, Figure] = {}
    for name, (words, most) in _STARTS.items():
        peer = f"rcx {' '.join(words).replace(_EXAMPLE, '01_power_up')}"
        found[f"start_{name}"] = _figure(_costs([*_RCX, *words], runs), "s", most, peer)
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:hypothesispytest"]
    costs = _costs(pytest, runs, _PROJECT)
    found["tests_of_rcx_new"] = _figure(costs, "s", 1.0, "19 tests, with pytest")
    for engine in ("builtin", "matiec"):
        if why := why_not(engine):
            found[f"cell_again_{engine}"] = missing("ms", "<= 3", why)
            continue
        again = [1000 * _cell(engine, 0) for _ in range(_CELLS)][1:]
        found[f"cell_again_{engine}"] = _figure(again, "ms", 3, "further cells of a program")
    every = [_cell("builtin", 5_000_000) for _ in range(tests)]
    peer = f"500 cells of 5 s, built-in engine{OUT_OF_REACH}; at best {_TESTS * min(every):.3g}"
    found["cells_500"] = at_most(sum(every) * _TESTS / tests, "s", 12, peer)
    return found | _memory()


def _figure(costs: Sequence[float], unit: str, most: float, peer: str) -> Figure:
    """The median, and beside it the best: far from each other where the machine is shared."""
    return at_most(median(costs), unit, most, f"{peer}; at best {min(costs):.3g}")


def _cell(engine: str, run_us: int) -> float:
    """CPU time of a cell of the project from its start to its end [s]."""
    begun = time.process_time()
    sources = sorted(_PROJECT.glob("plc/*.st"))
    with Cell.build(sources, robot=_PROJECT / "robot.toml", engine=engine) as cell:
        cell.run(run_us)
    return time.process_time() - begun


def _costs(command: Sequence[str], runs: int, folder: Path | None = None) -> list[float]:
    """CPU time of some processes, after one run that fills the cache [s]."""
    costs = []
    environment = keeping(_KEPT)
    for _ in range(runs + 1):
        before = _children_s()
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True, cwd=folder, env=environment)
        costs.append(_children_s() - before)
    return costs[1:]


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _memory() -> dict[str, Figure]:
    """The proportional share of memory of one served controller, and of a second one."""
    one, two = _held(1), _held(2)
    peer = "rcx serve, all its processes, proportional share"
    return {
        "serve_memory": at_most(one, "MiB", _FIRST_MIB, peer),
        "serve_memory_further": at_most(two - one, "MiB", _FURTHER_MIB, "a second controller"),
    }


def _held(controllers: int) -> float:
    """What the processes of `rcx serve` hold [MiB]."""
    addresses = [f"--address=127.99.8.{number}" for number in range(1, controllers + 1)]
    with running("rcx_harness", ["serve", *addresses]) as process:
        time.sleep(_SETTLED_S)
        kib = 0
        for number in (process.pid, *children(process.pid)):
            with suppress(OSError):
                share = (PROC / str(number) / "smaps_rollup").read_text(encoding="ascii")
                kib += sum(map(int, re.findall(r"^Pss:\s+(\d+)", share, re.MULTILINE)))
    return kib / 1024
