"""A run as an SVG picture, true to scale in time: waves, stages by their names, curves.

The charts of the processes show every change under its time; this one shows how long things take.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from html import escape
from itertools import pairwise
from typing import Any

from rcx_harness.trace.chart_svg import COLOURS, HIGH, WAVE_STYLE

__all__ = ["Track", "run_svg"]

_WIDTH, _ROW, _CURVE, _TOP = 1080, 28, 54, 44
_LETTER, _SMALL = 7.3, 5.9
#: Distances of the time marks [us]: the first that leaves not more than `_MOST_MARKS`.
_MARKS = (50_000, 100_000, 200_000, 500_000, 1_000_000, 2_000_000, 5_000_000)
_MOST_MARKS = 12
#: A curve that does not change for so long is at rest; on the way it has a point so often; a step
#: takes so long [us].
_REST_US, _FINE_US, _STEP_US = 20_000, 15_000, 5_000
_CURVE_COLOUR = "#a03a6a"
_STYLE = (
    WAVE_STYLE + ".b{font-size:10.5px;text-anchor:middle}.m{font-size:10px;fill:#777}"
    ".e{text-anchor:end}.h{font-weight:bold;font-size:15px}"
)


@dataclass
class Track:
    """A lane: its changes as (time [us], value), from the first value on.

    `kind` is one of the keys of `COLOURS` for a wave or for values in boxes, `stage` for the names
    of an enumeration, `curve` for a number over time.
    """

    label: str
    kind: str
    changes: list[tuple[int, Any]] = field(default_factory=list)

    def note(self, t_us: int, value: Any) -> None:
        """The value from `t_us` on."""
        if not self.changes or self.changes[-1][1] != value:
            self.changes.append((t_us, value))

    def spans(self, begin_us: int, end_us: int) -> Iterator[tuple[int, int, Any]]:
        """From, to, value, within these times; values that come and go in no time are left out."""
        ends = [t_us for t_us, _ in self.changes[1:]] + [end_us]
        for (start, value), stop in zip(self.changes, ends, strict=True):
            if max(start, begin_us) < min(stop, end_us):
                yield max(start, begin_us), min(stop, end_us), value


@dataclass(frozen=True)
class _Frame:
    """Where times lie on the picture."""

    left: float
    begin_us: int
    end_us: int

    def x(self, t_us: int) -> float:
        """A tenth of a pixel is enough, and the same on every machine."""
        scale = (_WIDTH - 12 - self.left) / (self.end_us - self.begin_us)
        return round(self.left + (t_us - self.begin_us) * scale, 1)


def run_svg(title: str, tracks: Sequence[Track], begin_us: int, end_us: int) -> str:
    """The picture as the text of an SVG file; the same run gives the same bytes.

    Args:
        title: A line above the chart.
        tracks: The lanes from top to bottom.
        begin_us: Where the chart begins; its times are those of the run.
        end_us: Where it ends.
    """
    left = 30 + round(_LETTER * max(len(track.label) for track in tracks))
    frame = _Frame(left, begin_us, end_us)
    body: list[str] = []
    top = _TOP + 24
    for track in tracks:
        high = _CURVE if track.kind == "curve" else _ROW
        line = top + high
        body.append(f'<line class="r" x1="8" y1="{line}" x2="{_WIDTH - 12}" y2="{line}"/>')
        body.append(f'<text x="12" y="{top + high / 2 + 5:g}">{escape(track.label)}</text>')
        body += _lane(track, frame, line - 6)
        top = line
    size = f'width="{_WIDTH}" height="{top + 12}"'
    head = [
        f'<svg xmlns="http://www.w3.org/2000/svg" {size} viewBox="0 0 {_WIDTH} {top + 12}">',
        f"<title>{escape(title)}</title>",
        "<!-- generated from plc/examples/charts.toml and a run of the example; do not edit -->",
        f"<style>{_STYLE}</style>",
        f'<rect {size} fill="#fff"/>',
        f'<text class="h" x="12" y="24">{escape(title)}</text>',
        *_marks(frame, top),
    ]
    return "\n".join([*head, *body, "</svg>", ""])


def _marks(frame: _Frame, bottom: int) -> Iterator[str]:
    """Time marks, and the lines below them."""
    whole = frame.end_us - frame.begin_us
    step = next((one for one in _MARKS if whole / one <= _MOST_MARKS), _MARKS[-1])
    yield f'<text class="m" x="12" y="{_TOP + 12}">time [s]</text>'
    for t_us in range(-(-frame.begin_us // step) * step, frame.end_us + 1, step):
        x = frame.x(t_us)
        yield f'<text class="t" x="{x:g}" y="{_TOP + 12}">{t_us / 1e6:g}</text>'
        yield f'<line class="g" x1="{x:g}" y1="{_TOP + 18}" x2="{x:g}" y2="{bottom}"/>'


def _lane(track: Track, frame: _Frame, base: int) -> Iterator[str]:
    spans = list(track.spans(frame.begin_us, frame.end_us))
    if track.kind == "curve":
        yield from _curve(spans, frame, base)
    elif all(value in (0, 1) for _, value in track.changes):
        levels = [(start, base - HIGH if value else base) for start, _, value in spans]
        path = f"M{frame.left} {levels[0][1]}"
        path += "".join(f"H{frame.x(t_us):g}V{y}" for t_us, y in levels[1:])
        colour = COLOURS[track.kind]
        yield f'<path stroke="{colour}" d="{path}H{frame.x(frame.end_us):g}"/>'
    else:
        yield from _boxes(track, spans, frame, base)


def _boxes(
    track: Track, spans: Sequence[tuple[int, int, Any]], frame: _Frame, base: int
) -> Iterator[str]:
    """A box for each value, its name in it where there is room."""
    names = {str(value) for _, value in track.changes}
    common = _prefix(names) if track.kind == "stage" else 0
    colour = COLOURS["word" if track.kind == "stage" else track.kind]
    for start, stop, value in spans:
        x1, x2 = frame.x(start), frame.x(stop)
        shown = str(value)[common:].replace("_", " ").lower() if track.kind == "stage" else value
        yield (
            f'<rect x="{x1:g}" y="{base - HIGH}" width="{x2 - x1:.1f}" height="{HIGH}" '
            f'fill="#f6f3fa" stroke="{colour}"/>'
        )
        if len(str(shown)) * _SMALL < x2 - x1 - 4:
            middle = (x1 + x2) / 2
            text = escape(str(shown))
            yield f'<text class="b" x="{middle:.1f}" y="{base - 5}">{text}</text>'


def _prefix(names: set[str]) -> int:
    """Characters up to the underscore that all names of an enumeration share."""
    first = {name.partition("_")[0] for name in names}
    return len(first.pop()) + 1 if len(first) == 1 else 0


def _curve(spans: Sequence[tuple[int, int, Any]], frame: _Frame, base: int) -> Iterator[str]:
    """A number over time, its least and its greatest value at the left."""
    values = [value for _, _, value in spans]
    low, high = min(values), max(values)
    room = _CURVE - 14
    scale = room / (high - low) if high != low else 0

    def y(value: Any) -> float:
        return float(round(base - (value - low) * scale, 1))

    path = f"M{frame.left:g} {y(values[0]):g}"
    for t_us, value, rests_since in _bends(spans):
        path += f"H{frame.x(rests_since):g}" if rests_since else ""
        path += f"L{frame.x(t_us):g} {y(value):g}"
    yield f'<path stroke="{_CURVE_COLOUR}" d="{path}H{frame.x(frame.end_us):g}"/>'
    yield f'<text class="m e" x="{frame.left - 6:g}" y="{base + 2}">{low:g}</text>'
    if high != low:
        yield f'<text class="m e" x="{frame.left - 6:g}" y="{base - room + 4}">{high:g}</text>'


def _bends(spans: Sequence[tuple[int, int, Any]]) -> Iterator[tuple[int, Any, int]]:
    """The points of a curve that are worth a line: time, value, where a rest before it ended."""
    drawn_us = spans[0][0]
    for (before_us, _, _), (start, stop, value) in pairwise(spans):
        rested = start - before_us > _REST_US
        if rested or stop - start > _REST_US or start - drawn_us >= _FINE_US:
            yield start, value, start - _STEP_US if rested else 0
            drawn_us = start
