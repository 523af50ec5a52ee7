"""Blocks and functions of a diagram: operators, nesting, EN and ENO, VAR_IN_OUT, feedback."""

from __future__ import annotations

from pathlib import Path

import pytest

from drawn import Drawing, lines_from, matiec_rows, scanned
from structured_text.engines.matiec.build import Matiec
from structured_text.projects.diagrams.networks.check import DiagramError
from structured_text.projects.diagrams.networks.model import Input, Output

_ORDERS = pytest.mark.parametrize("by_position", [True, False], ids=["position", "networks"])

_ADDER = """FUNCTION_BLOCK Adder
VAR_IN_OUT Sum : INT; END_VAR
VAR_INPUT Go : BOOL; Amount : INT := 2; END_VAR
VAR_OUTPUT Done : BOOL; Calls : INT; END_VAR
Calls := Calls + 1;
IF Go THEN Sum := Sum + Amount; END_IF;
Done := Go;
END_FUNCTION_BLOCK
END_POU
"""
_TWICE = """FUNCTION Twice : INT
VAR_INPUT X : INT; END_VAR
Twice := X + X;
END_FUNCTION
END_POU
"""
_SPLIT = """FUNCTION Split : INT
VAR_INPUT X : INT; END_VAR
VAR_OUTPUT Rest : INT; END_VAR
Split := X / 10;
Rest := X MOD 10;
END_FUNCTION
END_POU
"""


def _two(drawing: Drawing, kind: str, one: str, other: str) -> str:
    """Draw a function with two inputs; a name is a variable, `id.OUT` a block."""
    sources = [name if "." in name else drawing.read(name) for name in (one, other)]
    return drawing.block(kind, {"IN1": sources[0], "IN2": sources[1]}) + ".OUT"


def test_functions_become_operators_with_the_brackets_that_they_need() -> None:
    """Source: IEC 61131-3, table 52: the order of operators."""
    drawing = Drawing("A, B, C, N : INT; X, Y : BOOL;", by_position=False)
    drawing.write("N", _two(drawing, "MUL", _two(drawing, "ADD", "A", "B"), "C"))
    drawing.write("N", _two(drawing, "ADD", _two(drawing, "MUL", "A", "B"), "C"))
    drawing.write("N", _two(drawing, "SUB", "A", _two(drawing, "SUB", "B", "C")))
    drawing.write("N", _two(drawing, "MOD", "A", _two(drawing, "DIV", "B", "-3")))
    either = _two(drawing, "OR", "X", _two(drawing, "GE", "A", "5"))
    both = _two(drawing, "AND", either, "Y")
    drawing.coil("X", drawing.block("NOT", {"IN": both}) + ".OUT")
    drawing.coil("Y", _two(drawing, "EQ", _two(drawing, "LT", "A", "B"), "X"))
    drawing.coil("X", _two(drawing, "XOR", _two(drawing, "AND", "X", "Y"), "Y"))
    drawing.write("N", drawing.block("MOVE", {"IN": drawing.read("A")}))
    assert drawing.text()[1:] == [
        "N := (A + B) * C;",
        "N := A * B + C;",
        "N := A - (B - C);",
        "N := A MOD (B / (-3));",
        "X := NOT ((X OR A >= 5) AND Y);",
        "Y := (A < B) = X;",
        "X := (X AND Y) XOR Y;",
        "N := A;",
    ]


def test_functions_without_an_operator_are_called() -> None:
    """SEL has its arguments by position; a function of the project has them by name."""
    drawing = Drawing("G : BOOL; A, B, N : INT; R : REAL;", _TWICE)
    pins = {"G": drawing.read("G"), "IN0": drawing.read("A"), "IN1": drawing.read("B")}
    twice = drawing.block("Twice", {"X": drawing.block("SEL", pins)}, ["Twice"])
    drawing.write("N", twice)
    drawing.write("R", drawing.block("INT_TO_REAL", {"IN": drawing.read("N")}))
    assert drawing.text()[1:] == ["N := Twice(X := SEL(G, A, B));", "R := INT_TO_REAL(N);"]


def test_a_value_that_is_used_twice_has_a_variable_of_its_type() -> None:
    """The type comes from the variables, not from the literal."""
    drawing = Drawing("A : DINT; N, M : DINT;")
    total = _two(drawing, "ADD", "1", "A")
    drawing.write("N", total)
    drawing.write("M", total)
    section, _ = drawing.translated()
    assert [line.text.strip() for line in section] == ["VAR", "RcxAdd_1 : DINT;", "END_VAR"]
    assert drawing.text()[1:] == ["RcxAdd_1 := 1 + A;", "N := RcxAdd_1;", "M := RcxAdd_1;"]


@_ORDERS
def test_a_value_is_kept_while_its_variables_change(tmp_path: Path, by_position: bool) -> None:
    """The sum was computed before N was written, but it is used behind that.

    N + 1 is executed first, because it has the lowest number, or stands first in its network.
    """
    drawing = Drawing("N, M : INT;", by_position=by_position)
    one = drawing.block("ADD", {"IN1": drawing.read("N"), "IN2": drawing.read("1")}, order=1)
    drawing.write("N", drawing.read("100"), order=2)
    drawing.write("M", one, order=3)
    assert scanned(drawing, tmp_path, [{"N": 5}], "N M") == [(100, 6)]


@_ORDERS
def test_a_function_with_en_false_is_not_executed(tmp_path: Path, by_position: bool) -> None:
    """The variable behind the function keeps its value; ENO is FALSE.

    Source: IEC 61131-3, 2.5.1.2 and 2.5.2.1a; Beremiz, PLCGenerator.py, GetUsedEno.
    """
    drawing = Drawing("A, Ok : BOOL; N, D : INT;", by_position=by_position)
    pins = {"EN": drawing.contact("A"), "IN1": drawing.read("100"), "IN2": drawing.read("D")}
    share = drawing.block("DIV", pins, ["ENO", "OUT"])
    drawing.write("N", f"{share}.OUT")
    drawing.coil("Ok", f"{share}.ENO")
    given: list[dict[str, int]] = [{"D": 5, "A": True}, {"D": 0, "A": False}, {"D": 2}, {"A": True}]
    got = scanned(drawing, tmp_path, given, "N Ok")
    assert got == [(20, True), (20, False), (20, False), (50, True)]
    assert drawing.text()[1:] == ["IF A THEN", "  N := 100 / D;", "END_IF;", "Ok := A;"]


def test_a_value_behind_a_function_that_is_not_executed_is_0_by_position(tmp_path: Path) -> None:
    """The sum is used by a second function: without EN it is 0, as in matiec.

    Source: matiec, iec_std_functions.h, TEST_EN: the result is the initial value of its type.
    """
    drawing = Drawing("A : BOOL; N, M : INT;")
    pins = {"EN": drawing.contact("A"), "IN1": drawing.read("N"), "IN2": drawing.read("1")}
    total = drawing.block("ADD", pins, ["ENO", "OUT"])
    drawing.write("M", _two(drawing, "MUL", f"{total}.OUT", "10"))
    got = scanned(drawing, tmp_path, [{"N": 2, "A": True}, {"A": False}], "M")
    assert got == [(30,), (0,)]
    drawing.by_position = False  # in CODESYS the last value stays (assumed)
    assert scanned(drawing, tmp_path, [{"N": 2, "A": True}, {"A": False}], "M") == [(30,), (30,)]


@_ORDERS
def test_a_block_with_en_false_is_not_called(tmp_path: Path, by_position: bool) -> None:
    """The block counts its calls; its outputs stay, and ENO is FALSE."""
    drawing = Drawing("A, B, Ok : BOOL; S, C : INT; Add1 : Adder;", _ADDER, by_position)
    pins: dict[str, str | Input] = {
        "EN": drawing.contact("A"),
        "Sum": Input("", lines_from(drawing.read("S")), in_out=True),
        "Go": drawing.read("B"),
    }
    add = drawing.block("Adder", pins, ["ENO", "Sum", "Done", "Calls"], "Add1")
    drawing.write("C", f"{add}.Calls")
    drawing.coil("Ok", f"{add}.ENO")
    given = [{"A": True, "B": True}, {"A": False}, {"A": True}]
    got = scanned(drawing, tmp_path, given, "S C Ok")
    assert got == [(2, 1, True), (2, 1, False), (4, 2, True)]


def test_en_that_is_used_again_is_computed_before_the_block_changes_it(tmp_path: Path) -> None:
    """The block changes S, which its own EN reads; ENO has the value of EN at the call."""
    drawing = Drawing("Ok : BOOL; S : INT; Add1 : Adder;", _ADDER, by_position=False)
    low = drawing.block("LT", {"IN1": drawing.read("S"), "IN2": drawing.read("2")})
    pins = {"EN": low, "Sum": drawing.read("S"), "Go": drawing.read("TRUE")}
    add = drawing.block("Adder", pins, ["ENO", "Sum"], "Add1")
    drawing.coil("Ok", f"{add}.ENO")
    assert scanned(drawing, tmp_path, [{}, {}], "S Ok") == [(2, True), (2, False)]


@_ORDERS
def test_unconnected_inputs_of_a_block_keep_their_values(tmp_path: Path, by_position: bool) -> None:
    """Amount is not connected: its initial value is 2. Source: IEC 61131-3, 2.5.2.2."""
    drawing = Drawing("S : INT; Add1 : Adder;", _ADDER, by_position)
    pins = {"Sum": "=S", "Go": "=TRUE", "Amount": ""}
    drawing.block("Adder", pins, ["Sum", Output("Done")], "Add1")
    assert scanned(drawing, tmp_path, [{}, {}], "S") == [(2,), (4,)]
    assert drawing.text()[1:] == ["Add1(Sum := S, Go := TRUE);"]


def test_a_variable_goes_through_several_blocks(tmp_path: Path) -> None:
    """Both blocks of a chain add to S itself: 2 and 2 in each scan."""
    drawing = Drawing("S : INT; Add1, Add2 : Adder;", _ADDER, by_position=False)
    first = drawing.block("Adder", {"Sum": drawing.read("S"), "Go": "=TRUE"}, ["Sum"], "Add1")
    second = drawing.block("Adder", {"Sum": f"{first}.Sum", "Go": "=TRUE"}, ["Sum"], "Add2")
    drawing.network()
    drawing.write("S", _two(drawing, "ADD", f"{second}.Sum", "100"))
    assert scanned(drawing, tmp_path, [{}, {}], "S") == [(104,), (208,)]


def test_a_chain_of_variables_has_copies_by_position(tmp_path: Path) -> None:
    """The second block changes a copy of the first block's variable, as in Beremiz.

    Source: Beremiz, PLCGenerator.py, GenerateBlock, to_inout.
    """
    drawing = Drawing("S : INT; Add1, Add2 : Adder;", _ADDER)
    first = drawing.block("Adder", {"Sum": drawing.read("S"), "Go": "=TRUE"}, ["Sum"], "Add1")
    drawing.block("Adder", {"Sum": f"{first}.Sum", "Go": "=TRUE"}, ["Sum"], "Add2")
    assert scanned(drawing, tmp_path, [{}, {}], "S") == [(2,), (4,)]
    assert drawing.text()[2:] == [
        "RcxAdd1_SUM := Add1.Sum;",
        "Add2(Sum := RcxAdd1_SUM, Go := TRUE);",
    ]


def test_outputs_of_a_function_with_several_outputs(tmp_path: Path) -> None:
    """47 is split into 4 and 7."""
    drawing = Drawing("X, Tens, Ones : INT;", _SPLIT)
    split = drawing.block("Split", {"X": drawing.read("X")}, ["Split", "Rest"])
    drawing.write("Tens", f"{split}.Split")
    drawing.write("Ones", f"{split}.Rest")
    assert scanned(drawing, tmp_path, [{"X": 47}], "Tens Ones") == [(4, 7)]


@_ORDERS
def test_pins_invert_and_detect_edges(tmp_path: Path, by_position: bool) -> None:
    """The first AND has an inverted input, the second one an input with an edge."""
    drawing = Drawing("A, B, X, Y : BOOL;", by_position=by_position)
    pins: dict[str, str | Input] = {
        "IN1": drawing.read("A"),
        "IN2": Input("", lines_from(drawing.read("B")), negated=True),
    }
    drawing.coil("X", drawing.block("AND", pins))
    pins = {
        "IN1": drawing.read("A"),
        "IN2": Input("", lines_from(drawing.read("B")), edge="rising"),
    }
    drawing.coil("Y", drawing.block("AND", pins, [Output("OUT", negated=True)]))
    given = [{"A": True}, {"B": True}, {}]
    got = scanned(drawing, tmp_path, given, "X Y")
    assert got == [(True, True), (False, False), (False, True)]


def test_variables_at_the_pins_of_a_block(tmp_path: Path) -> None:
    """An output pin has its variable, with set; the variable behind EN FALSE keeps its value."""
    drawing = Drawing("A, X, Hit : BOOL; N, M : INT; C1 : CTU;", by_position=False)
    pins = {"CU": drawing.contact("A"), "PV": "=2"}
    outputs = [Output("Q", target="Hit", storage="set"), Output("CV", target="N")]
    drawing.block("CTU", pins, outputs, "C1")
    drawing.network()
    pins = {"EN": drawing.contact("Hit", negated=True), "In1": "=N", "In2": "=10"}
    drawing.block("ADD", pins, ["ENO", Output("Out1", target="M")])
    given = [{"A": True}, {"A": False}, {"A": True}, {"A": False}]
    got = scanned(drawing, tmp_path, given, "N Hit M")
    assert got == [(1, False, 11), (1, False, 11), (2, True, 11), (2, True, 11)]


@_ORDERS
def test_statements_in_a_block_are_executed_with_en(tmp_path: Path, by_position: bool) -> None:
    """An execute box has statements in place of a call."""
    drawing = Drawing("A, Ok : BOOL; N : INT;", by_position=by_position)
    box = drawing.block(
        "EXECUTE",
        {"EN": drawing.contact("A")},
        ["ENO"],
        statements=("N := N + 1;", "N := N * 2; (* {0} *)"),
    )
    drawing.coil("Ok", f"{box}.ENO")
    got = scanned(drawing, tmp_path, [{}, {"A": True}, {}], "N Ok")
    assert got == [(0, False), (2, True), (6, True)]


def test_connectors_continue_a_line(tmp_path: Path) -> None:
    """Both continuations have the value of A AND B."""
    drawing = Drawing("A, B, X, Y : BOOL;")
    drawing.coil("X", drawing.continued("Both"))
    drawing.coil("Y", drawing.contact("X", drawing.continued("both"), negated=True))
    drawing.connector("Both", drawing.contact("B", drawing.contact("A")))
    got = scanned(drawing, tmp_path, [{"A": True}, {"B": True}], "X Y")
    assert got == [(False, False), (True, False)]


def test_connectors_between_networks_of_codesys(tmp_path: Path) -> None:
    """The value is that of the first network, although A changes before its use."""
    drawing = Drawing("A, X : BOOL;", by_position=False)
    drawing.connector("Old", drawing.contact("A"))
    drawing.network()
    drawing.coil("A", drawing.contact("A", negated=True))
    drawing.network()
    drawing.coil("X", drawing.continued("Old"))
    assert scanned(drawing, tmp_path, [{}, {}], "A X") == [(True, False), (False, True)]


def test_a_feedback_has_the_value_of_the_last_scan(tmp_path: Path) -> None:
    """The sum goes back to its own input: it counts up by A.

    Source: IEC 61131-3, 4.3.2: the value of the feedback is that of the last evaluation.
    """
    drawing = Drawing("A, N : INT;")
    own = str(len(drawing.elements) + 1)
    total = drawing.block("ADD", {"IN1": drawing.read("A"), "IN2": f"{own}.OUT"})
    assert total == own
    drawing.write("N", total)
    assert scanned(drawing, tmp_path, [{"A": 3}, {}, {"A": 1}], "N") == [(3,), (6,), (7,)]


def test_a_function_that_needs_its_own_result_is_refused_in_networks() -> None:
    """CODESYS has no feedback without a variable."""
    drawing = Drawing("A, N : INT;", by_position=False)
    own = str(len(drawing.elements) + 1)
    drawing.write("N", drawing.block("ADD", {"IN1": drawing.read("A"), "IN2": own}))
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message == "network 1: the block ADD depends on its own result"
    assert caught.value.hint == "use a variable for the value of the last scan"


@pytest.mark.parametrize(
    ("kind", "inputs", "message"),
    [
        ("Unknown", {"A": "=N"}, "network 1: there is no function or block Unknown"),
        (
            "ADD",
            {"IN1": "=N", "IN2": ""},
            "network 1: the input IN2 of the block ADD is not connected",
        ),
        ("Twice", {"Y": "=N"}, "network 1: the block Twice has no input Y"),
        ("Adder", {"Go": "=TRUE"}, "network 1: the block Adder has no instance"),
        ("ADD", {"IN1": "=N", "IN2": "99"}, "network 1: the block ADD is connected to an element"),
    ],
)
def test_a_wrong_block_is_an_error(kind: str, inputs: dict[str, str], message: str) -> None:
    """Each message names the network and the block."""
    drawing = Drawing("N : INT;", _TWICE + _ADDER, by_position=False)
    drawing.write("N", drawing.block(kind, inputs))
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message.startswith(message)
    assert caught.value.hint


def test_blocks_run_on_matiec(tmp_path: Path, matiec: Matiec) -> None:
    """EN and ENO, VAR_IN_OUT, feedback and a function of the project."""
    drawing = Drawing("A, Ok : BOOL; S, N, M : INT; Add1 : Adder;", _ADDER + _TWICE)
    pins = {"EN": drawing.contact("A"), "Sum": drawing.read("S"), "Go": drawing.read("TRUE")}
    add = drawing.block("Adder", pins, ["ENO", "Sum", "Calls"], "Add1")
    drawing.write("N", f"{add}.Calls")
    drawing.coil("Ok", f"{add}.ENO")
    own = str(len(drawing.elements) + 1)
    total = drawing.block("ADD", {"IN1": drawing.read("S"), "IN2": own})
    drawing.write("M", drawing.block("Twice", {"X": total}, ["OUT"]))
    given = [{"A": True}, {"A": False}, {"A": True}]
    expected = [(2, 1, True, 4), (2, 1, False, 8), (4, 2, True, 16)]
    assert matiec_rows(drawing, tmp_path, given, "S N Ok M", matiec) == expected
    assert scanned(drawing, tmp_path, given, "S N Ok M") == expected


@pytest.mark.parametrize(
    ("kind", "pins", "declared"),
    [
        ("SEL", {"G": "=A", "IN0": "=0", "IN1": "=1"}, "LREAL"),
        ("ADD", {"IN1": "=1", "IN2": "=2"}, "LREAL"),
        ("LEN", {"IN": "='abc'"}, "INT"),
        ("ADD", {"IN1": "=D", "IN2": "=2"}, "DINT"),
        ("MUL", {"IN1": "=D", "IN2": "=R"}, "REAL"),
        ("GE", {"IN1": "=D", "IN2": "=2"}, "BOOL"),
        ("AND", {"IN1": "=W", "IN2": "=16#FF"}, "WORD"),
        ("ADD", {"IN1": "=T#1s", "IN2": "=T#2s"}, "TIME"),
        ("DINT_TO_REAL", {"IN": "=D"}, "REAL"),
        ("TO_UINT", {"IN": "=D"}, "UINT"),
    ],
)
def test_the_type_of_an_added_variable(kind: str, pins: dict[str, str], declared: str) -> None:
    """It comes from the inputs; for literals alone, from what the result is multiplied with."""
    drawing = Drawing("A : BOOL; D : DINT; R : REAL; L : LREAL; W : WORD;", by_position=False)
    value = drawing.block(kind, pins)
    drawing.write("L", drawing.block("MUL", {"IN1": value, "IN2": "=L"}))
    drawing.write("L", drawing.block("MUL", {"IN1": value, "IN2": "=L"}))
    section, _ = drawing.translated()
    assert section[1].text.rpartition(" : ")[2] == f"{declared};"


def test_a_selection_of_literals_before_a_conversion_is_an_integer(tmp_path: Path) -> None:
    """0 and 100 are INT, the input of INT_TO_BOOL, although the coil behind it is BOOL."""
    drawing = Drawing("A, X : BOOL; N : INT;", by_position=False)
    chosen = drawing.block("SEL", {"G": "=A", "IN0": "=0", "IN1": "=100"})
    drawing.coil("X", drawing.block("INT_TO_BOOL", {"IN": chosen}))
    drawing.write("N", chosen)
    section, _ = drawing.translated()
    assert section[1].text.rpartition(" : ")[2] == "INT;"
    given = [{"A": False}, {"A": True}]
    assert scanned(drawing, tmp_path, given, "X N") == [(False, 0), (True, 100)]


def test_a_long_line_is_translated(tmp_path: Path) -> None:
    """Sixty sums in a row, and sixty contacts: twelve values are in one statement at most."""
    drawing = Drawing("A, X : BOOL; N : INT;")
    value, power = drawing.read("1"), "0"
    for _ in range(60):
        value = drawing.block("ADD", {"IN1": value, "IN2": "=1"})
        power = drawing.contact("A", power)
    drawing.write("N", value)
    drawing.coil("X", power)
    assert scanned(drawing, tmp_path, [{"A": True}], "N X") == [(61, True)]
    lines = drawing.text()
    assert max(map(len, lines)) <= 100
    assert lines[1] == "RcxAdd_1 := " + " + ".join(["1"] * 13) + ";"


def test_a_line_without_an_end_is_an_error() -> None:
    """A thousand sums in a row are too many."""
    drawing = Drawing("N : INT;")
    value = drawing.read("1")
    for _ in range(1000):
        value = drawing.block("ADD", {"IN1": value, "IN2": "=1"})
    drawing.write("N", value)
    with pytest.raises(DiagramError) as caught:
        drawing.text()
    assert caught.value.message == "too many elements follow one another in a line"


def test_a_program_is_called_by_a_block(tmp_path: Path) -> None:
    """The program has no instance at the block."""
    other = "PROGRAM Other\nVAR N : INT; END_VAR\nN := N + 1;\nEND_PROGRAM\nEND_POU\n"
    drawing = Drawing("A : BOOL;", other, by_position=False)
    drawing.block("Other", {"EN": drawing.contact("A")}, ["ENO"])
    assert drawing.text()[1:] == ["IF A THEN", "  Other();", "END_IF;"]


def test_eno_is_written_to_a_variable_while_en_is_false(tmp_path: Path) -> None:
    """Ok is behind ENO itself and becomes FALSE in a network.

    In the order by position, it stays TRUE. Source: Beremiz, PLCGenerator.py, GetUsedEno.
    """
    drawing = Drawing("A, Ok : BOOL; N : INT;", by_position=False)
    pins = {"EN": drawing.contact("A"), "IN1": "=N", "IN2": "=1"}
    add = drawing.block("ADD", pins, ["ENO", "OUT"])
    drawing.write("Ok", f"{add}.ENO")
    given = [{"A": True}, {"A": False}]
    assert scanned(drawing, tmp_path, given, "Ok") == [(True,), (False,)]
    drawing.by_position = True
    assert scanned(drawing, tmp_path, given, "Ok") == [(True,), (True,)]


def test_both_blocks_of_a_chain_change_the_variable_itself(tmp_path: Path) -> None:
    """S is 2 behind the first block and 4 behind the second one."""
    drawing = Drawing("S : INT; Add1, Add2 : Adder;", _ADDER, by_position=False)
    first = drawing.block("Adder", {"Sum": drawing.read("S"), "Go": "=TRUE"}, ["Sum"], "Add1")
    drawing.block("Adder", {"Sum": f"{first}.Sum", "Go": "=TRUE"}, ["Sum"], "Add2")
    assert scanned(drawing, tmp_path, [{}, {}], "S") == [(4,), (8,)]


def test_a_sum_is_cut_to_its_type_before_it_is_compared() -> None:
    """The generator of Beremiz gives it to an INT; matiec would compare it with more bits."""
    drawing = Drawing("A : INT; X : BOOL;")
    drawing.coil("X", _two(drawing, "GT", _two(drawing, "ADD", "A", "1"), "A"))
    assert drawing.text()[1:] == ["RcxAdd_1 := A + 1;", "X := RcxAdd_1 > A;"]
