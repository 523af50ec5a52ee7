"""The order in which the elements of a diagram are executed, and who uses the values of each.

Source of the order by position: the generators of Beremiz (PLCGenerator.py, ComputeProgram) and of
OpenPLC Editor (xml2st).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cmp_to_key

from structured_text.projects.diagrams.networks.check import inputs_of
from structured_text.projects.diagrams.networks.expressions import Key
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Connector,
    Contact,
    Continuation,
    Diagram,
    Element,
    OutVariable,
)

__all__ = ["Graph", "executed"]

#: Elements with a difference of y below this number are in one row.
_ROW = 10


def executed(diagram: Diagram) -> list[Element]:
    """Return the elements that are executed, in their order.

    A block is executed earlier if an element before it uses its value.
    """
    if not diagram.by_position:
        numbers = {network.number: place for place, network in enumerate(diagram.networks)}
        return sorted(diagram.elements, key=lambda element: numbers.get(element.network, 0))
    numbered, outputs, blocks, connectors = [], [], [], []
    for element in diagram.elements:
        if isinstance(element, (OutVariable, Block)) and element.order > 0:
            numbered.append(element)
        elif isinstance(element, (OutVariable, Coil)):
            outputs.append(element)
        elif isinstance(element, Block):
            blocks.append(element)
        elif isinstance(element, Connector):
            connectors.append(element)
    numbered.sort(key=lambda element: element.order)
    if diagram.sorting == "together":
        return [*numbered, *_by_position([*outputs, *blocks, *connectors])]
    if diagram.sorting == "file":
        return [*numbered, *outputs, *blocks, *connectors]
    return [*numbered, *_by_position(outputs), *_by_position(blocks), *connectors]


def _by_position(elements: Sequence[Element]) -> list[Element]:
    """Return elements by rows, and from left to right in a row.

    The rows are not disjoint: the result is the one of this comparison, as in the generators.
    """
    return sorted(elements, key=cmp_to_key(_compare))


def _compare(one: Element, other: Element) -> int:
    down = int(one.position.y) - int(other.position.y)
    return int(one.position.x) - int(other.position.x) if abs(down) < _ROW else down


class Graph:
    """The lines of a diagram: the elements by their `id`, and the users of each value.

    Contacts, coils and connectors pass a value on, so the users behind them use it, too. If
    `contacts` is False, a contact is a user itself.
    """

    def __init__(self, diagram: Diagram, *, contacts: bool) -> None:
        self.elements = {element.id: element for element in diagram.elements}
        self._contacts = contacts
        self.connectors = {
            element.name.upper(): element
            for element in diagram.elements
            if isinstance(element, Connector)
        }
        self._next: dict[Key, list[tuple[Element, str]]] = {}
        for element in diagram.elements:
            for pin in inputs_of(element):
                for line in pin.connections:
                    self._next.setdefault(self.key(line), []).append((element, pin.name))
            if isinstance(element, Continuation):
                source = self.connectors[element.name.upper()]
                self._next.setdefault((source.id, ""), []).append((element, ""))

    def key(self, line: Connection) -> Key:
        """Return the output that a line begins at."""
        source = self.elements[line.source]
        if not isinstance(source, Block):
            return source.id, ""
        if line.pin or not source.outputs:
            return source.id, line.pin.upper()
        found = [pin.name.upper() for pin in source.outputs if pin.name.upper() != "ENO"]
        return source.id, found[0] if found else "ENO"

    def users(self, key: Key) -> tuple[tuple[Element, str], ...]:
        """Return the elements that use an output, each with its pin and once."""
        return tuple(dict.fromkeys(self._users(key, frozenset())))

    def user_ids(self, key: Key) -> tuple[str, ...]:
        """Return the identities of the elements that use an output, each once."""
        return tuple(dict.fromkeys(element.id for element, _ in self.users(key)))

    def _users(self, key: Key, passed: frozenset[Key]) -> Iterator[tuple[Element, str]]:
        if key in passed:
            return
        for element, pin in self._next.get(key, ()):
            passes = isinstance(element, (Connector, Continuation)) or (
                isinstance(element, Contact) and self._contacts
            )
            ends = isinstance(element, Connector) and (element.id, "") not in self._next
            if not passes or ends:
                yield element, pin
            if passes or isinstance(element, Coil):
                yield from self._users((element.id, ""), passed | {key})
