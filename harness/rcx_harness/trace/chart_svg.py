"""The timing chart as an SVG picture.

Drawn here and not by a library: the charts of wavedrom are one endless row, their names and
values are cut to a brick's width, and they cannot print a time above each change.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from html import escape

from rcx_harness.trace.chart import Band, Lane, Timeline, time_labels

__all__ = ["COLOURS", "HIGH", "WAVE_STYLE", "Frame", "draw_lane", "svg_chart"]

#: Height of a wave in pixels.
HIGH = 18

_COLUMN, _ROW = 74, 30
_LETTER = 7.6
_COLUMNS = 12
_LEAD = 24
_HEAD = 46
_GAP = 18
_EDGE = 4

#: Colour of a wave by the kind of its lane.
COLOURS = {
    "input": "#1f5fa8",
    "output": "#1b7a3d",
    "word": "#6a4a8f",
    "variable": "#444444",
    "event": "#9a5b12",
    "finding": "#c02020",
}

#: Style sheet of texts, waves and lines.
WAVE_STYLE = (
    "text{font:13px 'DejaVu Sans',Arial,sans-serif;fill:#222}"
    ".t{font-size:12px;text-anchor:middle}.d{font-size:10px;fill:#888;text-anchor:middle}"
    ".v{font:12px 'DejaVu Sans Mono',monospace}"
    ".g{stroke:#ddd;stroke-width:1}.r{stroke:#eee;stroke-width:1}"
    "path{fill:none;stroke-width:1.8;stroke-linejoin:round}"
)


def svg_chart(timeline: Timeline, title: str = "") -> str:
    """The chart as the text of an SVG file; the same run gives the same bytes.

    Args:
        timeline: What to draw.
        title: A line above the chart.
    """
    bands = timeline.bands(_COLUMNS)
    labels = time_labels([t_us for band in bands for t_us in band.instants])
    names = [lane.name for lane in timeline.lanes()]
    left = 24 + round(_LETTER * max(map(len, names)))
    widest = max((len(band.instants) for band in bands), default=1)
    width = left + _LEAD + widest * _COLUMN + 10
    top = 44
    body: list[str] = []
    last: int | None = None
    for number, band in enumerate(bands):
        times = labels[number * _COLUMNS : (number + 1) * _COLUMNS]
        body += _band(band, times, left, top, last)
        last = band.instants[-1]
        top += _HEAD + len(band.lanes) * _ROW + _GAP
    if not bands:
        body.append('<text x="12" y="60">no dedicated signal and no remote command changed</text>')
        top = 80
    if timeline.left_out():
        note = f"{timeline.left_out()} further instants are left out; the wave file has them all"
        body.append(f'<text x="12" y="{top + 6}">{note}</text>')
        top += _ROW
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{top}" '
        f'viewBox="0 0 {width} {top}">',
        f"<style>{WAVE_STYLE}</style>",
        f'<rect width="{width}" height="{top}" fill="#fff"/>',
        f'<text x="12" y="24" font-weight="bold">{escape(title)}</text>',
    ]
    return "\n".join([*head, *body, "</svg>", ""])


@dataclass(frozen=True)
class Frame:
    """Where waves lie: from `left` to `right`, the change of column k at `xs[k]`."""

    left: int
    right: int
    xs: Sequence[int]


def draw_lane(lane: Lane, instants: Sequence[int], base: int, frame: Frame) -> list[str]:
    """The elements of one wave.

    Args:
        lane: What to draw.
        instants: The times of the columns [us].
        base: Where OFF is drawn; ON is `HIGH` above it.
        frame: Where the columns are.
    """
    draw = {"word": _word, "finding": _finding}.get(lane.kind, _bit)
    return draw(lane, instants, base, frame)


def _band(band: Band, labels: list[str], left: int, top: int, last: int | None) -> list[str]:
    first, bottom = top + _HEAD - 8, top + _HEAD + len(band.lanes) * _ROW - 6
    count = len(band.instants)
    xs = [left + _LEAD + column * _COLUMN for column in range(count)]
    frame = Frame(left, left + _LEAD + count * _COLUMN, xs)
    parts = [f'<text x="12" y="{top + 20}">time [ms]</text>']
    for column, (t_us, label) in enumerate(zip(band.instants, labels, strict=True)):
        x = frame.xs[column]
        parts.append(f'<line class="g" x1="{x}" y1="{first}" x2="{x}" y2="{bottom}"/>')
        parts.append(f'<text class="t" x="{x}" y="{top + 20}">{label}</text>')
        if last is not None:
            gap = time_labels([t_us - last])[0]
            parts.append(f'<text class="d" x="{x}" y="{top + 33}">+{gap}</text>')
        last = t_us
    for row, lane in enumerate(band.lanes):
        base = top + _HEAD + row * _ROW + HIGH
        parts.append(f'<line class="r" x1="8" y1="{base + 7}" x2="{frame.right}" y2="{base + 7}"/>')
        parts.append(f'<text x="12" y="{base - 4}">{escape(lane.name)}</text>')
        parts += draw_lane(lane, band.instants, base, frame)
    return parts


def _bit(lane: Lane, instants: Sequence[int], base: int, frame: Frame) -> list[str]:
    value = lane.value_at(instants[0] - 1)
    y = base - HIGH if value else base
    path = [f"M{frame.left} {y}"]
    for column, t_us in enumerate(instants):
        new = lane.value_at(t_us)
        if new != value:
            x = frame.xs[column]
            y = base - HIGH if new else base
            path.append(f"H{x - _EDGE}L{x + _EDGE} {y}")
            value = new
    path.append(f"H{frame.right}")
    return [f'<path stroke="{COLOURS[lane.kind]}" d="{"".join(path)}"/>']


def _word(lane: Lane, instants: Sequence[int], base: int, frame: Frame) -> list[str]:
    """Zero is a line in the middle, any other value a box with its digits."""
    spans = [(frame.left, lane.value_at(instants[0] - 1))]
    for column, t_us in enumerate(instants):
        value = lane.value_at(t_us)
        if value != spans[-1][1]:
            spans.append((frame.xs[column], value))
    colour, middle = COLOURS["word"], base - HIGH // 2
    parts = []
    for (x, value), end in zip(spans, [x for x, _ in spans[1:]] + [frame.right], strict=True):
        if not value:
            parts.append(f'<path stroke="{colour}" d="M{x} {middle}H{end}"/>')
            continue
        top = base - HIGH
        parts.append(
            f'<path stroke="{colour}" d="M{x} {middle}L{x + _EDGE} {top}H{end - _EDGE}'
            f'L{end} {middle}L{end - _EDGE} {base}H{x + _EDGE}Z"/>'
        )
        parts.append(f'<text class="v" x="{x + _EDGE + 5}" y="{base - 5}">0x{value:04X}</text>')
    return parts


def _finding(lane: Lane, instants: Sequence[int], base: int, frame: Frame) -> list[str]:
    return [
        f'<path style="fill:{COLOURS["finding"]}" d="M{frame.xs[column] - 6} {base}h12l-6 -13Z"/>'
        for column, t_us in enumerate(instants)
        if lane.changes_at(t_us)
    ]
