"""The coverage of a drawing names its rungs, and shows the translation of each."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from drawing import drawing_files
from structured_text import Bench
from structured_text.coverage.formats import tracefile
from structured_text.coverage.html import pages
from structured_text.coverage.measure import FileResult, measure
from structured_text.coverage.parts import merge, part_of
from structured_text.coverage.report import conditions, gaps, missing
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.language.source import Extract, Line
from structured_text.projects.sources import SourceFiles


@pytest.fixture
def result(tmp_path: Path) -> FileResult:
    """Return the result of three scans in which Start is TRUE.

    Motor is TRUE, so Count is 3 in the end. Stop and Count > 100 never hold.
    """
    collector = Collector(tmp_path)
    with counting(collector), Bench.build(drawing_files(tmp_path), engine="builtin") as bench:
        bench["Main.Start"] = True
        bench.scan(3)
    (found,) = measure(merge([part_of(collector)]), tmp_path)
    return found


def test_gaps_name_the_rung_and_the_translated_statement(result: FileResult) -> None:
    """Both branches of the second IF are missing, and that no condition of the first holds."""
    assert [str(gap) for gap in gaps([result])] == [
        "main.xml:6: Main, rung 2: not taken: no condition of the IF was TRUE (no ELSE)",
        "main.xml:6: Main, rung 2: not taken: IF Stop",
        "main.xml:6: Main, rung 2: not taken: ELSIF Count > 100",
    ]


def test_missing_conditions_name_the_rung(result: FileResult) -> None:
    """Stop and Count > 100 never hold, so neither has decided its branch of rung 2."""
    shown = [str(gap) for gap in conditions(result)]
    for name in ("Stop", "Count > 100"):
        assert any(f"Main, rung 2: no MC/DC for {name}" in text for text in shown)


def test_the_table_names_the_rung_in_place_of_lines(result: FileResult) -> None:
    assert missing(result) == "Main, rung 2"


def test_each_statement_of_a_line_is_counted(result: FileResult) -> None:
    """Rung 2 has six statements for line 6; the two that did not run are 0 times executed."""
    counts = [(item.text, item.hits) for item in result.statements if item.line == 6]
    assert counts == [
        ("Motor := Lamp;", 3),
        ("IF Motor THEN", 3),
        ("Count := Count + 1;", 3),
        ("IF Stop THEN", 3),
        ("Count := 0;", 0),
        ("Count := 100;", 0),
    ]


def test_the_page_has_a_heading_for_each_rung(result: FileResult) -> None:
    """Behind the heading are the statements of the rung with their counts; links go to line 6."""
    (page,) = (text for name, text in pages([result], "p").items() if name != "index.html")
    headings = re.findall(r'<tr class="network"><th colspan="4">(.*?)</th></tr>', page)
    assert headings == ["Main, rung 1", "Main, rung 2", "Main, rung 3"]
    rows = re.findall(
        r'<tr id="(L6[^"]*)" class="([^"]*)">.*?"hits">(\d*)<.*?"text">(.*?)</td>', page
    )
    assert [(name, style, hits, text.strip()) for name, style, hits, text in rows] == [
        ("L6", "bad", "", "(* rung 2 *)"),
        ("L6.1", "good", "3", "Motor := Lamp;"),
        ("L6.2", "good", "3", "IF Motor THEN"),
        ("L6.3", "good", "3", "Count := Count + 1;"),
        ("L6.4", "", "", "END_IF;"),
        ("L6.5", "good", "3", "IF Stop THEN"),
        ("L6.6", "bad", "0", "Count := 0;"),
        ("L6.7", "", "", "ELSIF Count &gt; 100 THEN"),
        ("L6.8", "bad", "0", "Count := 100;"),
        ("L6.9", "", "", "END_IF;"),
    ]
    assert '<a href="#L6">line 6</a> Main, rung 2: not taken: IF Stop' in page


def test_the_tracefile_has_the_lines_of_the_file(result: FileResult) -> None:
    """Each line occurs once, with a plain number; line 6 has the lowest count of its statements."""
    lines = [line for line in tracefile([result]).splitlines() if line.startswith("DA:")]
    assert lines == ["DA:4,3", "DA:6,0", "DA:8,3", "DA:9,3"]


def test_a_network_whose_elements_are_mixed_with_another_has_one_heading() -> None:
    """Lines 2 and 4 are of network 1, line 3 is of network 2: the page shows 2, 4, 3."""
    result = FileResult("a.xml", {2: "A := B;", 3: "C := D;", 4: "E := F;"})
    result.networks = {2: "Main, network 1", 3: "Main, network 2", 4: "Main, network 1"}
    (page,) = (text for name, text in pages([result], "p").items() if name != "index.html")
    found = re.findall(r'<th colspan="4">(.*?)</th>|<tr id="(L\d)"', page)
    shown = [heading or row for heading, row in found]
    assert shown == ["Main, network 1", "L2", "L4", "Main, network 2", "L3"]


def test_the_only_contact_of_a_coil_is_a_condition(result: FileResult) -> None:
    """`Motor := Lamp` and `Last := First` are decisions of a drawing, as with two contacts.

    Lamp was always TRUE. First (Count > 1) was FALSE in the first scan.
    """
    found = {
        one.text: set(one.conditions[0].judged.values)
        for one in result.decisions
        if len(one.conditions) == 1
    }
    assert found["Lamp"] == {True}
    assert found["First"] == {False, True}


def test_the_only_contact_of_an_input_is_a_condition(tmp_path: Path) -> None:
    """The counter counts an edge of `a`; its PV and an output are not conditions."""
    file = tmp_path / "main.xml"
    file.write_text("<rung/>", encoding="utf-8")
    lines = (
        Line("PROGRAM Main VAR a, q : BOOL; C : CTU; END_VAR", 1),
        Line("C(CU := a, PV := 2, Q => q);", 1, network="rung 1"),
        Line("END_PROGRAM", 1),
    )
    source = Extract.make(file, lines, "Main")
    collector = Collector(tmp_path)
    files = SourceFiles((source,), (), None)
    with counting(collector), Bench.build(files, engine="builtin") as bench:
        bench["Main.a"] = True
        bench.scan(1)
    (found,) = measure(merge([part_of(collector)]), tmp_path)
    assert [(one.text, set(one.vectors.values())) for one in found.decisions] == [("a", {True})]


@pytest.mark.parametrize("network", ["", "action Work"])
def test_a_copy_in_a_text_is_not_a_decision(tmp_path: Path, network: str) -> None:
    """Only rungs and networks have contacts; an action of a chart may be text."""
    file = tmp_path / "main.xml"
    file.write_text("<chart/>", encoding="utf-8")
    lines = (
        Line("PROGRAM Main VAR a, b : BOOL; END_VAR", 1),
        Line("b := a;", 1, network=network),
        Line("END_PROGRAM", 1),
    )
    source = Extract.make(file, lines, "Main")
    collector = Collector(tmp_path)
    files = SourceFiles((source,), (), None)
    with counting(collector), Bench.build(files, engine="builtin") as bench:
        bench.scan(1)
    (found,) = measure(merge([part_of(collector)]), tmp_path)
    assert not found.decisions
