"""What all symbols are made of: marks, texts, and the shape that collects them."""

from __future__ import annotations

from dataclasses import dataclass, field

from structured_text.projects.diagrams.networks.draw.drawing import Pin, Symbol, Wire, columns
from structured_text.projects.diagrams.networks.model import Input, InVariable, OutVariable

__all__ = ["PIN_EDGES", "Maker", "Shape", "input_mark", "mark", "variable_text", "written"]

#: The marks of the edges that a pin detects.
PIN_EDGES = {"": "", "rising": ">", "falling": "<"}
_EDGES = {"": "", "rising": "P", "falling": "N"}
_STORAGES = {"": "", "set": "S", "reset": "R"}


@dataclass
class Shape:
    """An element with its symbols, in cells from its upper left corner.

    Attributes:
        element: The `id` of the element; empty for a piece of a line.
        width: The number of columns.
        height: The number of rows, with empty rows at the bottom.
        anchor: The columns left of the place that is put in line with the other shapes of a column;
            None for the left or right end, as `at_right` says.
        at_right: Whether a shape without an anchor stands at the right end of its column.
        symbols: The symbols.
        wires: The lines from variables to pins.
        ends: The ends of these lines.
        inputs: The places at which lines from other elements end, in the order of the inputs.
        outputs: The places at which lines to other elements begin, in the order of the outputs.
    """

    element: str
    width: int = 0
    height: int = 0
    anchor: int | None = None
    at_right: bool = False
    symbols: list[Symbol] = field(default_factory=list)
    wires: list[Wire] = field(default_factory=list)
    ends: list[Pin] = field(default_factory=list)
    inputs: list[Pin] = field(default_factory=list)
    outputs: list[Pin] = field(default_factory=list)


class Maker:
    """Collects the symbols and pins of an element."""

    def __init__(self, element: str, on: bool | None) -> None:
        self.made = Shape(element)
        self._on = on

    def symbol(
        self,
        kind: str,
        x: int,
        y: int,
        text: str,
        width: int = 0,
        align: str = "middle",
        pin: str = "",
    ) -> None:
        """Add a symbol with a text in one row."""
        wide, owner = width or columns(text), self.made.element
        made = Symbol(kind, x, y, wide, 1, text, owner, self._on, align, pin)
        self.made.symbols.append(made)

    def input(self, name: str, x: int, y: int) -> None:
        """Add an input."""
        self.made.inputs.append(Pin(self.made.element, name, False, x, y))

    def output(self, name: str, x: int, y: int) -> None:
        """Add an output."""
        self.made.outputs.append(Pin(self.made.element, name, True, x, y))

    def input_marks(self, given: Input, x: int, y: int) -> int:
        """Add circle and edge of an input that is not a pin; return the column behind them."""
        for sign in input_mark(given):
            self.symbol("not" if sign == "o" else "text", x, y, sign)
            x += 1
        return x

    def shape(self, width: int, height: int) -> Shape:
        """Return the shape with its size."""
        self.made.width, self.made.height = width, height
        return self.made


def input_mark(given: Input) -> str:
    """Return the marks of an input that is not the pin of a block; `o` is a circle."""
    return ("o" if given.negated else "") + PIN_EDGES.get(given.edge, "")


def mark(negated: bool, edge: str, storage: str = "") -> str:
    """Return the letters in a contact or coil."""
    return ("/" if negated else "") + _STORAGES.get(storage, "") + _EDGES.get(edge, "")


def variable_text(element: InVariable | OutVariable) -> str:
    """Return the text of a variable with its marks."""
    if isinstance(element, InVariable):
        return f"NOT {element.expression}" if element.negated else element.expression
    return written(element.expression, mark(element.negated, element.edge, element.storage))


def written(name: str, sign: str) -> str:
    """Return the text of a variable that is written; the mark of a coil is in front of it."""
    return f"({sign}) {name}" if sign else name
