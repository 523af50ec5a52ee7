"""Replay of a trace on the real program with real times, checked by two monitors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rcx_harness.spec.wire import CYCLE_US, SIZE
from rcx_harness.trace import Scan, Trace, Violation
from rcx_harness.trace.chart import Timeline
from rcx_harness.trace.chart_svg import svg_chart
from rcx_harness.watch.wire import WireMonitor
from rcx_tools.evidence.explore.model import Choice, Model
from rcx_tools.evidence.explore.oracle import Oracle
from rcx_tools.evidence.explore.search import LIBRARY, compiled, quiet_choices
from structured_text.engines.base import Program
from structured_text.explore.search import Broken

__all__ = ["Replay", "replay"]

#: Number of scans in the quiet environment that the replay of a hang shows.
_SHOWN = 40


class Replay:
    """The result of a replay.

    Attributes:
        trace: Records of the replay. A broken rule is a finding.
        timeline: The same run as data for a chart.
        rules: Rules that the oracle found broken, in words.
        monitor: Findings of the wire monitor in the same scans. This monitor also checks all
            simulations.
    """

    def __init__(self, trace: Trace, timeline: Timeline) -> None:
        self.trace, self.timeline = trace, timeline
        self.rules: list[str] = []
        self.monitor: list[str] = []

    def chart(self, title: str) -> str:
        """Return the timing chart of the replay as SVG."""
        return svg_chart(self.timeline, title)


def replay(
    model: Model, broken: Broken, library: Sequence[Path] = LIBRARY, file: Path | None = None
) -> Replay:
    """Replay the shortest trace to a broken rule from the start.

    Args:
        model: Model in which the rule was broken.
        broken: The broken rule with its trace.
        library: Library in which the rule was broken.
        file: File to which the trace is written.
    """
    program = compiled(model, library)
    oracle = Oracle(model, program.holder("Main"))
    header = {"scan_us": model.tick_ms * 1000, "cycle_us": CYCLE_US, "size": SIZE, "seed": 0}
    watch = [f"Main.{name}" for name in _watched(model)]
    watched = {path: program.type_of(path) for path in watch}
    trace = Trace({**header, "engine": "builtin", "link": "explored"}, file, watched=watched)
    timeline = Timeline(trace)
    trace.listen(timeline.take)
    shown = Replay(trace, timeline)
    look = program.reader(watch)
    monitor, memory, now_us = WireMonitor(), oracle.initial(), 0
    hanging = None if broken.quiet is None else quiet_choices(model, broken.quiet)
    for number in range(len(broken.path) + (0 if hanging is None else _SHOWN)):
        if number < len(broken.path):
            choice = broken.path[number]
        else:
            assert hanging is not None
            choice = hanging[oracle.wire(memory)]
        now_us += choice.ticks * model.tick_ms * 1000
        _apply(program, choice)
        before = oracle.all_seen()
        program.scan(now_us)
        now, written = oracle.all_seen(), oracle.written()
        memory, rules = oracle.judge(memory, choice, before, now, written)
        so = choice.image + bytes(SIZE - len(choice.image))
        si = program.read_bytes("Main.OutputArea")[:34] + bytes(SIZE - 34)
        values = dict(zip(watch, look(), strict=True))
        trace.add(Scan(now_us, number, so, si, {"done": model.tell(choice), **values}))
        found = monitor.scan(now_us, number, so, si, choice.situation.connected)
        shown.monitor += [one.text for one in found]
        for text in rules:
            trace.add(Violation(now_us, "explored", text))
        shown.rules += rules
    if broken.quiet is not None:
        shown.rules += broken.rules
        trace.add(Violation(now_us, "explored", broken.rules[0]))
    trace.close()
    return shown


def _watched(model: Model) -> list[str]:
    """Return the pins of the blocks, and the variables that show which block has the turn."""
    names = ["Connected", "StopOk", "EmergencyStopOk"]
    for block in model.blocks:
        pins = ("Busy", "Valid" if block.is_level else "Done", "Error", "ErrorID")
        names += [f"Call{block.name}", *(f"{block.name}.{pin}" for pin in (block.start, *pins))]
    for channel in ("Command", "Sequence"):
        names += [f"Robot.Inner.{channel}.Serving", f"Robot.Inner.{channel}.NextTicket"]
    return [*names, "Robot.Inner.Phase"]


def _apply(program: Program, choice: Choice) -> None:
    program.write_bytes("Main.InputArea", choice.image)
    for name, value in choice.values:
        program.write(f"Main.{name}", value)
