"""The timing chart of the last seconds on a linear time axis, as SVG."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from rcx_harness.trace.chart import Lane
from rcx_harness.trace.chart_svg import COLOURS, WAVE_STYLE

__all__ = ["live_chart"]

_ROW, _HIGH, _TOP = 22, 13, 28
_NAMES, _PLOT, _RIGHT = 352, 900, 14
_DIGITS = 44  # a word's digits need this width
_STEPS_US = (100_000, 200_000, 500_000, 1_000_000, 2_000_000, 5_000_000, 10_000_000)
_MOST_STEPS = 12
_STYLE = (
    WAVE_STYLE + "svg{display:block;min-width:900px}text{font-size:12px}"
    "path{stroke-width:1.6;stroke-linejoin:miter}"
    ".f{fill-opacity:.13}.v{font-size:11px}"
    ".e{stroke:#c9d2dc;stroke-width:1}.o{fill:#fff;stroke:#b3bfcc}"
)


def live_chart(lanes: Sequence[Lane], now_us: int, seconds: float) -> str:
    """The chart; the same lanes and times give the same text.

    Args:
        lanes: What to draw, from top to bottom.
        now_us: Time at the right end.
        seconds: Length of the axis.
    """
    span_us = round(seconds * 1e6)
    start_us = now_us - span_us
    bottom = _TOP + len(lanes) * _ROW
    width = _NAMES + _PLOT + _RIGHT
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {bottom + 8}" '
        f'role="img" aria-label="timing chart" data-start="{start_us}" data-span="{span_us}" '
        f'data-left="{_NAMES}" data-plot="{_PLOT}">',
        f"<style>{_STYLE}</style>",
    ]
    step_us = next((step for step in _STEPS_US if span_us / step <= _MOST_STEPS), _STEPS_US[-1])
    first = -(-max(start_us, 0) // step_us) * step_us
    for t_us in range(first, now_us + 1, step_us):
        x = _x(t_us, start_us, span_us)
        parts.append(f'<line class="g" x1="{x}" y1="{_TOP - 6}" x2="{x}" y2="{bottom}"/>')
        parts.append(f'<text class="t" x="{x}" y="{_TOP - 12}">{t_us / 1e6:g} s</text>')
    kind = ""
    for row, lane in enumerate(lanes):
        base = _TOP + (row + 1) * _ROW - 4
        line = "e" if kind and lane.kind != kind else "r"
        kind = lane.kind
        y = base - _ROW + 4
        parts.append(f'<line class="{line}" x1="0" y1="{y}" x2="{width}" y2="{y}"/>')
        parts.append(_lamp(lane, base - 6, now_us))
        parts.append(f'<text x="20" y="{base - 2}">{escape(lane.name)}</text>')
        draw = _word if lane.kind == "word" else _bit
        parts += draw(lane, base, start_us, now_us)
    parts.append("</svg>")
    return "\n".join(parts)


def _lamp(lane: Lane, y: int, now_us: int) -> str:
    """Filled while the signal is ON, or the word is not 0."""
    fill = f'fill="{COLOURS[lane.kind]}"' if lane.value_at(now_us) else 'class="o"'
    return f'<circle cx="10" cy="{y}" r="4.5" {fill}/>'


def _spans(lane: Lane, start_us: int, now_us: int) -> list[tuple[float, float, int]]:
    """Its values from left to right: (x, x of the end, value); 0 before the time began."""
    begin_us = max(start_us, 0)
    marks = [(begin_us, lane.value_at(begin_us))]
    marks += [(t_us, value) for t_us, value in lane.changes if begin_us < t_us <= now_us]
    span_us = now_us - start_us
    ends = [t_us for t_us, _ in marks[1:]] + [now_us]
    return [
        (_x(t_us, start_us, span_us), _x(end, start_us, span_us), value)
        for (t_us, value), end in zip(marks, ends, strict=True)
    ]


def _bit(lane: Lane, base: int, start_us: int, now_us: int) -> list[str]:
    spans = _spans(lane, start_us, now_us)
    colour = COLOURS[lane.kind]
    wave = f"M{spans[0][0]} {_level(base, spans[0][2])}"
    parts = []
    for x, end, value in spans:
        y = _level(base, value)
        wave += f"H{x}V{y}H{end}"
        if value:
            box = f'x="{x}" y="{y}" width="{round(end - x, 1)}" height="{_HIGH}"'
            parts.append(f'<rect class="f" {box} fill="{colour}"/>')
    return [*parts, f'<path stroke="{colour}" d="{wave}"/>']


def _word(lane: Lane, base: int, start_us: int, now_us: int) -> list[str]:
    """Zero is a line in the middle, any other value a box, with its digits if there is room."""
    colour, middle, top = COLOURS["word"], base - _HIGH // 2, base - _HIGH
    parts = []
    for x, end, value in _spans(lane, start_us, now_us):
        if not value:
            parts.append(f'<path stroke="{colour}" d="M{x} {middle}H{end}"/>')
            continue
        shown = f"0x{value:04X}"
        box = f"M{x} {top}H{end}V{base}H{x}Z"
        parts.append(f'<path stroke="{colour}" d="{box}"><title>{shown}</title></path>')
        if end - x >= _DIGITS:
            parts.append(f'<text class="v" x="{x + 4}" y="{base - 3}">{shown}</text>')
    return parts


def _level(base: int, value: int) -> int:
    return base - _HIGH if value else base


def _x(t_us: int, start_us: int, span_us: int) -> float:
    return round(_NAMES + (t_us - start_us) * _PLOT / span_us, 1)
