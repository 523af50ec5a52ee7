"""The timing chart as an SVG picture.

Drawn here and not by a library: the charts of wavedrom are one endless row, their names and
values are cut to a brick's width, and they cannot print a time above each change.
"""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from rcx_harness.chart import Band, Lane, Timeline, time_labels

__all__ = ["svg_chart"]

_COLUMN, _ROW, _HIGH = 74, 30, 18
_LETTER = 7.6
_COLUMNS = 12
_LEAD = 24
_HEAD = 46
_GAP = 18
_EDGE = 4
_COLOURS = {"input": "#1f5fa8", "output": "#1b7a3d", "word": "#6a4a8f", "finding": "#c02020"}
_STYLE = (
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
        f"<style>{_STYLE}</style>",
        f'<rect width="{width}" height="{top}" fill="#fff"/>',
        f'<text x="12" y="24" font-weight="bold">{escape(title)}</text>',
    ]
    return "\n".join([*head, *body, "</svg>", ""])


@dataclass(frozen=True)
class _Frame:
    """Where the waves of a band lie: from `left` to `right`."""

    left: int
    right: int

    def x(self, column: int) -> int:
        """Where the change of a column is drawn."""
        return self.left + _LEAD + column * _COLUMN


def _band(band: Band, labels: list[str], left: int, top: int, last: int | None) -> list[str]:
    first, bottom = top + _HEAD - 8, top + _HEAD + len(band.lanes) * _ROW - 6
    frame = _Frame(left, left + _LEAD + len(band.instants) * _COLUMN)
    parts = [f'<text x="12" y="{top + 20}">time [ms]</text>']
    for column, (t_us, label) in enumerate(zip(band.instants, labels, strict=True)):
        x = frame.x(column)
        parts.append(f'<line class="g" x1="{x}" y1="{first}" x2="{x}" y2="{bottom}"/>')
        parts.append(f'<text class="t" x="{x}" y="{top + 20}">{label}</text>')
        if last is not None:
            gap = time_labels([t_us - last])[0]
            parts.append(f'<text class="d" x="{x}" y="{top + 33}">+{gap}</text>')
        last = t_us
    for row, lane in enumerate(band.lanes):
        base = top + _HEAD + row * _ROW + _HIGH
        parts.append(f'<line class="r" x1="8" y1="{base + 7}" x2="{frame.right}" y2="{base + 7}"/>')
        parts.append(f'<text x="12" y="{base - 4}">{escape(lane.name)}</text>')
        draw = {"word": _word, "finding": _finding}.get(lane.kind, _bit)
        parts += draw(lane, band, base, frame)
    return parts


def _bit(lane: Lane, band: Band, base: int, frame: _Frame) -> list[str]:
    value = lane.value_at(band.instants[0] - 1)
    y = base - _HIGH if value else base
    path = [f"M{frame.left} {y}"]
    for column, t_us in enumerate(band.instants):
        new = lane.value_at(t_us)
        if new != value:
            x = frame.x(column)
            y = base - _HIGH if new else base
            path.append(f"H{x - _EDGE}L{x + _EDGE} {y}")
            value = new
    path.append(f"H{frame.right}")
    return [f'<path stroke="{_COLOURS[lane.kind]}" d="{"".join(path)}"/>']


def _word(lane: Lane, band: Band, base: int, frame: _Frame) -> list[str]:
    """Zero is a line in the middle, any other value a box with its digits."""
    spans = [(frame.left, lane.value_at(band.instants[0] - 1))]
    for column, t_us in enumerate(band.instants):
        value = lane.value_at(t_us)
        if value != spans[-1][1]:
            spans.append((frame.x(column), value))
    colour, middle = _COLOURS["word"], base - _HIGH // 2
    parts = []
    for (x, value), end in zip(spans, [x for x, _ in spans[1:]] + [frame.right], strict=True):
        if not value:
            parts.append(f'<path stroke="{colour}" d="M{x} {middle}H{end}"/>')
            continue
        top = base - _HIGH
        parts.append(
            f'<path stroke="{colour}" d="M{x} {middle}L{x + _EDGE} {top}H{end - _EDGE}'
            f'L{end} {middle}L{end - _EDGE} {base}H{x + _EDGE}Z"/>'
        )
        parts.append(f'<text class="v" x="{x + _EDGE + 5}" y="{base - 5}">0x{value:04X}</text>')
    return parts


def _finding(lane: Lane, band: Band, base: int, frame: _Frame) -> list[str]:
    return [
        f'<path style="fill:{_COLOURS["finding"]}" d="M{frame.x(column) - 6} {base}h12l-6 -13Z"/>'
        for column, t_us in enumerate(band.instants)
        if lane.changes_at(t_us)
    ]
