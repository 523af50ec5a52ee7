"""Drawings of networks as SVG."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

from network_elements import block, coil, contact, from_, ladder, plan, read, written
from structured_text.projects.diagrams.networks.draw.drawing import State
from structured_text.projects.diagrams.networks.draw.svg import STYLE, network_svg, networks_svg
from structured_text.projects.diagrams.networks.model import Network

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
            x, y = float(text.get("x") or 0), float(text.get("y") or 0)
            wide, words = len(text.text or "") * 7.3, (text.get("class") or "").split()
            x -= wide if "end" in words else wide / 2 if "middle" in words else 0
            assert left + x >= 0
            assert left + x + wide <= width
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


def test_the_names_of_the_pins_stand_at_the_edges_of_their_block() -> None:
    """A name begins a cell of 8 pixels behind the frame, or ends a cell before it."""
    timer = block("1", "TON", [from_(name="PT", value="T#1s")], ["ET"], instance="Timer")
    svg = network_svg(plan(timer), 1)
    box = re.search(r'<rect class="line" x="([\d.]+)" y="[\d.]+" width="([\d.]+)"', svg)
    assert box is not None
    left, right = float(box[1]), float(box[1]) + float(box[2])
    assert re.search(rf'<text x="{left + 8:g}" y="[\d.]+">PT</text>', svg)
    assert re.search(rf'<text class="end" x="{right - 8:g}" y="[\d.]+">ET</text>', svg)


def test_several_networks_stand_below_each_other() -> None:
    """The first network has a heading, a name and a contact: 18 + 6 + 36 pixels, and its margin."""
    first = (contact("1", "A", "0"), coil("2", "B", "1"))
    second = (contact("3", "C", "0"), coil("4", "D", "3"))
    both = replace(
        ladder(*first, *(replace(element, network=2) for element in second)),
        networks=(Network(1), Network(2, "Next")),
    )
    for headed, high in ((True, 70), (False, 46)):
        root = ElementTree.fromstring(networks_svg(both, "Two", headed=headed))
        parts = [part for part in root if part.tag == f"{_SPACE}g"]
        assert [part.get("transform") for part in parts] == [
            "translate(0 0)",
            f"translate(0 {high})",
        ]
        texts = [[text.text for text in part.iter(f"{_SPACE}text")] for part in parts]
        assert texts[0] == [*(["Network 1"] if headed else []), "A", "B"]
        assert texts[1] == [*(["Network 2: Next"] if headed else []), "C", "D"]


def test_a_variable_without_a_name_has_its_line() -> None:
    nameless = plan(read("1", " "), block("2", "F", [from_("1", name="EN")], []))
    assert network_svg(nameless, 1).count("<path d=") == 1
