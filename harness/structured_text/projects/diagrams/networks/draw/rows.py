"""The rows of the nodes: each node and each horizontal piece of a line gets cells of its own.

Between two columns of nodes is a channel for the vertical pieces. In a channel, a row belongs to
one line only, so that no two lines meet.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from structured_text.projects.diagrams.networks.draw.graph import Graph, Port

__all__ = ["Rows", "rows_of"]


@dataclass
class Rows:
    """Where the nodes are.

    Attributes:
        top: The first row of each node.
        back: The row of each line to the left.
        spans: The channels of each line to the left: the first and the last one.
        height: The number of rows.
    """

    top: list[int]
    back: list[int] = field(default_factory=list)
    spans: list[tuple[int, int]] = field(default_factory=list)
    height: int = 0


@dataclass
class _Claim:
    """The cells that a node or some nodes need, by rows from a first one."""

    cells: set[tuple[int, int]] = field(default_factory=set)
    lines: dict[tuple[int, int], int] = field(default_factory=dict)

    def fits(self, other: _Claim, row: int) -> bool:
        """Return whether another claim, moved to a row, needs nothing of this one."""
        return not any((column, row + y) in self.cells for column, y in other.cells) and all(
            self.lines.get((channel, row + y), line) == line
            for (channel, y), line in other.lines.items()
        )

    def add(self, other: _Claim, row: int) -> None:
        """Add another claim, moved to a row."""
        self.cells |= {(column, row + y) for column, y in other.cells}
        self.lines |= {(channel, row + y): line for (channel, y), line in other.lines.items()}


def rows_of(graph: Graph) -> Rows:
    """Return the rows of the nodes of a graph."""
    return _Placer(graph).rows()


class _Placer:
    """Places chains of nodes in rows, from top to bottom."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._net = graph.net_of()
        self._taken = _Claim()
        self._row: dict[int, int] = {}
        self._chain: dict[int, list[tuple[int, int]]] = {}
        self._claims = [self._claim(node) for node in range(len(graph.nodes))]
        self._make_chains()

    def rows(self) -> Rows:
        """Return the rows."""
        for node in range(len(self._graph.nodes)):
            if node not in self._row:
                self._walk(node)
        back, spans = self._lines_back()
        every = [row for _, row in self._taken.cells] + [row for _, row in self._taken.lines]
        first = min(every, default=0)
        top = [self._row[node] - first for node in range(len(self._graph.nodes))]
        height = max(every, default=-1) - first + 1
        return Rows(top, [row - first for row in back], spans, height)

    # --- what a node needs ---

    def _claim(self, node: int) -> _Claim:
        """Return the cells of a node, with the lines that go on from its pins in its own rows."""
        graph, made, column = self._graph, self._graph.nodes[node], self._graph.column[node]
        found = _Claim({(column, row) for row in range(made.height)})
        for k, pin in enumerate(made.inputs):
            number = self._net.get(Port("in", node, k))
            if number is not None:
                begin = graph.nets[number].channel
                found.cells |= {(at, pin.y) for at in range(begin + 1, column)}
                found.lines |= {(at, pin.y): number for at in range(begin, column)}
        for k, pin in enumerate(made.outputs):
            number = self._net.get(Port("out", node, k))
            if number is not None:
                end = graph.nets[number].channel
                found.cells |= {(at, pin.y) for at in range(column + 1, end + 1)}
                found.lines |= {(at, pin.y): number for at in range(column, end + 1)}
        return found

    # --- chains ---

    def _make_chains(self) -> None:
        """Join nodes that are connected only to each other, so that they get the same row."""
        behind: dict[int, tuple[int, int]] = {}
        before: set[int] = set()
        pairs = []
        for net in self._graph.nets:
            if len(net.sources) == len(net.targets) == 1:
                source, target = net.sources[0], net.targets[0]
                if source.kind == "out" and target.kind == "in":
                    pairs.append((source, target))
        pairs.sort(key=lambda pair: (pair[0].pin, pair[1].pin))
        for source, target in pairs:
            if source.node not in behind and target.node not in before:
                here = self._graph.nodes[source.node].outputs[source.pin].y
                there = self._graph.nodes[target.node].inputs[target.pin].y
                behind[source.node] = (target.node, here - there)
                before.add(target.node)
        for node in range(len(self._graph.nodes)):
            if node not in before:
                self._join(node, behind)

    def _join(self, first: int, behind: dict[int, tuple[int, int]]) -> None:
        """Make the chain that begins at a node; it ends where nodes do not fit together."""
        chain = [(first, 0)]
        claim = _Claim()
        claim.add(self._claims[first], 0)
        while True:
            for node, _ in chain:
                self._chain[node] = chain
            if chain[-1][0] not in behind:
                return
            node, step = behind[chain[-1][0]]
            row = chain[-1][1] + step
            if not claim.fits(self._claims[node], row):
                chain, row, claim = [], 0, _Claim()
            chain.append((node, row))
            claim.add(self._claims[node], row)

    # --- the walk ---

    def _walk(self, begin: int) -> None:
        """Place a node and all that is connected to it: first what leads to it."""
        way = [iter([begin])]
        while way:
            node = next(way[-1], None)
            if node is None:
                way.pop()
            elif node not in self._row:
                self._place(self._chain[node])
                way.append(self._neighbours(self._chain[node]))

    def _neighbours(self, chain: list[tuple[int, int]]) -> Iterator[int]:
        graph = self._graph
        for node, _ in chain:
            for k in range(len(graph.nodes[node].inputs)):
                number = self._net.get(Port("in", node, k))
                if number is not None:
                    yield from (p.node for p in graph.nets[number].sources if p.kind == "out")
        for node, _ in chain:
            for k in range(len(graph.nodes[node].outputs)):
                number = self._net.get(Port("out", node, k))
                if number is not None:
                    yield from (p.node for p in graph.nets[number].targets if p.kind == "in")

    def _place(self, chain: list[tuple[int, int]]) -> None:
        """Place a chain in line with a neighbour, or as little below it as possible."""
        claim = _Claim()
        for node, row in chain:
            claim.add(self._claims[node], row)
        row = self._wanted(chain)
        while not self._taken.fits(claim, row):
            row += 1
        self._taken.add(claim, row)
        for node, step in chain:
            self._row[node] = row + step

    def _wanted(self, chain: list[tuple[int, int]]) -> int:
        graph = self._graph
        for node, step in chain:
            pins = [(Port("in", node, k), pin.y) for k, pin in enumerate(graph.nodes[node].inputs)]
            pins += [
                (Port("out", node, k), pin.y) for k, pin in enumerate(graph.nodes[node].outputs)
            ]
            for port, y in pins:
                number = self._net.get(port)
                if number is None:
                    continue
                net = graph.nets[number]
                for other in net.sources if port.kind == "in" else net.targets:
                    if other.node in self._row and other.kind in ("in", "out"):
                        return self._row_of(other) - y - step
        return max((row for _, row in self._taken.cells), default=-1) + 1

    def _row_of(self, port: Port) -> int:
        made = self._graph.nodes[port.node]
        pins = made.inputs if port.kind == "in" else made.outputs
        return self._row[port.node] + pins[port.pin].y

    # --- lines back ---

    def _lines_back(self) -> tuple[list[int], list[tuple[int, int]]]:
        """Place the lines to the left below everything else."""
        rows, spans = [], []
        for number in range(len(self._graph.back)):
            leaves, arrives = Port("leaves", number), Port("arrives", number)
            end = self._graph.nets[self._net[leaves]].channel
            begin = self._graph.nets[self._net[arrives]].channel
            row = 1 + max(
                [row for _, row in self._taken.cells] + [row for _, row in self._taken.lines]
            )
            claim = _Claim({(at, row) for at in range(begin + 1, end + 1)})
            claim.lines = {(at, row): -1 - number for at in range(begin, end + 1)}
            self._taken.add(claim, 0)
            rows.append(row)
            spans.append((begin, end))
        return rows, spans
