"""Measure cyclic I/O in real time: packets, gaps and CPU time, with and without other traffic.

Each controller is an adapter and a scanner, each with its own loopback address and process.

Machines are shared and noisy. The gaps are therefore compared with the gaps of a bare timer that
runs at the same time. The CPU time is compared with the CPU time of a bare loop: two processes with
the same priority that only wait, receive and send. All processes of a run start before the first
packet. Otherwise the packets of many controllers, sent with real-time priority, would leave a new
process no time to start.
"""

from __future__ import annotations

import json
import select
import socket
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from statistics import median
from typing import NamedTuple

from rich.console import Console

from rcx_harness.enip.child import be_punctual
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.client import Client
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_tools.bench.figure import (
    OUT_OF_REACH,
    Figure,
    Options,
    at_least,
    at_most,
    percentile,
    shown,
)
from rcx_tools.bench.processes import (
    begin,
    cpu_of_children,
    first_line,
    in_ordinary_time,
    running,
)
from structured_text.output.units import format_us

__all__ = [
    "Case",
    "Run",
    "bare",
    "cases",
    "figures",
    "flood",
    "loop",
    "measure",
    "run",
    "timer",
]

_SIZE = 48
#: Size of a packet with its header [byte].
_PACKET = 72
_MODULE = "rcx_harness.enip.cyclic.process"
#: Period of new data on both sides [s].
_FRESH_S = 0.005
#: The longest time-out multiplier. A stall of a busy machine is then counted, but it does not end
#: the connection.
_PATIENT = 5
#: The shortest packet interval that is promised for one controller, and the shortest possible
#: packet interval.
_PROMISED_US, _SHORTEST_US = 2_000, 1_000
#: Target: half of the CPU time per packet that was measured before both ends were rewritten [us].
_CPU_US = 65
#: Number of controllers and interval [us] of the run with many controllers. `quick` skips this run.
_MANY = (16, 10_000)


class Case(NamedTuple):
    """One planned run.

    Attributes:
        rpi_us: Packet interval [us].
        controllers: Number of controllers.
        flooded: Each controller also receives a flood of explicit messages.
        ordinary: The processes run without real-time priority.
    """

    rpi_us: int
    controllers: int
    flooded: bool
    ordinary: bool = False

    @property
    def name(self) -> str:
        """Return the name of the measurement, such as `cyclic_2ms_x4_ordinary_flood`."""
        interval = format_us(self.rpi_us).replace(" ", "")
        many = f"_x{self.controllers}" if self.controllers > 1 else ""
        how = "_ordinary" if self.ordinary else ""
        return f"cyclic_{interval}{many}{how}{'_flood' if self.flooded else ''}"

    @property
    def rate(self) -> float:
        """Return the packets per second, both ways, of all controllers."""
        return 2e6 * self.controllers / self.rpi_us

    @property
    def is_compared(self) -> bool:
        """Return whether bare loops run just before and after this run, to compare the CPU time."""
        return (self.rpi_us, self.controllers, self.flooded) == (_PROMISED_US, 1, False)


@dataclass(frozen=True)
class Run:
    """The results of one run.

    Attributes:
        case: The planned run.
        seconds: Duration of the run.
        packets: Number of packets that all controllers and scanners received.
        nominal: Number of packets that were expected.
        missing: Number of missing sequence numbers in both directions.
        gap_median_us: Median gap between packets to the scanner. For several controllers it is the
            median of all medians.
        gap_p99_us: 99th percentile of the gaps for the worst controller.
        timer_p99_us: 99th percentile of the gaps of a bare timer.
        timer_missing: Intervals in which the bare timer did not wake.
        cpu_us: CPU time of all processes of cyclic I/O, divided by the packets sent and received.
    """

    case: Case
    seconds: float
    packets: int
    nominal: float
    missing: int
    gap_median_us: int
    gap_p99_us: int
    timer_p99_us: int
    timer_missing: int
    cpu_us: float


def measure(options: Options) -> dict[str, Figure]:
    """Measure all intervals alone and under flood, then many controllers.

    Print a line for each run.
    """
    seconds = 1.0 if options.quick else options.seconds
    console = Console(highlight=False)
    planned = cases(options)
    console.print(f"  {len(planned)} runs of {seconds:g} s")
    found: dict[str, Figure] = {}
    quiet: dict[Case, Run] = {}
    for number, case in enumerate(planned, start=1):
        told = ", without real-time priority" if case.ordinary else ""
        console.print(f"  {number} of {len(planned)}: {case.name}, {case.rate:g} packets/s{told}")
        loops_us = [bare(case.rpi_us, seconds / 2)] if case.is_compared else []
        done = run(case, seconds)
        if case.is_compared:
            loops_us.append(bare(case.rpi_us, seconds / 2))
        if case.flooded:
            found |= figures(done, quiet[case._replace(flooded=False)])
        else:
            quiet[case] = done
            found |= figures(done, None, loops_us)
    return found


def cases(options: Options) -> list[Case]:
    """Return the planned runs.

    Each packet interval runs alone and then under a flood of messages. The shortest intervals also
    run without real-time priority. Unless `quick` is set, many controllers follow.
    """
    alone = [Case(rpi_us, 1, flooded=False) for rpi_us in options.rpi_us]
    ordinary = [case._replace(ordinary=True) for case in alone if case.rpi_us <= _PROMISED_US]
    many = [] if options.quick else [Case(_MANY[1], _MANY[0], flooded=False)]
    return [*_flooded(alone), *ordinary, *_flooded(many)]


def _flooded(quiet: Sequence[Case]) -> list[Case]:
    """Return each run, followed by the same run under a flood."""
    return [case._replace(flooded=flooded) for case in quiet for flooded in (False, True)]


def run(case: Case, seconds: float) -> Run:
    """Hold the connections open for a time, and count the packets.

    Args:
        case: The planned run.
        seconds: The duration of the run.

    Raises:
        RcxError: an adapter did not start, or a connection was refused.
    """
    with ExitStack() as held:
        pairs = [_pair(held, number, case.rpi_us) for number in range(case.controllers)]
        addresses = [adapter.address for adapter, _ in pairs] if case.flooded else []
        loads = [
            held.enter_context(running(__name__, ["flood", host, str(port)]))
            for host, port in addresses
        ]
        bare = held.enter_context(running(__name__, ["timer", str(case.rpi_us), str(seconds)]))
        for process in (*loads, bare):
            first_line(process)
        if case.ordinary:
            in_ordinary_time(_MODULE)
        for _, scanner in pairs:
            scanner.open()
        for process in (*loads, bare):
            begin(process)
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
        # The CPU time is read before and after the packets, because reading it takes time.
        used = (cpu_of_children(_MODULE) - cpu[1]) / (time.monotonic() - cpu[0]) * passed
        seen = [scanner.statistics() for _, scanner in pairs]
        gaps = json.loads(bare.communicate()[0] or "[]")
    ends = list(zip(before, after, strict=True))
    # The rate of each end is measured over the time of this end, and scaled to the time of the run.
    rate = sum((b.received - a.received) / (b.time_s - a.time_s) for a, b in ends)
    packets = round(rate * passed)
    return Run(
        case, passed, packets,
        nominal=case.rate * passed,
        missing=sum(b.missing - a.missing for a, b in ends),
        gap_median_us=round(median(one.gap_median_us for one in seen)),
        gap_p99_us=max(one.gap_p99_us for one in seen),
        timer_p99_us=percentile(gaps, 0.99),
        timer_missing=sum(max(0, gap // case.rpi_us - 1) for gap in gaps),
        cpu_us=used * 1e6 / packets if packets else 0.0,
    )  # fmt: skip


def figures(run: Run, quiet: Run | None, loops_us: Sequence[float] = ()) -> dict[str, Figure]:
    """Return the figures of a run by name.

    Args:
        run: The measured run.
        quiet: The same run without the flood.
        loops_us: CPU time per packet of the bare loops just before and just after the run.
    """
    rate = run.packets / run.nominal
    beside = f"bare timer: p99 {run.timer_p99_us} us"
    case, name = run.case, run.case.name
    found = {
        f"{name}_packets": shown(round(run.packets / run.seconds), "packets/s"),
        f"{name}_missing": shown(run.missing, "packets"),
        f"{name}_rate": shown(rate, "of nominal"),
        f"{name}_gap_median": shown(run.gap_median_us, "us"),
        f"{name}_gap_p99": shown(run.gap_p99_us, "us", beside),
        f"{name}_cpu": shown(run.cpu_us, "us/packet", "adapter and scanner"),
    }
    if case.controllers == 1 and case.rpi_us == _SHORTEST_US and quiet is None:
        found[f"{name}_rate"] = at_least(rate, "of nominal", 0.95 if case.ordinary else 0.98)
    if (case.controllers, case.rpi_us) == _MANY and quiet is None:
        found[f"{name}_missing"] = at_most(run.missing, "packets", 0)
    if case.rpi_us < _PROMISED_US or case.controllers > 1:
        return found
    if loops_us:
        peer = f"bare loops {' and '.join(f'{one:.3g}' for one in loops_us)} us" + OUT_OF_REACH
        found[f"{name}_cpu"] = at_most(run.cpu_us, "us/packet", _CPU_US, peer)
    if case.ordinary:
        p99 = run.gap_p99_us / run.timer_p99_us if run.timer_p99_us else 0.0
        timers = f"bare timer: {run.timer_missing} intervals"
        found[f"{name}_missing"] = Figure(
            run.missing, "packets", "<= timer", timers, run.missing <= run.timer_missing
        )
        found[f"{name}_gap_p99"] = at_most(p99, "of the timer's", 1.1, beside)
    elif quiet is None:
        found[f"{name}_missing"] = at_most(run.missing, "packets", 0)
        found[f"{name}_rate"] = at_least(rate, "of nominal", 0.98)
    else:
        share = rate * quiet.nominal / quiet.packets if quiet.packets else 0.0
        found[f"{name}_rate"] = at_least(share, "of the quiet run", 0.9)
    return found


def bare(rpi_us: int, seconds: float) -> float:
    """Return the CPU time per packet of two processes that only exchange packets [us]."""
    ends = (("127.0.79.1", "127.0.79.2"), ("127.0.79.2", "127.0.79.1"))
    with ExitStack() as held:
        loops = [
            held.enter_context(running(__name__, ["loop", *end, str(rpi_us), str(seconds)]))
            for end in ends
        ]
        for process in loops:
            first_line(process)
        for process in loops:
            begin(process)
        told = [json.loads(process.communicate()[0] or "[0, 0]") for process in loops]
    packets = sum(received for received, _ in told)
    return sum(cpu_us for _, cpu_us in told) / packets if packets else 0.0


def _pair(held: ExitStack, number: int, rpi_us: int) -> tuple[Adapter, Scanner]:
    """Start a controller's adapter and its master, without a connection."""
    device, master = f"127.0.77.{number + 1}", f"127.0.78.{number + 1}"
    options = AdapterOptions(rpi_min_us=1000)
    adapter = held.enter_context(Adapter(_SIZE, host=device, cyclic=2222, options=options))
    port = adapter.address[1]
    scanner = held.enter_context(
        Scanner(device, _SIZE, rpi_us, multiplier=_PATIENT, address=master, port=port)
    )
    scanner.write(bytes(_SIZE))
    return adapter, scanner


class _Count(NamedTuple):
    """Number of packets that one end has received and missed, and the time of this reading [s]."""

    received: int
    missing: int
    time_s: float


def _counts(pairs: Sequence[tuple[Adapter, Scanner]]) -> list[_Count]:
    """Read the packet counts of both ends of all connections. This takes time if there are many."""
    counts = []
    for adapter, scanner in pairs:
        device = adapter.shared.status()
        counts.append(_Count(device.received, device.missing, time.monotonic()))
        master = scanner.statistics()
        counts.append(_Count(master.received, master.missing, time.monotonic()))
    return counts


def timer(interval_us: int, seconds: float) -> list[int]:
    """Return the gaps between the wake-ups of a timer [us]. The process does nothing else."""
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


def loop(own: str, other: str, rpi_us: int, seconds: float) -> tuple[int, float]:
    """Exchange packets for a time. Return the number of received packets, and the CPU time [us]."""
    packet, interval = bytes(_PACKET), rpi_us / 1e6
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind((own, 2222))
        line.setblocking(False)
        be_punctual("first")
        received, before = 0, time.process_time()
        due = time.monotonic()
        end = due + seconds
        while (now := time.monotonic()) < end:
            if now >= due:
                line.sendto(packet, (other, 2222))
                due += interval
            if select.select((line,), (), (), max(0.0, due - time.monotonic()))[0]:
                line.recv(_PACKET)
                received += 1
        return received, (time.process_time() - before) * 1e6


def flood(host: str, port: int) -> None:
    """Read assembly 100 in an endless loop, until the process is ended from outside."""
    with Client(host, port) as client:
        while True:
            client.get_assembly(100)


if __name__ == "__main__":
    print("ready", flush=True)
    sys.stdin.readline()
    if sys.argv[1] == "timer":
        print(json.dumps(timer(int(sys.argv[2]), float(sys.argv[3]))))
    elif sys.argv[1] == "loop":
        print(json.dumps(loop(sys.argv[2], sys.argv[3], int(sys.argv[4]), float(sys.argv[5]))))
    else:
        flood(sys.argv[2], int(sys.argv[3]))
