"""Drawings of networks as SVG."""

from __future__ import annotations

import re
from xml.etree import ElementTree

from network_elements import block, coil, contact, from_, ladder, plan, written
from structured_text.projects.diagrams.networks.draw.drawing import State
from structured_text.projects.diagrams.networks.draw.svg import STYLE, network_svg

_SPACE = "{http://www.w3.org/2000/svg}"
_RUNG = ladder(
    contact("1", "Start", "0"),
    contact("2", "Stop", "1", negated=True),
    coil("3", "Lamp", "2"),
    title="Start and stop",
)


def _texts(svg: str) -> list[str]:
    return [one.text or "" for one in ElementTree.fromstring(svg).iter(f"{_SPACE}text")]


def test_names_with_special_letters_are_escaped() -> None:
    name = "a<b & c"
    svg = network_svg(
        ladder(contact("1", name, "0"), coil("2", 'q"\x01', "1"), title="<t>", comment="]]>&"), 1
    )
    assert name in _texts(svg)
    assert _texts(svg)[:2] == ["Network 1: <t>", "]]>&"]
    assert 'q" ' in _texts(svg)


def test_a_screen_reader_gets_title_and_words() -> None:
    root = ElementTree.fromstring(network_svg(_RUNG, 1, name="x"))
    title, words = root.find(f"{_SPACE}title"), root.find(f"{_SPACE}desc")
    assert title is not None
    assert words is not None
    assert root.get("role") == "img"
    assert root.get("aria-labelledby") == f"{title.get('id')} {words.get('id')}"
    assert title.text == "Network 1: Start and stop"
    assert words.text == (
        "contact Start from the left rail. contact Stop, negated from contact Start."
        " coil Lamp from contact Stop, negated."
    )


def test_power_is_drawn_thick_and_values_as_text() -> None:
    """Start is closed, Stop is not: two wires have power, that from the rail and that behind."""
    state = State({"1": True, "2": False, "3": False}, {"2": "TRUE"})
    svg = network_svg(_RUNG, 1, state)
    wires = re.findall(r'<path class="on" d="M[\d.]+ [\d.]+H', svg)
    assert len(wires) == 2
    assert "Stop = TRUE" in _texts(svg)
    assert ".diagram path.on{stroke:var(--on);stroke-width:3.5}" in STYLE


def test_everything_is_inside_the_view_box() -> None:
    """Letters are at most 7.3 pixels wide; the picture has as much room as its view box says."""
    names = [contact(str(k), f"Contact_with_a_name_{k}", str(k - 1)) for k in range(1, 41)]
    for diagram in (_RUNG, ladder(*names, coil("41", "Q", "40"))):
        svg = network_svg(diagram, 1)
        root = ElementTree.fromstring(svg)
        _, _, width, height = map(float, (root.get("viewBox") or "").split())
        assert (root.get("width"), root.get("height")) == (f"{width:g}", f"{height:g}")
        group = root.find(f"{_SPACE}g")
        assert group is not None
        left, top = map(float, re.findall(r"[\d.]+", group.get("transform") or ""))
        for text in group.iter(f"{_SPACE}text"):
            x, y, half = float(text.get("x") or 0), float(text.get("y") or 0), 0.0
            half = len(text.text or "") * 7.3 / 2
            assert left + x - half >= 0
            assert left + x + half <= width
            assert 9 <= top + y <= height - 9
        for path in group.iter(f"{_SPACE}path"):
            for x, y in re.findall(r"M([\d.]+) ([\d.]+)", path.get("d") or ""):
                assert 0 <= left + float(x) <= width
                assert 0 <= top + float(y) <= height


def test_lines_that_are_connected_have_a_dot_and_crossings_have_none() -> None:
    """The output leads to two variables and back to the input: one place with a connection."""
    diagram = plan(
        block("1", "ADD", [from_("1.OUT", name="P")], ["OUT"]), written("w", "N", "1.OUT")
    )
    svg = network_svg(diagram, 1)
    assert svg.count('<circle class="full"') == 1


def test_a_page_with_many_pictures_has_the_style_once() -> None:
    assert "<style>" in network_svg(_RUNG, 1)
    assert "<style>" not in network_svg(_RUNG, 1, styled=False)
