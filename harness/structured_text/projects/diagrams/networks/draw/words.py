"""The elements of a network in words, for screen readers."""

from __future__ import annotations

from structured_text.projects.diagrams.networks.draw.making import variable_text
from structured_text.projects.diagrams.networks.draw.shapes import input_of
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Connector,
    Contact,
    Continuation,
    Diagram,
    Element,
    Input,
    InVariable,
    Jump,
    OutVariable,
    Rail,
    Return,
)

__all__ = ["in_words", "name_of"]


def in_words(diagram: Diagram, network: int) -> str:
    """Return a sentence for each element of a network that does something with its inputs."""
    names = {element.id: element for element in diagram.elements}
    found = []
    for element in diagram.elements:
        if element.network != network:
            continue
        sources = [_source(given, names) for given in input_of(element)]
        text = "; ".join(source for source in sources if source)
        if isinstance(element, Block) and element.operands:
            with_ = ", ".join(" ".join(filter(None, pair)) for pair in element.operands)
            text = f"{text} with {with_}"
        if isinstance(element, (Rail, InVariable, Continuation)):
            continue
        found.append(f"{name_of(element)}{' from ' if text else ''}{text}.")
    return " ".join(found)


def _source(given: Input, names: dict[str, Element]) -> str:
    """Return an input in words: what it is connected to, and how it changes the value."""
    texts = [_end(connection, names) for connection in given.connections] or [given.value]
    text = " or ".join(texts)
    if not text:
        return ""
    before = f"{given.name} " if given.name else ""
    change = [
        word
        for word, yes in (("inverted", given.negated), (f"{given.edge} edge", given.edge))
        if yes
    ]
    return f"{before}{text}{', ' if change else ''}{', '.join(change)}"


def _end(connection: Connection, names: dict[str, Element]) -> str:
    element = names.get(connection.source)
    if element is None:
        return "?"
    if isinstance(element, Rail):
        return "the left rail"
    text = name_of(element)
    return f"{text} {connection.pin}" if connection.pin else text


def name_of(element: Element) -> str:
    """Return the kind and the name of an element, with its marks in words."""
    if isinstance(element, (InVariable, OutVariable)):
        return variable_text(element)
    if isinstance(element, Block):
        return f"block {element.instance} ({element.type})" if element.instance else element.type
    if isinstance(element, (Contact, Coil)):
        storage = element.storage if isinstance(element, Coil) else ""
        marks = [
            "negated" if element.negated else "",
            storage,
            element.edge and f"{element.edge} edge",
        ]
        kind = "contact" if isinstance(element, Contact) else "coil"
        return ", ".join([f"{kind} {element.variable}", *(mark for mark in marks if mark)])
    if isinstance(element, Jump):
        return f"jump to {element.label}"
    if isinstance(element, Return):
        return "return"
    if isinstance(element, (Connector, Continuation)):
        return f"line {element.name}"
    return "rail"
