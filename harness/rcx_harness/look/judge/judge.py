"""The judgement of a recording (`rcx judge`)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from rcx_harness.enip.originator.client import PORT
from rcx_harness.look.judge.advice import advice
from rcx_harness.look.judge.capture import ENDINGS, Capture
from rcx_harness.look.judge.follow import Follower
from rcx_harness.look.judge.network import Network, Note, Sample
from rcx_harness.robot import Violation
from rcx_harness.spec.wire import AREA_SIZES, DEDICATED_AT
from rcx_harness.trace import Cycle, Record, Scan, Trace, read_trace
from rcx_harness.trace.chart import MOST_INSTANTS, Timeline
from structured_text.errors import InputError
from structured_text.output.limits import CAPTURE
from structured_text.output.reading import beginning

__all__ = ["REPORT_EVERY", "JudgeOptions", "Judgement", "is_capture", "is_judged", "judge"]

_SHOWN = slice(DEDICATED_AT, DEDICATED_AT + 2)
_MOST_KEPT = 1_000
REPORT_EVERY = 20_000
# first bytes of capture files in the formats pcap and pcapng
_CAPTURES = ("0a0d0d0a", "a1b2c3d4", "d4c3b2a1", "a1b23c4d", "4d3cb2a1")
_TRACE, _PACKED = "7b", "1f8b"
#: `rcx` commands that write traces without the broken rules of PLC and controller.
_UNJUDGED = ("rcx scan", "rcx serve")


@dataclass(frozen=True)
class JudgeOptions:
    """The options of `rcx judge`.

    Attributes:
        hosts: Addresses of the controllers, four bytes each; empty: the targets of the Forward
            Opens.
        sizes: Allowed sizes of their areas.
        tolerance_us: Tolerance of the rule that two changes of dedicated inputs are 100 ms apart.
        from_us: Time at which events and chart begin.
        until_us: Time at which events and chart end; None: the end of the file.
        trace: File for a trace of all samples; None: no file.
    """

    file: Path
    hosts: Collection[bytes] = ()
    sizes: Collection[int] = AREA_SIZES
    port: int = PORT
    tolerance_us: int = 1_000
    from_us: int = 0
    until_us: int | None = None
    trace: Path | None = None


@dataclass
class Judgement:
    """The result of `rcx judge`.

    Attributes:
        followers: Results by the number of the controller.
        network: The connections; None for a trace.
        capture: The capture; None for a trace.
        header: First line of a trace.
        timeline: The changes for the chart.
        chart_end_us: Time at which the chart was full; None if the chart is complete.
        findings: Broken rules, at most the first thousand.
        count: Number of all broken rules.
        last_us: Time of the last packet or record.
    """

    file: Path
    followers: dict[int, Follower] = field(default_factory=dict)
    network: Network | None = None
    capture: Capture | None = None
    header: Mapping[str, Any] = field(default_factory=dict)
    timeline: Timeline = field(default_factory=Timeline)
    chart_end_us: int | None = None
    findings: list[Violation] = field(default_factory=list)
    count: int = 0
    last_us: int = 0


class _Judge:
    """The judgement of one recording. Each sample goes to the follower of its controller."""

    def __init__(
        self,
        options: JudgeOptions,
        tell: Callable[[str], None],
        at: str,
        header: Mapping[str, Any],
    ) -> None:
        self.result = Judgement(options.file, header=header)
        self.judges = True
        self._at = at
        self._options, self._tell = options, tell
        self._shown: dict[int, tuple[bytes, ...]] = {}
        self._instants = 0
        self._trace: Trace | None = None

    def take(self, sample: Sample) -> None:
        """Pass a sample to the follower of its controller, and record it."""
        self.result.last_us = sample.t_us
        follower = self.result.followers.get(sample.controller)
        if follower is None:
            follower = self.result.followers[sample.controller] = Follower(
                len(sample.so or sample.si),
                lambda t_us, text: self.tell(t_us, sample.controller, text),
                lambda one: self.report(sample.controller, one),
                self._at,
                self._options.tolerance_us,
            )
        follower.take(sample)
        if not sample.so:
            return
        if self._options.trace is not None:
            if self._trace is None:
                self._trace = Trace(self.result.header, self._options.trace, keep=0)
            at = (sample.t_us, sample.number, sample.so, sample.si)
            self._trace.add(Scan(*at, controller=sample.controller))
        self._draw(sample)

    def tell(self, t_us: int, controller: int, text: str) -> None:
        """Report one event of a controller as a line of text, if it is in the chosen time."""
        if self._wanted(t_us):
            who = f"{controller}: " if controller > 1 else ""
            self._tell(f"{t_us / 1e6:12.6f} s  {who}{text}")

    def report(self, controller: int, one: Violation) -> None:
        """Report a broken rule, if this recording is judged."""
        if not self.judges:
            return
        if controller > 1:
            one = Violation(one.t_us, one.rule, f"controller {controller}: {one.text}")
        self.add(one)
        self.tell(one.t_us, 1, f"** {one.text}")

    def add(self, one: Violation) -> None:
        """Count a broken rule. Add it to findings and chart while they are not full."""
        self.result.count += 1
        if len(self.result.findings) < _MOST_KEPT:
            self.result.findings.append(one)
        if self._trace is not None:
            self._trace.add(one)
        if self._wanted(one.t_us) and self.result.chart_end_us is None:
            self.result.timeline.take(one)

    def finish(self) -> Judgement:
        """End the recording, and return the judgement."""
        for follower in self.result.followers.values():
            follower.finish()
        return self.result

    def close(self) -> None:
        """Close the trace."""
        if self._trace is not None:
            self._trace.close()

    def _wanted(self, t_us: int) -> bool:
        end_us = self._options.until_us
        return self._options.from_us <= t_us and (end_us is None or t_us <= end_us)

    def _draw(self, sample: Sample) -> None:
        """Add a sample to the chart until the chart is full."""
        if not self._wanted(sample.t_us) or self.result.chart_end_us is not None:
            return
        si = sample.si or bytes(len(sample.so))  # no master sends, so all inputs count as OFF
        shown = (sample.so[:2], sample.so[_SHOWN], si[:2], si[_SHOWN])
        if shown == self._shown.get(sample.controller):
            return
        self._shown[sample.controller] = shown
        self._instants += 1
        if self._instants > MOST_INSTANTS:
            self.result.chart_end_us = sample.t_us
        else:
            at = (sample.t_us, sample.number, sample.so, si)
            self.result.timeline.take(Scan(*at, controller=sample.controller))


def judge(
    options: JudgeOptions,
    tell: Callable[[str], None],
    progress: Callable[[float], None] = lambda share: None,
) -> Judgement:
    """Read a recording and judge it.

    `tell` is called with each line of the report, and `progress` with the part of the file that has
    been read.
    """
    if is_capture(options.file):
        return _judge_capture(options, tell, progress)
    return _judge_trace(options, tell, progress)


def is_capture(file: Path) -> bool:
    """Return whether the file is a capture; otherwise it is a trace."""
    begin = _beginning(file)
    if begin in _CAPTURES or (not begin and file.suffix.lower() in ENDINGS):
        return True
    if not begin.startswith(_TRACE):
        hint = (
            "unpack it first"
            if begin.startswith(_PACKED)
            else "check that the start of the file is complete"
        )
        text = "is neither a capture (pcapng, pcap) nor a trace (jsonl)"
        raise InputError(text, file=file, hint=hint)
    return False


def is_judged(file: Path) -> bool:
    """Return whether a trace already contains the broken rules of PLC and controller."""
    begin = _beginning(file)
    if not begin:
        raise InputError("is empty", file=file, hint="record again")
    if not begin.startswith(_TRACE):
        return False
    header, records = read_trace(file)
    records.close()
    return header.get("by") not in _UNJUDGED


def _beginning(file: Path) -> str:
    """Return the first four bytes of a file in hexadecimal."""
    return beginning(file, CAPTURE, 4).hex()


def _judge_capture(
    options: JudgeOptions, tell: Callable[[str], None], progress: Callable[[float], None]
) -> Judgement:
    capture = Capture(options.file)
    network = Network(options.hosts, options.sizes, options.port)
    header = {"by": "rcx judge", "of": options.file.name, "only": "changes"}
    one = _Judge(options, tell, "packet", header)
    one.result.capture, one.result.network = capture, network
    length = max(1, options.file.stat().st_size)
    try:
        for packet in capture:
            if capture.packets % REPORT_EVERY == 0:
                progress(min(1.0, capture.read_bytes / length))
            for found in network.take(packet):
                if isinstance(found, Note):
                    one.tell(found.t_us, found.controller, found.text)
                else:
                    one.take(found)
        one.result.last_us = capture.last_us
        if not any(robot.connections for robot in network.robots.values()):
            hint = advice(network, options.hosts, options.sizes)
            raise InputError(_nothing(capture, network), file=options.file, hint=hint)
    finally:
        one.close()
    return one.finish()


def _nothing(capture: Capture, network: Network) -> str:
    if capture.damage and not capture.packets:
        return f"is cut off before its first packet ({capture.damage})"
    seen = f"{capture.packets} packets, {network.cyclic} of class 1"
    others = "".join(f", {count} {what}" for what, count in capture.others.most_common())
    return f"contains no connection of a controller: {seen}{others}"


def _judge_trace(
    options: JudgeOptions, tell: Callable[[str], None], progress: Callable[[float], None]
) -> Judgement:
    header, records = read_trace(options.file, progress)
    by_cycle = header.get("by") == "rcx serve"
    one = _Judge(options, tell, "cycle" if by_cycle else "scan", header)
    one.judges = header.get("by") in _UNJUDGED
    try:
        for record in records:
            _take_record(one, record, by_cycle=by_cycle)
        if not one.result.followers:
            raise InputError("contains no scan and no cycle", file=options.file)
    finally:
        one.close()
    return one.finish()


def _take_record(one: _Judge, record: Record, *, by_cycle: bool) -> None:
    """Pass a record of a trace to the judge."""
    if isinstance(record, Violation):
        one.add(record)
    elif isinstance(record, Cycle) == by_cycle:
        if isinstance(record, Cycle):
            number, so, si = record.cycle, record.rcx_so, record.rcx_si
        else:
            number, so, si = record.scan, record.so, record.si
        if not all(len(area) in (0, *AREA_SIZES) for area in (so, si)):
            text = f"areas of {len(so)} and {len(si)} bytes do not belong to a controller"
            raise InputError(text, file=one.result.file)
        connected = bool(si) and any(so)
        at = (record.t_us, number, record.controller)
        one.take(Sample(*at, so, si, connected, at_once=by_cycle))
