"""Ladder and Function Block Diagrams in the form of CODESYS: no positions, one left rail."""

from __future__ import annotations

from pathlib import Path

import pytest

from plcopen_drawings import block, element, notes_of, program_of, project, scanned, text_of, value

_RAIL = element("leftPowerRail", 0)
_END = element("rightPowerRail", 2147483646)
_SPACE = "http://www.3s-software.com/plcopenxml"


def _title(number: int, text: str = "", comment: str = "", label: str = "") -> str:
    """Return the objects that open a network of ladder; they use the numbers up to number + 2."""
    found = element("comment", number, comment)
    found += element("label", number + 1, label=label) if label else ""
    return found + (
        f'<vendorElement localId="{number + 2}"><position x="0" y="0"/><alternativeText>'
        f'<xhtml xmlns="http://www.w3.org/1999/xhtml">{text}</xhtml></alternativeText><addData>'
        f'<data name="{_SPACE}/fbdelementtype"><ElementType>networktitle</ElementType></data>'
        "</addData></vendorElement>\n"
    )


def _codesys(variables: str, body: str, more: str = "") -> str:
    return project(variables, body, company="3S-Smart Software Solutions GmbH", more=more)


def test_networks_of_ladder_with_titles_and_a_jump(tmp_path: Path) -> None:
    """Network 2 is skipped while A is TRUE; network 3 writes C again in each scan.

    1 "Skip?"    |   A
                 +--| |------------->> Last
    2 "Copy"     |   B         C
                 +--| |-------( )--
    3 Last:      |   C         D
                 +--|/|-------( )--

    Source: IEC 61131-3, 4.1.4; exports of CODESYS.
    """
    body = (
        _RAIL
        + _title(1, "Skip?")
        + element("contact", 4, "A", "0", negated="false", storage="none", edge="none")
        + element("jump", 5, "", "4", label="Last")
        + _title(6, "Copy", comment="B to C")
        + element("contact", 9, "B", "0")
        + element("coil", 10, "C", "9", negated="false", storage="none")
        + _title(11, label="Last")
        + element("contact", 14, "C", "0", negated="true")
        + element("coil", 15, "D", "14")
        + _END
    )
    text = _codesys("A B C D : BOOL", f"<LD>{body}</LD>")
    got = scanned(program_of(tmp_path, text), "A B", "C D", "0 1", "1 0", "0 0", "1 1", "0 1")
    assert got == ["1 0", "1 0", "0 1", "0 1", "1 0"]
    lines = text_of(tmp_path, text)
    networks = {words: network for _, network, words in lines}
    assert networks["C := B;"] == "network 2"
    assert networks["D := NOT C;"] == "network 3"
    words = "\n".join(one for _, _, one in lines)
    assert words.index("Skip?") < words.index("Copy") < words.index("B to C")


def test_boxes_in_a_rung(tmp_path: Path) -> None:
    """Big is A and N > 2, so it is FALSE while A is FALSE. N is copied while B is TRUE.

    |   A      +--- GT ---+       Big
    +--| |-----|EN    Out1|------( )--
            N--|In2       |
            2--|In3       |
               +----------+
    |   B      +-- MOVE --+       Ok
    +--| |-----|EN     ENO|------( )--
            N--|In2   Out2|-- M
               +----------+
    |   A      +-- TON ---+       Late
    +--| |-----|IN       Q|------( )--
        T#10ms-|PT      ET|-- Time
               +----------+

    Source: exports of CODESYS; IEC 61131-3, 2.5.1.5 (EN and ENO).
    """
    body = (
        _RAIL
        + _title(1)
        + element("contact", 5, "A", "0")
        + element("inVariable", 6, "N")
        + element("inVariable", 7, "2")
        + block(4, "GT", {"EN": "5", "In2": "6", "In3": "7"}, "Out1", call="operator")
        + element("coil", 8, "Big", "4.Out1")
        + _title(9)
        + element("contact", 13, "B", "0")
        + element("inVariable", 14, "N")
        + block(12, "MOVE", {"EN": "13", "In2": "14"}, "ENO Out2=M", call="operator")
        + element("coil", 15, "Ok", "12.ENO")
        + _title(16)
        + element("contact", 20, "A", "0")
        + element("inVariable", 21, "T#10ms")
        + block(
            19,
            "TON",
            {"IN": "20", "PT": "21"},
            "Q ET=Time",
            call="functionblock",
            instanceName="Delay",
        )
        + element("coil", 22, "Late", "19.Q")
        + _END
    )
    variables = "A B Big Ok Late : BOOL; N M : INT; Delay : TON; Time : TIME"
    program = program_of(tmp_path, _codesys(variables, f"<LD>{body}</LD>"))
    program.write("Main.N", 3)
    got = scanned(program, "A B", "Big Ok M Late", "0 0", "1 0", "1 1", "0 0")
    assert got == ["0 0 0 0", "1 0 0 0", "1 1 3 1", "0 0 3 0"]
    program.write("Main.N", 2)
    assert scanned(program, "A B", "Big M", "1 1") == ["0 2"]


def _number(network: int, place: int) -> int:
    return network * 10**10 + place


def test_networks_of_fbd(tmp_path: Path) -> None:
    """The networks follow from the numbers of the elements; the third of them is not exported.

    1        +- AND -+
       A ----|       |
       B ---o|       |--- C
             +-------+
    2        +- SUB -+    +- MUL -+
       N ----|       |----|       |--- M
       1 ----|       |  2-|       |
             +-------+    +-------+
    4  M --- K

    Source: exports of CODESYS and TwinCAT.
    """
    body = (
        f'<vendorElement localId="{_number(1, 0)}"><position x="0" y="0"/><alternativeText/>'
        f'<addData><data name="{_SPACE}/fbd/implementationattributes"/></addData>'
        "</vendorElement>"
        + element("inVariable", _number(1, 1), "A")
        + element("inVariable", _number(1, 2), "B")
        + block(
            _number(1, 3),
            "AND",
            {"In1": str(_number(1, 1)), "In2": f"NOT {_number(1, 2)}"},
            "Out1",
            call="operator",
        )
        + element("outVariable", _number(1, 4), "C", f"{_number(1, 3)}.C")
        + element("inVariable", _number(2, 1), "N")
        + element("inVariable", _number(2, 2), "1")
        + block(
            _number(2, 3),
            "SUB",
            {"In1": str(_number(2, 1)), "In2": str(_number(2, 2))},
            "Out1",
            call="operator",
        )
        + element("inVariable", _number(2, 4), "2")
        + block(
            _number(2, 5),
            "MUL",
            {"In1": f"{_number(2, 3)}.Out1", "In2": str(_number(2, 4))},
            "Out1=M",
            call="operator",
        )
        + element("inVariable", _number(4, 1), "M")
        + element("outVariable", _number(4, 2), "K", str(_number(4, 1)))
    )
    text = _codesys("A B C : BOOL; N M K : INT", f"<FBD>{body}</FBD>")
    program = program_of(tmp_path, text)
    program.write("Main.N", 8)
    assert scanned(program, "A B", "C M K", "1 0", "1 1", "0 0") == [
        "1 14 14",
        "0 14 14",
        "0 14 14",
    ]
    networks = {words: network for _, network, words in text_of(tmp_path, text)}
    assert networks["K := M;"] == "network 4"


@pytest.mark.parametrize(("mode", "counted"), [("sce", 2), ("or", 4)])
def test_a_block_in_a_short_circuit_is_skipped(tmp_path: Path, mode: str, counted: int) -> None:
    """The counter is not called while B is TRUE, so it sees two of the four edges of A.

    |           B
    +----------| |--------------+---( Q )--
    |   A       +--- CTU ---+   |
    +--| |------|CU        Q|---+
            9 --|PV       CV|-- N
                +-----------+

    In a branch that is not a short circuit, all four edges are counted.

    Source: CODESYS help, LD element "Closed Branch".
    """
    body = (
        _RAIL
        + _title(1)
        + element("contact", 4, "B", "0")
        + element("contact", 6, "A", "0")
        + element("inVariable", 7, "9")
        + block(
            5,
            "CTU",
            {"CU": "6", "PV": "7"},
            "Q CV=N",
            call="functionblock",
            instanceName="C",
        )
        + f'<vendorElement localId="8"><position x="0" y="0"/><addData><data name="{_SPACE}/'
        f'ldparallelbranch"><ParallelBranch mode="{mode}"><BranchInput><connectionPointIn>'
        '<connection refLocalId="0"/></connectionPointIn></BranchInput><BranchTrees><Tree>'
        '<connectionPointIn><connection refLocalId="4"/></connectionPointIn></Tree><Tree>'
        '<connectionPointIn><connection refLocalId="5" formalParameter="Q"/></connectionPointIn>'
        "</Tree></BranchTrees></ParallelBranch></data></addData></vendorElement>"
        + element("coil", 9, "Q", "4 5.Q")
        + _END
    )
    program = program_of(tmp_path, _codesys("A B Q : BOOL; N : INT; C : CTU", f"<LD>{body}</LD>"))
    rows = ["1 0", "0 0", "1 1", "0 1", "1 1", "0 0", "1 0", "0 0"]
    assert scanned(program, "A B", "Q", *rows) == ["0", "0", "1", "1", "1", "0", "0", "0"]
    assert value(program, "N") == counted


def test_an_execute_box(tmp_path: Path) -> None:
    """The statements of the box are executed while A is TRUE.

    |   A      +-- EXECUTE --+
    +--| |-----|EN        ENO|------( B )--
               | N := N + 1; |
               +-------------+

    Source: exports of CODESYS.
    """
    code = "\nIF N &lt; 9 THEN\n  N := N + 1;\nEND_IF\n"
    body = (
        _RAIL
        + _title(1)
        + element("contact", 5, "A", "0")
        + block(4, "EXECUTE", {"EN": "5"}, "ENO", call="execute", code=code)
        + element("coil", 6, "B", "4.ENO")
    )
    program = program_of(tmp_path, _codesys("A B : BOOL; N : INT", f"<LD>{body}</LD>"))
    assert scanned(program, "A", "B N", "0", "1", "1", "0") == ["0 0", "1 1", "1 2", "0 2"]


def test_pins_without_a_variable(tmp_path: Path) -> None:
    """An input that is left out keeps its value, and an output `???` is assigned to nothing.

    |   A      +--- TON ---+
    +--| |-----|IN        Q|------( B )--
               |PT       ET|-- ???
               +-----------+
    """
    body = (
        _RAIL
        + _title(1)
        + element("contact", 5, "A", "0")
        + element("inVariable", 6, "")
        + block(
            4,
            "TON",
            {"IN": "5", "PT": "6"},
            "Q ET=???",
            call="functionblock",
            instanceName="T",
        )
        + element("coil", 7, "B", "4.Q")
    )
    text = _codesys("A B : BOOL; T : TON", f"<LD>{body}</LD>")
    assert scanned(program_of(tmp_path, text), "A", "B", "0", "1", "1")[-1] == "1"
    empty = text.replace('<inVariable localId="6"><position x="0" y="0"/>', "@").replace(
        "@", '<inVariable localId="6"><position x="0" y="0"/><expression>???</expression>'
    )
    assert "network 1: the input PT of TON has no value" in notes_of(tmp_path, empty)


def test_an_edge_in_a_method_is_not_read(tmp_path: Path) -> None:
    """A method has no memory from call to call, so its edge is not read; the program runs.

    |   A      Fill
    +--|P|-----( )--
    """
    body = _RAIL + _title(1) + element("contact", 4, "A", "0", edge="rising")
    body += element("coil", 5, "Fill", "4")
    more = (
        '<pou name="Tank" pouType="functionBlock"><interface><inputVars><variable name="A"><type>'
        "<BOOL/></type></variable></inputVars></interface><body><ST><p "
        'xmlns="http://www.w3.org/1999/xhtml">;</p></ST></body><addData>'
        f'<data name="{_SPACE}/method"><Method name="Fill"><interface><returnType><BOOL/>'
        f"</returnType></interface><body><LD>{body}</LD></body></Method></data></addData></pou>"
    )
    text = _codesys("T : Tank", "<LD/>", more)
    note = notes_of(tmp_path, text)
    assert "the body of Tank.Fill is not read: network 1: an edge needs a memory" in note
    plain = text.replace(' edge="rising"', "")
    assert notes_of(tmp_path, plain) == ""
    assert any(words == "Fill := A;" for _, _, words in text_of(tmp_path, plain, "Tank"))


def test_an_action_in_ladder_has_its_variables_in_its_program(tmp_path: Path) -> None:
    """The edge of an action has its memory in the program, apart from that of the body.

    body:  --|P A|--( B )--      action, called in the body:  --|P A|--( C )--
    """
    rung = _RAIL + _title(1) + element("contact", 4, "A", "0", edge="rising")
    body = (
        f"<LD>{rung}{element('coil', 5, 'B', '4')}{_title(6)}"
        + element("inVariable", 9, "TRUE")
        + block(10, "EXECUTE", {"EN": "9"}, "ENO", call="execute", code="Work();")
        + "</LD>"
    )
    action = f'<actions><action name="Work"><body><LD>{rung}{element("coil", 5, "C", "4")}'
    text = _codesys("A B C : BOOL", body)
    text = text.replace("<body>", f"{action}</LD></body></action></actions><body>", 1)
    program = program_of(tmp_path, text)
    got = scanned(program, "A", "B C", "0", "1", "1", "0", "1")
    assert got == ["0 0", "1 1", "0 0", "0 0", "1 1"]


def test_an_element_of_the_tool_that_is_not_known_is_named(tmp_path: Path) -> None:
    """An unknown kind of element makes the body unread."""
    body = _RAIL + _title(1).replace("networktitle", "spiral")
    note = notes_of(tmp_path, _codesys("A : BOOL", f"<LD>{body}</LD>"))
    assert "the element spiral of the tool is not supported" in note
