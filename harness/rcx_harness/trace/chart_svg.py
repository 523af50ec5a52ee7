"""Timing charts as SVG pictures: the drawing of lanes, and the chart of a run.

The drawing uses no library. A chart of wavedrom, for example, is one endless row, cuts names and
values to a fixed width, and cannot print a time above each change.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from html import escape
from itertools import accumulate, pairwise
from math import ceil, isfinite
from typing import Any

from rcx_harness.trace.chart import (
    LONGEST_TEXT,
    NOTHING,
    Band,
    Lane,
    Timeline,
    column_widths,
    time_labels,
)

__all__ = [
    "COLOURS",
    "CURVE",
    "STYLE",
    "Columns",
    "Look",
    "Scale",
    "document",
    "draw_lane",
    "rule",
    "svg_chart",
    "text",
]

#: Height of a curve in pixels.
CURVE = 40

_COLUMN, _ROW = 74, 30
#: Width of a letter in pixels, for three uses: in a name, in a small box, in a value.
_LETTER, _SMALL, _VALUE = 7.6, 5.9, 7.3
#: Width for the columns of a band, in pixels.
_ROOM = 12 * _COLUMN
_LEAD = 24
_HEAD = 46
_GAP = 18

#: Times of a curve [us]: a curve is at rest after the first time without a change; the second is
#: the time between two points; the third is the duration of a step.
_REST_US, _FINE_US, _STEP_US = 20_000, 15_000, 5_000

#: Colour of a wave by the kind of its lane.
COLOURS = {
    "input": "#1f5fa8",
    "output": "#1b7a3d",
    "word": "#6a4a8f",
    "value": "#444444",
    "stage": "#6a4a8f",
    "task": "#0b6f7d",
    "curve": "#a03a6a",
    "variable": "#444444",
    "event": "#9a5b12",
    "finding": "#c02020",
}

#: Style sheet of texts, waves and lines.
STYLE = (
    "text{font:13px 'DejaVu Sans',Arial,sans-serif;fill:#222}"
    ".t{font-size:12px;text-anchor:middle}.d{font-size:10px;fill:#888;text-anchor:middle}"
    ".v{font:12px 'DejaVu Sans Mono',monospace}"
    ".g{stroke:#ddd;stroke-width:1}.r{stroke:#eee;stroke-width:1}"
    "path{fill:none;stroke-width:1.8;stroke-linejoin:round}"
)

#: A piece of a lane: start position, end position, value.
_Span = tuple[float, float, Any]


@dataclass(frozen=True)
class Columns:
    """A time axis that is not to scale: each instant has a column; column k begins at `xs[k]`."""

    left: int
    right: int
    xs: Sequence[int]
    instants: Sequence[int]

    def spans(self, lane: Lane) -> list[_Span]:
        """Return the values of a lane from left to right."""
        found: list[tuple[float, Any]] = [(self.left, lane.value_at(self.instants[0] - 1))]
        for x, t_us in zip(self.xs, self.instants, strict=True):
            value = lane.value_at(t_us)
            if value != found[-1][1]:
                found.append((x, value))
        ends = [*(x for x, _ in found[1:]), self.right]
        return [(x, end, value) for (x, value), end in zip(found, ends, strict=True)]

    def marks(self, lane: Lane) -> list[float]:
        """Return the positions at which a lane has a change."""
        columns = zip(self.xs, self.instants, strict=True)
        return [x for x, t_us in columns if lane.changes_at(t_us)]


@dataclass(frozen=True)
class Scale:
    """A time axis that is true to scale."""

    left: int
    right: int
    begin_us: int
    end_us: int

    def x(self, t_us: int) -> float:
        """Return the position of a time, rounded to 0.1 pixel to be equal on every machine."""
        scale = (self.right - self.left) / (self.end_us - self.begin_us)
        return round(self.left + (t_us - self.begin_us) * scale, 1)

    def spans(self, lane: Lane) -> list[_Span]:
        """Return the values of a lane from left to right. Values before the time 0 are left out."""
        spans = lane.spans(max(self.begin_us, 0), self.end_us)
        return [(self.x(start), self.x(stop), value) for start, stop, value in spans]

    def marks(self, lane: Lane) -> list[float]:
        """Return the positions at which a lane has a change."""
        return [self.x(t_us) for t_us, _ in lane.changes if self.begin_us <= t_us < self.end_us]

    def round_times(self, steps_us: Sequence[int], most: int) -> Iterator[tuple[int, float]]:
        """Yield times and positions of the time marks. There are at most `most` marks."""
        whole = self.end_us - self.begin_us
        step = next((one for one in steps_us if whole / one <= most), steps_us[-1])
        for t_us in range(-(-max(self.begin_us, 0) // step) * step, self.end_us + 1, step):
            yield t_us, self.x(t_us)


@dataclass(frozen=True)
class Look:
    """The appearance of lanes, in pixels.

    Attributes:
        high: Height from OFF to ON.
        edge: Half the width of an edge.
        digits: Offset of the digits of a word: to the right of the edge, and above the OFF level.
        room: Least width of a box that shows digits.
        filled: Whether ON is drawn as a filled area, and boxes show their digits as tooltips.
        whole: Whether a curve is scaled to the values of the whole run instead of the shown part.
            Such a curve has as many points as are visible.
    """

    high: int = 18
    edge: int = 4
    digits: tuple[int, int] = (9, 5)
    room: int = 0
    filled: bool = False
    whole: bool = False


_PLAIN = Look()


def text(x: float, y: float, words: str, kind: str = "") -> str:
    """Return the SVG element of a text, with a class of the style sheet."""
    shown = f' class="{kind}"' if kind else ""
    return f'<text{shown} x="{x:g}" y="{y:g}">{escape(words)}</text>'


def rule(kind: str, x1: float, y1: float, x2: float, y2: float) -> str:
    """Return the SVG element of a straight line, with a class of the style sheet."""
    return f'<line class="{kind}" x1="{x1:g}" y1="{y1:g}" x2="{x2:g}" y2="{y2:g}"/>'


def document(
    width: int, height: int, style: str, body: Iterable[str], before: Iterable[str] = ()
) -> str:
    """Return the text of an SVG file. `before` is text in front of the style sheet."""
    size = f'width="{width}" height="{height}"'
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {width} {height}">',
        *before,
        f"<style>{style}</style>",
        f'<rect {size} fill="#fff"/>',
        *body,
    ]
    return "\n".join([*lines, "</svg>", ""])


def draw_lane(lane: Lane, axis: Columns | Scale, base: int, look: Look = _PLAIN) -> list[str]:
    """Return the SVG elements of one lane.

    Words and values are drawn as boxes with texts, stages as boxes with names, and broken rules as
    marks. Another lane is a wave, or consists of boxes if it has values other than 0 and 1. A curve
    is a line if the time axis is to scale, else its values are shown as text. `base` is the
    vertical position of the OFF level.
    """
    colour = COLOURS[lane.kind]
    if lane.kind == "finding":
        return [
            f'<path style="fill:{colour}" d="M{x - 6:g} {base}h12l-6 -13Z"/>'
            for x in axis.marks(lane)
        ]
    spans = axis.spans(lane)
    if not spans:
        return []
    if lane.is_curve and isinstance(axis, Scale):
        return _curve(lane, axis, base, colour, look)
    if lane.is_text:
        return _texts(lane, spans, base, colour, look)
    if lane.kind == "stage" or any(value not in (0, 1) for _, value in lane.changes):
        return _boxes(spans, base, colour, _names(lane), look)
    return _wave(spans, base, colour, look)


def _wave(spans: Sequence[_Span], base: int, colour: str, look: Look) -> list[str]:
    parts = []
    if look.filled:
        parts = [
            _box(x, end, base, f'class="f" fill="{colour}"', look) for x, end, on in spans if on
        ]
    path = f"M{spans[0][0]:g} {base - look.high if spans[0][2] else base}"
    for x, _, value in spans[1:]:
        y = base - look.high if value else base
        edge = f"H{x - look.edge:g}L{x + look.edge:g} {y}" if look.edge else f"H{x:g}V{y}"
        path += edge
    return [*parts, f'<path stroke="{colour}" d="{path}H{spans[-1][1]:g}"/>']


def _texts(lane: Lane, spans: Sequence[_Span], base: int, colour: str, look: Look) -> list[str]:
    """Return the elements of a lane with texts: a line for the word 0, a box for another value.

    A box contains the text of the value if it fits.
    """
    middle, top, edge = base - look.high // 2, base - look.high, look.edge
    parts = []
    for x, end, value in spans:
        if lane.is_idle(value):
            parts.append(f'<path stroke="{colour}" d="M{x:g} {middle}H{end:g}"/>')
            continue
        box = (
            f"M{x:g} {middle}L{x + edge:g} {top}H{end - edge:g}L{end:g} {middle}"
            f"L{end - edge:g} {base}H{x + edge:g}Z"
        )
        whole = lane.text(value)
        shown = _fitting(whole, end - x, look)
        tip = f"><title>{escape(whole)}</title></path>" if look.filled or shown != whole else "/>"
        parts.append(f'<path stroke="{colour}" d="{box}"{tip}')
        if shown:
            parts.append(text(x + look.digits[0], base - look.digits[1], shown, "v"))
    return parts


def _fitting(whole: str, width: float, look: Look) -> str:
    """Return the part of a text that fits into its box. If too few letters fit, it is empty."""
    if look.room:
        return whole if width >= look.room * len(whole) / 6 else ""
    letters = int((width - look.digits[0] - look.edge) / _VALUE)
    if letters >= len(whole):
        return whole
    return whole[: letters - 1] + "…" if letters > 3 else ""


def _box(x: float, end: float, base: int, more: str, look: Look) -> str:
    place = f'x="{x:g}" y="{base - look.high}" width="{end - x:.1f}" height="{look.high}"'
    return f"<rect {place} {more}/>"


def _names(lane: Lane) -> dict[Any, str]:
    """Return the names of a lane's values; names of an enumeration lose their common prefix."""
    shown = {value: str(value) for _, value in lane.changes}
    if lane.kind != "stage":
        return shown
    first = {name.partition("_")[0] for name in shown.values()}
    common = len(first.pop()) + 1 if len(first) == 1 else 0
    return {value: name[common:].replace("_", " ").lower() for value, name in shown.items()}


def _boxes(
    spans: Sequence[_Span], base: int, colour: str, names: dict[Any, str], look: Look
) -> list[str]:
    """Return a box for each value of a lane. A box contains the name of the value if it fits."""
    parts = []
    for x, end, value in spans:
        parts.append(_box(x, end, base, f'fill="#f6f3fa" stroke="{colour}"', look))
        name = names.get(value, str(value))
        if len(name) * _SMALL < end - x - 4:
            place = f'x="{(x + end) / 2:.1f}" y="{base - 5}"'
            parts.append(f'<text class="b" {place}>{escape(name)}</text>')
    return parts


def _curve(lane: Lane, axis: Scale, base: int, colour: str, look: Look) -> list[str]:
    """Return the elements of a curve, with its least and greatest value on the left."""
    numbers = (int, float)
    spans = [
        span
        for span in lane.spans(axis.begin_us, axis.end_us)
        if isinstance(span[2], numbers) and isfinite(span[2])
    ]
    if not spans:
        return []
    values = [value for _, _, value in spans]
    low, high = lane.limits() if look.whole else (min(values), max(values))
    scale = CURVE / (high - low) if high != low else 0

    def y(value: Any) -> float:
        return float(round(base - (value - low) * scale, 1))

    path = f"M{axis.left} {y(values[0]):g}"
    fine_us = 2 * (axis.end_us - axis.begin_us) // (axis.right - axis.left)
    for t_us, value, rests_since in _bends(spans, fine_us if look.whole else _FINE_US):
        path += f"H{axis.x(rests_since):g}" if rests_since else ""
        path += f"L{axis.x(t_us):g} {y(value):g}"
    parts = [f'<path stroke="{colour}" d="{path}H{axis.right:g}"/>']
    parts.append(text(axis.left - 6, base + 2, f"{low:g}", "m e"))
    if high != low:
        parts.append(text(axis.left - 6, base - CURVE + 4, f"{high:g}", "m e"))
    return parts


def _bends(spans: Sequence[tuple[int, int, Any]], fine_us: int) -> Iterator[tuple[int, Any, int]]:
    """Yield the drawn points of a curve: time, value, end of the rest before it (0: no rest)."""
    drawn_us = spans[0][0]
    for (before_us, _, _), (start, stop, value) in pairwise(spans):
        rested = start - before_us > _REST_US
        if rested or stop - start > _REST_US or start - drawn_us >= fine_us:
            yield start, value, start - _STEP_US if rested else 0
            drawn_us = start


def svg_chart(timeline: Timeline, title: str = "") -> str:
    """Return the chart of a run as SVG. The same run gives the same bytes."""
    bands = timeline.bands(column_widths(timeline, _COLUMN, _box_width), _ROOM)
    labels = time_labels([t_us for band in bands for t_us in band.instants])
    names = [lane.name for lane in timeline.lanes()]
    left = 24 + round(_LETTER * max(map(len, names), default=0))
    widest = max((_lead(band) + sum(band.widths) for band in bands), default=_LEAD + _COLUMN)
    width = left + widest + 10
    top = 44
    body = [f'<text x="12" y="24" font-weight="bold">{escape(title)}</text>']
    last: int | None = None
    for band in bands:
        times, labels = labels[: len(band.instants)], labels[len(band.instants) :]
        body += _band(band, times, left, top, last)
        last = band.instants[-1]
        top += _HEAD + len(band.lanes) * _ROW + _GAP
    if not bands:
        body.append(text(12, 60, NOTHING))
        top = 80
    if timeline.left_out():
        note = f"{timeline.left_out()} further instants are left out; the wave file has them all"
        body.append(text(12, top + 6, note))
        top += _ROW
    return document(width, top, STYLE, body)


def _lead(band: Band) -> int:
    """Return the width of the space before the first column.

    It shows the values before the first change.
    """
    wanted = [_LEAD]
    for lane in band.lanes:
        before, then = (lane.value_at(band.instants[0] - back) for back in (1, 0))
        if lane.is_text and before != then and not lane.is_idle(before):
            wanted.append(_box_width(min(len(lane.text(before)), LONGEST_TEXT)))
    return max(wanted)


def _box_width(letters: int) -> int:
    return ceil(letters * _VALUE) + _PLAIN.digits[0] + _PLAIN.edge


def _band(band: Band, labels: list[str], left: int, top: int, last: int | None) -> list[str]:
    first, bottom = top + _HEAD - 8, top + _HEAD + len(band.lanes) * _ROW - 6
    *xs, right = accumulate(band.widths, initial=left + _lead(band))
    axis = Columns(left, right, xs, band.instants)
    parts = [text(12, top + 20, "time [ms]")]
    for x, t_us, label in zip(xs, band.instants, labels, strict=True):
        parts += [rule("g", x, first, x, bottom), text(x, top + 20, label, "t")]
        if last is not None:
            parts.append(text(x, top + 33, f"+{time_labels([t_us - last])[0]}", "d"))
        last = t_us
    for row, lane in enumerate(band.lanes):
        base = top + _HEAD + row * _ROW + _PLAIN.high
        parts.append(rule("r", 8, base + 7, axis.right, base + 7))
        parts.append(text(12, base - 4, lane.name))
        parts += draw_lane(lane, axis, base)
    return parts
