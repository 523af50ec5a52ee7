"""Cyclic I/O in real time: packets, gaps and CPU, alone and under a flood of explicit messages.

Each controller is an adapter and a scanner on loopback addresses of their own, each in processes
of its own. Beside the gaps stand those of a bare timer that runs at the same time, because
machines are shared and noisy.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple

from rcx_harness.bench.figure import Figure, Options, at_least, at_most, percentile, shown
from rcx_harness.bench.processes import cpu_of_children, running
from rcx_harness.enip.adapter import Adapter
from rcx_harness.enip.client import Client
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.scanner import Scanner
from rcx_harness.units import format_us

__all__ = ["Run", "figures", "flood", "measure", "timer"]

_SIZE = 48
_MODULE = "rcx_harness.enip.cyclic_process"
#: How often both sides get new data [s].
_FRESH_S = 0.005
#: Longest time-out: a stall of a busy machine is to be counted, not to end the connection.
_PATIENT = 5
_CONTROLLERS = (1, 4, 16)
#: The interval at which the manual's users run several controllers, and the promise is made.
_PROMISED_US = 2_000


@dataclass(frozen=True)
class Run:
    """One run of all its controllers.

    Attributes:
        rpi_us: Packet interval [us].
        controllers: How many at once.
        flooded: Beside an explicit flood of each.
        seconds: How long.
        packets: That came, both ways, of all controllers.
        nominal: That should have come.
        missing: By their sequence numbers, both ways.
        gap_median_us: Median of the gaps between packets to the scanner; of several, the median.
        gap_p99_us: 99 % of the gaps are not longer; the worst controller's.
        timer_p99_us: The same of the bare timer.
        cpu_us: CPU time for each packet sent and received, of all processes of the cyclic part.
    """

    rpi_us: int
    controllers: int
    flooded: bool
    seconds: float
    packets: int
    nominal: float
    missing: int
    gap_median_us: int
    gap_p99_us: int
    timer_p99_us: int
    cpu_us: float

    @property
    def name(self) -> str:
        """`cyclic_2ms_x4_flood`."""
        interval = format_us(self.rpi_us).replace(" ", "")
        many = f"_x{self.controllers}" if self.controllers > 1 else ""
        return f"cyclic_{interval}{many}{'_flood' if self.flooded else ''}"


def measure(options: Options) -> dict[str, Figure]:
    """All intervals alone and under flood, and the promised one with more controllers."""
    seconds = 1.0 if options.quick else options.seconds
    found: dict[str, Figure] = {}
    for rpi_us in options.rpi_us:
        quiet = run(rpi_us, 1, False, seconds)
        found |= figures(quiet, None)
        found |= figures(run(rpi_us, 1, True, seconds), quiet)
    for controllers in _CONTROLLERS[1 : 2 if options.quick else None]:
        quiet = run(_PROMISED_US, controllers, False, seconds)
        found |= figures(quiet, None)
        found |= figures(run(_PROMISED_US, controllers, True, seconds), quiet)
    return found


def run(rpi_us: int, controllers: int, flooded: bool, seconds: float) -> Run:
    """Hold the connections, and count.

    Raises:
        RcxError: an adapter did not start, or a connection was refused.
    """
    with ExitStack() as held:
        pairs = [_pair(held, number, rpi_us) for number in range(controllers)]
        if flooded:
            for adapter, _ in pairs:
                host, port = adapter.address
                held.enter_context(running(__name__, ["flood", host, str(port)]))
        arguments = ["timer", str(rpi_us), str(seconds)]
        bare = held.enter_context(running(__name__, arguments))
        cpu = time.monotonic(), cpu_of_children(_MODULE)
        before, start = _counts(pairs), time.monotonic()
        count = 0
        while (passed := time.monotonic() - start) < seconds:
            count += 1
            image = count.to_bytes(_SIZE, "little")
            for adapter, scanner in pairs:
                adapter.write_to_master(image)
                scanner.write(image)
            time.sleep(_FRESH_S)
        after = _counts(pairs)
        # What the processes use is read before and after the packets: it takes its time.
        used = (cpu_of_children(_MODULE) - cpu[1]) / (time.monotonic() - cpu[0]) * passed
        seen = [scanner.statistics() for _, scanner in pairs]
        gaps = json.loads(bare.communicate()[0] or "[]")
    ends = list(zip(before, after, strict=True))
    # Packets of each end in its own time, brought to the time of the run.
    rate = sum((b.received - a.received) / (b.time_s - a.time_s) for a, b in ends)
    packets = round(rate * passed)
    return Run(
        rpi_us, controllers, flooded, passed, packets,
        nominal=2 * controllers * passed * 1e6 / rpi_us,
        missing=sum(b.missing - a.missing for a, b in ends),
        gap_median_us=round(median(one.gap_median_us for one in seen)),
        gap_p99_us=max(one.gap_p99_us for one in seen),
        timer_p99_us=percentile(gaps, 0.99),
        cpu_us=used * 1e6 / packets if packets else 0.0,
    )  # fmt: skip


def figures(run: Run, quiet: Run | None) -> dict[str, Figure]:
    """What a run says, by name; `quiet` is the same without the flood."""
    rate = run.packets / run.nominal
    beside = f"bare timer: p99 {run.timer_p99_us} us"
    promised = run.rpi_us >= _PROMISED_US and run.controllers == 1
    found = {
        f"{run.name}_packets": shown(round(run.packets / run.seconds), "packets/s"),
        f"{run.name}_missing": shown(run.missing, "packets"),
        f"{run.name}_rate": shown(rate, "of nominal"),
        f"{run.name}_gap_median": shown(run.gap_median_us, "us"),
        f"{run.name}_gap_p99": shown(run.gap_p99_us, "us", beside),
        f"{run.name}_cpu": shown(run.cpu_us, "us/packet", "adapter and scanner"),
    }
    if promised and quiet is None:
        found[f"{run.name}_missing"] = at_most(run.missing, "packets", 0)
        found[f"{run.name}_rate"] = at_least(rate, "of nominal", 0.98)
    elif promised and quiet is not None:
        share = rate * quiet.nominal / quiet.packets if quiet.packets else 0.0
        found[f"{run.name}_rate"] = at_least(share, "of the quiet run", 0.9)
    return found


def _pair(held: ExitStack, number: int, rpi_us: int) -> tuple[Adapter, Scanner]:
    """A controller's adapter and its master, connected."""
    device, master = f"127.0.77.{number + 1}", f"127.0.78.{number + 1}"
    options = AdapterOptions(rpi_min_us=1000)
    adapter = held.enter_context(Adapter(_SIZE, host=device, cyclic=2222, options=options))
    port = adapter.address[1]
    scanner = held.enter_context(
        Scanner(device, _SIZE, rpi_us, multiplier=_PATIENT, address=master, port=port)
    )
    scanner.write(bytes(_SIZE))
    scanner.open()
    return adapter, scanner


class _Count(NamedTuple):
    """Packets that one end has received and missed so far, and when it was asked [s]."""

    received: int
    missing: int
    time_s: float


def _counts(pairs: Sequence[tuple[Adapter, Scanner]]) -> list[_Count]:
    """Of each end of all connections; with many of them to ask takes its time."""
    counts = []
    for adapter, scanner in pairs:
        device = adapter.shared.status()
        counts.append(_Count(device.received, device.missing, time.monotonic()))
        master = scanner.statistics()
        counts.append(_Count(master.received, master.missing, time.monotonic()))
    return counts


def timer(interval_us: int, seconds: float) -> list[int]:
    """The gaps of a timer that does nothing else [us]."""
    interval, end = interval_us / 1e6, time.monotonic() + seconds
    gaps: list[int] = []
    due = before = time.monotonic()
    while due < end:
        due += interval
        time.sleep(max(0.0, due - time.monotonic()))
        now = time.monotonic()
        gaps.append(round((now - before) * 1e6))
        before = now
    return gaps


def flood(host: str, port: int) -> None:
    """Ask for assembly 100 without a pause, until ended."""
    with Client(host, port) as client:
        while True:
            client.get_assembly(100)


if __name__ == "__main__":
    if sys.argv[1] == "timer":
        print(json.dumps(timer(int(sys.argv[2]), float(sys.argv[3]))))
    else:
        flood(sys.argv[2], int(sys.argv[3]))
