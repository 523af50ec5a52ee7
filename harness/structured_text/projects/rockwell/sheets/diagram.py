"""A routine in Function Block Diagram as a diagram that can be drawn; a sheet is a network."""

from __future__ import annotations

from collections.abc import Mapping

from structured_text.projects.diagrams.networks.model import (
    Block,
    Connection,
    Connector,
    Continuation,
    Diagram,
    Element,
    Input,
    InVariable,
    Network,
    Output,
    OutVariable,
    Position,
)
from structured_text.projects.rockwell.data import Types
from structured_text.projects.rockwell.sheets.blocks import CALLED, FUNCTIONS
from structured_text.projects.rockwell.sheets.model import Node, Routine, Wire
from structured_text.projects.rockwell.sheets.structures import STRUCTURES

__all__ = ["diagram_of"]


def diagram_of(routine: Routine, types: Types) -> Diagram:
    """Return the diagram of the sheets. A pin without a wire is drawn if it is visible."""
    networks = tuple(
        Network(sheet.number, comment=sheet.description, at=sheet.at) for sheet in routine.sheets
    )
    wires: dict[str, list[Wire]] = {}
    outputs: dict[str, dict[str, str]] = {}
    for wire in routine.wires:
        wires.setdefault(wire.target, []).append(wire)
        outputs.setdefault(wire.source, {}).setdefault(wire.output.upper(), wire.output)
    elements = tuple(
        _element(node, wires.get(node.id, []), outputs.get(node.id, {}), types)
        for node in routine.nodes
    )
    return Diagram("SHEETS", networks, elements, by_position=False)


def _element(node: Node, wires: list[Wire], outputs: Mapping[str, str], types: Types) -> Element:
    position = Position(node.x, node.y)
    place = node.id, node.sheet, 0, position, node.at
    only = Input("", tuple(_line(wire) for wire in wires))
    if node.kind == "IRef":
        return InVariable(*place, node.operand)
    if node.kind == "ORef":
        return OutVariable(*place, node.operand, only)
    if node.kind == "ICon":
        return Continuation(*place, node.name)
    if node.kind == "OCon":
        return Connector(*place, node.name, only)
    wired = {wire.input.upper(): wire for wire in wires}
    order = [*node.pins, *(wire.input for wire in wires), *outputs.values()]
    pins = {pin.upper(): pin for pin in order}
    known = _inputs(node, types)
    inputs = tuple(
        Input(pin, (_line(wired[key]),) if key in wired else ())
        for key, pin in pins.items()
        if key in wired or (key in known and key not in outputs)
    )
    names = {pin.name for pin in inputs}
    results = tuple(Output(pin) for pin in pins.values() if pin not in names)
    plain = node.kind in ("Block", "Function", "AddOnInstruction")
    kind = node.name if plain else f"{node.kind} {node.name}".rstrip()
    return Block(*place, kind, node.operand, inputs, results)


def _inputs(node: Node, types: Types) -> set[str]:
    """Return the names of a block's inputs, in upper case."""
    name = node.name.upper()
    if node.kind == "Block" and (name in CALLED or name in FUNCTIONS):
        kind = CALLED[name].type if name in CALLED else FUNCTIONS[name].type
        return {*STRUCTURES[kind].of_inputs(), "SOURCE"}
    block = types.instructions.get(name)
    usages = block.usages if block is not None and node.kind == "AddOnInstruction" else {}
    return {"ENABLEIN", *(pin for pin, usage in usages.items() if usage != "Output")}


def _line(wire: Wire) -> Connection:
    return Connection(wire.source, wire.output)
