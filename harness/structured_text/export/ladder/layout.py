"""The places of the elements of a ladder, so that none overlaps another.

Each rung has rows and columns. A block covers a row for each of its pins. The first line to an
input stays in the row of its element; each further line gets a row below.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from structured_text.projects.diagrams.networks import model as m

__all__ = ["COMMENT_WIDTH", "ROW", "Box", "Layout", "layout_of"]

#: Height of a row, which is also the distance of the pins of a block.
ROW = 30
#: Height of the name in a block, above its pins.
_TITLE = 20
_LEFT, _TOP, _BETWEEN_RUNGS = 20, 20, 40
_GAP = 50
_CONTACT, _VARIABLE_HEIGHT, _RAIL = (21, 15), 24, 3
_LETTER = 8
COMMENT_WIDTH = 600


@dataclass(frozen=True)
class Box:
    """The place and size of an element; `inputs` and `outputs` are heights of its pins in it."""

    x: int
    y: int
    width: int
    height: int
    inputs: tuple[int, ...] = ()
    outputs: tuple[int, ...] = ()


@dataclass(frozen=True)
class Layout:
    """The boxes of elements by their `id`, and those of comments by the number of the network."""

    elements: dict[str, Box]
    comments: dict[int, Box]


def layout_of(diagram: m.Diagram) -> Layout:
    """Return the places of all elements, rung below rung."""
    boxes: dict[str, Box] = {}
    comments: dict[int, Box] = {}
    top = _TOP
    for network in diagram.networks:
        own = [element for element in diagram.elements if element.network == network.number]
        if network.comment:
            height = 20 * (network.comment.count("\n") + 1) + 10
            comments[network.number] = Box(_LEFT, top, COMMENT_WIDTH, height)
            top += height + 10
        placed = _Rung(own, top).boxes()
        boxes |= placed
        top = max((box.y + box.height for box in placed.values()), default=top) + _BETWEEN_RUNGS
    return Layout(boxes, comments)


def _inputs(element: m.Element) -> Sequence[m.Input]:
    if isinstance(element, m.Block):
        return element.inputs
    found = getattr(element, "input", None)
    return () if found is None else (found,)


def _text_width(text: str) -> int:
    return _LETTER * len(text)


class _Rung:
    """Rows and columns of the elements of a rung."""

    def __init__(self, elements: Sequence[m.Element], top: int) -> None:
        self._all, self._top = elements, top
        self._known = {element.id: element for element in elements}
        self._row: dict[str, int] = {}
        self._next = 0

    def boxes(self) -> dict[str, Box]:
        used = {
            line.source
            for element in self._all
            for given in _inputs(element)
            for line in given.connections
        }
        for element in self._all:
            if element.id not in used and not isinstance(element, m.Rail):
                self._place(element, self._next)
        columns = self._columns()
        widths: dict[int, int] = {}
        for element in self._all:
            column = columns[element.id]
            widths[column] = max(widths.get(column, 0), self._width(element))
        lefts = {
            column: _LEFT + sum(widths.get(before, 0) + _GAP for before in range(column))
            for column in range(max(widths, default=0) + 2)
        }
        return {
            element.id: self._box(element, lefts[columns[element.id]], widths[columns[element.id]])
            for element in self._all
        }

    # --- rows ---

    def _place(self, element: m.Element, row: int) -> None:
        if element.id in self._row or isinstance(element, m.Rail):
            return
        if isinstance(element, m.Block):
            self._place_block(element, max(row, self._next))
            return
        lines = [line for given in _inputs(element) for line in given.connections]
        source = self._known[lines[0].source] if lines else None
        if isinstance(source, m.Block):
            self._place(source, row)
            pins = [pin.name for pin in source.outputs]
            row = self._row[source.id] + (pins.index(lines[0].pin) if lines[0].pin in pins else 0)
        self._row[element.id] = row
        self._next = max(self._next, row + 1)
        for number, line in enumerate(lines):
            self._place(self._known[line.source], row if not number else self._next)

    def _place_block(self, block: m.Block, row: int) -> None:
        self._row[block.id] = row
        free = row
        for number, given in enumerate(block.inputs):
            for line in given.connections:
                self._next = max(free, row + number)
                self._place(self._known[line.source], self._next)
                free = max(self._next, row + number + 1)
        self._next = max(free, row + _pins(block))

    # --- columns ---

    def _columns(self) -> dict[str, int]:
        found: dict[str, int] = {}

        def column(element: m.Element) -> int:
            if element.id not in found:
                lines = [line for given in _inputs(element) for line in given.connections]
                sources = [column(self._known[line.source]) for line in lines]
                start = 0 if isinstance(element, m.Rail) else 1
                found[element.id] = max([start, *(number + 1 for number in sources)])
            return found[element.id]

        for element in self._all:
            column(element)
        for element in self._all:
            for given in _inputs(element):
                for line in given.connections:
                    if isinstance(self._known[line.source], m.InVariable):
                        found[line.source] = found[element.id] - 1
        last = max(found.values(), default=0) + 1
        for element in self._all:
            if isinstance(element, m.Rail) and not element.left:
                found[element.id] = last
        return found

    # --- boxes ---

    def _width(self, element: m.Element) -> int:
        if isinstance(element, m.Contact | m.Coil):
            return max(_CONTACT[0], _text_width(element.variable))
        return self._own_width(element)

    def _own_width(self, element: m.Element) -> int:
        if isinstance(element, m.Contact | m.Coil):
            return _CONTACT[0]
        if isinstance(element, m.InVariable | m.OutVariable):
            return _text_width(element.expression) + 10
        if isinstance(element, m.Block):
            left = max((_text_width(pin.name) for pin in element.inputs), default=0)
            right = max((_text_width(pin.name) for pin in element.outputs), default=0)
            title = max(_text_width(element.type), _text_width(element.instance))
            return max(left + right + 20, title + 10)
        return _RAIL

    def _box(self, element: m.Element, left: int, room: int) -> Box:
        width = self._own_width(element)
        if isinstance(element, m.Rail):
            return self._rail(element, left)
        middle = self._middle(self._row[element.id])
        if isinstance(element, m.Block):
            return self._block(element, left, middle)
        if isinstance(element, m.Contact | m.Coil):
            x, y = left + (room - width) // 2, middle - 8
            return Box(x, y, width, _CONTACT[1], (8,), (8,))
        x = left + room - width if isinstance(element, m.InVariable) else left
        half = _VARIABLE_HEIGHT // 2
        return Box(x, middle - half, width, _VARIABLE_HEIGHT, (half,), (half,))

    def _middle(self, row: int) -> int:
        """Return the height of a row, below the name of an instance and the title of a block."""
        return self._top + _TITLE + _TITLE + ROW // 2 + ROW * row

    def _block(self, block: m.Block, left: int, middle: int) -> Box:
        height = _TITLE + ROW * _pins(block)
        inputs = tuple(_TITLE + ROW // 2 + ROW * number for number in range(len(block.inputs)))
        outputs = tuple(_TITLE + ROW // 2 + ROW * number for number in range(len(block.outputs)))
        y = middle - _TITLE - ROW // 2
        return Box(left, y, self._own_width(block), height, inputs, outputs)

    def _rail(self, rail: m.Rail, left: int) -> Box:
        """Return the box of a rail, which has a pin in the row of each element at it."""
        rows = [0]
        if rail.left:
            rows = [
                self._row[element.id]
                for element in self._all
                if element.id in self._row and not isinstance(element, m.Block)
                for given in _inputs(element)
                if any(line.source == rail.id for line in given.connections)
            ]
            rows += [
                self._row[element.id] + number
                for element in self._all
                if isinstance(element, m.Block)
                for number, given in enumerate(element.inputs)
                if any(line.source == rail.id for line in given.connections)
            ]
        else:
            rows = [self._row[element.id] for element in self._all if isinstance(element, m.Coil)]
        rows = sorted(set(rows))
        first = self._middle(rows[0])
        pins = tuple(self._middle(row) - first + ROW // 2 for row in rows)
        return Box(left, first - ROW // 2, _RAIL, pins[-1] + ROW // 2, (*pins,), (*pins,))


def _pins(block: m.Block) -> int:
    return max(len(block.inputs), len(block.outputs), 1)
