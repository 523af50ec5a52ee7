"""A page of `rcx run --view` shows the networks of a drawn program."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from plcopen_drawings import block, element, program_of, project
from rcx_harness.trace import Scan
from rcx_harness.trace.view.networks import DrawnProgram
from rcx_harness.trace.view.page import View
from structured_text.engines.base import Program
from structured_text.projects.sources import source_files
from view_page import PageContent

_RUNG = (
    element("leftPowerRail", 1, at="0 10")
    + element("contact", 2, "Start", "1", at="50 10", edge="rising")
    + element("contact", 3, "Stop", "2", at="100 10", negated="true")
    + element("coil", 4, "Motor", "3", at="150 10", storage="set")
)
_TIMED = element("inVariable", 5, "Motor", at="0 99") + block(
    6, "TON", {"IN": "5"}, "Q ET", at="50 99", instanceName="Timer"
)


def _drawn(folder: Path) -> tuple[Program, DrawnProgram]:
    text = project("Start Stop Motor : BOOL; Timer : TON", f"<LD>{_RUNG}{_TIMED}</LD>")
    program = program_of(folder, text)
    return program, DrawnProgram(program, source_files(folder / "plc.xml", None).own)


def test_a_page_has_the_networks_and_the_variables_that_they_show(tmp_path: Path) -> None:
    """Start is TRUE from the second scan on; the trigger of its edge is TRUE in that scan only."""
    program, drawn = _drawn(tmp_path)
    view = View(drawn.header({"scan_us": 10_000}), drawn.groups)
    for number in range(3):
        program.write("Main.Start", number > 0)
        program.scan(number * 10_000)
        view.take(drawn.filled(Scan(number * 10_000, number, bytes(48), bytes(48))))
    page = PageContent(view.page("drawn"))
    (group,) = page.table["networks"]
    assert group["title"] == "Main"
    assert [network["title"] for network in group["networks"]] == ["Network 1", "Network 2"]
    (edge,) = [one for one in group["networks"][0]["elements"] if one["id"] == "2"]
    assert page.changes(edge["tests"]) == [(-1, 0), (10_000, 1), (20_000, 0)]
    assert page.changes("Main.Motor") == [(-1, 0), (10_000, 1)]
    names = ["Main.Start", edge["tests"], "Main.Stop", "Main.Motor", "Main.Timer.Q"]
    names.append("Main.Timer.ET")
    lanes = page.table["lanes"]
    shown = {path: lanes[place]["name"] for path, place in page.table["variables"].items()}
    assert shown == {name.upper(): name for name in names}


def test_a_bit_of_a_variable_is_recorded_with_its_variable(tmp_path: Path) -> None:
    rung = element("leftPowerRail", 1) + element("contact", 2, "Bits.3", "1", at="50 0")
    rung += element("coil", 3, "Count.0", "2", at="99 0")
    text = project("Bits : WORD; Count : INT", f"<LD>{rung}</LD>")
    program = program_of(tmp_path, text)
    drawn = DrawnProgram(program, source_files(tmp_path / "plc.xml", None).own)
    elements = drawn.groups[0]["networks"][0]["elements"]
    assert [one["name"] for one in elements] == ["Main.Bits.3", "Main.Count.0"]
    assert drawn.header({})["watch"] == {"Main.Bits": "WORD", "Main.Count": "INT"}


def test_watched_variables_stay_beside_those_of_the_networks(tmp_path: Path) -> None:
    _, drawn = _drawn(tmp_path)
    header = drawn.header({"watch": {"Main.Own": "INT"}})
    assert header["watch"]["Main.Own"] == "INT"
    assert header["watch"]["Main.Stop"] == "BOOL"
    filled: Any = drawn.filled(Scan(0, 0, b"", b"", {"Main.Own": 7}))
    assert (filled.vars["Main.Own"], filled.vars["Main.Stop"]) == (7, False)
    other = Scan(0, 0, b"", b"", None, controller=2)
    assert drawn.filled(other) == other


def test_a_program_of_text_has_no_networks(tmp_path: Path) -> None:
    program, _ = _drawn(tmp_path)
    drawn = DrawnProgram(program, [tmp_path / "plc.st"])
    scan = Scan(0, 0, b"", b"")
    assert (drawn.groups, drawn.filled(scan)) == ([], scan)
    assert drawn.header({"engine": "builtin"}) == {"engine": "builtin", "watch": {}}


def test_each_instance_of_a_drawn_block_has_its_own_networks(tmp_path: Path) -> None:
    """The program comes first, then the blocks in it, each with its own variables."""
    inside = element("inVariable", 1, "A") + element("outVariable", 2, "B", "1", at="50 0")
    own = (
        '<pou name="Own" pouType="functionBlock"><interface><localVars>'
        '<variable name="A"><type><BOOL/></type></variable>'
        '<variable name="B"><type><BOOL/></type></variable></localVars></interface>'
        f"<body><FBD>{inside}</FBD></body></pou>"
    )
    calls = "".join(
        block(number, "Own", {}, "", at=f"0 {number}0", instanceName=name)
        for number, name in ((1, "First"), (2, "Second"))
    )
    text = project("First Second : Own", f"<FBD>{calls}</FBD>", more=own)
    program = program_of(tmp_path, text)
    drawn = DrawnProgram(program, source_files(tmp_path / "plc.xml", None).own)
    assert [group["title"] for group in drawn.groups] == ["Main", "Main.First", "Main.Second"]
    assert drawn.groups[2]["networks"][0]["elements"][0]["name"] == "Main.Second.A"
