"""Many workers beside one: how much of each processor is used, and that the verdicts are the same.

An item is a seed: it draws the clocks of a cell, which then carries out two commands. Machines are
shared, so the efficiency is made of ratios that other work hardly changes: the share of the time
in which a worker has an item, and the processor time of the items without workers beside that in
them, each as a quiet processor takes it (`pace`).
"""

from __future__ import annotations

import os
import time
from collections import defaultdict
from collections.abc import Sequence
from random import Random
from typing import NamedTuple

from rcx_harness.cli.options import counted
from rcx_harness.spec.wire import CYCLE_US
from rcx_tools.bench.figure import Figure, Options, at_least, at_most, shown
from rcx_tools.bench.handshake import Case, Simulated, simulate_command
from rcx_tools.bench.pace import Slower
from structured_text.farm import Farm
from structured_text.output.system import processors

__all__ = ["Timed", "busy", "measure", "timed", "verdict"]

#: Rounds and seeds in each: all take part in each round.
_ROUNDS, _QUICK = (4, 250), (1, 12)
_HERE, _WORKERS = 0, (1, 2, 4)
_LEAST = 0.9
#: Of this process.
_slower = Slower()


class Timed(NamedTuple):
    """A verdict, who gave it, from when until when [s], its time on a quiet processor [s]."""

    verdict: Simulated
    process: int
    begin: float
    end: float
    cpu: float


def measure(options: Options) -> dict[str, Figure]:
    """The same seeds in this process and in 1, 2 and 4 workers."""
    rounds, seeds = _QUICK if options.quick else _ROUNDS
    runs: dict[int, list[list[Timed]]] = {count: [] for count in (_HERE, *_WORKERS)}
    for first in range(0, rounds * seeds, seeds):
        for count, those in runs.items():
            run = Farm(count).run(timed, range(first, first + seeds))
            those.append([one for _, one in run])
    every = {count: [one for run in those for one in run] for count, those in runs.items()}
    verdicts = zip(*([one.verdict for one in those] for those in every.values()), strict=True)
    differ = sum(any(one != seed[0] for one in seed) for seed in verdicts)
    counts = ", ".join(map(str, _WORKERS))
    beside = f"{rounds * seeds} seeds without workers and with {counts}"
    found = {"farm_verdicts_that_differ": at_most(differ, "seeds", 0, beside)}
    there, here_s = processors(), _cpu(runs[_HERE])
    for count in _WORKERS:
        share = sum(busy(run) for run in runs[count]) / rounds
        efficiency = share * here_s / _cpu(runs[count])
        beside = f"{counted(count, 'worker')} on {counted(there, 'processor')}"
        found[f"farm_efficiency_{count}"] = (
            at_least(efficiency, "a processor", _LEAST, beside)
            if count <= there
            else shown(efficiency, "a worker", beside)
        )
    return found


def busy(run: Sequence[Timed]) -> float:
    """The share of the time in which workers have an item, from the end of the first of each on."""
    of: dict[int, list[Timed]] = defaultdict(list)
    for one in sorted(run, key=lambda one: one.begin):
        of[one.process].append(one)
    end = max(one.end for one in run)
    has = sum(one.end - one.begin for those in of.values() for one in those[1:])
    could = sum(end - those[0].end for those in of.values())
    return has / could if could else 1.0


def _cpu(runs: Sequence[Sequence[Timed]]) -> float:
    """Processor time of all items but the first of each worker, which compiles; for each [s]."""
    times = []
    for run in runs:
        seen: set[int] = set()
        for one in sorted(run, key=lambda one: one.begin):
            if one.process in seen:
                times.append(one.cpu)
            seen.add(one.process)
    return sum(times) / len(times) if times else 1.0


def timed(seed: int) -> Timed:
    """The verdict of a seed, and how long it takes."""
    begin, cpu = time.monotonic(), time.process_time()
    found = verdict(seed)
    quiet = (time.process_time() - cpu) / _slower()
    return Timed(found, os.getpid(), begin, time.monotonic(), quiet)


def verdict(seed: int) -> Simulated:
    """What a cell does whose clocks are drawn from a seed."""
    random = Random(seed)
    scan_us, rpi_us = 1000 * random.randint(1, 20), 1000 * random.randint(1, 100)
    periods = (CYCLE_US, rpi_us, rpi_us, scan_us)
    first, second, third, fourth = (random.randrange(period) for period in periods)
    response_us = 1000 * random.randint(0, 20)
    return simulate_command(Case(scan_us, rpi_us, response_us, (first, second, third, fourth)))
