"""Where people wait: start of commands, tests of a project, cells; and what serving holds.

CPU time of a quiet processor (`pace`), medians, with what is kept of earlier runs (a warm cache).
The project is that of `rcx new`.
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
from rcx_harness.cell.sources import default_lib
from rcx_harness.new import new_project
from rcx_tools.bench.figure import Figure, Options, at_most, missing
from rcx_tools.bench.pace import Cost, beside, paced
from rcx_tools.bench.processes import PROC, children, keeping, on_one_processor, running
from structured_text.engines.load import why_not

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
_RUNS, _CELLS, _TESTS = 9, 50, 500
#: So many cells are measured at once: the known work between them takes the caches' place.
_AFTER_ANOTHER = 5
_FIRST_MIB, _FURTHER_MIB, _SETTLED_S = 60, 40, 20


def measure(options: Options) -> dict[str, Figure]:
    """Start, tests, cells, memory; with `quick` a few of each."""
    runs, tests = (1, 10) if options.quick else (_RUNS, _TESTS)
    for folder in (_PROJECT, _KEPT):
        shutil.rmtree(folder, ignore_errors=True)
    new_project(_PROJECT)
    with on_one_processor():
        found = _starts(runs) | _cells(tests)
    return found | _memory()


def _starts(runs: int) -> dict[str, Figure]:
    """What commands take, and the tests of the project."""
    found: dict[str, Figure] = {}
    for name, (words, most) in _STARTS.items():
        peer = f"rcx {' '.join(words).replace(_EXAMPLE, '01_power_up')}"
        found[f"start_{name}"] = _figure(_costs([*_RCX, *words], runs), "s", most, peer)
    pytest = [sys.executable, "-m", "pytest", "-q", "-p", "no:hypothesispytest"]
    costs = _costs(pytest, runs, _PROJECT)
    peer = f"19 tests on {'the built-in engine' if why_not('matiec') else 'matiec'}, with pytest"
    return found | {"tests_of_rcx_new": _figure(costs, "s", 1.0, peer)}


def _cells(tests: int) -> dict[str, Figure]:
    """What further cells of a program take, and so many tests of 5 s."""
    found: dict[str, Figure] = {}
    for engine in ("builtin", "matiec"):
        if why := why_not(engine):
            found[f"cell_again_{engine}"] = missing("ms", "<= 3", why)
            continue
        again = _cells_of(engine, 0, _CELLS)[1:]
        found[f"cell_again_{engine}"] = _figure(again, "ms", 3, "further cells of a program")
    every = _cells_of("builtin", 5_000_000, tests)
    peer = f"500 cells of 5 s, built-in engine; {beside(every, 's', _TESTS)}"
    whole = sum(cost.quiet for cost in every) * _TESTS / len(every)
    return found | {"cells_500": at_most(whole, "s", 12, peer)}


def _figure(costs: Sequence[Cost], unit: str, most: float, peer: str) -> Figure:
    """The median, and beside it what was measured."""
    factor = 1000 if unit == "ms" else 1
    value = median(cost.quiet for cost in costs) * factor
    return at_most(value, unit, most, f"{peer}; {beside(costs, unit, factor)}")


def _cells_of(engine: str, run_us: int, cells: int) -> list[Cost]:
    """What a cell of the project takes from its start to its end, a few after another."""
    sources = sorted(_PROJECT.glob("plc/*.st"))

    def some() -> float:
        begun = time.process_time()
        for _ in range(_AFTER_ANOTHER):
            with Cell.build(sources, robot=_PROJECT / "robot.toml", engine=engine) as cell:
                cell.run(run_us)
        return (time.process_time() - begun) / _AFTER_ANOTHER

    return [paced(some) for _ in range(cells // _AFTER_ANOTHER)]


def _costs(command: Sequence[str], runs: int, folder: Path | None = None) -> list[Cost]:
    """Some processes, after one run that fills the cache."""
    environment = keeping(_KEPT)

    def one() -> float:
        before = _children_s()
        subprocess.run(command, stdout=subprocess.DEVNULL, check=True, cwd=folder, env=environment)
        return _children_s() - before

    one()
    return [paced(one) for _ in range(runs)]


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
