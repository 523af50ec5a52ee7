"""A network as data for JSON, so that a process can pass it to another one."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from structured_text.language.source import Line, NetworkLine
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
    Network,
    Output,
    OutVariable,
    Position,
    Rail,
    Return,
)

__all__ = ["as_data", "from_data", "lines_of", "network_at", "stored_networks"]

#: What the lines of a translation call a network.
_WORDS = ("rung", "network", "sheet")
_KINDS = {
    kind.__name__: kind
    for kind in (
        *(Rail, Contact, Coil, InVariable, OutVariable),
        *(Block, Connector, Continuation, Jump, Return),
    )
}


def as_data(diagram: Diagram, number: int) -> dict[str, Any]:
    """Return a network of a diagram, with the rails, as data."""
    elements = [
        {**asdict(element), "kind": type(element).__name__}
        for element in diagram.elements
        if element.network == number or isinstance(element, Rail)
    ]
    networks = [asdict(network) for network in diagram.networks if network.number == number]
    return {"language": diagram.language, "networks": networks, "elements": elements}


def from_data(data: Mapping[str, Any]) -> Diagram:
    """Return the diagram with the network from which `as_data` made the data."""
    networks = tuple(Network(**given) for given in data["networks"])
    return Diagram(data["language"], networks, tuple(map(_element, data["elements"])))


def stored_networks(source: Path, places: Collection[str]) -> dict[str, dict[str, Any]]:
    """Return the networks of a source as data, by their places, such as `Main, rung 3`.

    `places` are those of the lines of the source. A network without lines is not drawn.
    """
    found = {}
    for pou, diagram in getattr(source, "diagrams", ()):
        for network in diagram.networks:
            for word in _WORDS:
                place = f"{pou}, {word} {network.number}"
                if place in places:
                    found[place] = as_data(diagram, network.number)
    return found


def network_at(source: Path, line: NetworkLine) -> tuple[Path, Diagram, int] | None:
    """Return source, diagram and number of the network that a line was translated from."""
    for owner, diagram in getattr(source, "diagrams", ()):
        for network in diagram.networks:
            if owner == line.pou and _is_of(line.network, network.number):
                return source, diagram, network.number
    return None


def lines_of(source: Path, owner: str, number: int) -> list[Line]:
    """Return the translation of a network; `owner` is the name of its POU, method or action."""
    lines: Sequence[Line] = getattr(source, "lines", None) or ()
    title = getattr(source, "title", "")
    return [
        line for line in lines if (line.owner or title) == owner and _is_of(line.network, number)
    ]


def _is_of(place: str, number: int) -> bool:
    return any(place == f"{word} {number}" for word in _WORDS)


def _element(data: Mapping[str, Any]) -> Element:
    given = {key: value for key, value in data.items() if key != "kind"}
    given["position"] = Position(**given["position"])
    if "input" in given:
        given["input"] = _input(given["input"])
    if data["kind"] == "Block":
        given["inputs"] = tuple(map(_input, given["inputs"]))
        given["outputs"] = tuple(Output(**output) for output in given["outputs"])
        given["statements"] = tuple(given["statements"])
        given["operands"] = tuple(map(tuple, given["operands"]))
    made: Element = _KINDS[data["kind"]](**given)
    return made


def _input(data: Mapping[str, Any]) -> Input:
    connections = tuple(Connection(**given) for given in data["connections"])
    return Input(**{**data, "connections": connections})
