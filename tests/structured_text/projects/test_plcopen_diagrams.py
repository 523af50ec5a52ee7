"""Ladder and Function Block Diagrams in the form of Beremiz and OpenPLC Editor."""

from __future__ import annotations

from pathlib import Path

import pytest

from plcopen_drawings import block, element, notes_of, program_of, project, scanned, text_of

_RAIL = element("leftPowerRail", 1, at="0 10")
_SEAL = (
    _RAIL
    + element("contact", 2, "Start", "1", at="50 10", negated="false")
    + element("contact", 3, "Motor", "1", at="50 50", negated="false")
    + element("contact", 4, "Stop", "2 3", at="100 10", negated="true")
    + element("coil", 5, "Motor", "4", at="150 10", negated="false")
    + element("rightPowerRail", 6, "", "5", at="200 10")
)


def test_a_rung_with_parallel_contacts(tmp_path: Path) -> None:
    """Start seals the motor in; Stop breaks the seal, also while Start is pressed.

    |  Start       Stop      Motor
    +---| |---+-----|/|-------( )---
    |  Motor  |
    +---| |---+

    Source: PLCopen TC6 XML 2.01, ldObjects; IEC 61131-3, 4.2.
    """
    program = program_of(tmp_path, project("Start Stop Motor : BOOL", f"<LD>{_SEAL}</LD>"))
    got = scanned(program, "Start Stop", "Motor", "0 0", "1 0", "0 0", "0 1", "0 0", "1 1")
    assert got == ["0", "1", "1", "0", "0", "0"]


def test_coils_and_contacts_with_modifiers(tmp_path: Path) -> None:
    """A sets S at a rising edge and B resets it; N is the inverse of B; F shows falling edges.

    Beremiz makes an F_TRIG of the last contact. F_TRIG is TRUE in its first call with FALSE.

    |   A                  S
    +--|P|----------------(S)--
    |   B                  S
    +--| |---+------------(R)--
    |        |             N
    |        +------------(/)--
    |   A                  F
    +--|N|----------------( )--

    Source: IEC 61131-3, 4.2.3 and 4.2.4 (contacts and coils).
    """
    body = (
        _RAIL
        + element("contact", 2, "A", "1", at="50 10", edge="rising")
        + element("coil", 3, "S", "2", at="99 10", storage="set")
        + element("contact", 4, "B", "1", at="50 50")
        + element("coil", 5, "S", "4", at="99 50", storage="reset")
        + element("coil", 6, "N", "4", at="99 90", negated="true")
        + element("contact", 7, "A", "1", at="50 130", edge="falling")
        + element("coil", 8, "F", "7", at="99 130")
    )
    program = program_of(tmp_path, project("A B S N F : BOOL", f"<LD>{body}</LD>"))
    got = scanned(program, "A B", "S N F", "0 0", "1 0", "1 1", "1 0", "0 0", "1 0")
    assert got == ["0 1 1", "1 1 0", "0 0 0", "0 1 0", "0 1 1", "1 1 0"]


def test_blocks_with_pins(tmp_path: Path) -> None:
    """Q follows A 20 ms later; Sum becomes N + 2 while B is TRUE; the counter takes edges of A.

         +---- T ----+                 +-- ADD --+
    A ---|IN  TON   Q|--- Q       B ---|EN    ENO|--(Ok)
    20ms-|PT       ET|            N ---|IN1   OUT|--- Sum
         +-----------+            2 ---|IN2      |
                                       +---------+
           +---- C ----+
    A --->-|CU  CTU   Q|
    B -----|R        CV|--- N
    9 -----|PV         |
           +-----------+

    Source: IEC 61131-3, 4.1.3 and 4.1.4, 2.5.1.5 (EN and ENO).
    """
    body = (
        element("inVariable", 1, "A", at="0 10")
        + element("inVariable", 2, "T#20ms", at="0 30")
        + block(3, "TON", {"IN": "1", "PT": "2"}, "Q ET", "90 10", instanceName="T")
        + element("outVariable", 4, "Q", "3.Q", at="200 10")
        + element("inVariable", 5, "B", at="0 110")
        + element("inVariable", 6, "N", at="0 130")
        + element("inVariable", 7, "2", at="0 150")
        + block(8, "ADD", {"EN": "5", "IN1": "6", "IN2": "7"}, "ENO OUT", "90 110")
        + element("coil", 9, "Ok", "8.ENO", at="200 110")
        + element("outVariable", 10, "Sum", "8.OUT", at="200 130")
        + element("inVariable", 11, "A", at="0 210")
        + element("inVariable", 12, "9", at="0 250")
        + element("inVariable", 14, "FALSE", at="0 230")
        + block(
            13,
            "CTU",
            {"CU": "rising 11", "R": "14", "PV": "12"},
            "Q CV",
            "90 210",
            instanceName="C",
        )
        + element("outVariable", 15, "N", "13.CV", at="200 230")
    )
    variables = "A B Q Ok : BOOL; N Sum : INT; T : TON; C : CTU"
    program = program_of(tmp_path, project(variables, f"<LD>{body}</LD>"))
    got = scanned(program, "A B", "Q Ok Sum N", "1 0", "1 1", "1 1", "0 0", "1 1")
    # The counter counts an edge of A in the first and the last scan.
    assert [row.split()[0] for row in got] == ["0", "0", "1", "0", "0"]
    assert [row.split()[1] for row in got] == ["0", "1", "1", "0", "1"]
    assert [row.split()[3] for row in got] == ["1", "1", "1", "1", "2"]
    assert got[2].split()[2] == "3"


def test_connectors_in_outs_and_the_order_of_execution(tmp_path: Path) -> None:
    """Block 2 with order 1 is executed before block 1 with order 2, and both add to the same N.

           +-- Step --+ (2)         +-- Step --+ (1)
    N -----|N        N|      N -----|N        N|
    10 >---|Factor    |      A=3 ---|Factor    |
           +----------+             +----------+
    with N := N * Factor + 1: first 1 * 3 + 1 = 4, then 4 * 10 + 1 = 41.

    Source: PLCopen TC6 XML 2.01, executionOrderId, connector, inOutVariables.
    """
    more = (
        '<pou name="Step" pouType="functionBlock"><interface>'
        '<inputVars><variable name="Factor"><type><INT/></type></variable></inputVars>'
        '<inOutVars><variable name="N"><type><INT/></type></variable></inOutVars></interface>'
        '<body><ST><p xmlns="http://www.w3.org/1999/xhtml">N := N * Factor + 1;</p></ST></body>'
        "</pou>\n"
    )
    body = (
        element("inVariable", 1, "10", at="0 200")
        + element("connector", 2, "", "1", at="50 200", name="Ten")
        + element("continuation", 3, "", at="0 30", name="Ten")
        + element("inVariable", 4, "N", at="0 10")
        + block(
            5,
            "Step",
            {"Factor": "3"},
            "",
            "90 10",
            in_outs={"N": "4"},
            instanceName="S1",
            executionOrderId="2",
        )
        + element("inVariable", 6, "N", at="0 110")
        + element("inVariable", 7, "A", at="0 130")
        + block(
            8,
            "Step",
            {"Factor": "7"},
            "",
            "90 110",
            in_outs={"N": "6"},
            instanceName="S2",
            executionOrderId="1",
        )
    )
    text = project("N A : INT; S1 S2 : Step", f"<FBD>{body}</FBD>", more=more)
    program = program_of(tmp_path, text)
    program.write("Main.N", 1)
    program.write("Main.A", 3)
    program.scan(0)
    assert program.read("Main.N") == 41


def test_networks_are_numbered_from_the_top_with_their_comments(tmp_path: Path) -> None:
    """The upper rung is network 1, though it is the second in the file; both share a rail.

    A comment above a rung and a comment to the right of a rung belong to it. Each statement has
    the line of its coil in the file.
    """
    body = (
        _RAIL
        + element("contact", 2, "B", "1", at="50 200")
        + element("coil", 3, "D", "2", at="99 200")
        + element("comment", 4, "lower", at="50 150", width="40", height="20")
        + element("contact", 5, "A", "1", at="50 50")
        + element("coil", 6, "C", "5", at="99 50")
        + element("comment", 7, "upper", at="200 50", width="40", height="20")
    )
    text = project("A B C D : BOOL", f"<LD>\n{body}</LD>", company="OpenPLC")
    lines = text_of(tmp_path, text)
    file = text.splitlines()
    places = {words: (network, at) for at, network, words in lines if ":=" in words}
    assert places["C := A;"][0] == "network 1"
    assert places["D := B;"][0] == "network 2"
    for words, variable in (("C := A;", "C"), ("D := B;", "D")):
        line = file[places[words][1] - 1]
        assert line.startswith("<coil")
        assert f">{variable}<" in line
    joined = "\n".join(words for _, _, words in lines)
    assert joined.index("upper") < joined.index("C := A;") < joined.index("lower")


def test_an_empty_diagram_has_no_statements(tmp_path: Path) -> None:
    """A body without elements does nothing, and its program runs."""
    program = program_of(tmp_path, project("A : BOOL", "<FBD/>"))
    program.scan(0)
    assert program.read("Main.A") is False


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ('refLocalId="1"', 'refLocalId="77"', "network 1: the contact Start is not connected on"),
        ('localId="3"', 'localId="2"', "two elements have the number 2"),
        (
            "<coil",
            '<actionBlock localId="9"/><coil',
            "element 9: the element <actionBlock> is not supported",
        ),
        (">Stop<", "><", "element 4: a contact has no variable"),
        ('negated="true"', 'edge="both"', "element 4: 'both' is not a value of edge"),
    ],
)
def test_a_diagram_that_is_not_read_is_named_with_its_reason(
    tmp_path: Path, old: str, new: str, reason: str
) -> None:
    """The body is reported with its language or element and a hint; the rest is read."""
    text = project("Start Stop Motor : BOOL", f"<LD>{_SEAL}</LD>")
    assert old in text
    note = notes_of(tmp_path, text.replace(old, new))
    assert "the body of Main is not read: " in note
    assert reason in note


def test_a_diagram_beside_another_body_is_named(tmp_path: Path) -> None:
    """A POU with several bodies is read only if all of them are in Structured Text."""
    text = project("Start Stop Motor : BOOL", f"<LD>{_SEAL}</LD>")
    note = notes_of(tmp_path, text.replace("</body>", "</body><body><FBD/></body>"))
    assert "is not read: it has several bodies, and one is in LD (draw a single body)" in note
