"""Measure in real time what tests must not: `make bench`, or `python -m rcx_harness.bench`.

Cyclic I/O between the adapter and a scanner on loopback, each in processes of its own: packets
missing, rate, and the gaps between packets beside those of a bare timer that runs at the same
time, because machines are shared and noisy. It prints a table and writes out/bench.json; nothing
depends on its figures.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from rcx_harness.enip.adapter import Adapter
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.scanner import Scanner
from rcx_harness.units import format_us, parse_us

__all__ = ["Figure", "Measured", "figures", "main", "measure", "percentile"]

OUTPUT = Path("out/bench.json")

#: The adapter's and the scanner's loopback address.
_DEVICE, _MASTER = "127.0.77.1", "127.0.77.2"
_SIZE = 48
#: How often both sides get new data [s].
_FRESH_S = 0.005

_BARE_TIMER = """
import json, sys, time
interval, end = float(sys.argv[1]), time.monotonic() + float(sys.argv[2])
gaps, due, before = [], time.monotonic(), None
while due < end:
    due += interval
    time.sleep(max(0.0, due - time.monotonic()))
    now = time.monotonic()
    if before is not None:
        gaps.append(round((now - before) * 1e6))
    before = now
print(json.dumps(gaps))
"""


@dataclass(frozen=True)
class Figure:
    """One row of out/bench.json; `peer` is what it was measured beside."""

    value: float
    unit: str
    target: str
    peer: str
    met: bool


@dataclass(frozen=True)
class Measured:
    """One run: packets that came and that are missing, gaps and those of the bare timer [us]."""

    rpi_us: int
    seconds: float
    received: int
    missing: int
    gap_median_us: int
    gap_p99_us: int
    timer_p99_us: int


def percentile(values: Sequence[int], share: float) -> int:
    """The value that `share` of all do not exceed; 0 without any."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(len(ordered) * share))] if ordered else 0


def measure(rpi_us: int, seconds: float) -> Measured:
    """Hold a cyclic connection and count.

    Raises:
        RcxError: the adapter did not start, or the connection was refused or lost.
    """
    timer = subprocess.Popen(
        [sys.executable, "-c", _BARE_TIMER, str(rpi_us / 1e6), str(seconds)],
        stdout=subprocess.PIPE,
        text=True,
    )
    options = AdapterOptions(rpi_min_us=1000)
    with (
        Adapter(_SIZE, host=_DEVICE, cyclic=2222, options=options) as adapter,
        Scanner(
            _DEVICE, _SIZE, rpi_us, multiplier=5, address=_MASTER, port=adapter.address[1]
        ) as scanner,
    ):
        scanner.write(bytes(_SIZE))
        scanner.open()
        start = time.monotonic()
        count = 0
        while (passed := time.monotonic() - start) < seconds:
            count += 1
            image = count.to_bytes(_SIZE, "little")
            adapter.write_to_master(image)
            scanner.write(image)
            time.sleep(_FRESH_S)
        seen = scanner.statistics()
    gaps = json.loads(timer.communicate()[0])
    return Measured(
        rpi_us, passed, seen.received, seen.missing, seen.gap_median_us, seen.gap_p99_us,
        percentile(gaps, 0.99),
    )  # fmt: skip


def figures(run: Measured) -> dict[str, Figure]:
    """What a run says, by name."""
    name = f"cyclic_{format_us(run.rpi_us)}".replace(" ", "")
    rate = run.received / (run.seconds * 1e6 / run.rpi_us)
    jitter = run.gap_p99_us / run.timer_p99_us if run.timer_p99_us else 0.0
    timer = f"bare timer beside it: p99 {run.timer_p99_us} us"
    return {
        f"{name}_missing": Figure(run.missing, "packets", "0", "none", run.missing == 0),
        f"{name}_rate": Figure(round(rate, 4), "of nominal", ">= 0.98", "none", rate >= 0.98),
        f"{name}_gap_median": Figure(run.gap_median_us, "us", "none", "none", True),
        f"{name}_gap_p99": Figure(round(jitter, 3), "of timer", "<= 2", timer, jitter <= 2),
    }


def main(arguments: Sequence[str]) -> int:
    """Measure, print, write; 0 if all targets are met, else 1."""
    parser = argparse.ArgumentParser(prog="rcx_harness.bench", description=__doc__)
    parser.add_argument("--rpi", default="10ms", help="packet intervals, such as 10ms,2ms")
    parser.add_argument("--for", default="60s", dest="duration", help="length of each run")
    options = parser.parse_args(arguments)
    seconds = parse_us(options.duration) / 1e6
    console = Console()
    found: dict[str, Figure] = {}
    for text in options.rpi.split(","):
        console.print(f"cyclic I/O at {text} for {seconds:g} s ...")
        found |= figures(measure(parse_us(text), seconds))
    table = Table("figure", "value", "unit", "target", "peer", "met")
    for name, one in found.items():
        met = "yes" if one.met else "no"
        table.add_row(name, f"{one.value:g}", one.unit, one.target, one.peer, met)
    console.print(table)
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    OUTPUT.write_text(json.dumps({k: asdict(v) for k, v in found.items()}, indent=1) + "\n")
    console.print(f"written: {OUTPUT}")
    return 0 if all(one.met for one in found.values()) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
