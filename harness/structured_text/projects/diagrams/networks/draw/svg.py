"""A network as an SVG picture, for pages and as a file.

The picture has its own background and two sets of colours, for light and for dark pages. Lines with
power are thick, and values stand beside the names, so that nothing depends on colours.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import replace
from html import escape

from structured_text.projects.diagrams.networks.draw.bands import in_bands
from structured_text.projects.diagrams.networks.draw.drawing import (
    RAIL,
    Drawing,
    State,
    Symbol,
    Wire,
)
from structured_text.projects.diagrams.networks.draw.layout import layout
from structured_text.projects.diagrams.networks.model import Diagram

__all__ = ["RULES", "STYLE", "VALUE", "live_svg", "network_svg", "networks_svg"]

#: Size of a cell in pixels.
_WIDE, _HIGH = 8, 18
#: Space around the drawing, in pixels.
_MARGIN = 10
#: Half the height of a contact or coil, in pixels.
_HALF = 8
#: Space between a text and its line, in pixels.
_SPACE = 3

#: A text in `State.values` in place of a value that a script writes later.
VALUE = "\N{MIDDLE DOT}" * 10

#: Style sheet of a drawing without its colours, for a page that has colours of its own. All rules
#: are for elements of the class `diagram`.
RULES = (
    ".diagram .ground{fill:var(--back)}"
    ".diagram text{font:12px 'DejaVu Sans Mono',Consolas,monospace;fill:var(--ink);"
    "dominant-baseline:central;white-space:pre}"
    ".diagram .head{font-weight:bold}.diagram .more{fill:var(--soft)}"
    ".diagram .middle{text-anchor:middle}.diagram .end{text-anchor:end}"
    ".diagram path,.diagram rect.line,.diagram circle{fill:none;stroke:var(--ink);"
    "stroke-width:1.5}"
    ".diagram rect.line{fill:var(--fill)}.diagram circle.full{fill:var(--ink);stroke:none}"
    ".diagram .rail{stroke-width:3}"
    ".diagram path.on{stroke:var(--on);stroke-width:3.5}.diagram circle.full.on{fill:var(--on)}"
    ".diagram rect.line.on{stroke:var(--on);stroke-width:3}"
    ".diagram text.on{font-weight:bold;fill:var(--on)}"
    ".diagram circle.not{fill:var(--back)}.diagram .cut{fill:var(--soft)}"
)
#: Style sheet of a drawing.
STYLE = (
    ".diagram{--ink:#1d2733;--soft:#566371;--on:#0b6bcb;--back:#fff;--fill:#eef2f6}"
    "@media(prefers-color-scheme:dark){"
    ".diagram{--ink:#dde5ee;--soft:#93a1b1;--on:#74b3f2;--back:#1a2430;--fill:#263442}}"
) + RULES


def network_svg(
    diagram: Diagram,
    network: int,
    state: State | None = None,
    *,
    width: int = 150,
    name: str = "network",
    styled: bool = True,
) -> str:
    """Return the drawing of a network as an SVG element.

    Args:
        diagram: The diagram.
        network: The number of the network.
        state: What was energised, and the values of the variables.
        width: Number of columns of 8 pixels from which on the drawing goes on below.
        name: The beginning of the ids, which must be unique in a page.
        styled: Whether the style sheet is inside the picture. A page with several pictures can
            have it once.
    """
    drawing = in_bands(layout(diagram, network, state), width)
    title, *more = drawing.heading or ("",)
    words = " ".join([*more, drawing.words])
    lines, wide, high = _picture(drawing)
    ids = f"{name}-{network}"
    return _element(lines, wide, high, title=title, words=words, ids=ids, styled=styled)


def networks_svg(
    diagram: Diagram, title: str, *, width: int = 150, headed: bool = True, name: str = "networks"
) -> str:
    """Return all networks of a diagram below each other as one SVG element.

    Args:
        diagram: The diagram.
        title: A title for screen readers.
        width: Number of columns of 8 pixels from which on a drawing goes on below.
        headed: Whether number, title and comment stand above each network.
        name: The beginning of the ids, which must be unique in a page.
    """
    lines: list[str] = []
    words: list[str] = []
    wide = high = 0
    for network in diagram.networks:
        drawing = in_bands(layout(diagram, network.number), width)
        words += [*drawing.heading, drawing.words]
        own, across, down = _picture(drawing if headed else replace(drawing, heading=()))
        lines += [f'<g transform="translate(0 {high})">', *own, "</g>"]
        wide, high = max(wide, across), high + down - _MARGIN
    text = " ".join(words)
    return _element(lines, wide, high + _MARGIN, title=title, words=text, ids=name)


def live_svg(
    diagram: Diagram, network: int, values: Mapping[str, str], *, width: int, name: str
) -> str:
    """Return the drawing of a network for a script that shows a state in it.

    The parts of the drawing have these attributes. An output is a list of the `id` of an element
    and of the formal name of the output.

    - `data-power`: a line; the outputs that it comes from.
    - `data-symbol`: a contact or coil; the `id` of the element.
    - `data-name`: the name of an element's variable; the `id` of the element.
    - `data-value`: the place of a value; the output that has it.

    Args:
        diagram: The diagram.
        network: The number of the network.
        values: `VALUE` for each element or output whose value is shown as text.
        width: Number of columns of 8 pixels from which on the drawing goes on below.
        name: The beginning of the ids, which must be unique in a page.
    """
    drawing = in_bands(layout(diagram, network, State({}, values)), width)
    lines, wide, high = _picture(replace(drawing, heading=()), live=True)
    title = drawing.heading[0]
    ids = f"{name}-{network}"
    words = drawing.words
    return _element(lines, wide, high, title=title, words=words, ids=ids, styled=False)


def _element(
    lines: Iterable[str],
    wide: int,
    high: int,
    *,
    title: str,
    words: str,
    ids: str,
    styled: bool = True,
) -> str:
    """Return the SVG element of a picture."""
    first, second = escape(f"{ids}-title"), escape(f"{ids}-words")
    begin = [
        f'<svg xmlns="http://www.w3.org/2000/svg" class="diagram" role="img"'
        f' width="{wide}" height="{high}" viewBox="0 0 {wide} {high}"'
        f' aria-labelledby="{first} {second}">',
        f'<title id="{first}">{_clean(title)}</title>',
        f'<desc id="{second}">{_clean(words)}</desc>',
        *([f"<style>{STYLE}</style>"] if styled else []),
        f'<rect class="ground" width="{wide}" height="{high}"/>',
    ]
    return "\n".join([*begin, *lines, "</svg>", ""])


def _picture(drawing: Drawing, *, live: bool = False) -> tuple[list[str], int, int]:
    """Return the elements of a drawing, its width and its height, with margins."""
    head = len(drawing.heading)
    wide = drawing.width * _WIDE + 2 * _MARGIN
    high = (drawing.height + head) * _HIGH + 2 * _MARGIN + (_HIGH // 3 if head else 0)
    lines = []
    for row, text in enumerate(drawing.heading):
        y = _MARGIN + (row + 0.5) * _HIGH
        lines.append(_text(_MARGIN, y, text, "more" if row else "head"))
    lines.append(f'<g transform="translate({_MARGIN} {high - _MARGIN - drawing.height * _HIGH})">')
    lines += [_wire(wire, live) for wire in drawing.wires if not wire.on]
    lines += [_wire(wire, live) for wire in drawing.wires if wire.on]
    lines += _dots(drawing, live)
    begins = {(wire.x1, wire.y1) for wire in drawing.wires}
    ends = {(wire.x2, wire.y1) for wire in drawing.wires}
    order = {"box": 0, "rail": 1}
    symbols = sorted(drawing.symbols, key=lambda symbol: order.get(symbol.kind, 2))
    for symbol in symbols:
        before = (symbol.x, symbol.y) in ends
        behind = (symbol.x + symbol.width, symbol.y) in begins
        found = _symbol(symbol, _SPACE * (before - behind))
        lines += [_marked(symbol, line) for line in found] if live else found
    return [*lines, "</g>"], wide, high


def _clean(text: str) -> str:
    """Return a text escaped, without letters that XML does not allow."""
    return escape("".join(letter if letter >= " " or letter == "\t" else " " for letter in text))


def _text(x: float, y: float, text: str, kind: str = "") -> str:
    shown = f' class="{kind}"' if kind else ""
    return f'<text{shown} x="{x:g}" y="{y:g}">{_clean(text)}</text>'


def _x(column: float) -> float:
    return column * _WIDE


def _y(row: float) -> float:
    return (row + 0.5) * _HIGH


def _path(data: str, on: bool | None = None, kind: str = "", more: str = "") -> str:
    classes = " ".join(word for word in (kind, "on" if on else "") if word)
    shown = f' class="{classes}"' if classes else ""
    return f'<path{shown}{more} d="{data}"/>'


def _power(wire: Wire, live: bool) -> str:
    return _data("power", list(wire.outputs)) if live and wire.outputs else ""


def _data(name: str, value: object) -> str:
    return f' data-{name}="{escape(json.dumps(value))}"'


def _marked(symbol: Symbol, line: str) -> str:
    """Return the line of a symbol with the attributes of a live drawing."""
    element = symbol.element
    if symbol.kind == "rail" and symbol.text == "left":
        return line.replace(" ", f"{_data('power', [RAIL])} ", 1)
    if symbol.kind in ("contact", "coil"):
        return line.replace(" ", f"{_data('symbol', element)} ", 1)
    if symbol.kind not in ("text", "inner") or not element:
        return line
    if VALUE in symbol.text:
        place = f"<tspan{_data('value', [element, symbol.pin])}></tspan>"
        return line.replace(VALUE, place)
    if symbol.kind == "inner":
        return (
            line.replace(" ", f"{_data('power', [(element, symbol.pin)])} ", 1)
            if symbol.pin
            else line
        )
    return line.replace(" ", f"{_data('name', element)} ", 1)


def _wire(wire: Wire, live: bool) -> str:
    x1, y1, x2, y2 = _x(wire.x1), _y(wire.y1), _x(wire.x2), _y(wire.y2)
    if wire.y1 != wire.y2:
        return _path(f"M{x1:g} {y1:g}V{y2:g}", wire.on, more=_power(wire, live))
    line = f"M{x1:g} {y1:g}H{x2:g}"
    if wire.back:  # with an arrow, because it leads to the left
        line += f"M{(x1 + x2) / 2 + 6:g} {y1 - 5:g}l-8 5l8 5"
    return _path(line, wire.on, more=_power(wire, live))


def _dots(drawing: Drawing, live: bool) -> list[str]:
    """Return a dot at each place where lines are connected, but not at bends."""
    found = []
    for wire in drawing.wires:
        if wire.y1 == wire.y2:
            continue
        for row in range(wire.y1, wire.y2 + 1):
            ends = sum(
                1
                for other in drawing.wires
                if other.y1 == other.y2 == row and wire.x1 in (other.x1, other.x2)
            )
            if ends + (wire.y1 < row) + (row < wire.y2) > 2 and ends:
                on = " on" if wire.on else ""
                place = f'cx="{_x(wire.x1):g}" cy="{_y(row):g}"'
                more = _power(wire, live)
                found.append(f'<circle class="full{on}"{more} {place} r="3"/>')
    return found


def _symbol(symbol: Symbol, shift: int) -> list[str]:
    """Return the elements of a symbol; a text is shifted away from its line."""
    left, right = _x(symbol.x), _x(symbol.x + symbol.width)
    y = _y(symbol.y)
    top, bottom = y - _HALF, y + _HALF
    middle = (left + right) / 2
    if symbol.kind == "rail":
        edge = right - 1.5 if symbol.text == "left" else left + 1.5
        top, bottom = symbol.y * _HIGH, (symbol.y + symbol.height) * _HIGH
        return [_path(f"M{edge:g} {top:g}V{bottom:g}", symbol.on, "rail")]
    if symbol.kind == "contact":
        bars = f"M{left:g} {top:g}V{bottom:g}M{right:g} {top:g}V{bottom:g}"
        if symbol.text == "/":
            return [_path(f"{bars}M{right - 3:g} {top:g}L{left + 3:g} {bottom:g}", symbol.on)]
        return [_path(bars, symbol.on), *_mark(symbol, middle, y)]
    if symbol.kind == "coil":
        arcs = f"M{left + 6:g} {top:g}q-12 {_HALF} 0 {2 * _HALF}"
        arcs += f"M{right - 6:g} {top:g}q12 {_HALF} 0 {2 * _HALF}"
        return [_path(arcs, symbol.on), *_mark(symbol, middle, y)]
    if symbol.kind == "box":
        size = f'width="{right - left:g}" height="{(symbol.height - 1) * _HIGH:g}"'
        kind = "line on" if symbol.on else "line"
        return [f'<rect class="{kind}" x="{left:g}" y="{y:g}" {size} rx="3"/>']
    if symbol.kind == "not":
        return [f'<circle class="not" cx="{middle:g}" cy="{y:g}" r="4"/>']
    if symbol.kind == "cut":
        return [_text(left + shift, y, symbol.text, "cut")]
    on = ["on"] if symbol.on and symbol.kind != "inner" else []
    words = [*([] if symbol.align == "start" else [symbol.align]), *on]
    x = {"start": left, "end": right}.get(symbol.align, middle)
    return [_text(x + shift, y, symbol.text, " ".join(words))]


def _mark(symbol: Symbol, middle: float, y: float) -> list[str]:
    return [_text(middle, y, symbol.text, "middle")] if symbol.text.strip() else []
