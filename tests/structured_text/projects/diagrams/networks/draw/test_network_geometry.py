"""Properties of the drawings of random networks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations
from math import ceil, floor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from structured_text.projects.diagrams.networks.draw.bands import in_bands
from structured_text.projects.diagrams.networks.draw.drawing import Drawing, Symbol, Wire
from structured_text.projects.diagrams.networks.draw.layout import layout
from structured_text.projects.diagrams.networks.draw.shapes import input_of, outputs_of
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
    Position,
    Rail,
)

_NAMES = st.text("abc._ 開", min_size=1, max_size=30)


@st.composite
def _diagrams(draw: st.DrawFn) -> Diagram:
    """Return a diagram of up to 14 elements, with feedback and with any mix of branches."""
    ladder = draw(st.booleans())
    kinds = [
        draw(st.sampled_from("cccqbbvw" if ladder else "bbbbvvw")) for _ in range(draw(_COUNT))
    ]
    made: list[Element] = [Rail("0")] if ladder else []
    pins = {"c": [""], "q": [""], "b": ["OUT", "ENO"], "v": [""], "w": []}
    ends = [Connection(str(k + 1), pin) for k, kind in enumerate(kinds) for pin in pins[kind]]
    ends += [Connection("0")] if ladder else []

    def wired(name: str = "", negated: bool = False) -> Input:
        few = st.lists(st.sampled_from(ends), max_size=3, unique=True)
        found = tuple(draw(few)) if ends else ()
        return Input(name, found, draw(st.sampled_from(["", "5"])), negated)

    for k, kind in enumerate(kinds, 1):
        number, name = str(k), draw(_NAMES)
        at = Position(draw(st.integers(0, 9)), draw(st.integers(0, 9)))
        if kind == "c":
            element: Element = Contact(number, variable=name, input=wired())
        elif kind == "q":
            element = Coil(number, variable=name, input=wired(), storage="set")
        elif kind == "v":
            element = InVariable(number, expression=name)
        elif kind == "w":
            element = OutVariable(number, expression=name, input=wired())
        else:
            names = draw(st.sampled_from([["EN"], ["EN", "B"], ["A", "B", "C"]]))
            given_pins = tuple(wired(pin, draw(st.booleans())) for pin in names)
            outputs = (Output("OUT", negated=draw(st.booleans())), Output("ENO"))
            element = Block(number, type="T", instance=name, inputs=given_pins, outputs=outputs)
        made.append(replace(element, position=at))
    return Diagram("LD" if ladder else "FBD", (Network(1),), tuple(made))


_COUNT = st.integers(0, 14)


def _cells(symbol: Symbol) -> Iterator[tuple[int, int]]:
    for row in range(symbol.y, symbol.y + symbol.height):
        for x in range(symbol.x, symbol.x + symbol.width):
            yield x, row


def _passed(wire: Wire) -> Iterator[tuple[int, int]]:
    """Yield the cells of a wire."""
    if wire.y1 == wire.y2:
        yield from ((x, wire.y1) for x in range(floor(wire.x1), ceil(wire.x2)))
    else:
        yield from ((floor(wire.x1), row) for row in range(wire.y1, wire.y2 + 1))


def _overlap(first: tuple[float, float], second: tuple[float, float]) -> bool:
    return first[0] < second[1] and second[0] < first[1]


def _check_places(drawing: Drawing) -> None:
    """Assert that no two symbols overlap, no line passes a symbol, and no two lines overlap."""
    taken: dict[tuple[int, int], Symbol] = {}
    for symbol in drawing.symbols:
        assert symbol.x >= 0
        assert symbol.x + symbol.width <= drawing.width
        assert symbol.y >= 0
        assert symbol.y + symbol.height <= drawing.height
        if symbol.kind == "inner":
            continue
        for cell in _cells(symbol):
            assert cell not in taken, (symbol, taken[cell])
            taken[cell] = symbol
    for symbol in drawing.symbols:
        if symbol.kind == "inner":
            assert {taken[cell].element for cell in _cells(symbol)} == {symbol.element}
    inner = [cell for one in drawing.symbols if one.kind == "inner" for cell in _cells(one)]
    assert len(inner) == len(set(inner))
    for wire in drawing.wires:
        assert 0 <= wire.x1 <= wire.x2 <= drawing.width
        assert 0 <= wire.y1 <= wire.y2 < drawing.height
        assert not [taken[cell] for cell in _passed(wire) if cell in taken], wire
    for one, other in combinations(drawing.wires, 2):
        if one.y1 == one.y2 == other.y1 == other.y2:
            assert not _overlap((one.x1, one.x2), (other.x1, other.x2)), (one, other)
        elif one.x1 == one.x2 == other.x1 == other.x2:
            assert one.y2 + 1 < other.y1 or other.y2 + 1 < one.y1, (one, other)


def _drawn(drawing: Drawing) -> Counter[tuple[str, str, str, str]]:
    """Return how often each connection is drawn, by following the lines from left to right.

    A vertical piece leads to all horizontal pieces on its right, and to a line back on its left.
    """
    targets = {(pin.x, pin.y): pin for pin in drawing.pins if not pin.output}
    flat = [wire for wire in drawing.wires if wire.y1 == wire.y2]
    upright = [wire for wire in drawing.wires if wire.y1 != wire.y2]
    found: Counter[tuple[str, str, str, str]] = Counter()

    def behind(x: float, row: int) -> Iterator[tuple[float, int]]:
        for piece in upright:
            if piece.x1 == x and piece.y1 <= row <= piece.y2:
                for wire in flat:
                    if not piece.y1 <= wire.y1 <= piece.y2:
                        continue
                    if wire.x1 == x and not wire.back:
                        yield from ends(wire)
                    elif wire.x2 == x and wire.back:
                        yield from behind(wire.x1, wire.y1)

    def ends(wire: Wire) -> Iterator[tuple[float, int]]:
        if wire.x2 == floor(wire.x2):
            yield wire.x2, wire.y1
            for other in flat:  # the line goes on
                if (other.x1, other.y1) == (wire.x2, wire.y1):
                    yield from ends(other)
        else:
            yield from behind(wire.x2, wire.y1)

    for pin in drawing.pins:
        if pin.output:
            for wire in flat:
                if (wire.x1, wire.y1) == (pin.x, pin.y):
                    for end in ends(wire):
                        if end in targets:
                            target = targets[floor(end[0]), end[1]]
                            found[pin.element, pin.name, target.element, target.name] += 1
    return found


def _connections(diagram: Diagram) -> Counter[tuple[str, str, str, str]]:
    by_id = {element.id: element for element in diagram.elements}
    found: Counter[tuple[str, str, str, str]] = Counter()
    for element in diagram.elements:
        for pin in input_of(element):
            for one in pin.connections:
                first = outputs_of(by_id[one.source])[0]
                found[one.source, one.pin or first, element.id, pin.name] = 1
    return found


@settings(max_examples=60, deadline=None)
@given(_diagrams())
def test_symbols_and_lines_never_overlap(diagram: Diagram) -> None:
    _check_places(layout(diagram, 1))


@settings(max_examples=60, deadline=None)
@given(_diagrams())
def test_each_connection_is_drawn_once_and_no_other(diagram: Diagram) -> None:
    assert _drawn(layout(diagram, 1)) == _connections(diagram)


@pytest.mark.exhaustive
@settings(max_examples=40, deadline=None)
@given(_diagrams(), st.integers(20, 120))
def test_bands_keep_all_symbols_and_fit_the_width(diagram: Diagram, width: int) -> None:
    whole = layout(diagram, 1)
    cut = in_bands(whole, width)
    _check_places(cut)
    kept = [(one.kind, one.text) for one in cut.symbols if one.kind != "cut"]
    assert sorted(kept) == sorted((one.kind, one.text) for one in whole.symbols)
    marks = [one.text for one in cut.symbols if one.kind == "cut"]
    ends = sorted(mark.strip(">") for mark in marks if mark.startswith(">"))
    assert ends == sorted(mark.strip(">") for mark in marks if mark.endswith(">"))
    assert len(ends) == len(set(ends)) == len(marks) / 2
    widest = max(b - a for a, b in zip((0, *whole.cuts), (*whole.cuts, whole.width), strict=True))
    assert cut.width <= max(width, widest + 8)


@pytest.mark.exhaustive
@settings(max_examples=40, deadline=None)
@given(_diagrams())
def test_the_same_network_has_the_same_drawing(diagram: Diagram) -> None:
    assert layout(diagram, 1) == layout(diagram, 1)


def test_a_large_network_is_drawn() -> None:
    """A chain of 600 contacts with a coil behind each."""
    elements: list[Element] = [Rail("0")]
    for k in range(1, 601):
        wire = Input("", (Connection(str(k - 1)),))
        elements.append(Contact(str(k), variable=f"C{k}", input=wire))
        elements.append(Coil(f"q{k}", variable=f"Q{k}", input=Input("", (Connection(str(k)),))))
    diagram = Diagram("LD", (Network(1),), tuple(elements[:121]))
    assert _drawn(layout(diagram, 1)) == _connections(diagram)
