"""The timing chart of a run, in the style of the manual: the changes of each signal over time.

Each column is an instant at which a value changed, so an answer after 5 ms is as visible as an
interval of 100 ms. Long runs continue in bands below each other.
"""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from typing import Any

from rcx_harness.spec import Signal, command_name, signals
from rcx_harness.spec.wire import ABNORMAL_END
from rcx_harness.trace.explaining import named, of_alarms, of_errors, unanswered
from rcx_harness.trace.records import Cycle, Record, Scan, Trace
from rcx_harness.trace.tasks import task_text
from rcx_harness.watch.wire import word
from structured_text.bench import samples
from structured_text.errors import Violation
from structured_text.language.displayed import Changed, value_text
from structured_text.language.types import ElementaryType, Type

__all__ = [
    "LONGEST_TEXT",
    "MOST_INSTANTS",
    "NOTHING",
    "Band",
    "Glyphs",
    "Lane",
    "Timeline",
    "column_widths",
    "glyphs",
    "name_width",
    "text_chart",
    "time_labels",
]

#: Greatest number of instants in a readable chart. A wave file contains all instants.
MOST_INSTANTS = 400

#: The names get two fifths of the width. These are the least and the greatest width in characters.
_LABEL = (26, 50)
#: If a watched variable has more changes than this, its changes get no columns of their own.
_OFTEN = 50
#: If more variables than this number are watched, variables that never change are left out.
_MOST_STILL = 16
#: A column becomes wider for a text up to this length [characters].
LONGEST_TEXT = 24
#: If only this number of letters of a text fits, the text is left out, because it would be
#: unreadable.
_TOO_FEW = 2

_WORD = ElementaryType("WORD")

#: Text that replaces the chart if nothing has changed.
NOTHING = "no dedicated signal and no remote command changed"


def _when(change: tuple[int, Any]) -> int:
    return change[0]


@dataclass
class Lane:
    """One signal of a chart: its changes as (time in microseconds, new value).

    Attributes:
        name: The text beside the lane.
        kind: `input`, `output`, `variable` or `event` for ON or OFF, `word` for a word, `value` for
            values as text, `task` for a task of a robot program, `stage` for the names of an
            enumeration, `curve` for a number over time, `finding` for broken rules.
        changes: The changes in order of time.
        first: The value before the first change.
        show: Function that converts a value to text. With None a word is shown in hexadecimal
            digits.
        always: Whether the lane is drawn even if it is OFF all the time.
    """

    name: str
    kind: str
    changes: list[tuple[int, Any]] = field(default_factory=list)
    first: Any = 0
    show: Callable[[Any], str] | None = None
    always: bool = False

    def note(self, t_us: int, value: Any) -> None:
        """Record that the signal has this value from `t_us` on."""
        if value != (self.changes[-1][1] if self.changes else self.first):
            self.changes.append((t_us, value))

    def text(self, value: Any) -> str:
        """Return a value of this signal as text."""
        if self.show is not None:
            return self.show(value)
        return f"0x{value:04X}" if self.kind == "word" else str(value)

    def short(self, value: Any) -> str:
        """Return a value of this signal as short text for a terminal."""
        return self.text(value).removeprefix("0x")

    @property
    def is_text(self) -> bool:
        """Return whether the chart shows the values of this signal as text."""
        return self.kind in ("word", "value", "curve", "task")

    def is_idle(self, value: Any) -> bool:
        """Return whether a value is drawn as a line without text: the word 0, or no program."""
        return self.kind in ("word", "task") and not value

    @property
    def is_curve(self) -> bool:
        """Return whether a chart that is true to scale draws this signal as a curve.

        Curves are positions, and numbers that change very often.
        """
        if self.kind == "curve":
            return True
        return self.kind == "value" and self.is_restless and isinstance(self.first, (int, float))

    @property
    def is_restless(self) -> bool:
        """Return whether the signal changes too often to get a column for each change."""
        return len(self.changes) > _OFTEN

    def spans(self, begin_us: int, end_us: int) -> Iterator[tuple[int, int, Any]]:
        """Yield start, end and value of each period between two times.

        Periods with the duration 0 are left out.
        """
        inside = [change for change in self.changes if begin_us < change[0] < end_us]
        starts = [(begin_us, self.value_at(begin_us)), *inside]
        ends = [*(t_us for t_us, _ in inside), end_us]
        for (start, value), stop in zip(starts, ends, strict=True):
            if start < stop:
                yield start, stop, value

    def value_at(self, t_us: int) -> Any:
        """Return the value that the signal has from `t_us` on."""
        found = bisect_right(self.changes, t_us, key=_when)
        return self.changes[found - 1][1] if found else self.first

    def tells(self, first_us: int, last_us: int) -> bool:
        """Return whether the lane must be drawn from `first_us` to `last_us`.

        A chart leaves out bits that are OFF and findings without a mark.
        """
        if self.always:
            return True
        on = self.kind == "word" or (self.kind != "finding" and self.value_at(first_us - 1))
        return bool(on) or self.count(first_us, last_us + 1) > 0

    def limits(self) -> tuple[float, float]:
        """Return the least and the greatest value of this signal."""
        values = (self.first, *(value for _, value in self.changes))
        numbers = [v for v in values if isinstance(v, (int, float)) and math.isfinite(v)]
        return min(numbers, default=0), max(numbers, default=0)

    def count(self, begin_us: int, end_us: int) -> int:
        """Return the number of changes from `begin_us` on, before `end_us`."""
        first = bisect_left(self.changes, begin_us, key=_when)
        return bisect_left(self.changes, end_us, key=_when) - first

    def changes_at(self, t_us: int) -> bool:
        """Return whether the signal changes exactly at this time."""
        return self.count(t_us, t_us + 1) > 0


@dataclass(frozen=True)
class Band:
    """A part of a chart: some successive instants, with the lanes to draw."""

    instants: tuple[int, ...]
    widths: tuple[int, ...]
    lanes: tuple[Lane, ...]


class _Signals:
    """The lanes of one controller.

    The names contain the controller's number, except for controller 1.
    """

    def __init__(self, controller: int) -> None:
        table, who = signals(), "" if controller == 1 else f"{controller}: "
        self.inputs = [(one.byte, one.bit, _lane(one, "input", who)) for one in table.input]
        self.outputs = [(one.byte, one.bit, _lane(one, "output", who)) for one in table.output]
        self._codes = [one.signal for one in (*table.input, *table.output)]
        self.alarms: set[str] = set()
        """The numbers of the alarms that ended remote commands."""
        self.code = Lane(f"{who}Remote command code", "word", show=command_name)
        self.status = Lane(f"{who}Remote status", "word")
        self._si = self._so = b""

    def take(self, scan: Scan) -> None:
        """Add the changes of the controller's signals in the next scan."""
        if scan.so != self._so:
            self._so = scan.so
            self.status.note(scan.t_us, word(scan.so, 0))
            if word(scan.so, 0) == ABNORMAL_END:
                self.alarms.add(f"{word(scan.so, 2)}.{word(scan.so, 4)}")
            for byte, bit, lane in self.outputs:
                lane.note(scan.t_us, scan.so[byte] >> bit & 1)
        if scan.si != self._si:
            self._si = scan.si
            self.code.note(scan.t_us, word(scan.si, 0))
            for byte, bit, lane in self.inputs:
                lane.note(scan.t_us, scan.si[byte] >> bit & 1)

    def lanes(self, told: Collection[str]) -> list[Lane]:
        """Return the lanes to draw: changed or explaining bits, command code, and status.

        `told` has bits that explain a problem although the areas do not show it.
        """
        bits = [lane for _, _, lane in self.inputs + self.outputs]
        ever_on = {code for code, lane in zip(self._codes, bits, strict=True) if lane.changes}
        explains = {*told, *unanswered(ever_on), *of_alarms(self.alarms)}
        for code, lane in zip(self._codes, bits, strict=True):
            lane.always = code in explains
        shown = [lane for lane in bits if lane.changes or lane.always]
        return [*shown, self.code, self.status]


class _Variables:
    """The lanes of the watched variables. Structures and arrays have a lane for each element."""

    def __init__(self, watched: Mapping[str, Type]) -> None:
        self._changed = Changed(watched)
        self._lanes: dict[str, Lane] = {}
        self.words: set[int] = set()
        """All values of WORD variables. Some of these values are ErrorIDs."""

    def take(self, t_us: int, values: Mapping[str, Any]) -> None:
        """Add the values of the watched variables after the next scan."""
        for part, held in self._changed.take(values):
            if part.type == _WORD:
                self.words.add(held)
            if isinstance(held, float) and math.isnan(held):
                held = "nan"  # NaN differs from itself, so each scan would count as a change
            if part.path in self._lanes:
                self._lanes[part.path].note(t_us, held)
            else:
                self._lanes[part.path] = _of_variable(part.path, part.type, held)

    def lanes(self) -> list[Lane]:
        """Return the lanes that have changed. If there are only few lanes, return all of them."""
        every = list(self._lanes.values())
        return every if len(every) <= _MOST_STILL else [lane for lane in every if lane.changes]


def _of_variable(name: str, kind: Type, first: Any) -> Lane:
    if kind == ElementaryType("BOOL"):
        return Lane(name, "variable", first=first, always=True)
    return Lane(name, "value", first=first, show=partial(_text_of, kind), always=True)


def _text_of(kind: Type, value: Any) -> str:
    return value if value == "nan" else value_text(kind, value)


class Timeline:
    """The changes of the dedicated signals, as the PLC reads and writes them.

    It also collects the lines of the tasks of robot programs, if these are recorded. With a trace
    it collects the changes of recorded variables and positions in addition. Pass `take` to
    `Trace.listen`. Memory grows with the changes, not with the time.
    """

    def __init__(self, trace: samples.Trace[Any] | None = None) -> None:
        # a trace of a program without a robot has no size of areas
        alone = trace is not None and "size" not in trace.header
        self._controllers = {} if alone else {1: _Signals(1)}
        self._variables = _Variables(trace.watched if trace is not None else {})
        self._positions = [
            [_of_axis(title, number) for title in titles]
            for number, titles in enumerate(trace.axes if isinstance(trace, Trace) else (), 1)
        ]
        self._tasks: dict[tuple[int, int], Lane] = {}
        self._findings = Lane("Rule broken", "finding")
        self._named: set[str] = set()
        self.end_us = 0
        """The time of the last record [us]."""

    def take(self, record: Record) -> None:
        """Add the changes of the next record of the run."""
        self.end_us = record.t_us
        if isinstance(record, Scan):
            if record.so and record.controller not in self._controllers:
                self._controllers[record.controller] = _Signals(record.controller)
            if record.so:
                self._controllers[record.controller].take(record)
            if record.vars is not None:
                self._variables.take(record.t_us, record.vars)
        elif isinstance(record, Violation):
            self._findings.changes.append((record.t_us, 1))
            self._named |= named([record.text])
        else:
            if record.positions is not None and self._positions:
                self._take_positions(record, record.positions)
            if record.tasks is not None:
                self._take_tasks(record, record.tasks)

    def _take_positions(self, record: Cycle, positions: tuple[float, ...]) -> None:
        for lane, value in zip(self._positions[record.controller - 1], positions, strict=True):
            if lane.first is None:
                lane.first = value
            lane.note(record.t_us, value)

    def _take_tasks(self, record: Cycle, tasks: Sequence[Mapping[str, Any]]) -> None:
        shown = {(record.controller, task["task"]): task_text(task) for task in tasks}
        is_first = all(controller != record.controller for controller, _ in self._tasks)
        for key, text in shown.items():
            if key not in self._tasks:
                self._tasks[key] = _of_task(*key, text if is_first else "")
        for key, lane in self._tasks.items():
            if key[0] == record.controller:
                lane.note(record.t_us, shown.get(key, ""))

    def explain(self, errors: Iterable[int]) -> None:
        """Add ErrorIDs. Signals in the cause of an ErrorID are drawn even if they are OFF."""
        self._named |= of_errors(errors)

    def lanes(self) -> list[Lane]:
        """Return the lanes: signals, tasks, variables, positions and broken rules.

        A signal that has never been ON is drawn only if it explains why a request had no effect.
        Such a signal is named by a broken rule or by the cause of an ErrorID, belongs to the alarm
        of a remote command, or is the missing answer to an input or a condition of this answer.
        """
        told = {*self._named, *of_errors(self._variables.words)}
        every = [lane for one in self._controllers.values() for lane in one.lanes(told)]
        every += self._of_cell()
        return [*every, *([self._findings] if self._findings.changes else [])]

    def _of_cell(self) -> list[Lane]:
        """Return the lanes of tasks, variables and positions."""
        found = [lane for _, lane in sorted(self._tasks.items())]
        found += self._variables.lanes()
        for lanes in self._positions:
            found += [lane for lane in lanes if lane.first is not None]
        return found

    def instants(self) -> list[int]:
        """Return the times at which a lane changed, in order.

        Changes of curves, of tasks and of very frequently changing lanes count only if there are no
        other changes.
        """
        moving = {
            id(one) for one in self._of_cell() if one.kind in ("curve", "task") or one.is_restless
        }
        lanes = self.lanes()
        calm = [lane for lane in lanes if id(lane) not in moving]
        return _times(calm) or _times(lanes)

    def bands(self, widths: Sequence[int], room: int) -> list[Band]:
        """Return the bands of the chart. A band is at most as wide as `room`.

        A band does not show bits that are OFF in the whole band.

        `widths` are the widths of the columns of all instants. A band has at least one column.
        """
        instants = self.instants()[: len(widths)]
        found = []
        begin = 0
        for end in [*_breaks(widths, room), len(instants)]:
            part = tuple(instants[begin:end])
            if part:
                lanes = tuple(lane for lane in self.lanes() if lane.tells(part[0], part[-1]))
                found.append(Band(part, tuple(widths[begin:end]), lanes))
            begin = end
        return found

    def left_out(self) -> int:
        """Return the number of instants that the chart leaves out."""
        return max(0, len(self.instants()) - MOST_INSTANTS)


def _of_axis(title: str, controller: int) -> Lane:
    who = "" if controller == 1 else f"{controller}: "
    return Lane(f"{who}{title}", "curve", first=None, show="{:g}".format, always=True)


def _of_task(controller: int, number: int, first: str) -> Lane:
    who = "" if controller == 1 else f"{controller}: "
    return Lane(f"{who}Task {number}", "task", first=first, always=True)


def _times(lanes: Iterable[Lane]) -> list[int]:
    return sorted({when for lane in lanes for when, _ in lane.changes})


def _breaks(widths: Sequence[int], room: int) -> Iterator[int]:
    """Yield the columns at which bands begin, except the first."""
    used = 0
    for number, width in enumerate(widths):
        if number and used + width > room:
            yield number
            used = 0
        used += width


def column_widths(timeline: Timeline, narrow: int, need: Callable[[int], int]) -> list[int]:
    """Return the widths of the columns of a chart, wide enough for short values.

    `need` is a function that returns the width of a text with this number of characters, with
    margins.
    """
    instants = timeline.instants()[:MOST_INSTANTS]
    widths = [narrow] * len(instants)
    for lane in timeline.lanes():
        if not lane.is_text:
            continue
        values = [lane.value_at(t_us) for t_us in instants]
        begins = [k for k, value in enumerate(values) if not k or value != values[k - 1]]
        for begin, end in pairwise([*begins, len(values)]):
            if not lane.is_idle(values[begin]):
                wanted = need(min(len(lane.short(values[begin])), LONGEST_TEXT))
                widths[begin] += max(0, wanted - sum(widths[begin:end]))
    return widths


def time_labels(instants: Sequence[int]) -> list[str]:
    """Return the times in milliseconds, with as many decimals as they need."""
    units = (1_000, 100, 10, 1)
    decimals = next(k for k, unit in enumerate(units) if all(t % unit == 0 for t in instants))
    return [f"{t_us / 1000:.{decimals}f}" for t_us in instants]


def text_chart(timeline: Timeline, width: int = 100, *, ascii_only: bool = False) -> str:
    """Return the chart for a terminal.

    A line has `width` characters, at least 60. With `ascii_only` the chart has only ASCII
    characters.
    """
    labels = time_labels(timeline.instants()[:MOST_INSTANTS])
    if not labels:
        return NOTHING + "\n"
    names = name_width((lane.name for lane in timeline.lanes()), width)
    widths = column_widths(timeline, max(6, *(len(label) + 1 for label in labels)), _with_edge)
    drawn = glyphs(ascii_only)
    lines = []
    for band in timeline.bands(widths, max(width, 60) - names - 3):
        head = "".join(f"{labels.pop(0):<{cell}}" for cell in band.widths)
        lines.append(f"{'time [ms]':<{names}}   {head}".rstrip())
        lines += [_line(lane, band, names, drawn) for lane in band.lanes]
        lines.append("")
    if timeline.left_out():
        lines.append(f"{timeline.left_out()} further instants are left out; --vcd has them all")
    return drawn.finished(lines)


def name_width(names: Iterable[str], width: int) -> int:
    """Return the width of the names of the lanes [characters] in a chart of the given width."""
    return min(max(map(len, names)), max(_LABEL[0], width * 2 // 5), _LABEL[1])


def _with_edge(letters: int) -> int:
    return letters + 2


@dataclass(frozen=True)
class Glyphs:
    """The characters of a chart on a terminal.

    `levels` has the characters of a curve from low to high.
    """

    low: str
    high: str
    rise: str
    fall: str
    idle: str
    cross: str
    mark: str
    more: str
    levels: str

    def finished(self, lines: Iterable[str]) -> str:
        """Return the finished chart.

        For a terminal without Unicode, other characters become question marks.
        """
        chart = "\n".join(lines).rstrip() + "\n"
        return chart.encode("ascii", "replace").decode() if self is _ASCII else chart

    def name(self, name: str, width: int) -> str:
        """Return the name of a lane, cut to the given width, for the beginning of a line."""
        return f"{self.cut(name, width):<{width}} "

    def cut(self, text: str, room: int) -> str:
        """Return a text, cut to the given width.

        If too few letters would remain, return an empty text.
        """
        if len(text) <= room:
            return text
        return text[: room - 1] + self.more if room > _TOO_FEW + 1 else ""


_UNICODE = Glyphs("▁", "▔", "╱", "╲", "─", "╳", "▲", "…", "▁▂▃▄▅▆▇█")  # noqa: RUF001 - drawn lines
_ASCII = Glyphs("_", '"', "/", "\\", "-", "X", "!", "~", "_.:-=+*#")


def glyphs(ascii_only: bool) -> Glyphs:
    """Return the characters for a terminal with or without Unicode."""
    return _ASCII if ascii_only else _UNICODE


def _line(lane: Lane, band: Band, names: int, drawn: Glyphs) -> str:
    value = lane.value_at(band.instants[0] - 1)
    parts = [drawn.name(lane.name, names)]
    columns = list(zip(band.instants, band.widths, strict=True))
    if lane.kind == "finding":
        marks = ((drawn.mark if lane.changes_at(t_us) else " ", cell) for t_us, cell in columns)
        return "".join([*parts, "  ", *(f"{mark:<{cell}}" for mark, cell in marks)]).rstrip()
    if lane.is_text:
        return "".join([*parts, drawn.idle * 2, *_texts(lane, band, drawn)])
    parts.append((drawn.high if value else drawn.low) * 2)
    for t_us, cell in columns:
        before, value = value, lane.value_at(t_us)
        level = drawn.high if value else drawn.low
        edge = level if value == before else drawn.rise if value else drawn.fall
        parts.append(edge + level * (cell - 1))
    return "".join(parts)


def _texts(lane: Lane, band: Band, drawn: Glyphs) -> Iterator[str]:
    """Yield the pieces of a lane. The word 0 is a line; another value is written at its start.

    The value is repeated at the start of each band.
    """
    before = lane.value_at(band.instants[0] - 1)
    values = [lane.value_at(t_us) for t_us in band.instants]
    begins = [k for k, value in enumerate(values) if not k or value != values[k - 1]]
    for begin, end in pairwise([*begins, len(values)]):
        value, width = values[begin], sum(band.widths[begin:end])
        shown = "" if lane.is_idle(value) else drawn.cut(lane.short(value), width - 1)
        edge = drawn.cross if value != before else drawn.idle
        yield edge + shown + drawn.idle * (width - 1 - len(shown))
        before = value


def _lane(signal: Signal, kind: str, who: str) -> Lane:
    return Lane(f"{who}{signal.signal} {signal.title}", kind)
