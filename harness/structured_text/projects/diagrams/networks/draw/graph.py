"""The lines of a network as a graph: which outputs a line joins, and to which inputs it leads.

A vertical line in ladder gives the OR of all that comes from its left to all that is on its right.
So a line with several outputs and several inputs may be drawn as one only if each of its inputs is
connected to each of its outputs. `Graph` gives every other connection a piece of line of its own.

Source: IEC 61131-3, 8.2.2 (third edition): link elements and states.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field

from structured_text.projects.diagrams.networks.draw.boxes import Attached
from structured_text.projects.diagrams.networks.draw.drawing import RAIL, Output, State
from structured_text.projects.diagrams.networks.draw.making import Shape
from structured_text.projects.diagrams.networks.draw.shapes import (
    input_of,
    line_shape,
    outputs_of,
    shape,
)
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Contact,
    Diagram,
    Element,
    InVariable,
    Jump,
    OutVariable,
    Rail,
    Return,
)

__all__ = ["Graph", "Net", "Port", "graph_of"]


@dataclass(frozen=True, order=True)
class Port:
    """An end of a line.

    Attributes:
        kind: `out` and `in` of a node; `left` and `right` for a place at a rail; `leaves` and
            `arrives` for the ends of a line that leads back to the left.
        node: The number of the node, of the place at the rail, or of the line back.
        pin: The index of the output or input.
    """

    kind: str
    node: int
    pin: int = 0


@dataclass
class Net:
    """A line: each input on its right side is connected to each output on its left side.

    Attributes:
        sources: What is on its left side.
        targets: What is on its right side.
        channel: The number of the channel with its vertical piece: that behind this column.
    """

    sources: list[Port]
    targets: list[Port]
    channel: int = 0


@dataclass
class Graph:
    """A network as nodes in columns, and the lines between them.

    Attributes:
        nodes: The shapes of the elements, and pieces of lines that need a row of their own.
        elements: The elements of the nodes; None for pieces of lines.
        column: The column of each node, from 1. Column 0 is the left rail.
        nets: The lines.
        back: For each line to the left, the output where it begins and the input where it ends.
        left: For each place at the left rail, the `id` of the rail.
        coils: The number of places at the right rail.
        last: The number of the last column.
    """

    nodes: list[Shape] = field(default_factory=list)
    elements: list[Element | None] = field(default_factory=list)
    column: list[int] = field(default_factory=list)
    nets: list[Net] = field(default_factory=list)
    back: list[tuple[Port, Port]] = field(default_factory=list)
    left: list[str] = field(default_factory=list)
    coils: int = 0
    last: int = 0

    def net_of(self) -> dict[Port, int]:
        """Return the number of the line of each end."""
        return {
            port: number
            for number, net in enumerate(self.nets)
            for port in (*net.sources, *net.targets)
        }

    def origins(self) -> tuple[list[tuple[Output, ...]], dict[Port, tuple[Output, ...]]]:
        """Return the outputs that each line comes from, and those of each of its sources."""
        of = self.net_of()
        lines: dict[int, tuple[Output, ...]] = {}
        sources: dict[Port, tuple[Output, ...]] = {}

        def source(port: Port) -> tuple[Output, ...]:
            if port.kind == "left":
                return (RAIL,)
            if port.kind == "arrives":
                return source(self.back[port.node][0])
            element = self.elements[port.node]
            if element is None:
                return line(of[Port("in", port.node)])
            return ((element.id, self.nodes[port.node].outputs[port.pin].name),)

        def line(number: int) -> tuple[Output, ...]:
            if number not in lines:
                for port in self.nets[number].sources:
                    sources[port] = source(port)
                found = [sources[port] for port in self.nets[number].sources]
                lines[number] = tuple(dict.fromkeys(output for every in found for output in every))
            return lines[number]

        return [line(number) for number in range(len(self.nets))], sources


def graph_of(diagram: Diagram, network: int, state: State) -> Graph:
    """Return the graph of a network of a diagram."""
    return _Builder(diagram, network, state).build()


class _Builder:
    """Makes the graph of a network."""

    def __init__(self, diagram: Diagram, network: int, state: State) -> None:
        self._ladder = diagram.language in ("LD", "RLL")
        #: What stands at the right end of a rung.
        self._ends: tuple[type[Element], ...] = (Coil,)
        if diagram.language == "RLL":
            self._ends = (Contact, Coil, Block)
        self._all = {element.id: element for element in diagram.elements}
        elements = [
            element
            for element in diagram.elements
            if element.network == network and not isinstance(element, Rail)
        ]
        places = [(element.position.y, element.position.x) for element in elements]
        if any(place != (0, 0) for place in places):
            elements.sort(key=lambda element: (element.position.y, element.position.x))
        self._state = state
        self._own = {element.id: element for element in elements}
        self._attached: dict[str, Attached] = {}
        self._hidden: set[str] = set()
        self._attach()
        self.graph = Graph()
        self._edges: list[tuple[Port, Port]] = []
        self._number: dict[str, int] = {}

    def build(self) -> Graph:
        """Return the graph."""
        self._make_nodes()
        self._connect()
        self._turn_back()
        self._give_own_lines()
        self.graph.nets = _joined(self._edges)
        self._make_columns()
        return self.graph

    # --- nodes ---

    def _attach(self) -> None:
        """Find the variables that only one pin uses. They are drawn at this pin."""
        uses: dict[tuple[str, str], list[tuple[str, int]]] = {}
        for element in self._all.values():
            for k, given in enumerate(input_of(element)):
                for connection in given.connections:
                    uses.setdefault(self._end(connection), []).append((element.id, k))
        for element in self._own.values():
            if isinstance(element, InVariable):
                users = uses.get((element.id, ""), [])
                block = self._own.get(users[0][0]) if len(users) == 1 else None
                if isinstance(block, Block) and len(block.inputs[users[0][1]].connections) == 1:
                    self._attached.setdefault(block.id, {})[False, users[0][1]] = element
                    self._hidden.add(element.id)
            elif isinstance(element, OutVariable) and not element.read:
                self._attach_output(element, uses)

    def _attach_output(
        self, element: OutVariable, uses: dict[tuple[str, str], list[tuple[str, int]]]
    ) -> None:
        given = element.input
        if len(given.connections) != 1 or given.negated or given.edge:
            return
        source, pin = self._end(given.connections[0])
        block = self._own.get(source)
        if isinstance(block, Block) and len(uses[source, pin]) == 1:
            names = outputs_of(block)
            if pin in names and not block.outputs[names.index(pin)].target:
                self._attached.setdefault(source, {})[True, names.index(pin)] = element
                self._hidden.add(element.id)

    def _end(self, connection: Connection) -> tuple[str, str]:
        """Return element and output of a connection; without a pin it is the first output."""
        element = self._all.get(connection.source)
        if isinstance(element, Block):
            first = element.outputs[0].name if element.outputs else ""
            return connection.source, connection.pin or first
        return connection.source, ""

    def _make_nodes(self) -> None:
        for element in self._own.values():
            if element.id not in self._hidden:
                attached = self._attached.get(element.id, {})
                self._number[element.id] = self._node(
                    shape(element, attached, self._state), element
                )

    def _node(self, made: Shape, element: Element | None) -> int:
        self.graph.nodes.append(made)
        self.graph.elements.append(element)
        return len(self.graph.nodes) - 1

    # --- lines ---

    def _connect(self) -> None:
        """Make the connections of the nodes, except those that are drawn with a block."""
        graph = self.graph
        for element in list(self._own.values()):
            if element.id not in self._number:
                continue
            attached = self._attached.get(element.id, {})
            for k, given in enumerate(input_of(element)):
                target = Port("in", self._number[element.id], k)
                if (False, k) not in attached:
                    ends = dict.fromkeys(self._end(connection) for connection in given.connections)
                    self._edges += [(self._source(*end), target) for end in ends]
        if not self._ladder:
            return
        used = {source for source, _ in self._edges}
        for number, node in enumerate(graph.elements):
            source = Port("out", number)
            if isinstance(node, self._ends) and source not in used:
                self._edges.append((source, Port("right", graph.coils)))
                graph.coils += 1

    def _source(self, source: str, pin: str) -> Port:
        """Return the end of the line at an output; each line from a rail has its own place."""
        element = self._all.get(source)
        if isinstance(element, Rail):
            self.graph.left.append(source)
            return Port("left", len(self.graph.left) - 1)
        if source not in self._number:
            # The other end is outside this network. Its name stands in its place.
            name = _name(element) if element else "?"
            text = InVariable(source, expression=f"{name}.{pin}" if pin else name)
            self._number[source] = self._node(shape(text, {}, self._state), text)
        node = self.graph.nodes[self._number[source]]
        names = [output.name for output in node.outputs]
        return Port("out", self._number[source], names.index(pin) if pin in names else 0)

    def _turn_back(self) -> None:
        """Replace each connection that closes a loop by the two ends of a line to the left."""
        edges: dict[int, list[int]] = {}
        for k, (source, target) in enumerate(self._edges):
            if source.kind == "out" and target.kind == "in":
                edges.setdefault(source.node, []).append(k)
        fed = {self._edges[k][1].node for found in edges.values() for k in found}
        every = range(len(self.graph.nodes))
        begins = [node for node in every if node not in fed] + [*every]
        back = _closing(begins, edges, self._edges)
        for k in sorted(back):
            source, target = self._edges[k]
            number = len(self.graph.back)
            self.graph.back.append((source, target))
            self._edges[k] = (source, Port("leaves", number))
            self._edges.append((Port("arrives", number), target))

    def _give_own_lines(self) -> None:
        """Insert a piece of a line where lines may not be drawn as one."""
        kept: list[tuple[Port, Port]] = []
        for net in _joined(self._edges):
            sources = {port: [b for a, b in self._edges if a == port] for port in net.sources}
            targets = {port: [a for a, b in self._edges if b == port] for port in net.targets}
            complete = all(len(found) == len(net.targets) for found in sources.values())
            for source, found in sources.items():
                for target in found:
                    several = len(found) > 1 and len(targets[target]) > 1 and not complete
                    rail = source.kind == "left" and len(targets[target]) > 1
                    if several or rail:
                        node = self._node(line_shape(), None)
                        kept += [(source, Port("in", node)), (Port("out", node), target)]
                    else:
                        kept.append((source, target))
        self._edges = kept

    # --- columns ---

    def _make_columns(self) -> None:
        """Give each node its column: as far left as possible, or close to what it leads to."""
        graph = self.graph
        after: dict[int, set[int]] = {node: set() for node in range(len(graph.nodes))}
        before: dict[int, set[int]] = {node: set() for node in range(len(graph.nodes))}
        for source, target in self._edges:
            if source.kind == "out" and target.kind == "in":
                after[source.node].add(target.node)
                before[target.node].add(source.node)
        order = _sorted(before, after)
        column = dict.fromkeys(order, 1)
        fed = {target.node for source, target in self._edges if source.kind == "left"}
        for node in order:
            column[node] = max((column[one] + 1 for one in before[node]), default=1)
            if before[node] & fed:
                fed.add(node)
        graph.last = max(column.values(), default=0)
        ends: set[int] = set()
        for node in reversed(order):
            element = graph.elements[node]
            last = (*self._ends, Jump, Return)
            if self._ladder and isinstance(element, last) and after[node] <= ends:
                ends.add(node)
            if node in ends or (node not in fed and after[node]):
                limits = (column[one] - 1 for one in after[node])
                column[node] = min(limits, default=graph.last)
        graph.column = [column[node] for node in range(len(graph.nodes))]
        for net in graph.nets:
            columns = [graph.column[port.node] for port in net.sources if port.kind == "out"]
            if any(port.kind == "right" for port in net.targets):
                net.channel = graph.last
            elif columns:
                net.channel = max(columns)
            elif net.sources[0].kind == "arrives":
                net.channel = min(graph.column[port.node] for port in net.targets) - 1


def _name(element: Element) -> str:
    """Return the name of an element of another network."""
    if isinstance(element, Block):
        return element.instance or element.type
    if isinstance(element, (Contact, Coil)):
        return element.variable
    if isinstance(element, (InVariable, OutVariable)):
        return element.expression
    return getattr(element, "name", "") or "?"


def _joined(edges: Iterable[tuple[Port, Port]]) -> list[Net]:
    """Return the connected parts of the connections, each as a line."""
    part: dict[Port, Net] = {}
    for source, target in edges:
        first = part.get(source) or part.get(target) or Net([], [])
        other = part.get(target, first)
        if other is not first:
            first.sources += other.sources
            first.targets += other.targets
            part.update(dict.fromkeys((*other.sources, *other.targets), first))
        if source not in part:
            first.sources.append(source)
        if target not in part:
            first.targets.append(target)
        part[source] = part[target] = first
    nets = {id(net): net for net in part.values()}
    for net in nets.values():
        net.sources.sort(key=lambda port: (port.node, port.pin))
        net.targets.sort(key=lambda port: (port.node, port.pin))
    return list(nets.values())


def _closing(
    begins: Sequence[int], after: Mapping[int, Sequence[int]], edges: Sequence[tuple[Port, Port]]
) -> set[int]:
    """Return the connections that lead to a node on the way to their own source."""
    found: set[int] = set()
    state: dict[int, bool] = {}  # True: on the way; False: finished
    for begin in begins:
        if begin in state:
            continue
        state[begin] = True
        way = [(begin, iter(after.get(begin, ())))]
        while way:
            node, rest = way[-1]
            k = next(rest, None)
            if k is None:
                state[node] = False
                way.pop()
                continue
            target = edges[k][1].node
            if target not in state:
                state[target] = True
                way.append((target, iter(after.get(target, ()))))
            elif state[target]:
                found.add(k)
    return found


def _sorted(before: Mapping[int, set[int]], after: Mapping[int, set[int]]) -> list[int]:
    """Return the nodes so that each one is behind those that lead to it."""
    waiting = {node: len(sources) for node, sources in before.items()}
    found = [node for node, count in waiting.items() if not count]
    for node in found:  # grows
        for target in sorted(after[node]):
            waiting[target] -= 1
            if not waiting[target]:
                found.append(target)
    return found
