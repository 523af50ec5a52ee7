"""The last seconds of a controller: as lanes, and as a timing chart on a linear time axis."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Sequence

from rcx_harness.serve.status import Change
from rcx_harness.spec import command_name, signals
from rcx_harness.trace.chart import Lane
from rcx_harness.trace.chart_svg import COLOURS, STYLE, Look, Scale, draw_lane, rule, text

__all__ = ["History", "live_chart"]

_SKIPPED = 30  # a Change contains bytes 0, 1, 32 and 33 of the area

_ROW, _TOP = 22, 28
_NAMES, _RIGHT, _WIDE = 352, 14, 1266
#: If the chart is narrower than the first number, the names are above the waves, and the waves have
#: the whole width. Each row is then higher by the second number.
_NARROW, _NAME_ROW = 760, 16
_LOOK = Look(high=13, edge=0, digits=(4, 3), room=44, filled=True)
_STEPS_US = (100_000, 200_000, 500_000, 1_000_000, 2_000_000, 5_000_000, 10_000_000)
_MOST_STEPS, _APART = 12, 60
_STYLE = (
    STYLE + "svg{display:block;width:100%}text{font-size:12px}"
    "path{stroke-width:1.6;stroke-linejoin:miter}"
    ".f{fill-opacity:.13}.v{font-size:11px}"
    ".e{stroke:#c9d2dc;stroke-width:1}.o{fill:#fff;stroke:#b3bfcc}"
)


class History:
    """The changes in the last `kept_us`, and the state before them.

    Args:
        most: Maximum number of changes, so that memory stays bounded.
    """

    def __init__(self, kept_us: int = 60_000_000, most: int = 20_000) -> None:
        self._kept_us = kept_us
        self._most = most
        self._changes: deque[Change] = deque()
        self.now_us = 0

    def add(self, changes: Iterable[Change], now_us: int) -> None:
        """Add new changes, in order of time, and drop changes that are too old at `now_us`."""
        self._changes.extend(changes)
        self.now_us = max(self.now_us, now_us)
        kept = self._changes
        oldest = self.now_us - self._kept_us
        while len(kept) > 1 and (kept[1].t_us <= oldest or len(kept) > self._most):
            kept.popleft()

    def lanes(self) -> list[Lane]:
        """Return the lanes (signals, code, status, connection), each with its changes."""
        table = signals()
        connection = Lane("Connection with the master", "event")
        code = Lane("Remote command code", "word", show=command_name)
        status = Lane("Remote status", "word")
        inputs = [Lane(f"{one.signal} {one.title}", "input") for one in table.input]
        outputs = [Lane(f"{one.signal} {one.title}", "output") for one in table.output]
        for change in self._changes:
            si, so = bytes.fromhex(change.si), bytes.fromhex(change.so)
            connection.note(change.t_us, int(change.connected))
            code.note(change.t_us, int.from_bytes(si[:2], "little"))
            status.note(change.t_us, int.from_bytes(so[:2], "little"))
            for lane, one in zip(inputs + outputs, table.input + table.output, strict=True):
                area = si if lane.kind == "input" else so
                lane.note(change.t_us, area[one.byte - _SKIPPED] >> one.bit & 1)
        return [connection, *inputs, *outputs, code, status]


def live_chart(lanes: Sequence[Lane], now_us: int, seconds: float, width: int = _WIDE) -> str:
    """Return the chart as SVG; the same lanes and times give the same text.

    The lanes are drawn from top to bottom; `now_us` is the time at the right end. In a narrow chart
    (`width` in px) the names stand above the waves.
    """
    is_narrow = width < _NARROW
    left, high = (4, _ROW + _NAME_ROW) if is_narrow else (_NAMES, _ROW)
    plot = width - left - (4 if is_narrow else _RIGHT)
    span_us = round(seconds * 1e6)
    axis = Scale(left, left + plot, now_us - span_us, now_us)
    bottom = _TOP + len(lanes) * high
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {bottom + 8}" '
        f'role="img" aria-label="timing chart" data-start="{axis.begin_us}" '
        f'data-span="{span_us}" data-left="{left}" data-plot="{plot}">',
        f"<style>{_STYLE}</style>",
    ]
    for t_us, x in axis.round_times(_STEPS_US, min(_MOST_STEPS, plot // _APART)):
        parts.append(rule("g", x, _TOP - 6, x, bottom))
        parts.append(text(x, _TOP - 12, f"{t_us / 1e6:g} s", "t"))
    kind = ""
    for row, lane in enumerate(lanes):
        base = _TOP + (row + 1) * high - 4
        y = base - high + 4
        parts.append(rule("e" if kind and lane.kind != kind else "r", 0, y, width, y))
        kind = lane.kind
        named = y + 12 if is_narrow else base - 2
        parts.append(_lamp(lane, named - 4, now_us))
        parts.append(text(20, named, lane.name))
        parts += draw_lane(lane, axis, base, _LOOK)
    parts.append("</svg>")
    return "\n".join(parts)


def _lamp(lane: Lane, y: int, now_us: int) -> str:
    """Return the lamp of a lane: filled while the signal is ON, or the word is not 0."""
    fill = f'fill="{COLOURS[lane.kind]}"' if lane.value_at(now_us) else 'class="o"'
    return f'<circle cx="10" cy="{y}" r="4.5" {fill}/>'
