"""The network that a line was translated from, and the lines of a network."""

from __future__ import annotations

from pathlib import Path

from network_elements import coil, ladder
from structured_text.language.source import Extract, Line, NetworkLine
from structured_text.projects.diagrams.networks.stored import lines_of, network_at

_MAIN, _WORK = ladder(coil("1", "A", "0")), ladder(coil("1", "B", "0"))
_LINES = (
    Line("PROGRAM Main", 1),
    Line("A := TRUE;", 2, network="rung 1"),
    Line("B := TRUE;", 3, network="network 1", owner="Main.Work"),
    Line("B := FALSE;", 4, network="network 11", owner="Main.Work"),
)
_SOURCE = Extract.make(
    Path("plc.xml"), _LINES, "Main", diagrams=(("Main", _MAIN), ("Main.Work", _WORK))
)


def test_a_line_leads_to_the_network_of_its_pou_or_action() -> None:
    found = [
        network_at(_SOURCE, NetworkLine(2, owner, _LINES[1])) for owner in ("Main", "Main.Work")
    ]
    assert found == [(_SOURCE, _MAIN, 1), (_SOURCE, _WORK, 1)]
    assert network_at(_SOURCE, NetworkLine(4, "Main.Work", _LINES[3])) is None
    assert network_at(Path("plc.st"), NetworkLine(2, "Main", _LINES[1])) is None


def test_the_lines_of_a_network_are_those_of_its_owner() -> None:
    assert [line.text for line in lines_of(_SOURCE, "Main", 1)] == ["A := TRUE;"]
    assert [line.text for line in lines_of(_SOURCE, "Main.Work", 1)] == ["B := TRUE;"]
    assert lines_of(Path("plc.st"), "Main", 1) == []
