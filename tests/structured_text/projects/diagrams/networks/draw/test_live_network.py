"""Networks for a page whose script shows what was energised."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any
from xml.etree import ElementTree

from network_elements import block, coil, contact, from_, ladder, plan, read, written
from structured_text.projects.diagrams.networks.draw.live import Found, live_network
from structured_text.projects.diagrams.networks.draw.power import power_of
from structured_text.projects.diagrams.networks.model import (
    Block,
    Coil,
    Contact,
    Diagram,
    Element,
    Network,
    Output,
    Rail,
)

_VARIABLES = {
    "Start": Found("Main.Start", True, True),
    "Motor": Found("Main.Motor", True, True),
    "Level": Found("Main.Level", False, True),
    "Robot": Found("Main.Robot", False, False),
    "Timer.Q": Found("Main.Timer.Q", True, True),
    "Timer.ET": Found("Main.Timer.ET", False, True),
    "Timer.PT": Found("Main.Timer.PT", False, True),
    "Trigger.Q": Found("Main.Trigger.Q", True, True),
}


def _entry(diagram: Diagram, edges: dict[tuple[str, str], str] | None = None) -> dict[str, Any]:
    return live_network(diagram, 1, _VARIABLES.get, edges or {}, width=100, name="d")


def _of(entry: dict[str, Any], number: str) -> dict[str, Any]:
    (found,) = [element for element in entry["elements"] if element["id"] == number]
    return dict(found)


def test_a_rung_names_the_variables_that_it_shows() -> None:
    """Gone is no variable of the program, so its contact tests nothing."""
    rung = (contact("1", "Start", "0"), contact("2", "Gone", "1", negated=True))
    entry = _entry(ladder(*rung, coil("3", "Motor", "2"), title="Go", comment="Why"))
    assert (entry["title"], entry["comment"]) == ("Network 1: Go", "Why")
    assert entry["paths"] == ["Main.Start", "Main.Motor"]
    first, second, third = entry["elements"]
    assert (first["tests"], first["in"][0]["from"]) == ("Main.Start", [("", "")])
    assert (second["tests"], second["negated"]) == (None, True)
    assert (third["name"], third["in"][0]["from"]) == ("Main.Motor", [("2", "")])


def test_a_contact_with_an_edge_tests_its_trigger() -> None:
    """Without a trigger, its state is not known. The edge of a negated contact is not known."""
    rung = ladder(contact("1", "Start", "0", edge="rising"), coil("2", "Motor", "1"))
    known = _of(_entry(rung, {("START", "rising"): "Trigger.Q"}), "1")
    assert (known["tests"], known["name"]) == ("Main.Trigger.Q", "Main.Start")
    assert _of(_entry(rung, {("START", "falling"): "Trigger.Q"}), "1")["tests"] is None
    negated = contact("1", "Start", "0", edge="rising", negated=True)
    both = ladder(negated, coil("2", "Motor", "1"))
    assert _of(_entry(both, {("START", "rising"): "Trigger.Q"}), "1")["tests"] is None


def test_values_that_are_not_boolean_have_a_place_in_the_drawing() -> None:
    """ET is shown at its pin, Level beside its name. Robot is a structure, and 5 is a number."""
    inputs = [from_("1", name="IN"), from_("2", name="PT"), from_("3", name="R")]
    timer = block("4", "TON", inputs, ["Q", "ET", "R"], instance="Timer")
    diagram = plan(read("1", "TRUE"), read("2", "Level"), read("3", "Robot"), timer)
    entry = _entry(diagram)
    places = [
        json.loads(node.get("data-value") or "")
        for node in ElementTree.fromstring(entry["svg"]).iter()
        if node.get("data-value")
    ]
    assert sorted(places) == [["2", ""], ["4", "ET"]]
    assert [_of(entry, number)["number"] for number in "123"] == [False, True, True]
    assert _of(entry, "1")["always"] is True
    assert [(pin["pin"], pin["number"]) for pin in _of(entry, "4")["out"]] == [
        ("Q", False),
        ("ET", True),
        ("R", True),
    ]
    assert "Main.Robot" not in entry["paths"]
    assert _of(_entry(plan(read("1", "5"), written("2", "Level", "1"))), "1")["number"] is True


def test_each_line_names_the_outputs_that_it_comes_from() -> None:
    """Two contacts beside each other lead to one coil: a line of each, and one of both."""
    both = (contact("1", "A", "0"), contact("2", "B", "0"), coil("3", "Q", "1", "2"))
    root = ElementTree.fromstring(_entry(ladder(*both))["svg"])
    paths = [node for node in root.iter() if node.get("data-power") and node.tag.endswith("path")]
    lines = {json.dumps(json.loads(node.get("data-power") or "")) for node in paths}
    assert lines == {
        '[["", ""]]',
        '[["1", ""]]',
        '[["2", ""]]',
        '[["1", ""], ["2", ""]]',
        '[["3", ""]]',
    }
    marked = [node.get("data-symbol") for node in root.iter() if node.get("data-symbol")]
    assert sorted(set(filter(None, marked))) == ['"1"', '"2"', '"3"']
    names = [node for node in root.iter() if node.get("data-name")]
    assert [(node.text, node.get("data-name")) for node in names] == [
        ("A", '"1"'),
        ("B", '"2"'),
        ("Q", '"3"'),
    ]


def _rung(*elements: Element) -> dict[str, Any]:
    return _entry(Diagram("RLL", (Network(1),), (Rail("0"), *elements), False))


def test_a_rung_of_logix_uses_the_names_of_its_translation() -> None:
    entry = _rung(
        Contact("1", variable="Local:1:I.0", input=from_("0"), translation="Start"),
        Coil("2", variable="Local:2:O.0", input=from_("1"), translation="Motor := ?;"),
    )
    assert entry["title"] == "Rung 1"
    assert [element["name"] for element in entry["elements"]] == ["Main.Start", "Main.Motor"]


def test_an_instruction_of_logix_passes_power_or_tests_something() -> None:
    """ONS passes power for one scan only, and an Add-On Instruction as it likes."""
    made = {
        "EQU": "(Level = 5)",
        "LIM": "(1 <= Level OR Level <= 9)",
        "XIC": "Start",
        "MOV": "Level := 5;",
        "TON": "L5X_TON(Timer := Timer, Power := ?);",
        "ONS": "Level.0 := ?;",
    }
    boxes = [
        Block(name, type=name, inputs=(from_("0"),), outputs=(Output(),), translation=text)
        for name, text in made.items()
    ]
    own = replace(boxes[0], id="Own", type="Own", instance="Own", translation="Own();")
    entry = _rung(*boxes, own)
    kinds = {element["id"]: element["kind"] for element in entry["elements"]}
    assert kinds == {
        "EQU": "contact",
        "LIM": "contact",
        "XIC": "contact",
        "MOV": "coil",
        "TON": "coil",
        "ONS": "end",
        "Own": "end",
    }
    assert _of(entry, "EQU")["compare"] == [
        "EQ",
        {"name": "Main.Level", "constant": None},
        {"name": None, "constant": 5},
    ]
    assert (_of(entry, "LIM")["tests"], _of(entry, "LIM")["compare"]) == (None, None)
    assert _of(entry, "XIC")["tests"] == "Main.Start"
    found: dict[str, object] = {"Main.Start": True, "Main.Level": 5}
    assert power_of(entry["elements"], found.get) == {
        "EQU": True,
        "XIC": True,
        "MOV": True,
        "TON": True,
    }
    assert power_of(entry["elements"], {"Main.Level": 6}.get)["EQU"] is False
