"""Timing charts with a time axis that is true to scale, without gaps.

A chart continues in lines below each other. Each line shows the same length of time.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from typing import Any

from rcx_harness.trace.chart import NOTHING, Glyphs, Lane, Timeline, glyphs, name_width, time_labels
from rcx_harness.trace.chart_svg import CURVE, STYLE, Look, Scale, document, draw_lane, rule, text

__all__ = ["scaled_svg", "scaled_text"]

#: Number of lines of a chart if the user has not chosen a scale, and greatest number of lines.
_LINES, _MOST_LINES = 6, 100
_MS, _S, _MIN = 1_000, 1_000_000, 60_000_000
#: Possible lengths of a line in time, and possible distances between two time marks [us].
_STEPS = (
    *(k * unit for unit in (_MS, 10 * _MS, 100 * _MS) for k in (1, 2, 5)),
    *(k * _S for k in (1, 2, 5, 10, 20, 30)),
    *(k * _MIN for k in (1, 2, 5, 10, 20, 30, 60)),
)

#: Sizes in the picture [pixels].
_PLOT, _LETTER = 1000, 7.6
_ROW, _TOP, _HEAD, _GAP = 28, 44, 34, 16
_MARKS = 10
_STYLE = STYLE + ".m{font-size:10px;fill:#777}.e{text-anchor:end}"
_LOOK = Look(edge=0, digits=(5, 5), whole=True)
#: Minimum distance of two time marks on a terminal [characters].
_APART = 10


@dataclass(frozen=True)
class _Line:
    """One line of a chart: start and end in time, and the part of the full width that it fills."""

    begin_us: int
    end_us: int
    part: float
    lanes: tuple[Lane, ...]


def _lines(timeline: Timeline, line_us: int) -> list[_Line]:
    """Return the lines of the chart. If nothing has changed there are none."""
    if not timeline.instants():
        return []
    found = []
    last_us = max(timeline.end_us, 1)
    for begin in range(0, last_us, line_us)[:_MOST_LINES]:
        # A change at the time of the last record is drawn with a length of a microsecond.
        end = begin + line_us if begin + line_us < last_us else last_us + 1
        lanes = tuple(lane for lane in timeline.lanes() if lane.tells(begin, end - 1))
        found.append(_Line(begin, end, min(1.0, (end - begin) / line_us), lanes))
    return found


def _chosen(timeline: Timeline, line_us: int) -> int:
    """Return the time that one line shows: the requested time, or enough for only a few lines."""
    if line_us:
        return line_us
    few = (step for step in _STEPS if timeline.end_us <= _LINES * step)
    return next(few, -(-timeline.end_us // _LINES) or _STEPS[0])


def _left_out(timeline: Timeline, line_us: int) -> str:
    shown = line_us * _MOST_LINES
    if timeline.end_us <= shown:
        return ""
    return f"the part after {time_labels([shown])[0]} ms is left out; make a line longer"


def scaled_svg(timeline: Timeline, title: str = "", line_us: int = 0) -> str:
    """Return the chart of a run as SVG, true to scale. The same run gives the same bytes.

    A line shows `line_us` microseconds. With 0 the length is chosen so that there are only a few
    lines.
    """
    line_us = _chosen(timeline, line_us)
    names = max(len(lane.name) for lane in timeline.lanes())
    left = 44 + round(_LETTER * names)
    top = _TOP
    body = [f'<text x="12" y="24" font-weight="bold">{escape(title)}</text>']
    lines = _lines(timeline, line_us)
    for line in lines:
        body += _drawn(line, left, top)
        top += _HEAD + sum(map(_height, line.lanes)) + _GAP
    notes = [] if lines else [NOTHING]
    notes += [note for note in [_left_out(timeline, line_us)] if note]
    for note in notes:
        body.append(text(12, top + 6, note))
        top += _ROW
    return document(left + _PLOT + 24, top, _STYLE, body)


def _height(lane: Lane) -> int:
    return CURVE + 14 if lane.is_curve else _ROW


def _drawn(line: _Line, left: int, top: int) -> Iterator[str]:
    axis = Scale(left, left + round(_PLOT * line.part), line.begin_us, line.end_us)
    first = top + _HEAD
    bottom = first + sum(map(_height, line.lanes))
    yield text(12, top + 20, "time [ms]")
    for t_us, x in _marks(axis, max(1, round(_MARKS * line.part))):
        yield rule("g", x, first - 6, x, bottom)
        yield text(x, top + 20, time_labels([t_us])[0], "t")
    for lane in line.lanes:
        first += _height(lane)
        yield rule("r", 8, first, axis.right, first)
        yield text(12, first - _height(lane) / 2 + 5, lane.name)
        yield from draw_lane(lane, axis, first - 6, _LOOK)


def _marks(axis: Scale, most: int) -> Iterator[tuple[int, float]]:
    """Yield the times of the time marks. A mark at the end of a line belongs to the next line."""
    return ((t_us, x) for t_us, x in axis.round_times(_STEPS, most) if t_us < axis.end_us)


def scaled_text(
    timeline: Timeline, width: int = 100, *, ascii_only: bool = False, line_us: int = 0
) -> str:
    """Return the chart for a terminal, true to scale.

    A character stands for an interval of time. An edge shows one change in the interval, a cross
    several changes. Curves have eight levels from their least to their greatest value. Both values
    are written beside the name.

    A line has `width` characters, at least 60, and shows `line_us` microseconds. With 0 the length
    is chosen so that there are only a few lines. With `ascii_only` the chart has only ASCII
    characters.
    """
    line_us = _chosen(timeline, line_us)
    drawn = glyphs(ascii_only)
    names = name_width(map(_title, timeline.lanes()), width)
    room = max(width, 60) - names - 2
    lines = []
    for line in _lines(timeline, line_us):
        axis = Scale(0, max(1, round(room * line.part)), line.begin_us, line.end_us)
        lines.append(f"{'time [ms]':<{names}} {_labels(axis, room)}".rstrip())
        lines += [drawn.name(_title(lane), names) + _row(lane, axis, drawn) for lane in line.lanes]
        lines.append("")
    notes = [] if lines else [NOTHING]
    lines += [note for note in [*notes, _left_out(timeline, line_us)] if note]
    return drawn.finished(lines)


def _title(lane: Lane) -> str:
    """Return the name of a lane.

    For a curve it includes the least and the greatest value in the run.
    """
    if not lane.is_curve:
        return lane.name
    low, high = lane.limits()
    return f"{lane.name} {lane.text(low)} to {lane.text(high)}"


def _labels(axis: Scale, room: int) -> str:
    """Return the line with the time labels. Each label is above the column of its time."""
    line = ""
    for t_us, x in _marks(axis, max(1, axis.right // _APART)):
        label = time_labels([t_us])[0]
        if int(x) + len(label) <= room:
            line = f"{line:<{int(x)}}{label}"
    return line


def _row(lane: Lane, axis: Scale, drawn: Glyphs) -> str:
    whole = axis.end_us - axis.begin_us
    borders = [axis.begin_us + whole * k // axis.right for k in range(axis.right + 1)]
    counts = [lane.count(begin, end) for begin, end in pairwise(borders)]
    if lane.kind == "finding":
        return "".join(drawn.mark if count else " " for count in counts).rstrip()
    values = [lane.value_at(end - 1) for end in borders[1:]]
    if lane.is_curve:
        return "".join(_level(lane, value, drawn) for value in values)
    if lane.is_text:
        return "".join(_texts(lane, values, counts, drawn))
    row = ""
    for value, count in zip(values, counts, strict=True):
        level, edge = (drawn.high, drawn.rise) if value else (drawn.low, drawn.fall)
        row += drawn.cross if count > 1 else edge if count else level
    return row


def _level(lane: Lane, value: object, drawn: Glyphs) -> str:
    low, high = lane.limits()
    if not isinstance(value, (int, float)) or not low <= value <= high:
        return " "
    step = (value - low) / (high - low) if high > low else 0
    return drawn.levels[min(len(drawn.levels) - 1, int(step * len(drawn.levels)))]


def _texts(lane: Lane, values: list[Any], counts: list[int], drawn: Glyphs) -> Iterator[str]:
    """Yield a piece of the lane for each change, with the text of the value if it fits."""
    begins = [0, *(k for k, count in enumerate(counts) if count and k)]
    for begin, end in pairwise([*begins, len(values)]):
        value, width = values[begin], end - begin
        shown = "" if lane.is_idle(value) else drawn.cut(lane.short(value), width - 1)
        edge = drawn.cross if counts[begin] else drawn.idle
        yield edge + shown + drawn.idle * (width - 1 - len(shown))
