"""The recording of one controller: its inputs and outputs with their times."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.judge.advice import advice
from rcx_harness.look.judge.capture import Capture, host_text
from rcx_harness.look.judge.judge import is_capture
from rcx_harness.look.judge.network import Network, Sample
from rcx_harness.spec.wire import AREA_SIZES, CYCLE_US, READY
from rcx_harness.trace import Cycle, Scan, read_trace
from rcx_harness.watch.wire import word
from structured_text.errors import InputError
from structured_text.output.limits import MOST_REPLAYED_US

__all__ = ["Recording", "load", "of_cycles"]

_HOUR_US = 3_600_000_000
Progress = Callable[[float], None]


@dataclass(frozen=True)
class Recording:
    """One controller's part of a recording; all times in microseconds from its beginning.

    Attributes:
        inputs: Changes of the area to the controller with their times; None: no connection.
        outputs: Changes of the area from the controller, with their times.
        times: Times of the controller's cycles. Empty if the recording does not have them.
        tolerance_us: Answers whose times differ by at most this much count as equal.
        from_power_on: Whether the recording begins at the power-on of the controller.
        trouble: Error about the damage of the file, at which the recording ends. None if the file
            is undamaged.
        missing: Number of packets that were lost or captured only in part.
    """

    size: int
    inputs: Sequence[tuple[int, bytes | None]]
    outputs: Sequence[tuple[int, bytes]]
    times: Sequence[int]
    end_us: int
    tolerance_us: int
    from_power_on: bool
    trouble: InputError | None = None
    missing: int = 0

    @property
    def begin_us(self) -> int:
        """Return the start of the comparison: the first time at which no command runs."""
        if self.from_power_on:
            return min(self.inputs[0][0], self.outputs[0][0])
        si: bytes | None = None
        so = b""
        merged: list[tuple[int, bytes | None, bytes]] = [(t, one, b"") for t, one in self.inputs]
        merged += [(t, None, one) for t, one in self.outputs]
        for t_us, to_robot, to_master in sorted(merged, key=lambda one: one[0]):
            si, so = to_robot or si, to_master or so
            if si is not None and so and word(si, 0) == READY == word(so, 0):
                return t_us
        raise InputError(
            "the recording has no moment without a remote command",
            hint="record longer, or from before the PLC connects",
        )

    def cycles(self) -> Sequence[int]:
        """Return the times of the cycles from `begin_us` on: as recorded, or every 5 ms."""
        begin_us = self.begin_us
        if self.times:
            return [t_us for t_us in self.times if t_us >= begin_us]
        return range(begin_us, self.end_us + 1, CYCLE_US)


def load(
    path: Path,
    hosts: Collection[bytes] = (),
    sizes: Collection[int] = AREA_SIZES,
    port: int = PORT,
    progress: Progress = lambda share: None,
) -> Recording:
    """Read the recording of one controller.

    The file is a capture, or a trace of `rcx serve`, `run`, `scan`, `judge` or `probe`. If a
    capture has several controllers, `hosts` selects one by its address. `sizes` are the allowed
    sizes of its areas, and `port` is the TCP port of explicit messages. `progress` is called with
    the part of the file that has been read.

    Raises:
        InputError: the file cannot be read, or it does not contain exactly one controller.
    """
    if is_capture(path):
        return _of_capture(path, hosts, sizes, port, progress)
    header, records = read_trace(path)
    cycles: list[Cycle] = []
    samples: list[Sample] = []
    for record in records:
        if isinstance(record, Cycle) and record.controller == 1:
            cycles.append(record)
        elif isinstance(record, Scan) and record.controller == 1:
            connected = bool(record.si) and any(record.so)
            samples.append(
                Sample(record.t_us, record.scan, 1, record.so, record.si, connected=connected)
            )
    if cycles:
        every = "only" not in header
        found = [(one.t_us, one.rcx_si or None, one.rcx_so) for one in cycles]
        return of_cycles(found, every=every, from_power_on=bool(header.get("power_on", True)))
    return _of_samples(path, samples, 2 * CYCLE_US)


def of_cycles(
    cycles: Sequence[tuple[int, bytes | None, bytes]], *, every: bool, from_power_on: bool = True
) -> Recording:
    """Return an exact recording of the controller's own cycles.

    `cycles` has for each cycle the time, the input area (None without a connection) and the output
    area. `every` is False if only cycles with changes are recorded. With `from_power_on` the first
    cycle is the first cycle after power-on.
    """
    if not cycles:
        raise InputError("the recording contains no cycle of a controller")
    size = len(cycles[0][2])
    for _, si, so in cycles:
        if len(so) != size or size not in AREA_SIZES or (si is not None and len(si) != size):
            raise InputError(f"areas of {len(so)} bytes do not belong to a controller")
    return Recording(
        size=size,
        inputs=_changes([(t_us, si) for t_us, si, _ in cycles]),
        outputs=_changes([(t_us, so) for t_us, _, so in cycles]),
        times=[t_us for t_us, _, _ in cycles] if every else (),
        end_us=cycles[-1][0],
        tolerance_us=0,
        from_power_on=from_power_on,
    )


def _changes(values: Sequence[tuple[int, bytes | None]]) -> list[tuple[int, bytes]]:
    """Return only the entries that differ from their predecessor."""
    kept: list[tuple[int, bytes | None]] = []
    for t_us, value in values:
        if not kept or value != kept[-1][1]:
            kept.append((t_us, value))
    return kept  # type: ignore[return-value]  # of the outputs none is None


def _of_samples(path: Path, samples: Sequence[Sample], tolerance_us: int) -> Recording:
    """Return a recording from packets. It does not contain the times of the controller's cycles."""
    driven = [one for one in samples if one.so and one.si]
    if not driven:
        text = "the recording contains neither the PLC's nor the controller's data"
        hint = "record the traffic of a PLC with rcx record: rcx scan only reads"
        raise InputError(text, file=path, hint=hint)
    size = len(driven[0].so)
    lasts_us = samples[-1].t_us - driven[0].t_us
    if lasts_us > MOST_REPLAYED_US:
        raise InputError(
            f"lasts {lasts_us // _HOUR_US:,} h, and at most {MOST_REPLAYED_US // _HOUR_US} h are "
            "compared",
            file=path,
            hint="cut out the part of interest, or check whether the clock was set meanwhile",
        )
    begin = samples.index(driven[0])
    inputs = [(one.t_us, one.si if one.connected else None) for one in samples[begin:]]
    return Recording(
        size=size,
        inputs=_changes(inputs),
        outputs=_changes([(one.t_us, one.so) for one in samples[begin:] if one.so]),
        times=(),
        end_us=samples[-1].t_us,
        tolerance_us=tolerance_us,
        from_power_on=False,
    )


def _of_capture(
    path: Path, hosts: Collection[bytes], sizes: Collection[int], port: int, progress: Progress
) -> Recording:
    capture, network = Capture(path), Network(hosts, sizes, port)
    samples: list[Sample] = []
    length = max(1, path.stat().st_size)
    for packet in capture:
        if not capture.packets % 20_000:
            progress(min(1.0, capture.read_bytes / length))
        samples += [one for one in network.take(packet) if isinstance(one, Sample)]
    found = sorted({one.controller for one in samples})
    if not found and (trouble := capture.trouble("read")):
        raise trouble
    if not found:
        hint = advice(network, hosts, sizes)
        raise InputError("contains no connection of a controller", file=path, hint=hint)
    if len(found) > 1:
        names = ", ".join(host_text(host) for host in network.robots)
        hint = f"name one with --controller: {names}"
        raise InputError(f"contains {len(found)} controllers", file=path, hint=hint)
    robot = next(one for one in network.robots.values() if one.number == found[0])
    intervals = [one.to_master_us for one in robot.connections]
    if not any(intervals):  # without a Forward Open the mean interval is used
        heard = [way for one in robot.connections if (way := one.to_master).packets > 1]
        intervals = [(way.last_us - (way.first_us or 0)) // (way.packets - 1) for way in heard]
    slowest_us = max(intervals, default=0)
    recording = _of_samples(path, samples, slowest_us + 2 * CYCLE_US)
    ways = [way for one in robot.connections for way in (one.to_robot, one.to_master)]
    missing = sum(way.lost + way.cut for way in ways)
    return replace(recording, trouble=capture.trouble("compared"), missing=missing)
