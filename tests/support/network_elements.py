"""Short ways to write the elements of networks. A source is `id` or `id.pin`; rail 0 is left."""

from __future__ import annotations

from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connection,
    Contact,
    Diagram,
    Element,
    Input,
    InVariable,
    Network,
    Output,
    OutVariable,
    Rail,
)

__all__ = ["block", "coil", "contact", "from_", "ladder", "plan", "read", "written"]


def from_(*sources: str, name: str = "", value: str = "", negated: bool = False) -> Input:
    """Return an input that is connected to sources."""
    ends = [source.partition(".") for source in sources]
    return Input(name, tuple(Connection(a, b) for a, _, b in ends), value, negated)


def contact(
    number: str, variable: str, *sources: str, negated: bool = False, edge: str = ""
) -> Contact:
    """Return a contact."""
    given = from_(*sources)
    return Contact(number, variable=variable, input=given, negated=negated, edge=edge)


def coil(
    number: str, variable: str, *sources: str, negated: bool = False, storage: str = ""
) -> Coil:
    """Return a coil."""
    given = from_(*sources)
    return Coil(number, variable=variable, input=given, negated=negated, storage=storage)


def block(
    number: str, type_: str, inputs: list[Input], outputs: list[str], instance: str = ""
) -> Block:
    """Return a block; an output is `NAME`, or `NAME:=TARGET` with a variable at the pin."""
    ends = [output.partition(":=") for output in outputs]
    pins = tuple(Output(name, target) for name, _, target in ends)
    return Block(number, type=type_, instance=instance, inputs=tuple(inputs), outputs=pins)


def read(number: str, expression: str) -> InVariable:
    """Return a variable that is read."""
    return InVariable(number, expression=expression)


def written(number: str, expression: str, *sources: str) -> OutVariable:
    """Return a variable that is written."""
    return OutVariable(number, expression=expression, input=from_(*sources))


def ladder(*elements: Element, title: str = "", comment: str = "") -> Diagram:
    """Return a Ladder Diagram with a left rail and one network."""
    return Diagram("LD", (Network(1, title, comment),), (Rail("0"), *elements))


def plan(*elements: Element) -> Diagram:
    """Return a Function Block Diagram with one network."""
    return Diagram("FBD", (Network(1),), elements)
