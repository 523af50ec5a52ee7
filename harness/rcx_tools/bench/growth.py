"""What more of something costs: each doubling of it doubles the time, and takes no more memory.

Command blocks, robots, the length of a run that writes a trace, the packets of a capture that is
judged, and the seeds of a campaign. The costs of three sizes have to lie on a straight line; where
a longer run keeps nothing of what is over, its memory has to stay.
"""

from __future__ import annotations

import contextlib
import io
import os
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rcx_harness.cell import Cell
from rcx_harness.cli.app import main as rcx
from rcx_tools.bench import pace
from rcx_tools.bench.figure import OUT_OF_REACH, Figure, Options, at_least, at_most, shown
from rcx_tools.bench.planted import PLANTED
from rcx_tools.bench.processes import on_one_processor, peak_memory
from rcx_tools.bench.simulation import demo_cell

__all__ = ["Cost", "bend", "measure"]

_SUPPORT = Path(__file__).resolve().parents[3] / "tests" / "support"
_TURNS, _TURN_S = 25, 4.0
#: Processes of each length: a trace's memory is 1.3 MiB more in every second one, where pages lie.
_ROUNDS = {"trace": 8, "capture": 9, "seeds": 1}
_SIZES = {"blocks": (1, 10, 50), "robots": (1, 2, 4)}
#: Seconds of a run (records stay in memory for the first of them), of a capture; seeds.
_LENGTHS = {"trace": (150, 300, 600), "capture": (60, 120, 240), "seeds": (32, 64, 128)}
_QUICK = {"trace": (2, 4, 8), "capture": (2, 4, 8), "seeds": (1, 2, 4)}
_UNITS = {"trace": "us/s", "capture": "us/s", "seeds": "ms/seed"}
_SCAN_US = 10_000
#: What grew with its length would need so much for a minute [KiB]; it must stay well below.
_MOST_KIB = 1_000
_OFF = 0.1
#: Twice what a campaign made before cells became faster [scans/s].
_CAMPAIGN_SCANS = 16_600


class Cost(NamedTuple):
    """CPU time [s] and peak of memory [KiB] of a process, and the scans it has made."""

    measured: float
    seconds: float  # as a quiet processor takes it
    memory: int
    scans: int


def measure(options: Options) -> dict[str, Figure]:
    """Scans with more blocks and robots; longer runs and captures, more seeds."""
    found: dict[str, Figure] = {}
    with on_one_processor():
        for what, sizes in _SIZES.items():
            found |= _scans(what, sizes, 0.5 if options.quick else _TURN_S)
        for what, sizes in (_QUICK if options.quick else _LENGTHS).items():
            found |= _runs(what, sizes, 1 if options.quick else _ROUNDS[what])
    return found


def bend(sizes: Sequence[int], costs: Sequence[float]) -> float:
    """How far the cost of the middle size is off the line of the others, as a part of the last."""
    first, middle, last = sizes
    share = (middle - first) / (last - first)
    expected = costs[0] + (costs[2] - costs[0]) * share
    return abs(costs[1] - expected) / costs[2]


def _scans(what: str, sizes: Sequence[int], seconds: float) -> dict[str, Figure]:
    """Cost of a scan with so many blocks, or robots."""
    with ExitStack() as held:
        cells = []
        for size in sizes:
            robots, blocks = (size, 1) if what == "robots" else (1, size)
            cells.append(held.enter_context(demo_cell("builtin", robots=robots, blocks=blocks)))
        rounds = [[_cost(cell, seconds) for cell in cells] for _ in range(_TURNS)]
    # In turns, and the median of each: what else the machine does is no growth.
    costs = [median(each) for each in zip(*rounds, strict=True)]
    found = {
        f"scan_{size}_{what}": shown(cost, "us/scan", "built-in engine")
        for size, cost in zip(sizes, costs, strict=True)
    }
    return found | _line(what, sizes, costs)


def _cost(cell: Cell, seconds: float) -> float:
    """CPU time of a scan [us]."""

    def run() -> float:
        begun = time.process_time()
        cell.run(round(seconds * 1e6))
        return time.process_time() - begun

    return pace.paced(run).quiet / seconds * _SCAN_US


def _runs(what: str, sizes: Sequence[int], rounds: int) -> dict[str, Figure]:
    """Cost and memory of processes of their own, of several lengths."""
    turns = [[_alone(what, size) for size in sizes] for _ in range(rounds)]
    costs = [_usual(each) for each in zip(*turns, strict=True)]
    unit, factor = _UNITS[what], 1e3 if what == "seeds" else 1e6
    found = {
        f"growth_{what}_{size}": shown(one.seconds / size * factor, unit, _peer(one, size, factor))
        for size, one in zip(sizes, costs, strict=True)
    }
    grown = max(0, costs[-1].memory - costs[0].memory)
    beside = f"{sizes[-1]} beside {sizes[0]}"
    found[f"growth_{what}_memory"] = at_most(grown, "KiB", _MOST_KIB, beside)
    if what == "seeds":
        rate = costs[-1].scans / costs[-1].seconds
        peer = "of one processor, built-in engine" + OUT_OF_REACH
        found["campaign_scans"] = at_least(rate, "scans/s", _CAMPAIGN_SCANS, peer)
    return found | _line(what, sizes, [one.seconds for one in costs])


def _usual(rounds: Sequence[Cost]) -> Cost:
    """Of several processes the medians of their time, and the least memory."""
    return Cost(
        median(one.measured for one in rounds), median(one.seconds for one in rounds),
        min(one.memory for one in rounds), rounds[0].scans,
    )  # fmt: skip


def _peer(one: Cost, size: int, factor: float) -> str:
    return f"{one.memory} KiB; as measured {one.measured / size * factor:.4g}"


def _line(what: str, sizes: Sequence[int], costs: Sequence[float]) -> dict[str, Figure]:
    return {f"growth_{what}": at_most(bend(sizes, costs), "off a straight line", _OFF)}


def _alone(what: str, size: int) -> Cost:
    """One of the functions below in a process of its own."""
    done = subprocess.run(
        [sys.executable, "-m", __name__, what, str(size)], stdout=subprocess.PIPE, check=True,
        env={**os.environ, "PYTHONPATH": os.fspath(_SUPPORT)},
    )  # fmt: skip
    measured, seconds, memory, scans = done.stdout.split()
    return Cost(float(measured), float(seconds), int(memory), int(scans))


def _trace(folder: Path, seconds: int) -> tuple[pace.Cost, int]:
    """A run with a trace file: its CPU time, and its scans."""
    with demo_cell("builtin", trace=folder / "trace.jsonl") as cell:
        used = pace.paced_throughout(lambda: cell.run(seconds * 1_000_000))
    return used, seconds * 1_000_000 // _SCAN_US


def _capture(folder: Path, seconds: int) -> tuple[pace.Cost, int]:
    """`rcx judge` of a capture with one command after the other: CPU time, packets."""
    file = folder / "capture.pcap"
    words = [sys.executable, __file__, "write", str(seconds), os.fspath(file)]
    subprocess.run(words, check=True)  # apart, for it holds all packets at once
    used = pace.paced_throughout(lambda: _rcx(["judge", os.fspath(file), "--quiet"]))
    return used, 2 * 100 * seconds


def _write(seconds: int, file: Path) -> None:
    import captures

    story = captures.Story()
    story.open(0)
    for number in range(seconds * 100):
        code, status = (0x0517, 0x0200) if number % 4 in (1, 2) else (0, 0)
        si = captures.area({0: code}, dedicated=0x0041)
        so = captures.area({0: status if number % 4 == 2 else 0}, dedicated=0x0003)
        story.both(10_000 * (number + 1), si, so)
    captures.pcap(file, story.frames())


def _seeds(folder: Path, seeds: int) -> tuple[pace.Cost, int]:
    """`rcx campaign` of the good cell of tests/data/planted: CPU time, scans."""
    cell = PLANTED / "cell"
    command = next(
        line.split()[1:]
        for line in (cell / "README.md").read_text(encoding="utf-8").splitlines()
        if line.startswith("rcx campaign ")
    )
    command[command.index("--seeds") + 1] = str(seeds)
    os.chdir(cell)
    command += ["--workers=0", "--engine=builtin", f"--out={folder / 'out'}"]
    told: list[str] = []
    used = pace.paced_throughout(lambda: told.append(_rcx(command)))
    found = re.search(r"([\d,]+) scans", told[0])
    return used, int(found[1].replace(",", "")) if found else 0


def _rcx(words: Sequence[str]) -> str:
    """What a command prints."""
    told = io.StringIO()
    with contextlib.redirect_stdout(told), contextlib.redirect_stderr(io.StringIO()):
        rcx(list(words))
    return told.getvalue()


def _main(what: str, size: int) -> None:
    """One of these in this process: its CPU time [s], its memory [KiB] and its scans or packets."""
    kinds = {"trace": _trace, "capture": _capture, "seeds": _seeds}
    with tempfile.TemporaryDirectory() as folder:
        used, made = kinds[what](Path(folder), size)
    print(used.measured, used.quiet, peak_memory(), made)


if __name__ == "__main__":
    if sys.argv[1] == "write":
        _write(int(sys.argv[2]), Path(sys.argv[3]))
    else:
        _main(sys.argv[1], int(sys.argv[2]))
