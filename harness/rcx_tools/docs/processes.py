"""The processes of the manual (such as servo on) in a run of the cell, with the time of each step.

docs/explanation/charts/processes.toml lists the processes. The program and the stimulus of each
process are in the same folder, and `rcx run` can also run them. The charts are always drawn from
the trace of a run, not from the list.

If the steps do not happen in the order of the list, an error is raised.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from typing import Any

from rcx_harness.cell import Cell
from rcx_harness.cell.stimulus import Stimulus
from rcx_harness.spec import command_name, signals
from rcx_harness.trace import Cycle, Record, Scan
from rcx_harness.trace.chart import Lane, time_labels
from rcx_harness.watch.wire import word
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml
from structured_text.output.units import parse_us

__all__ = ["FOLDER", "Process", "ProcessChart", "Step", "TimedStep", "Track", "process_chart"]
__all__ += ["processes", "run_process"]

#: Folder of the list, the programs and the charts.
FOLDER = Path(__file__).resolve().parents[3] / "docs/explanation/charts"


@dataclass(frozen=True)
class _Surrounding:
    """A signal outside of the process image: its name, and the events and words for ON and OFF."""

    name: str
    at_start: bool
    events: tuple[str, str]
    words: tuple[str, str]


_SURROUNDINGS = {
    "power": _Surrounding(
        "Controller's power",
        True,
        ("power_on", "power_off"),
        ("controller switched on", "controller switched off"),
    ),
    "cable": _Surrounding(
        "Network cable plugged in",
        True,
        ("link_up", "link_down"),
        ("network cable plugged in", "network cable unplugged"),
    ),
    "auto": _Surrounding(
        "AUTO mode input (SAFETY connector)",
        True,
        ("auto_input_on", "auto_input_off"),
        ("AUTO mode input ON", "AUTO mode input OFF"),
    ),
    "lock": _Surrounding(
        "Programming box: manual lock",
        False,
        ("manual_lock_on", "manual_lock_off"),
        ("manual lock ON", "manual lock OFF"),
    ),
    "pendant": _Surrounding(
        "Programming box: control authority",
        False,
        ("pendant_on", "pendant_off"),
        ("control authority taken", "control authority cancelled"),
    ),
    "button": _Surrounding(
        "Hard-wired emergency stop",
        False,
        ("emergency_stop", "emergency_stop_release"),
        ("emergency stop pressed", "emergency stop released"),
    ),
}

_SURROUND, _PROGRAM = "Around the robot", "PLC program"
_TO_ROBOT, _TO_PLC, _INSIDE = "PLC to controller", "Controller to PLC", "Inside the controller"


@dataclass(frozen=True)
class Step:
    """One step of a process: its edges, such as `("SI01", 1)`, and its description."""

    edges: tuple[tuple[str, int], ...]
    text: str


@dataclass(frozen=True)
class Process:
    """One entry of the list.

    Attributes:
        name: File name of the chart, the program and the stimulus.
        title: Title on the page.
        section: Section of the manual.
        blocks: The blocks that perform the process.
        seen: The side from which the chart shows the signals: PLC or controller.
        about: One or two sentences below the title.
        begin_us: Start of the chart, in the time of the run.
        end_us: End of the chart and of the run.
        lanes: The signals to draw, each with its label. None means that the name is the label.
        steps: The steps in the manual's order.
    """

    name: str
    title: str
    section: str
    blocks: tuple[str, ...]
    seen: str
    about: str
    begin_us: int
    end_us: int
    lanes: tuple[tuple[str, str | None], ...]
    steps: tuple[Step, ...]

    @property
    def program(self) -> Path:
        """Return the path of the ST file of the process."""
        return FOLDER / f"{self.name}.st"

    @property
    def stimulus(self) -> Path:
        """Return the path of the stimulus of the process."""
        return FOLDER / f"{self.name}.toml"


@dataclass
class Track:
    """A lane of a chart, with its group and the function that reads its values."""

    signal: str
    group: str
    lane: Lane
    source: type[Scan] | type[Cycle] | None
    value: Callable[[Any], int] = field(repr=False)

    def take(self, record: Record) -> None:
        """Record the value of the lane from a record of the run."""
        if self.source is not None and isinstance(record, self.source):
            self.lane.note(record.t_us, self.value(record))

    def says(self, value: int) -> str:
        """Return a short text for a change to `value`, such as `SI(01) ON` or `n + 2 = 0x0004`."""
        if self.lane.kind == "word":
            return f"{self.lane.name.partition(':')[0]} = 0x{value:04X}"
        if self.signal in _SURROUNDINGS:
            return _SURROUNDINGS[self.signal].words[not value]
        code = re.match(r"S[IO]\(\d+\)", self.lane.name)
        inside = " inside" if self.signal.startswith("rcx.SI") else ""
        return f"{code[0] if code else self.lane.name} {'ON' if value else 'OFF'}{inside}"

    def when(self, value: int, since_us: int) -> int | None:
        """Return the time of the first change to `value` at or after `since_us`, or None."""
        return next((t for t, new in self.lane.changes if t >= since_us and new == value), None)


@dataclass(frozen=True)
class TimedStep:
    """A step of a process with its times in a run.

    Attributes:
        number: Number of the step, from 1.
        change: Edges of the step, such as `SI(01) ON`.
        text: Description of the step.
        edges: Each signal with the time of its change.
        t_us: Time of the last edge.
        at: Time in ms since the first step. Two times if the edges come at different times.
        since_last: Time in ms since the previous step. Empty for the first step.
    """

    number: int
    change: str
    text: str
    edges: tuple[tuple[str, int], ...]
    t_us: int
    at: str
    since_last: str


@dataclass(frozen=True)
class ProcessChart:
    """The result of a run of a process.

    Attributes:
        process: The entry of the list.
        tracks: The lanes, in the order of the list.
        steps: The steps with their times.
        inputs: Times at which the PLC changed dedicated inputs, within the chart.
        timing: Description of scan time, packet interval, and interval between inputs.
    """

    process: Process
    tracks: tuple[Track, ...]
    steps: tuple[TimedStep, ...]
    inputs: tuple[int, ...]
    timing: str

    @property
    def zero_us(self) -> int:
        """Return the time of the first edge of the first step, which is time 0 of the chart."""
        return min(t_us for _, t_us in self.steps[0].edges)

    @property
    def instants(self) -> tuple[int, ...]:
        """Return all times within the chart at which a signal changes."""
        begin, end = self.process.begin_us, self.process.end_us
        found = {t for track in self.tracks for t, _ in track.lane.changes if begin < t < end}
        return tuple(sorted(found))


@cache
def processes() -> dict[str, Process]:
    """Return the processes by name, in the order of the manual.

    Raises:
        InputError: the list cannot be read, or an entry is wrong.
    """
    file = FOLDER / "processes.toml"
    found = {}
    for entry in load_toml(file)["process"]:
        try:
            found[entry["name"]] = _process(**entry)
        except (TypeError, ValueError) as error:
            raise InputError(f"process {entry.get('name')!r}: {error}", file=file) from None
    return found


@cache
def process_chart(name: str) -> ProcessChart:
    """Return the chart of a process, from a run on the built-in engine."""
    return run_process(processes()[name], engine="builtin")


def run_process(process: Process, *, engine: str = "auto") -> ProcessChart:
    """Run a process in the cell and find its steps.

    Raises:
        InputError: the steps do not happen in their order, a rule is broken, or a dedicated input
            changes that the chart does not show.
    """
    tracks = [_track(signal, label) for signal, label in process.lanes]
    watch = [track.signal for track in tracks if track.group == _PROGRAM]
    wire = [_track(signal.short, None) for signal in signals().input]
    with Cell.build(process.program, engine=engine, watch=watch) as cell:
        for track in [*tracks, *wire]:
            cell.trace.listen(track.take)
        stimulus = Stimulus.load(process.stimulus)
        stimulus.schedule(cell)
        cell.run(process.end_us)
        if cell.violations:
            raise InputError(f"{process.name}: {cell.violations[0].text}", file=process.program)
        margin = cell["Main.WriteArea.Margin"]
        timing = f"Scan {cell.timing.scan_us / 1000:g} ms, RPI {cell.timing.rpi_us / 1000:g} ms"
        timing += f", Interval 100 ms + Margin {margin.total_seconds() * 1000:g} ms"
    for track in tracks:
        _follow_events(track, stimulus)
    shown = [track.signal for track in tracks]
    begin, end = process.begin_us, process.end_us
    changes = [(t, one) for one in wire for t, _ in one.lane.changes if begin < t < end]
    for t_us, one in changes:
        if one.signal not in shown:
            text = f"{process.name}: {one.signal} changes at {t_us} us and is not shown"
            raise InputError(text, file=FOLDER / "processes.toml")
    inputs = tuple(sorted({t_us for t_us, _ in changes}))
    return ProcessChart(process, tuple(tracks), _find_steps(process, tracks), inputs, timing)


def _find_steps(process: Process, tracks: Sequence[Track]) -> tuple[TimedStep, ...]:
    """Find each step in the run: its first occurrence after the previous step."""
    by_signal = {track.signal: track for track in tracks}
    found: list[TimedStep] = []
    zero = 0
    for number, step in enumerate(process.steps, 1):
        since = found[-1].t_us if found else process.begin_us
        edges = []
        for signal, value in step.edges:
            t_us = by_signal[signal].when(value, since)
            if t_us is None or t_us >= process.end_us:
                text = f"{process.name}, step {number}: no change of {signal} to {value}"
                raise InputError(text, file=process.program)
            edges.append((signal, t_us))
        times = sorted({t_us for _, t_us in edges})
        zero = zero if found else times[0]
        at = " to ".join(time_labels([times[0] - zero, times[-1] - zero])[: len(times)])
        gap = f"+{time_labels([times[-1] - since])[0]}" if found else ""
        change = ", ".join(by_signal[signal].says(value) for signal, value in step.edges)
        found.append(TimedStep(number, change, step.text, tuple(edges), times[-1], at, gap))
    return tuple(found)


def _process(*, begin: str, end: str, lanes: list[str], step: list[Any], **rest: Any) -> Process:
    shown = [lane.partition("=") for lane in lanes]
    rest["blocks"] = tuple(rest["blocks"])
    return Process(
        begin_us=parse_us(begin),
        end_us=parse_us(end),
        lanes=tuple((signal.strip(), label.strip() or None) for signal, _, label in shown),
        steps=tuple(Step(tuple(map(_edge, one["edges"])), one["text"]) for one in step),
        **rest,
    )


def _edge(text: str) -> tuple[str, int]:
    """Parse an edge: `SI01 ON` or `m+0 0x0200`."""
    signal, _, value = text.rpartition(" ")
    return signal, {"ON": 1, "OFF": 0}.get(value) or int(value.replace("OFF", "0"), 0)


def _track(signal: str, label: str | None) -> Track:
    """Return the lane for a name in processes.toml.

    Names are `SI01` and `SO02` as the PLC writes and reads them, `rcx.SI01` as the controller reads
    it, `n+0` and `m+2` for words, `Main.X` for a BOOL, and the signals of the surroundings.
    """
    if signal in _SURROUNDINGS:
        lane = Lane(label or _SURROUNDINGS[signal].name, "event")
        return Track(signal, _SURROUND, lane, None, int)
    if signal.startswith("Main."):
        lane = Lane(label or signal.removeprefix("Main."), "variable")
        return Track(signal, _PROGRAM, lane, Scan, lambda scan: int(scan.vars[signal]))
    match = re.fullmatch(r"([mn])\+(\d+)", signal)
    if match:
        lane, at = Lane(label or signal, "word"), int(match[2])
        if signal == "n+0":
            lane.show = command_name
        if match[1] == "n":
            return Track(signal, _TO_ROBOT, lane, Scan, lambda scan: word(scan.si, at))
        return Track(signal, _TO_PLC, lane, Scan, lambda scan: word(scan.so, at))
    row = signals().find(signal.removeprefix("rcx."))
    byte, bit, out = row.byte, row.bit, row.short.startswith("SO")
    lane = Lane(label or f"{row.signal} {row.title}", "output" if out else "input")
    if signal.startswith("rcx."):
        if out:
            return Track(signal, _INSIDE, lane, Cycle, lambda one: one.rcx_so[byte] >> bit & 1)
        # Without a connection rcx_si is empty, because the controller reads all inputs as OFF.
        level = lambda one: one.rcx_si[byte] >> bit & 1 if one.rcx_si else 0  # noqa: E731
        return Track(signal, _INSIDE, lane, Cycle, level)
    if out:
        return Track(signal, _TO_PLC, lane, Scan, lambda scan: scan.so[byte] >> bit & 1)
    return Track(signal, _TO_ROBOT, lane, Scan, lambda scan: scan.si[byte] >> bit & 1)


def _follow_events(track: Track, stimulus: Stimulus) -> None:
    """Record the changes of the robot's surroundings that the stimulus defines."""
    if track.signal not in _SURROUNDINGS:
        return
    one = _SURROUNDINGS[track.signal]
    if one.at_start:
        track.lane.changes.append((-1, 1))
    for entry in stimulus.entries:
        for event, _ in entry.events:
            if event in one.events:
                track.lane.changes.append((entry.t_us, int(event == one.events[0])))
