"""Checks of a diagram that its translation relies on."""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.errors import near
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connector,
    Contact,
    Continuation,
    Diagram,
    Element,
    Input,
    Jump,
    OutVariable,
    Rail,
    Return,
)

__all__ = ["DiagramError", "check", "inputs_of", "named", "wrong"]


class DiagramError(Exception):
    """The error for a diagram that cannot be translated: the message, its line and a hint."""

    def __init__(self, message: str, at: int, hint: str) -> None:
        super().__init__(message)
        self.message, self.at, self.hint = message, at, hint


def wrong(element: Element, message: str, hint: str) -> DiagramError:
    """Return the error for an element; the message begins with its network."""
    place = f"network {element.network}: " if element.network else ""
    return DiagramError(f"{place}{message}", element.at, hint)


def inputs_of(element: Element) -> tuple[Input, ...]:
    """Return the inputs of an element."""
    if isinstance(element, Block):
        return element.inputs
    if isinstance(element, (Coil, Connector, Contact, Jump, OutVariable, Return)):
        return (element.input,)
    return ()


def check(diagram: Diagram) -> None:
    """Raise DiagramError if names or connections of a diagram are wrong."""
    _check_ids(diagram)
    _check_labels(diagram)
    _check_connectors(diagram)
    known = {element.id: element for element in diagram.elements}
    for element in diagram.elements:
        for pin in inputs_of(element):
            for line in pin.connections:
                source = known.get(line.source)
                if source is None:
                    text = f"{named(element)} is connected to an element that does not exist"
                    raise wrong(element, text, "draw the connection again")
                if isinstance(source, (Connector, Jump, Return)) or (
                    isinstance(source, Rail) and not source.left
                ):
                    text = f"{named(element)} is connected to an element without an output"
                    raise wrong(element, text, "draw the connection again")
        if isinstance(element, Contact) and not _is_connected(element.input):
            text = f"{named(element)} is not connected on its left side"
            raise wrong(element, text, "connect it, or remove it")
        if isinstance(element, (Jump, Return)) and not _is_connected(element.input):
            raise wrong(element, f"{named(element)} is not connected", "connect it, or remove it")


def named(element: Element) -> str:
    """Return the words for an element in a message."""
    if isinstance(element, Block):
        return f"the block {element.instance or element.type}"
    if isinstance(element, (Coil, Contact)):
        return f"the {type(element).__name__.lower()} {element.variable}"
    if isinstance(element, OutVariable):
        return f"the output {element.expression}"
    if isinstance(element, (Connector, Continuation)):
        return f"the {type(element).__name__.lower()} {element.name}"
    return f"the jump to {element.label}" if isinstance(element, Jump) else "the return"


def _is_connected(pin: Input) -> bool:
    return bool(pin.connections or pin.value)


def _check_ids(diagram: Diagram) -> None:
    seen: set[str] = set()
    for element in diagram.elements:
        if element.id in seen:
            text = f"two elements have the number {element.id}"
            raise wrong(element, text, "draw the element again, so that it gets its own number")
        seen.add(element.id)


def _labels(diagram: Diagram) -> Iterator[tuple[str, int, int]]:
    """Yield each label in upper case with the number and line of its network."""
    for network in diagram.networks:
        if network.label:
            yield network.label.upper(), network.number, network.at


def _check_labels(diagram: Diagram) -> None:
    seen: dict[str, int] = {}
    for label, number, at in _labels(diagram):
        if label in seen:
            text = f"network {number}: the label {label} is also the label of network {seen[label]}"
            raise DiagramError(text, at, "give each label a name of its own")
        seen[label] = number
    for element in diagram.elements:
        if isinstance(element, Jump) and element.label.upper() not in seen:
            text = f"there is no label {element.label} to jump to"
            names = [network.label for network in diagram.networks if network.label]
            raise wrong(element, text, near(element.label, names, "the labels are"))


def _check_connectors(diagram: Diagram) -> None:
    seen: set[str] = set()
    for element in diagram.elements:
        if isinstance(element, Connector):
            if element.name.upper() in seen:
                text = f"there are two connectors with the name {element.name}"
                raise wrong(element, text, "give each connector a name of its own")
            seen.add(element.name.upper())
    for element in diagram.elements:
        if isinstance(element, Continuation) and element.name.upper() not in seen:
            text = f"there is no connector for the continuation {element.name}"
            raise wrong(element, text, "draw the connector, or connect the element directly")
