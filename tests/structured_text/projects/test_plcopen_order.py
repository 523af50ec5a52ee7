"""The order of elements without a number, which depends on the editor of a file.

Source: PLCGenerator.py of Beremiz (SortInstances, ComputeProgram) and of xml2st.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from plcopen_drawings import block, element, notes_of, program_of, project, scanned, text_of
from structured_text.projects.open import project_sources

_RAIL = element("leftPowerRail", 1, at="0 10")


def _copies(*, number: str = "") -> str:
    """Return two copies: C := B at the bottom and first in the file, B := A above it.

    A `number` is the execution order of the upper copy.
    """
    given = {"executionOrderId": number} if number else {}
    return (
        element("inVariable", 2, "B", at="0 200")
        + element("outVariable", 3, "C", "2", at="99 200")
        + element("inVariable", 4, "A", at="0 50")
        + element("outVariable", 5, "B", "4", at="99 50", **given)
    )


@pytest.mark.parametrize(
    ("company", "later", "order"),
    [
        # C is written first, in the order of the file, so it has the B of the last scan.
        ("Beremiz", ["0", "1"], "in the order of the file"),
        ("Unknown", ["0", "1"], "in the order of the file"),
        ("", ["0", "1"], "in the order of the file"),
        # B stands above C, so it is written first.
        ("OpenPLC Editor", ["1", "1"], "by position, outputs and blocks together"),
    ],
)
def test_the_order_is_that_of_the_editor_of_the_file(
    tmp_path: Path, company: str, later: list[str], order: str
) -> None:
    """The note has the place, the POU, the networks, and the order that was chosen."""
    text = project("A B C : BOOL", f"<FBD>{_copies()}</FBD>", company=company)
    assert scanned(program_of(tmp_path, text), "A", "C", "1", "1") == later
    at = next(k for k, line in enumerate(text.splitlines(), 1) if line.startswith("<FBD>"))
    (note,) = notes_of(tmp_path, text).splitlines()
    assert note.startswith(
        f"{tmp_path / 'plc.xml'}:{at}: Main: the order of execution of networks 1 and 2 depends on"
        f" the version of the editor; here it is executed {order}"
    )
    assert note.endswith("execution order, and draw coils from top to bottom)")


def test_an_execution_order_is_the_same_in_all_editors(tmp_path: Path) -> None:
    """With a number, B is written first."""
    text = project("A B C : BOOL", f"<FBD>{_copies(number='1')}</FBD>")
    assert scanned(program_of(tmp_path, text), "A", "C", "1", "1") == ["1", "1"]
    assert notes_of(tmp_path, text) == ""


def test_networks_without_common_variables_have_no_note(tmp_path: Path) -> None:
    """The lower rung is executed first, but no rung reads what the other writes.

    Two timers have inputs of the same names and read the same variables; a coil has the name of an
    input.
    """
    body = (
        _RAIL
        + element("contact", 2, "A", "1", at="50 200")
        + block(3, "TON", {"IN": "2", "PT": "9"}, "Q ET", "90 200", instanceName="T")
        + element("coil", 4, "C", "3.Q", at="199 200")
        + element("contact", 5, "A", "1", at="50 50", edge="rising")
        + block(6, "TON", {"IN": "5", "PT": "9"}, "Q ET", "90 50", instanceName="U")
        + element("coil", 7, "IN", "6.Q", at="199 50")
        + element("inVariable", 9, "P", at="0 220")
    )
    text = project("A C IN : BOOL; P : TIME; T U : TON", f"<LD>{body}</LD>")
    calls = [words[0] for _, _, words in text_of(tmp_path, text) if "(IN" in words]
    assert calls == ["T", "U"]
    assert notes_of(tmp_path, text) == ""


def test_conditions_in_brackets_are_no_calls(tmp_path: Path) -> None:
    """Two rungs (A OR B) AND (A OR D) set X and Y; the lower rung is the first in the file.

    |  A      A      X
    +--| |-+--| |-+--(S)
    |  B   |  D   |
    +--| |-+--| |-+
    """
    body = _RAIL
    for first, name, y in ((10, "X", 200), (20, "Y", 50)):
        body += element("contact", first, "A", "1", at=f"50 {y}")
        body += element("contact", first + 1, "B", "1", at=f"50 {y + 40}")
        before = f"{first} {first + 1}"
        body += element("contact", first + 2, "A", before, at=f"99 {y}")
        body += element("contact", first + 3, "D", before, at=f"99 {y + 40}")
        before = f"{first + 2} {first + 3}"
        body += element("coil", first + 4, name, before, at=f"150 {y}", storage="set")
    text = project("A B D X Y : BOOL", f"<LD>{body}</LD>")
    words = [line for _, _, line in text_of(tmp_path, text) if line.startswith("IF ")]
    assert words == ["IF (A OR B) AND (A OR D) THEN"] * 2
    assert notes_of(tmp_path, text) == ""


def test_the_order_of_blocks_and_outputs_in_a_network(tmp_path: Path) -> None:
    """The block S stands above the output M that it reads.

    Beremiz writes M first, because outputs come before blocks, so S has the new M. OpenPLC Editor
    calls S first, because it stands above; S has the M of the last scan.
    """
    body = (
        element("inVariable", 2, "M", at="0 10")
        + element("inVariable", 3, "FALSE", at="0 30")
        + block(4, "SR", {"S1": "2", "R": "3"}, "Q1", "90 10", instanceName="S")
        + element("inVariable", 5, "A", at="0 90")
        + element("outVariable", 6, "M", "5", at="90 90")
        + element("outVariable", 7, "N", "4.Q1", at="190 190")
    )
    variables, body = "A M N : BOOL; S : SR", f"<FBD>{body}</FBD>"
    openplc = project(variables, body, company="OpenPLC")
    assert scanned(program_of(tmp_path, openplc), "A", "N", "1", "0", "0") == ["0", "1", "1"]
    assert "networks 1 and 2 depends" in notes_of(tmp_path, openplc)
    beremiz = project(variables, body)
    assert scanned(program_of(tmp_path, beremiz), "A", "N", "1", "0", "0") == ["1", "1", "1"]
    assert "networks 1 and 2 depends" in notes_of(tmp_path, beremiz)


def test_the_power_behind_a_coil_with_parallel_lines(tmp_path: Path) -> None:
    """D has A AND B in Beremiz, and A OR B in OpenPLC Editor 4; C has A OR B in both.

    |  A       C     D
    +--| |--+--( )---( )
    |  B    |
    +--| |--+
    """
    body = (
        _RAIL
        + element("contact", 2, "A", "1", at="50 10")
        + element("contact", 3, "B", "1", at="50 50")
        + element("coil", 4, "C", "2 3", at="99 10")
        + element("coil", 5, "D", "4", at="150 10")
    )
    variables, body = "A B C D : BOOL", f"<LD>{body}</LD>"
    for company, expected in (("Beremiz", "1 0"), ("OpenPLC", "1 1")):
        text = project(variables, body, company=company)
        assert scanned(program_of(tmp_path, text), "A B", "C D", "1 0") == [expected]
        note = notes_of(tmp_path, text)
        assert "the result of network 1 depends on the version of the editor" in note
        assert "lead no line on behind a coil that several lines lead to" in note


def test_blocks_with_a_common_variable_have_a_note(tmp_path: Path) -> None:
    """Both blocks add to N through a VAR_IN_OUT: the order decides which value it has between."""
    variable = '<variable name="{}"><type><INT/></type></variable>'
    more = (
        '<pou name="Adder" pouType="functionBlock"><interface>'
        f"<inOutVars>{variable.format('N')}</inOutVars>"
        f"<outputVars>{variable.format('V')}</outputVars></interface>\n"
        '<body><ST><p xmlns="http://www.w3.org/1999/xhtml">N := N + 1; V := N;</p></ST></body>'
        "</pou>\n"
    )
    body = element("inVariable", 9, "N", at="0 10")
    for number, name, y in ((2, "X", 200), (3, "Y", 50)):
        body += block(number, "Adder", {}, "V", f"90 {y}", in_outs={"N": "9"}, instanceName=name)
    text = project("N : INT; X Y : Adder", f"<FBD>{body}</FBD>", more=more)
    program = program_of(tmp_path, text)
    program.scan(0)
    assert (program.read("Main.X.V"), program.read("Main.Y.V")) == (1, 2)
    assert "the order of execution in network 1 depends" in notes_of(tmp_path, text)


def test_a_file_without_positions_has_no_note(tmp_path: Path) -> None:
    """CODESYS executes networks in the order of the file."""
    body = (
        element("inVariable", 2, "B")
        + element("outVariable", 3, "C", "2")
        + element("inVariable", 4, "A")
        + element("outVariable", 5, "B", "4")
    )
    text = project("A B C : BOOL", f"<FBD>{body}</FBD>", company="CODESYS")
    assert notes_of(tmp_path, text) == ""


def test_a_body_that_is_replaced_has_no_note(tmp_path: Path) -> None:
    """The order of execution of a diagram is not that of the text in its place."""
    file, own = tmp_path / "plc.xml", tmp_path / "Main.st"
    file.write_text(project("A B C : BOOL", f"<FBD>{_copies()}</FBD>"), encoding="utf-8")
    own.write_text("C := A;\n", encoding="utf-8")
    assert len(project_sources([file], {}).notes) == 1
    assert not project_sources([file], {"Main": own}).notes
