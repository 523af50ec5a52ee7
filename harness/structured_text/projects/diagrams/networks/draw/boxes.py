"""The symbol of a block: a box with pins, and the variables at its pins."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from structured_text.projects.diagrams.networks.draw.drawing import (
    Output,
    Pin,
    State,
    Symbol,
    Wire,
    columns,
    wrapped,
)
from structured_text.projects.diagrams.networks.draw.making import (
    PIN_EDGES,
    Maker,
    Shape,
    mark,
    variable_text,
    written,
)
from structured_text.projects.diagrams.networks.model import Block, InVariable, OutVariable

__all__ = ["Attached", "box"]

#: Length of the line between a variable and the pin of its block.
_LEAD = 2

#: The variables that are drawn at the pins of a block, by (whether it is an output, index of the
#: pin).
Attached = dict[tuple[bool, int], InVariable | OutVariable]


@dataclass(frozen=True)
class _Place:
    """A pin of a block.

    Attributes:
        name: The formal name.
        inner: The text in the box.
        outer: The text at the outer end, in lines.
        negated: Whether the pin has a circle.
        output: Whether it is an output.
        element: The `id` of the variable at the outer end; empty for a text of the block itself.
        on: Whether the line between variable and pin has power.
        source: The output whose power that is.
    """

    name: str
    inner: str
    outer: tuple[str, ...]
    negated: bool
    output: bool
    element: str
    on: bool | None
    source: Output


def box(block: Block, attached: Attached, state: State) -> Shape:
    """Return a block: its instance above a box with its type, its pins and its statements."""
    places = _places(block, attached, state)
    left = [place for place in places if not place.output]
    right = [place for place in places if place.output]
    above = wrapped(state.named(block.instance, block.id))
    title = wrapped(block.type)
    operands = _operands(block.operands)
    in_title = len(left) < 2 > len(right) and not any(one.inner or one.outer for one in places)
    code = [*operands, *_code(block.statements)]
    count = max(len(left), len(right))
    pairs = [[*left[k : k + 1], *right[k : k + 1]] for k in range(count)]
    inside = max(
        3,
        *(columns(text) + 2 for text in (*title, *code, *above)),
        *(sum(columns(place.inner) for place in pair) + 3 for pair in pairs),
    )
    begin = _outer_width(left)
    end = begin + inside + 2
    made = Maker(block.id, state.on(block.id))
    for k, text in enumerate(above):
        made.symbol("text", begin + (inside + 2 - columns(text)) // 2, k, text)
    first = row = len(above) + 1
    for text in title:
        made.symbol("inner", begin + 1 + (inside - columns(text)) // 2, row, text)
        row += 1
    if in_title:
        for place in (*left, *right):
            _add(made, place, end if place.output else begin, first)
        pairs = []
    for pair in pairs:
        for place in pair:
            _add(made, place, end if place.output else begin, row)
        row += max(1, *(len(place.outer) for place in pair))
    for text in code:
        if text:
            made.symbol("inner", begin + 2, row, text, align="start")
        row += 1
    frame = Symbol(
        "box", begin, len(above), inside + 2, row - len(above) + 1, "", block.id, state.on(block.id)
    )
    made.made.symbols.append(frame)
    made.made.anchor = (begin + end) // 2
    # An empty row below keeps boxes apart.
    return made.shape(end + _outer_width(right), row + 2)


def _places(block: Block, attached: Attached, state: State) -> list[_Place]:
    outer: tuple[str, ...]
    found = []
    for k, pin in enumerate(block.inputs):
        variable = attached.get((False, k))
        outer = () if pin.connections else tuple(wrapped(pin.value))
        element, on = "", None
        if variable:
            outer, element, on = _outer(variable, state), variable.id, state.on(variable.id)
        inner = PIN_EDGES.get(pin.edge, "") + state.named(pin.name, f"{block.id}.{pin.name}")
        source = (element or block.id, "")
        found.append(_Place(pin.name, inner, outer, pin.negated, False, element, on, source))
    for k, output in enumerate(block.outputs):
        variable = attached.get((True, k))
        element = variable.id if variable else ""
        target = written(output.target, mark(False, "", output.storage)) if output.target else ""
        outer = _outer(variable, state) if variable else tuple(wrapped(target))
        inner = state.named(output.name, f"{block.id}.{output.name}")
        on = state.on(block.id, output.name)
        source = (block.id, output.name)
        found.append(_Place(output.name, inner, outer, output.negated, True, element, on, source))
    return found


def _outer(variable: InVariable | OutVariable, state: State) -> tuple[str, ...]:
    # A variable without a name has an empty line, so that its connection is drawn.
    return tuple(wrapped(state.named(variable_text(variable), variable.id))) or ("",)


def _code(statements: Sequence[str]) -> list[str]:
    """Return the lines of statements."""
    return [line.rstrip() for text in statements for line in text.expandtabs(2).splitlines()]


def _operands(operands: Sequence[tuple[str, str]]) -> list[str]:
    """Return the lines of operands: the texts stand below each other, behind the names."""
    width = max((columns(name) for name, _ in operands), default=0)
    found = []
    for name, text in operands:
        for line in wrapped(text):
            blanks = " " * (width - columns(name) + (2 if width else 0))
            found.append(f"{name}{blanks}{line}")
            name = ""
    return found


def _outer_width(places: Sequence[_Place]) -> int:
    """Return the columns beside a box: circles, and the texts at the pins with their lines."""
    texts = [columns(line) for place in places for line in place.outer]
    circle = any(place.negated for place in places)
    return (max(texts) + _LEAD if texts else 0) + circle


def _add(made: Maker, place: _Place, edge: int, row: int) -> None:
    """Add a pin, with the variable at it and the line between them, at the edge of the box."""
    element, shape = made.made.element, made.made
    wide = columns(place.inner)
    if wide:
        x = edge - 1 - wide if place.output else edge + 1
        align = "end" if place.output else "start"
        pin = place.name if place.output else ""
        made.symbol("inner", x, row, place.inner, align=align, pin=pin)
    at = edge
    if place.negated:
        made.symbol("not", edge if place.output else edge - 1, row, "o")
        at = edge + 1 if place.output else edge - 1
    (made.output if place.output else made.input)(place.name, at, row)
    if not place.outer:
        return
    far = at + _LEAD if place.output else at - _LEAD
    wire = Wire(min(at, far), row, max(at, far), row, place.on, outputs=(place.source,))
    shape.wires.append(wire)
    if place.element:
        shape.ends += [
            Pin(element, place.name, place.output, at, row),
            Pin(place.element, "", not place.output, far, row),
        ]
    for k, text in enumerate(place.outer):
        wide = columns(text)
        x = far if place.output else far - wide
        owner, align = place.element or element, "start" if place.output else "end"
        shape.symbols.append(Symbol("text", x, row + k, wide, 1, text, owner, place.on, align))
