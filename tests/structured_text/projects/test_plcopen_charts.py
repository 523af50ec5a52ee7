"""Charts of PLCopen XML: the example has all kinds of elements, drawn as Beremiz writes them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.language.load import load
from structured_text.projects.open import project_sources

_HEAD = """<project xmlns="http://www.plcopen.org/xml/tc6_0201"
  xmlns:xhtml="http://www.w3.org/1999/xhtml">
<fileHeader companyName="{company}" productName="p" productVersion="1"
  creationDateTime="2026-01-01"/>
<types><dataTypes/><pous><pou name="Main" pouType="program"><interface><localVars>
<variable name="Go"><type><BOOL/></type></variable>
<variable name="Stop"><type><BOOL/></type></variable>
<variable name="Lamp"><type><BOOL/></type></variable>
<variable name="N"><type><INT/></type></variable>
</localVars></interface>
<actions><action name="Work"><body>
<ST><xhtml:p>N := N + 1;</xhtml:p></ST></body></action></actions>
<transitions><transition name="Back"><body>
<ST><xhtml:p>:= Stop;</xhtml:p></ST></body></transition></transitions>
<body><SFC>
"""
_TAIL = "</SFC></body></pou></pous></types><instances><configurations/></instances></project>\n"


def _element(kind: str, number: int, above: str = "", more: str = "", **given: object) -> str:
    """Return an SFC object that is connected to the objects with the numbers in `above`."""
    points = "".join(
        f'<connectionPointIn><connection refLocalId="{one}"/></connectionPointIn>'
        for one in above.split()
    )
    values = "".join(f' {key}="{value}"' for key, value in given.items())
    x = 10 * number
    position = f'<position x="{x}" y="0"/>'
    return f'<{kind} localId="{number}"{values}>{position}{points}{more}</{kind}>\n'


def _when(text: str) -> str:
    inline = f'<inline name=""><ST><xhtml:p>{text}</xhtml:p></ST></inline>'
    return f"<condition>{inline}</condition>"


_CHART = (
    _element("step", 1, "", name="Start", initialStep="true")
    + _element("transition", 2, "1", _when("Go"))
    + _element("simultaneousDivergence", 3, "2")
    + _element("step", 4, "3", name="L")
    + _element("step", 5, "3", name="R")
    + _element("actionBlock", 6, "4", '<action qualifier="N"><reference name="Work"/></action>')
    + _element(
        "actionBlock",
        7,
        "5",
        '<action qualifier="D" duration="T#20ms"><reference name="Lamp"/></action>',
    )
    + _element("simultaneousConvergence", 8, "4 5")
    + _element("selectionDivergence", 9, "8")
    + _element(
        "transition", 10, "9", '<condition><reference name="Back"/></condition>', priority="1"
    )
    + _element("transition", 11, "9", _when("NOT Go"), priority="2")
    + _element("selectionConvergence", 12, "10 11")
    + _element("jumpStep", 13, "12", targetName="Start")
)

_Open = Callable[..., tuple[Path, ...]]


@pytest.fixture
def opened(tmp_path: Path) -> _Open:
    """Return a function that opens a project with a chart."""

    def read(chart: str, company: str = "Beremiz") -> tuple[Path, ...]:
        file = tmp_path / "plc.xml"
        file.write_text(_HEAD.format(company=company) + chart + _TAIL)
        return project_sources([file], {}).paths

    return read


@pytest.mark.parametrize(("company", "last"), [("Beremiz", 4), ("Other", 5)])
def test_a_chart_is_executed(opened: _Open, company: str, last: int) -> None:
    """The steps L and R are active in the scans 1 to 4; a final scan is the fifth for the action.

    Source: PLCopen TC6 XML 2.01, sfcObjects; IEC 61131-3, 2.6.
    """
    program = BuiltinProgram.build(load(list(opened(_CHART, company))))
    got = []
    for scan, (go, stop) in enumerate([(0, 0), (1, 0), (1, 0), (1, 0), (1, 0), (1, 1), (0, 0)]):
        program.write("Main.Go", bool(go))
        program.write("Main.Stop", bool(stop))
        program.scan(scan * 10_000)
        got.append((program.read("Main.N"), int(program.read("Main.Lamp"))))
    assert got == [(0, 0), (1, 0), (2, 0), (3, 1), (4, 1), (last, 0), (last, 0)]


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("<jumpStep", '<macroStep localId="77" name="M"/><jumpStep', "the macro step M"),
        (_when("Go"), "", "the condition of the transition Start -> (L, R) is empty"),
        ('qualifier="N"', 'qualifier="SD"', "an action with SD in the step L has no time"),
        ('targetName="Start"', 'targetName="Stat"', "there is no step Stat"),
        (
            '<step localId="4" name="L">',
            '<step localId="4" name="L"><addData><data name="x"><EntryAction/></data></addData>',
            "the step L has an entry, exit or main action of the tool",
        ),
        ("<ST><xhtml:p>N := N + 1;</xhtml:p></ST>", "<IL/>", "the action Work is in Instruction"),
        (
            "<ST><xhtml:p>NOT Go</xhtml:p></ST>",
            "<IL/>",
            "the condition of the transition (L, R) -> Start is in IL",
        ),
    ],
)
def test_a_chart_that_is_not_read_is_named_with_its_reason(
    tmp_path: Path, old: str, new: str, reason: str
) -> None:
    """Source: docs/reference/language.md, Sequential Function Chart."""
    text = _HEAD.format(company="Beremiz") + _CHART + _TAIL
    assert old in text
    file = tmp_path / "plc.xml"
    file.write_text(text.replace(old, new))
    notes = project_sources([file], {}).notes
    assert "the body of Main is not read: " in notes[0]
    assert reason in notes[0]


def test_each_line_names_its_part_of_the_chart(opened: _Open) -> None:
    """Coverage and debugger name steps by name, transitions by number, and actions by name."""
    main = next(file for file in opened(_CHART) if getattr(file, "title", "") == "Main")
    found = {line.text.strip(): line.network for line in getattr(main, "lines", ())}
    assert found["N := N + 1;"] == "action Work"
    assert {network for network in found.values() if network} >= {
        *("transition 1", "transition 2", "transition 3"),
        *("action Work", "action Lamp", "step R"),
    }
    assert found["PROGRAM Main"] == ""
