"""A network as text, for terminals and comments."""

from __future__ import annotations

from math import ceil, floor
from unicodedata import combining

from structured_text.projects.diagrams.networks.draw.bands import in_bands
from structured_text.projects.diagrams.networks.draw.drawing import (
    Drawing,
    State,
    Symbol,
    Wire,
    columns,
)
from structured_text.projects.diagrams.networks.draw.layout import layout
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = ["network_text"]

#: Box drawing letters by their arms: 27 * up + 9 * right + 3 * down + left. An arm is 0 for none,
#: 1 for a thin line, 2 for a thick line.
_LETTERS = " ╴╸╷┐┑╻┒┓╶─╾┌┬┭┎┰┱╺╼━┍┮┯┏┲┳╵┘┙│┤┥╽┧┪└┴┵├┼┽┟╁╅┕┶┷┝┾┿┢╆╈╹┚┛╿┦┩┃┨┫┖┸┹┞╀╃┠╂╉┗┺┻┡╄╇┣╊╋"
_UP, _RIGHT, _DOWN, _LEFT = 27, 9, 3, 1


def network_text(
    diagram: Diagram,
    network: int,
    state: State | None = None,
    *,
    width: int = 100,
    plain: bool = False,
) -> str:
    """Return the drawing of a network in lines of text.

    With a state, lines with power are thick (`=` and `#` in ASCII).

    Args:
        diagram: The diagram.
        network: The number of the network.
        state: What was energised, and the values of the variables.
        width: Number of columns from which on the drawing goes on below.
        plain: Whether lines are drawn in ASCII. Names keep their letters.
    """
    drawing = in_bands(layout(diagram, network, state), width)
    canvas = _Canvas(drawing, plain)
    return "\n".join([*drawing.heading, *canvas.lines()]) + "\n"


class _Canvas:
    """The cells of a drawing."""

    def __init__(self, drawing: Drawing, plain: bool) -> None:
        self._cells = [[" "] * drawing.width for _ in range(drawing.height)]
        self._plain = plain
        self._arms: dict[tuple[int, int], list[int]] = {}
        crossed = {(floor(wire.x1), row) for wire in drawing.wires for row in _rows(wire)}
        for wire in drawing.wires:
            if wire.y1 == wire.y2:
                self._across(wire, crossed)
            else:
                self._down(wire)
        for (x, y), arms in self._arms.items():
            self._cells[y][x] = self._letter(arms)
        for wire in drawing.wires:
            if wire.back:
                self._write(floor((wire.x1 + wire.x2) / 2), wire.y1, "<")
        for symbol in drawing.symbols:
            self._symbol(symbol)

    def lines(self) -> list[str]:
        """Return the lines without blanks at their ends."""
        return ["".join(row).rstrip() for row in self._cells]

    def _arm(self, x: int, y: int, arm: int, on: bool | None) -> None:
        index = (_UP, _RIGHT, _DOWN, _LEFT).index(arm)
        arms = self._arms.setdefault((x, y), [0, 0, 0, 0])
        arms[index] = max(arms[index], 2 if on else 1)

    def _across(self, wire: Wire, crossed: set[tuple[int, int]]) -> None:
        y, first, last = wire.y1, floor(wire.x1), ceil(wire.x2) - 1
        # A vertical line is in front of a horizontal one, which has gaps beside it.
        front = {x for x in range(ceil(wire.x1), floor(wire.x2)) if (x, y) in crossed}
        for x in range(first, last + 1):
            if x in front:
                continue
            left, right = x >= wire.x1, x + 1 <= wire.x2
            if not (x - 1 in front and x + 1 in front):
                left, right = left and x - 1 not in front, right and x + 1 not in front
            if left:
                self._arm(x, y, _LEFT, wire.on)
            if right:
                self._arm(x, y, _RIGHT, wire.on)

    def _down(self, wire: Wire) -> None:
        x = floor(wire.x1)
        for y in range(wire.y1, wire.y2 + 1):
            if y > wire.y1:
                self._arm(x, y, _UP, wire.on)
            if y < wire.y2:
                self._arm(x, y, _DOWN, wire.on)

    def _letter(self, arms: list[int]) -> str:
        up, right, down, left = arms
        if not self._plain:
            return _LETTERS[_UP * up + _RIGHT * right + _DOWN * down + _LEFT * left]
        thick = 2 in arms
        if not up and not down:
            return "=" if thick else "-"
        if not left and not right:
            return "#" if thick else "|"
        return "#" if thick else "+"

    def _symbol(self, symbol: Symbol) -> None:
        x, y, text = symbol.x, symbol.y, symbol.text
        if symbol.kind == "rail":
            for row in range(symbol.height):
                self._write(x, y + row, "|" if self._plain else "┃" if symbol.on else "│")
        elif symbol.kind == "contact":
            self._write(x, y, f"|{text}|" if self._plain else f"┤{text}├")
        elif symbol.kind == "coil":
            self._write(x, y, f"({text})")
        elif symbol.kind == "box":
            self._box(symbol)
        else:
            self._write(x, y, text)

    def _box(self, symbol: Symbol) -> None:
        inside = symbol.width - 2
        corners, across, side = ("++++", "-", "|") if self._plain else ("┌┐└┘", "─", "│")
        self._write(symbol.x, symbol.y, corners[0] + across * inside + corners[1])
        for row in range(symbol.y + 1, symbol.y + symbol.height - 1):
            self._write(symbol.x, row, side)
            self._write(symbol.x + inside + 1, row, side)
        bottom = corners[2] + across * inside + corners[3]
        self._write(symbol.x, symbol.y + symbol.height - 1, bottom)

    def _write(self, x: int, y: int, text: str) -> None:
        """Write a text; behind a wide letter, a cell stays empty."""
        for letter in text:
            if combining(letter):
                self._cells[y][x - 1] += letter
                continue
            wide = columns(letter)
            self._cells[y][x] = letter
            if wide == 2:
                self._cells[y][x + 1] = ""
            x += wide


def _rows(wire: Wire) -> range:
    """Return the rows that a vertical wire passes; none for a horizontal wire."""
    return range(wire.y1, wire.y2 + 1) if wire.y1 != wire.y2 else range(0)
