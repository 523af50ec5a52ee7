"""A drawing of a network in cells of one letter, before it becomes text or SVG.

`layout` makes it, `bands` cuts it into bands of a given width, `text` and `svg` write it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from unicodedata import combining, east_asian_width

__all__ = ["RAIL", "Drawing", "Output", "Pin", "State", "Symbol", "Wire", "columns", "wrapped"]

#: The `id` of an element, and the formal name of its output; empty for an element with one output.
Output = tuple[str, str]
#: The left power rail as an output.
RAIL: Output = ("", "")

#: Width of a name before it goes on in the next line, in letters.
_LONGEST = 24
#: Letters behind which a long name is best cut.
_BREAKS = "._ ,)]"


@dataclass(frozen=True)
class State:
    """What a drawing shows of a run.

    A key is the `id` of an element, or `id.pin` for an output of a block. An output without a key
    of its own has the state of its block.

    Attributes:
        energised: Whether there is power at the output of an element.
        values: The texts to show beside the names.
        between: The text between a name and its value.
    """

    energised: Mapping[str, bool] = field(default_factory=dict)
    values: Mapping[str, str] = field(default_factory=dict)
    between: str = " = "

    def on(self, element: str, pin: str = "") -> bool | None:
        """Return whether an output has power; None if this is not known."""
        return self.energised.get(f"{element}.{pin}", self.energised.get(element))

    def power(self, outputs: Iterable[Output]) -> bool | None:
        """Return whether a line from some outputs has power; None if this is not known."""
        states = [
            (True if self.energised else None) if output == RAIL else self.on(*output)
            for output in outputs
        ]
        return True if True in states else None if None in states else False

    def named(self, name: str, key: str) -> str:
        """Return a name with its value behind it, if there is one."""
        value = self.values.get(key, "")
        return self.between.join(part for part in (name, value) if part)


@dataclass(frozen=True)
class Symbol:
    """A part of a drawing that has an area.

    Attributes:
        kind: `contact`, `coil`, `box`, `text` (beside a symbol), `inner` (in a box), `flag` (a
            jump, a return or the end of a line), `not` (the circle of an inverted pin), `rail`,
            `cut` (the end of a line at the edge of a band).
        x: The first column.
        y: The first row.
        width: The number of columns.
        height: The number of rows.
        text: The text in it, in one line; for a rail, `left` or `right`.
        element: The `id` of its element; empty if it has none.
        on: Whether its element has power; None if this is not known.
        pin: The formal name of the output that `on` is about, if the element is a block.
        align: Where a text stands if its letters are narrower than the cells: `start`, `middle`,
            `end`.
    """

    kind: str
    x: int
    y: int
    width: int
    height: int = 1
    text: str = ""
    element: str = ""
    on: bool | None = None
    align: str = "middle"
    pin: str = ""

    def moved(self, x: int, y: int) -> Symbol:
        """Return the symbol further to the right and further down."""
        return replace(self, x=self.x + x, y=self.y + y)


@dataclass(frozen=True)
class Wire:
    """A horizontal or vertical piece of a line.

    A horizontal piece ends at the edge of a symbol (a whole number), or in the middle of a cell
    with a vertical piece (a half), to which it is connected then. A horizontal piece that goes on
    behind a vertical one is not connected to it.

    Attributes:
        x1: The left end, in columns.
        y1: The upper end, in rows.
        x2: The right end.
        y2: The lower end.
        on: Whether it has power; None if this is not known.
        back: Whether it leads from right to left.
        outputs: The outputs that it comes from; it has power if one of them has it.
    """

    x1: float
    y1: int
    x2: float
    y2: int
    on: bool | None = None
    back: bool = False
    outputs: tuple[Output, ...] = ()

    def moved(self, x: float, y: int) -> Wire:
        """Return the wire further to the right and further down."""
        return replace(self, x1=self.x1 + x, x2=self.x2 + x, y1=self.y1 + y, y2=self.y2 + y)


@dataclass(frozen=True)
class Pin:
    """The place at which a line begins or ends.

    Attributes:
        element: The `id` of the element.
        name: The formal name of a block's pin; otherwise empty.
        output: Whether a line begins here.
        x: The column of the symbol's edge.
        y: The row.
    """

    element: str
    name: str
    output: bool
    x: int
    y: int

    def moved(self, x: int, y: int) -> Pin:
        """Return the pin further to the right and further down."""
        return replace(self, x=self.x + x, y=self.y + y)


@dataclass(frozen=True)
class Drawing:
    """A network as symbols and wires.

    Attributes:
        width: The number of columns.
        height: The number of rows.
        symbols: The symbols.
        wires: The wires.
        pins: The ends of all lines.
        cuts: The columns at which the drawing can be cut into bands: only horizontal wires cross
            their left edges.
        heading: The number, title, label and comment of the network, in lines.
        words: The elements and their connections in words.
    """

    width: int
    height: int
    symbols: tuple[Symbol, ...] = ()
    wires: tuple[Wire, ...] = ()
    pins: tuple[Pin, ...] = ()
    cuts: tuple[int, ...] = ()
    heading: tuple[str, ...] = ()
    words: str = ""


def columns(text: str) -> int:
    """Return the number of columns that a text fills: wide letters fill two, accents none."""
    return sum(
        0 if combining(letter) else 2 if east_asian_width(letter) in "WF" else 1 for letter in text
    )


def wrapped(text: str, width: int = _LONGEST) -> list[str]:
    """Return a text in lines of at most `width` columns, cut behind a dot or a blank if possible.

    Every letter is kept, except blanks at the places of the cuts.
    """
    found: list[str] = []
    for line in text.splitlines():
        rest = line.strip()
        while columns(rest) > width:
            most = next(k for k in range(len(rest), 0, -1) if columns(rest[:k]) <= width)
            good = [k for k in range(width // 3, most + 1) if rest[k - 1] in _BREAKS]
            at = good[-1] if good else most
            found.append(rest[:at].rstrip())
            rest = rest[at:].lstrip()
        if rest:
            found.append(rest)
    return found
