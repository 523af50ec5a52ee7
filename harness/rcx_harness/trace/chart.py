"""The timing chart of a run, as the manual draws them: which signal changed when.

Columns are the instants at which something changed, each under its time, so that 100 ms of
interval and a 5 ms answer are both seen. Long runs go on in bands below each other.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from rcx_harness.spec import Signal, signals
from rcx_harness.trace.records import Record, Scan, Violation
from rcx_harness.watch.wire import word

__all__ = ["Band", "Lane", "Timeline", "text_chart", "time_labels"]

#: More instants than this make no chart that anybody reads; a wave file holds them all.
MOST_INSTANTS = 400

#: Characters for the names: at least, at most; in between two fifths of the width.
_LABEL = (26, 50)


def _when(change: tuple[int, Any]) -> int:
    return change[0]


@dataclass
class Lane:
    """One signal: its changes as (time in microseconds, new value).

    Attributes:
        name: What stands beside it.
        kind: `input`, `output`, `variable` or `event` for what is ON or OFF, `word` for a word,
            `stage` for the names of an enumeration, `curve` for a number over time, `finding` for
            broken rules.
        changes: In order of time.
    """

    name: str
    kind: str
    changes: list[tuple[int, Any]] = field(default_factory=list)

    def note(self, t_us: int, value: Any) -> None:
        """The value from `t_us` on."""
        if value != (self.changes[-1][1] if self.changes else 0):
            self.changes.append((t_us, value))

    def spans(self, begin_us: int, end_us: int) -> Iterator[tuple[int, int, Any]]:
        """From, to, value, within these times; values that come and go in no time are left out."""
        inside = [change for change in self.changes if begin_us < change[0] < end_us]
        starts = [(begin_us, self.value_at(begin_us)), *inside]
        ends = [*(t_us for t_us, _ in inside), end_us]
        for (start, value), stop in zip(starts, ends, strict=True):
            if start < stop:
                yield start, stop, value

    def value_at(self, t_us: int) -> Any:
        """The value from `t_us` on; 0 before the first change."""
        found = bisect_right(self.changes, t_us, key=_when)
        return self.changes[found - 1][1] if found else 0

    def tells(self, first_us: int, last_us: int) -> bool:
        """Is there anything but OFF to see from `first_us` to `last_us`?"""
        on = self.kind == "word" or (self.kind != "finding" and self.value_at(first_us - 1))
        return bool(on) or self._has(first_us, last_us)

    def changes_at(self, t_us: int) -> bool:
        """Is there a change at exactly this time?"""
        return self._has(t_us, t_us)

    def _has(self, first_us: int, last_us: int) -> bool:
        found = bisect_left(self.changes, first_us, key=_when)
        return found < len(self.changes) and self.changes[found][0] <= last_us


@dataclass(frozen=True)
class Band:
    """Some successive instants of a chart, with the lanes to draw."""

    instants: tuple[int, ...]
    lanes: tuple[Lane, ...]


class _Signals:
    """The lanes of one controller; those of all but the first bear its number."""

    def __init__(self, controller: int) -> None:
        table, who = signals(), "" if controller == 1 else f"{controller}: "
        self.inputs = [(one.byte, one.bit, _lane(one, "input", who)) for one in table.input]
        self.outputs = [(one.byte, one.bit, _lane(one, "output", who)) for one in table.output]
        self.code = Lane(f"{who}Remote command code", "word")
        self.status = Lane(f"{who}Remote status", "word")
        self._si = self._so = b""

    def take(self, scan: Scan) -> None:
        """Take the next scan."""
        if scan.so != self._so:
            self._so = scan.so
            self.status.note(scan.t_us, word(scan.so, 0))
            for byte, bit, lane in self.outputs:
                lane.note(scan.t_us, scan.so[byte] >> bit & 1)
        if scan.si != self._si:
            self._si = scan.si
            self.code.note(scan.t_us, word(scan.si, 0))
            for byte, bit, lane in self.inputs:
                lane.note(scan.t_us, scan.si[byte] >> bit & 1)

    def lanes(self) -> list[Lane]:
        """The bits that changed, the command code and the status."""
        bits = [lane for _, _, lane in self.inputs + self.outputs if lane.changes]
        return [*bits, self.code, self.status]


class Timeline:
    """Collects the changes of the dedicated signals, as the PLC reads and writes them.

    Give `take` to `Trace.listen`. Memory grows with the changes, not with the time.
    """

    def __init__(self) -> None:
        self._controllers = {1: _Signals(1)}
        self._findings = Lane("Rule broken", "finding")

    def take(self, record: Record) -> None:
        """Take the next record of the run."""
        if isinstance(record, Scan):
            if record.controller not in self._controllers:
                self._controllers[record.controller] = _Signals(record.controller)
            self._controllers[record.controller].take(record)
        elif isinstance(record, Violation):
            self._findings.changes.append((record.t_us, 1))

    def lanes(self) -> list[Lane]:
        """The lanes of each controller; broken rules if there are any."""
        every = [lane for one in self._controllers.values() for lane in one.lanes()]
        return [*every, *([self._findings] if self._findings.changes else [])]

    def instants(self) -> list[int]:
        """All times at which something changed, in order."""
        return sorted({when for lane in self.lanes() for when, _ in lane.changes})

    def bands(self, columns: int) -> list[Band]:
        """The chart in bands of at most `columns` instants.

        A bit that is OFF all through a band is left out of it.
        """
        instants = self.instants()[:MOST_INSTANTS]
        parts = [tuple(instants[k : k + columns]) for k in range(0, len(instants), columns)]
        return [
            Band(part, tuple(lane for lane in self.lanes() if lane.tells(part[0], part[-1])))
            for part in parts
        ]

    def left_out(self) -> int:
        """How many instants the chart does not show."""
        return max(0, len(self.instants()) - MOST_INSTANTS)


def time_labels(instants: Sequence[int]) -> list[str]:
    """Milliseconds, with as many decimals as these times need."""
    units = (1_000, 100, 10, 1)
    decimals = next(k for k, unit in enumerate(units) if all(t % unit == 0 for t in instants))
    return [f"{t_us / 1000:.{decimals}f}" for t_us in instants]


def text_chart(timeline: Timeline, width: int = 100, *, ascii_only: bool = False) -> str:
    """The chart for a terminal.

    Args:
        timeline: What to draw.
        width: Characters per line, at least 60.
        ascii_only: For terminals without Unicode.
    """
    labels = time_labels(timeline.instants()[:MOST_INSTANTS])
    if not labels:
        return "no dedicated signal and no remote command changed\n"
    cell = max(6, max(map(len, labels)) + 1)
    longest = max(len(lane.name) for lane in timeline.lanes())
    names = min(longest, max(_LABEL[0], width * 2 // 5), _LABEL[1])
    columns = max(1, (max(width, 60) - names - 3) // cell)
    glyphs = _ASCII if ascii_only else _UNICODE
    lines = []
    for number, band in enumerate(timeline.bands(columns)):
        times = labels[number * columns : (number + 1) * columns]
        head = "".join(f"{label:<{cell}}" for label in times)
        lines.append(f"{'time [ms]':<{names}}   {head}".rstrip())
        lines += [_line(lane, band.instants, names, cell, glyphs) for lane in band.lanes]
        lines.append("")
    if timeline.left_out():
        lines.append(f"{timeline.left_out()} further instants are left out; --vcd has them all")
    return "\n".join(lines).rstrip() + "\n"


@dataclass(frozen=True)
class _Glyphs:
    low: str
    high: str
    rise: str
    fall: str
    idle: str
    cross: str
    mark: str
    more: str


_UNICODE = _Glyphs("▁", "▔", "╱", "╲", "─", "╳", "▲", "…")  # noqa: RUF001 - drawn lines
_ASCII = _Glyphs("_", '"', "/", "\\", "-", "X", "!", "~")


def _line(lane: Lane, instants: tuple[int, ...], names: int, cell: int, glyphs: _Glyphs) -> str:
    name = lane.name if len(lane.name) <= names else lane.name[: names - 1] + glyphs.more
    value = lane.value_at(instants[0] - 1)
    parts = [f"{name:<{names}} "]
    if lane.kind == "finding":
        marks = (glyphs.mark if lane.changes_at(t_us) else " " for t_us in instants)
        return "".join([*parts, "  ", *(f"{mark:<{cell}}" for mark in marks)]).rstrip()
    if lane.kind == "word":
        return "".join([*parts, glyphs.idle * 2, *_words(lane, instants, cell, glyphs)])
    parts.append((glyphs.high if value else glyphs.low) * 2)
    for t_us in instants:
        before, value = value, lane.value_at(t_us)
        level = glyphs.high if value else glyphs.low
        edge = level if value == before else glyphs.rise if value else glyphs.fall
        parts.append(edge + level * (cell - 1))
    return "".join(parts)


def _words(lane: Lane, instants: tuple[int, ...], cell: int, glyphs: _Glyphs) -> list[str]:
    """Zero is a plain line; any other value stands where it begins, and at each band's start."""
    parts = []
    before = lane.value_at(instants[0] - 1)
    for number, t_us in enumerate(instants):
        value = lane.value_at(t_us)
        begins = lane.changes_at(t_us)
        edge = glyphs.cross if begins and value != before else glyphs.idle
        shown = f"{value:04X}" if value and (begins or number == 0) else ""
        parts.append(edge + shown + glyphs.idle * (cell - 1 - len(shown)))
        before = value
    return parts


def _lane(signal: Signal, kind: str, who: str) -> Lane:
    return Lane(f"{who}{signal.signal} {signal.title}", kind)
