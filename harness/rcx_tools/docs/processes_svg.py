"""Drawing of a process as SVG: waveforms, numbered steps at their edges, and a legend."""

from __future__ import annotations

import textwrap
from html import escape
from itertools import pairwise

from rcx_harness.trace.chart import time_labels
from rcx_harness.trace.chart_svg import STYLE, Columns, Look, document, draw_lane, rule, text
from rcx_tools.docs.processes import ProcessChart, Track

__all__ = ["process_svg"]

_ROW, _GROUP, _PACE, _LINE = 34, 22, 24, 19
_LETTER = 7.3
_TEXT = 6.9
_LEAD = 34
_NARROW, _WIDE, _LEAST = 56, 120, 820
_WORD = 86
_PACING = "#c05a00"
_HIGH = Look.high
_STYLE = (
    STYLE + ".h{font-weight:bold;font-size:15px}.s{font-size:11px;fill:#666}"
    ".q{font-size:11px;font-weight:bold;fill:#555}.e{text-anchor:end}"
    ".n{font-size:10.5px;font-weight:bold;fill:#fff;text-anchor:middle}"
    f".p{{font-size:11px;fill:{_PACING};text-anchor:middle}}"
    ".gs{stroke:#bbb;stroke-width:1;stroke-dasharray:3 3}"
)


class _Page:
    """The SVG elements of a picture, and the height that they use."""

    def __init__(self, chart: ProcessChart) -> None:
        self.chart = chart
        self.instants = chart.instants
        self.labels = time_labels([t - chart.zero_us for t in self.instants])
        names = max(len(track.lane.name) for track in chart.tracks)
        left = 34 + round(_LETTER * names)
        words = any(track.lane.kind == "word" for track in chart.tracks)
        space = (_LEAST - left - _LEAD) // len(self.instants)
        column = max(_WORD if words else _NARROW, min(space, _WIDE))
        xs = [left + _LEAD + k * column for k in range(len(self.instants))]
        self.axis = Columns(left, max(xs[-1] + column, _LEAST - 12), xs, self.instants)
        self.width = self.axis.right + 12
        self.top = self.bottom = 0
        self.body: list[str] = []

    def text(self, x: float, y: float, words: str, kind: str = "") -> None:
        """Add a line of text to the picture."""
        self.body.append(text(x, y, words, kind))

    def x(self, t_us: int) -> int:
        """Return the horizontal position of the column for a time."""
        return self.axis.xs[self.instants.index(t_us)]

    def badge(self, x: float, y: float, number: int) -> None:
        """Add the number of a step in a circle."""
        self.body.append(f'<circle cx="{x:g}" cy="{y:g}" r="9" fill="#333"/>')
        self.text(x, y + 4, str(number), "n")

    def arrow(self, x1: float, x2: float, y: float, colour: str) -> None:
        """Add a dimension line from `x1` to `x2`."""
        tips = f"M{x1 + 5:g} {y - 3}L{x1 + 1:g} {y}L{x1 + 5:g} {y + 3}"
        tips += f"M{x2 - 5:g} {y - 3}L{x2 - 1:g} {y}L{x2 - 5:g} {y + 3}"
        self.body.append(
            f'<path stroke="{colour}" style="stroke-width:1" d="M{x1 + 1:g} {y}H{x2 - 1:g}{tips}"/>'
        )


def process_svg(chart: ProcessChart) -> str:
    """Return the picture as the text of an SVG file. The same run always gives the same bytes."""
    page = _Page(chart)
    process = chart.process
    page.text(12, 24, process.title, "h")
    note = "Times in ms from step 1, not to scale; the controller's answering times are assumed."
    for k, line in enumerate((f"Manual {process.section}; {process.seen}.", chart.timing, note)):
        page.text(12, 42 + 14 * k, line, "s")
    page.top = 80
    _times(page)
    first = page.top - 4
    _waves(page)
    guides = [_guide(page, k, first) for k in range(len(page.instants))]
    _legend(page)
    title = f"<title>{escape(process.title)}</title>"
    return document(page.width, page.top, _STYLE, [*guides, *page.body], [title])


def _times(page: _Page) -> None:
    """Draw the times of all changes, and the durations between two changes."""
    page.text(12, page.top + 14, "time [ms]", "q")
    for k, label in enumerate(page.labels):
        page.text(page.axis.xs[k], page.top + 14, label, "t")
    for k, (before, after) in enumerate(pairwise(page.instants)):
        middle = (page.axis.xs[k] + page.axis.xs[k + 1]) / 2
        page.text(middle, page.top + 29, f"+{time_labels([after - before])[0]}", "d")
    page.top += 36
    page.bottom = page.top


def _waves(page: _Page) -> None:
    """Draw the lanes by group. The intervals of the dedicated inputs are below their lanes."""
    tracks = page.chart.tracks
    for k, track in enumerate(tracks):
        if k == 0 or track.group != tracks[k - 1].group:
            page.text(12, page.top + 15, track.group, "q")
            page.top += _GROUP
        base = page.top + 3 + _HIGH
        line = base + 9
        page.body.append(rule("r", 8, line, page.axis.right, line))
        page.text(22, base - 4, track.lane.name)
        page.body += draw_lane(track.lane, page.axis, base)
        _badges(page, track, base)
        page.top += _ROW
        last = k + 1 == len(tracks) or tracks[k + 1].group != track.group
        if last and track.signal.startswith("SI"):
            _pace(page)
    page.bottom = page.top
    page.top += 6


def _badges(page: _Page, track: Track, base: int) -> None:
    """Draw the numbers of the steps that have an edge on this lane."""
    for step in page.chart.steps:
        for signal, t_us in step.edges:
            if signal != track.signal:
                continue
            x = page.x(t_us)
            on = track.lane.value_at(t_us)
            if track.lane.kind == "word":
                page.badge(x - 13 if on else x + 13, base - _HIGH // 2, step.number)
            else:
                page.badge(x - 16 if on else x + 16, base - _HIGH + 6, step.number)


def _pace(page: _Page) -> None:
    """Draw the intervals between changes of the dedicated inputs."""
    inputs = page.chart.inputs
    if len(inputs) < 2:
        return
    y = page.top + 8
    page.text(22, y + 4, "interval between inputs [ms]", "s")
    for before, after in pairwise(inputs):
        x1, x2 = page.x(before), page.x(after)
        label = time_labels([after - before])[0]
        room = len(label) * _LETTER / 2 + 4
        middle = (x1 + x2) / 2
        page.arrow(x1, x2, y, _PACING)
        place = f'x="{middle - room:g}" y="{y - 7}" width="{2 * room:g}" height="14"'
        page.body.append(f'<rect {place} fill="#fff"/>')
        page.text(middle, y + 4, label, "p")
    page.top += _PACE


def _guide(page: _Page, column: int, first: int) -> str:
    """Return the vertical line of a column. The line of a step reaches up to the step's time."""
    steps = [t_us for step in page.chart.steps for _, t_us in step.edges]
    kind = "gs" if page.instants[column] in steps else "g"
    x = page.axis.xs[column]
    return rule(kind, x, first, x, page.bottom)


def _legend(page: _Page) -> None:
    """Draw the text of each step, its time, and the time since the previous step."""
    page.top += 10
    times, gaps = _LEAST - 130, _LEAST - 16
    page.body.append(
        f'<line x1="8" y1="{page.top}" x2="{page.width - 8}" y2="{page.top}" stroke="#999"/>'
    )
    page.text(12, page.top + 17, "Step", "q")
    page.text(times, page.top + 17, "at [ms]", "q e")
    page.text(gaps, page.top + 17, "since last [ms]", "q e")
    page.top += 30
    room = int((times - 70 - 46) / _TEXT)
    for step in page.chart.steps:
        y = page.top + 6
        page.badge(22, y, step.number)
        lines = textwrap.wrap(step.text, room)
        for k, line in enumerate(lines):
            page.text(40, y + 4 + k * _LINE, line)
        page.text(times, y + 4, step.at, "e")
        page.text(gaps, y + 4, step.since_last, "e")
        page.top += _LINE * len(lines) + 4
    page.top += 8
