"""A wide drawing cut into bands below each other, so that it fits a page or terminal."""

from __future__ import annotations

from dataclasses import replace
from math import ceil

from structured_text.projects.diagrams.networks.draw.drawing import (
    Drawing,
    Pin,
    Symbol,
    Wire,
    columns,
    wrapped,
)

__all__ = ["in_bands"]

#: Rows between two bands.
_GAP = 1


def in_bands(drawing: Drawing, width: int) -> Drawing:
    """Return a drawing with at most `width` columns, if no single column of elements is wider.

    A line that is cut ends at `>1`, and goes on in the next band at `1>`.
    """
    heading = tuple(line for text in drawing.heading for line in wrapped(text, max(width, 20)))
    drawing = replace(drawing, heading=heading)
    if drawing.width <= width or not drawing.cuts:
        return drawing
    rows = {cut: _rows_at(drawing, cut) for cut in drawing.cuts}
    mark = 1 + len(str(sum(map(len, rows.values()))))
    begins = [0]
    for cut, following in zip(drawing.cuts, (*drawing.cuts[1:], drawing.width), strict=True):
        marks = mark * (len(begins) > 1) + (mark + 1) * (following < drawing.width)
        if following - begins[-1] + marks > width:
            begins.append(cut)
    cutter = _Cutter(drawing, mark)
    first = 1
    for begin, end in zip(begins, (*begins[1:], drawing.width + 1), strict=True):
        cutter.band(begin, end, rows.get(begin, []), rows.get(end, []), first)
        first += len(rows.get(begin, []))
    return cutter.drawing()


def _rows_at(drawing: Drawing, cut: int) -> list[int]:
    """Return the rows of the lines that a cut divides."""
    return sorted(
        wire.y1 for wire in drawing.wires if wire.y1 == wire.y2 and wire.x1 <= cut < wire.x2
    )


class _Cutter:
    """Puts the bands of a drawing below each other."""

    def __init__(self, drawing: Drawing, mark: int) -> None:
        self._whole, self._mark = drawing, mark
        self._symbols: list[Symbol] = []
        self._wires: list[Wire] = []
        self._pins: list[Pin] = []
        self._width = max([1, *map(columns, drawing.heading)])
        self._row = 0

    def band(
        self, begin: int, end: int, arriving: list[int], leaving: list[int], number: int
    ) -> None:
        """Add the part between two columns.

        `arriving` and `leaving` are the rows of the cut lines. `number` is that of the first
        arriving line.
        """
        symbols = [one for one in self._whole.symbols if begin <= one.x < end]
        pins = [pin for pin in self._whole.pins if begin <= pin.x - (pin.output or begin > 0) < end]
        wires = []
        for wire in self._whole.wires:
            if wire.y1 != wire.y2:
                wires += [wire] if begin <= wire.x1 < end else []
            elif wire.x1 < end and wire.x2 > begin:
                wires.append(replace(wire, x1=max(wire.x1, begin), x2=min(wire.x2, end)))
        used = [one.y for one in symbols if one.kind != "rail"]
        used += [one.y + one.height - 1 for one in symbols if one.kind != "rail"]
        used += [row for wire in wires for row in (wire.y1, wire.y2)]
        top, bottom = min(used, default=0), max(used, default=0)
        x, y = (self._mark if begin else 0) - begin, self._row - top
        for symbol in symbols:
            if symbol.kind == "rail":
                symbol = replace(symbol, y=top, height=bottom - top + 1)
            self._add(symbol.moved(x, y))
        self._wires += [wire.moved(x, y) for wire in wires]
        self._pins += [pin.moved(x, y) for pin in pins]
        for k, row in enumerate(arriving):
            text = f"{number + k}>"
            self._add(Symbol("cut", self._mark - len(text), row + y, len(text), 1, text))
        for k, row in enumerate(leaving):
            text = f">{number + len(arriving) + k}"
            self._add(Symbol("cut", end + x + 1, row + y, len(text), 1, text))
            wire = next(w for w in self._whole.wires if _passes(w, end, row))
            self._wires.append(
                replace(wire, x1=end + x, x2=end + x + 1, y1=row + y, y2=row + y, back=False)
            )
        self._row += bottom - top + 1 + _GAP

    def _add(self, symbol: Symbol) -> None:
        self._symbols.append(symbol)
        self._width = max(self._width, symbol.x + symbol.width)

    def drawing(self) -> Drawing:
        """Return the bands as a drawing that cannot be cut again."""
        return replace(
            self._whole,
            width=max([self._width, *(ceil(wire.x2) for wire in self._wires)]),
            height=self._row - _GAP,
            symbols=tuple(self._symbols),
            wires=tuple(self._wires),
            pins=tuple(self._pins),
            cuts=(),
        )


def _passes(wire: Wire, cut: int, row: int) -> bool:
    return wire.y1 == wire.y2 == row and wire.x1 <= cut < wire.x2
