"""The layout of a network, which does not use the positions of the file: columns, rows, lines.

The column of an element is its distance from the left rail. Coils stand at the right end. Branches
get rows below each other. Elements with positions are taken from top to bottom, so that branches
keep the order of the file's drawing.
"""

from __future__ import annotations

from dataclasses import replace

from structured_text.projects.diagrams.networks.draw.drawing import (
    RAIL,
    Drawing,
    Output,
    Pin,
    State,
    Symbol,
    Wire,
    columns,
    wrapped,
)
from structured_text.projects.diagrams.networks.draw.graph import Graph, Port, graph_of
from structured_text.projects.diagrams.networks.draw.rows import Rows, rows_of
from structured_text.projects.diagrams.networks.draw.tracks import Vertical, tracks
from structured_text.projects.diagrams.networks.draw.words import in_words
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = ["layout"]

#: Width of a comment before it goes on in the next line, in letters.
_COMMENT = 90
#: Least width of a channel with lines, in columns.
_CHANNEL = 2


def layout(diagram: Diagram, network: int, state: State | None = None) -> Drawing:
    """Return the drawing of a network, in one band.

    Args:
        diagram: The diagram.
        network: The number of the network.
        state: What was energised, and the values of the variables.
    """
    shown = state or State()
    graph = graph_of(diagram, network, shown)
    return _Layout(graph, shown).drawing(_heading(diagram, network), in_words(diagram, network))


def _heading(diagram: Diagram, number: int) -> tuple[str, ...]:
    word = diagram.word.capitalize()
    for network in diagram.networks:
        if network.number == number:
            lines = wrapped(
                f"{word} {number}{': ' if network.title else ''}{network.title}", _COMMENT
            )
            lines += wrapped(network.comment, _COMMENT)
            return (*lines, *([f"{network.label}:"] if network.label else []))
    return (f"{word} {number}",)


class _Layout:
    """Gives columns and rows their places in cells, and makes the wires."""

    def __init__(self, graph: Graph, state: State) -> None:
        self._graph, self._rows = graph, rows_of(graph)
        self._lines, self._sources = graph.origins()
        self._state = state
        self._rail = bool(graph.left)
        self._net = graph.net_of()
        self._wires: list[Wire] = []
        self._symbols: list[Symbol] = []
        self._pins: list[Pin] = []
        self._make_columns()

    # --- columns and channels ---

    def _make_columns(self) -> None:
        """Find the first cell of each column of nodes, and of each vertical piece."""
        graph, rows = self._graph, self._rows
        count = graph.last + 1
        wide, before, behind = [int(self._rail), *[0] * graph.last], [0] * count, [0] * count
        for node, made in enumerate(graph.nodes):
            column = graph.column[node]
            wide[column] = max(wide[column], made.width)
            if made.anchor is not None:
                before[column] = max(before[column], made.anchor)
                behind[column] = max(behind[column], made.width - made.anchor)
        wide = [max(wide[at], before[at] + behind[at]) for at in range(count)]
        self._wide, self._anchor = wide, before
        used = self._used_channels(rows)
        self._at: list[int] = []
        self._ends: list[int] = []
        self._vertical: dict[int, int] = {}
        x = 0
        for channel in range(graph.last + 1):
            self._at.append(x)
            x += wide[channel]
            self._ends.append(x)
            offsets, width = tracks(self._verticals(channel))
            for number, offset in offsets.items():
                self._vertical[number] = x + offset
            x += max(width, _CHANNEL if channel in used else 0)
            if 0 < channel < graph.last:
                x = max(x, self._ends[-1] + _CHANNEL)
        self._right = x
        self._width = x + bool(graph.coils)

    def _used_channels(self, rows: Rows) -> set[int]:
        """Return the channels that lines pass."""
        graph = self._graph
        used = {channel for begin, end in rows.spans for channel in range(begin, end + 1)}
        for net in graph.nets:
            first = [graph.column[port.node] for port in net.sources if port.kind == "out"]
            last = [graph.column[port.node] - 1 for port in net.targets if port.kind == "in"]
            used |= set(range(min([*first, net.channel]), max([*last, net.channel]) + 1))
        return used

    def _verticals(self, channel: int) -> list[Vertical]:
        """Return the vertical pieces of a channel, and the rows of the lines that pass it."""
        found = []
        for number, net in enumerate(self._graph.nets):
            if net.channel == channel:
                left = [self._row(port) for port in net.sources if port.kind == "out"]
                right = [self._row(port) for port in net.targets if port.kind == "in"]
                left += [self._row(port) for port in net.targets if port.kind == "leaves"]
                right += [self._row(port) for port in net.sources if port.kind == "arrives"]
                if len({*left, *right}) > 1:
                    found.append(Vertical(number, tuple(left), tuple(right)))
        return found

    def _row(self, port: Port) -> int:
        if port.kind in ("leaves", "arrives"):
            return self._rows.back[port.node]
        made = self._graph.nodes[port.node]
        pins = made.inputs if port.kind == "in" else made.outputs
        return self._rows.top[port.node] + pins[port.pin].y

    def _left(self, node: int) -> int:
        """Return the first cell of a node."""
        column, made = self._graph.column[node], self._graph.nodes[node]
        if made.anchor is not None:
            return self._at[column] + self._anchor[column] - made.anchor
        return self._at[column] + (self._wide[column] - made.width if made.at_right else 0)

    # --- symbols and wires ---

    def drawing(self, heading: tuple[str, ...], words: str) -> Drawing:
        """Return the drawing."""
        graph = self._graph
        for node, made in enumerate(graph.nodes):
            x, y = self._left(node), self._rows.top[node]
            self._symbols += [symbol.moved(x, y) for symbol in made.symbols]
            self._pins += [pin.moved(x, y) for pin in made.ends]
            self._wires += [wire.moved(x, y) for wire in made.wires]
        for number in range(len(graph.nets)):
            self._line(number)
        for number in range(len(graph.back)):
            self._line_back(number)
        ends = [symbol.y + symbol.height for symbol in self._symbols]
        height = max([1, *ends, *(wire.y2 + 1 for wire in self._wires)])
        if graph.left:
            on = self._state.power([RAIL])
            rail = Symbol("rail", 0, 0, 1, height, "left", graph.left[0], on)
            self._symbols.append(rail)
        if graph.coils:
            self._symbols.append(Symbol("rail", self._right, 0, 1, height, "right"))
        width = max([self._width, 1, *(columns(line) for line in heading)])
        cuts = tuple(self._ends[1:-1])
        return Drawing(
            width,
            height,
            tuple(self._symbols),
            tuple(self._wires),
            tuple(self._pins),
            cuts,
            heading,
            words,
        )

    def _edge(self, port: Port) -> int:
        """Return the column of the symbol's edge at an end of a line."""
        made = self._graph.nodes[port.node]
        pins = made.inputs if port.kind == "in" else made.outputs
        return self._left(port.node) + pins[port.pin].x

    def _line(self, number: int) -> None:
        """Make the wires of a line."""
        net, outputs = self._graph.nets[number], self._lines[number]
        if number not in self._vertical:
            self._straight(net.sources[0], net.targets[0], outputs)
            return
        at = self._vertical[number] + 0.5
        ends = [*net.sources, *net.targets]
        rows = [self._row(port) for port in ends]
        self._wire(at, min(rows), at, max(rows), outputs)
        for port, row in zip(ends, rows, strict=True):
            if port.kind == "out":
                self._wire(self._edge(port), row, at, row, self._sources[port])
                self._pin(port, self._edge(port), row)
            elif port.kind == "in":
                self._wire(at, row, self._edge(port), row, outputs)
                self._pin(port, self._edge(port), row)

    def _wire(
        self,
        x1: float,
        y1: int,
        x2: float,
        y2: int,
        outputs: tuple[Output, ...],
        *,
        back: bool = False,
    ) -> None:
        power = self._state.power(outputs)
        self._wires.append(Wire(x1, y1, x2, y2, power, back, outputs))

    def _straight(self, source: Port, target: Port, outputs: tuple[Output, ...]) -> None:
        """Make the wire of a line without a vertical piece; one end may be at a rail."""
        row = self._row(target if source.kind == "left" else source)
        begin = int(self._rail) if source.kind == "left" else self._edge(source)
        end = self._right if target.kind == "right" else self._edge(target)
        self._wire(begin, row, end, row, outputs)
        self._pin(source, begin, row)
        if target.kind == "in":
            self._pin(target, end, row)

    def _pin(self, port: Port, x: int, row: int) -> None:
        if port.kind == "left":
            self._pins.append(Pin(self._graph.left[port.node], "", True, x, row))
        elif self._graph.elements[port.node]:
            made = self._graph.nodes[port.node]
            pins = made.inputs if port.kind == "in" else made.outputs
            self._pins.append(replace(pins[port.pin], x=x, y=row))

    def _line_back(self, number: int) -> None:
        """Make the horizontal piece of a line to the left, below everything else."""
        leaves, arrives = (self._net[Port(kind, number)] for kind in ("leaves", "arrives"))
        begin, end = self._vertical[arrives] + 0.5, self._vertical[leaves] + 0.5
        row = self._rows.back[number]
        outputs = self._sources[self._graph.back[number][0]]
        self._wire(begin, row, end, row, outputs, back=True)
