"""The symbols of the elements of a network, each in its own cells."""

from __future__ import annotations

from structured_text.projects.diagrams.networks.draw.boxes import Attached, box
from structured_text.projects.diagrams.networks.draw.drawing import Pin, State, columns, wrapped
from structured_text.projects.diagrams.networks.draw.making import (
    Maker,
    Shape,
    input_mark,
    mark,
    variable_text,
)
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Connector,
    Contact,
    Continuation,
    Element,
    Input,
    InVariable,
    Jump,
    OutVariable,
    Return,
)

__all__ = ["input_of", "line_shape", "outputs_of", "shape"]


def input_of(element: Element) -> tuple[Input, ...]:
    """Return the inputs of an element."""
    if isinstance(element, Block):
        return element.inputs
    if isinstance(element, (Contact, Coil, OutVariable, Connector, Jump, Return)):
        return (element.input,)
    return ()


def outputs_of(element: Element) -> tuple[str, ...]:
    """Return the formal names of the outputs of an element; an only output has an empty name."""
    if isinstance(element, Block):
        return tuple(output.name for output in element.outputs)
    if isinstance(element, (Connector, Jump, Return)):
        return ()
    if isinstance(element, OutVariable):
        return ("",) if element.read else ()
    return ("",)


def line_shape() -> Shape:
    """Return the shape of a piece of a line that needs a row of its own."""
    return Shape("", 0, 1, inputs=[Pin("", "", False, 0, 0)], outputs=[Pin("", "", True, 0, 0)])


def shape(element: Element, attached: Attached, state: State) -> Shape:
    """Return the shape of an element other than a rail."""
    if isinstance(element, Block):
        return box(element, attached, state)
    if isinstance(element, (Contact, Coil)):
        return _bars(element, state)
    text, kind = _word(element)
    lines = wrapped(state.named(text, element.id)) if kind == "text" else [text]
    made = Maker(element.id, state.on(element.id))
    width = max((columns(line) for line in lines), default=0) or 1
    made.made.at_right = right = isinstance(element, (InVariable, Continuation))
    start = 0
    for given in input_of(element):
        start = made.input_marks(given, 0, 0)
        made.input(given.name, 0, 0)
    align = "end" if right else "start"
    for row, line in enumerate(lines):
        x = start + (width - columns(line) if right else 0)
        made.symbol(kind, x, row, line, align=align)
    for name in outputs_of(element):
        made.output(name, start + width, 0)
    return made.shape(start + width, max(1, len(lines)))


def _word(element: Element) -> tuple[str, str]:
    """Return the text of an element that consists of a text, and the kind of its symbol."""
    if isinstance(element, Connector):
        return f">{element.name}>", "flag"
    if isinstance(element, Continuation):
        return f">{element.name}>", "flag"
    if isinstance(element, Jump):
        return f">>{element.label}", "flag"
    if isinstance(element, Return):
        return "<RETURN>", "flag"
    assert isinstance(element, (InVariable, OutVariable))
    return variable_text(element), "text"


def _bars(element: Contact | Coil, state: State) -> Shape:
    """Return a contact or a coil with its name above it."""
    storage = element.storage if isinstance(element, Coil) else ""
    sign = mark(element.negated, element.edge, storage) or " "
    kind = "contact" if isinstance(element, Contact) else "coil"
    names = wrapped(state.named(element.variable, element.id))
    made = Maker(element.id, state.on(element.id))
    before = len(input_mark(element.input))
    size = 2 + len(sign)
    width = max([before + size, *map(columns, names)])
    row, left = len(names), (width - size - before) // 2
    for k, name in enumerate(names):
        made.symbol("text", max(0, (width - columns(name)) // 2), k, name)
    made.input("", left, row)
    at = made.input_marks(element.input, left, row)
    made.symbol(kind, at, row, sign, size)
    made.output("", at + size, row)
    made.made.anchor = at + size // 2
    return made.shape(width, row + 1)
