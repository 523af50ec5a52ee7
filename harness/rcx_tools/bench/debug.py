"""How long a step back takes after a long run under the debugger, and what its past weighs."""

from __future__ import annotations

import tempfile
import time
import tracemalloc
from pathlib import Path
from random import Random

from rcx_harness.cell import Cell
from rcx_harness.robot import RobotConfig, RobotProgram
from rcx_harness.verify.debug.machine import CellMachine
from rcx_tools.bench.figure import Figure, Options, at_most, shown
from rcx_tools.bench.simulation import demo_program
from structured_text.debug.places import Places
from structured_text.debug.player import Player

__all__ = ["measure"]

#: Of a run of so long with a scan of 10 ms [s].
_LONG_S, _QUICK_S = 600, 20
_STEPS, _WEIGHED = 40, 50
_MOST_MS, _MOST_MIB = 50, 200


def measure(options: Options) -> dict[str, Figure]:
    """A step back over the border of two scans, and all snapshots of the run."""
    seconds = _QUICK_S if options.quick else _LONG_S
    robot = RobotConfig(programs=(RobotProgram(),))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "Demo.st"
        file.write_text(demo_program(), encoding="utf-8")
        cell = Cell.build(file, scan="10ms", engine="builtin", robot=robot, keep=1)
    machine = CellMachine(cell, seconds * 1_000_000, f"{seconds}s")
    player = Player(machine, Places(machine.program))
    began = time.perf_counter()
    while not machine.ended:
        player.plain()
    run_s, scans = time.perf_counter() - began, machine.scans
    steps = sorted(_step_back(player, scan) for scan in _scans(scans))
    weight = _weight(machine) * player.kept
    machine.close()
    run = f"{seconds} s of virtual time, {scans} scans"
    return {
        "debug_step_back": at_most(steps[-1], "ms", _MOST_MS, f"the slowest of {_STEPS}; {run}"),
        "debug_step_back_median": shown(steps[len(steps) // 2], "ms", run),
        "debug_memory": at_most(weight, "MiB", _MOST_MIB, f"{player.kept} snapshots; {run}"),
        "debug_run": shown(seconds / run_s, "x real time", "keeping snapshots"),
    }


def _scans(many: int) -> list[int]:
    random = Random("steps back")
    return [many - 1, *(random.randrange(1, many) for _ in range(_STEPS - 1))]


def _step_back(player: Player, scan: int) -> float:
    """From the beginning of the scan behind it to its last statement [ms]."""
    player.seek(scan + 1)
    began = time.perf_counter()
    player.seek(scan)
    player.every(lambda: None)  # which is its last statement?
    player.seek(scan)
    player.every(lambda: None)  # and there
    return (time.perf_counter() - began) * 1000


def _weight(machine: CellMachine) -> float:
    """Of one snapshot [MiB]."""
    tracemalloc.start()
    kept = [machine.snapshot() for _ in range(_WEIGHED)]
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return size / len(kept) / 2**20
