"""`rcx export plcopen --ladder` writes the user's programs as rungs of contacts, coils, blocks."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from example_runs import EXAMPLES
from exported import imported, recorded, trace_of
from ladders import Compared, read_back, written_ladder
from plcopen_structure import check_structure, local
from rcx_harness.cell.exports import export
from rcx_tools.docs.examples import examples
from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load

_NAMES = [example.name for example in EXAMPLES]
#: Examples whose whole runs are compared in the quick tests.
_QUICK = ["03_general_io"]


def _program(variables: str, statements: str, types: str = "") -> str:
    return (
        f"{types}PROGRAM Small\n  VAR\n    {variables}\n  END_VAR\n\n{statements}\nEND_PROGRAM\n"
        "CONFIGURATION C\n  RESOURCE R ON PLC\n    TASK T1(INTERVAL := T#10ms, PRIORITY := 0);\n"
        "    PROGRAM Main WITH T1 : Small;\n  END_RESOURCE\nEND_CONFIGURATION\n"
    )


@pytest.fixture
def small(tmp_path: Path) -> Path:
    """Return the path of a file for a small program."""
    return tmp_path / "Small.st"


def _body(file: Path, pou: str = "Small") -> list[ET.Element]:
    """Return the elements of the ladder of a POU in the order of the file."""
    root = ET.parse(file).getroot()
    (found,) = [one for one in root.iter() if local(one) == "pou" and one.get("name") == pou]
    return [one for body in found if local(body) == "body" for one in body[0]]


def _elements(file: Path) -> list[str]:
    """Return a line for each element: number, kind, order of execution, words, lines to inputs."""
    lines = []
    for one in _body(file):
        order = one.get("executionOrderId")
        words = [f"{one.get('localId')} {local(one)}" + (f" #{order}" if order else "")]
        words += [one.get(key, "") for key in ("typeName", "instanceName") if one.get(key)]
        words += ["not"] * (one.get("negated") == "true")
        words += [one.get("storage", "")] * (one.get("storage") in ("set", "reset"))
        words += [str(part.text) for part in one if local(part) in ("variable", "expression")]
        for part in one.iter():
            if local(part) == "variable" and part.get("formalParameter"):
                words.append(f"{part.get('formalParameter')}:")
            if local(part) == "connection":
                pin = part.get("formalParameter")
                words.append(f"<{part.get('refLocalId')}" + (f".{pin}" if pin else ""))
        lines.append(" ".join(words))
    return lines


def test_statements_become_contacts_coils_and_blocks(small: Path, tmp_path: Path) -> None:
    """Each statement is a rung; OR is parallel, AND is in series, NOT is a negated contact.

    Motor is used by the timer below. A coil would be executed after the timer in Beremiz, so the
    rung ends with a numbered variable. Lamp is used by MOVE. Nothing below uses Alarm: it is a
    coil. The expected elements were drawn by hand.

    Source: IEC 61131-3, 4.2; PLCopen TC6 XML 2.01, ldObjects and fbdObjects.
    """
    small.write_text(
        _program(
            "Start, Stop, Motor, Lamp, Alarm : BOOL; N : INT; Delay : TON;",
            "  (* seal-in *)\n"
            "  Motor := (Start OR Motor) AND NOT Stop;\n"
            "  Delay(IN := Motor, PT := T#1s, Q => Lamp);\n"
            "  IF Lamp THEN\n    N := N + 1;\n  END_IF;\n"
            "  IF N > 5 AND NOT (Start OR NOT Stop) THEN\n    Alarm := TRUE;\n  END_IF;",
        )
    )
    written_ladder([small], tmp_path / "small.xml")
    assert _elements(tmp_path / "small.xml") == [
        "21 comment",
        # Motor := (Start OR Motor) AND NOT Stop
        "1 leftPowerRail",
        "2 contact Start <1",
        "3 contact Motor <1",
        "4 contact not Stop <2 <3",
        "5 outVariable #1 Motor <4",
        # Delay(IN := Motor, PT := T#1s, Q => Lamp)
        "6 leftPowerRail",
        "7 contact Motor <6",
        "8 inVariable T#1s",
        "9 block #2 TON Delay IN: <7 PT: <8 Q: ET:",
        "10 outVariable #3 Lamp <9.Q",
        # IF Lamp THEN N := N + 1
        "11 leftPowerRail",
        "12 contact Lamp <11",
        "13 inVariable N + 1",
        "14 block #4 MOVE EN: <12 IN: <13 ENO: OUT:",
        "15 outVariable #5 N <14.OUT",
        # IF N > 5 AND NOT Start AND Stop THEN Alarm := TRUE
        "16 inVariable N > 5",
        "17 contact not Start <16",
        "18 contact Stop <17",
        "19 coil set Alarm <18",
        "20 rightPowerRail <19",
    ]


def test_the_schema_of_plcopen_orders_the_elements(small: Path, tmp_path: Path) -> None:
    """Source: PLCopen TC6 XML 2.01, body, ldObjects, fbdObjects, commonObjects."""
    small.write_text(_program("A, B : BOOL; T : TON;", "  (* x *) T(IN := A); B := T.Q OR A;"))
    file = tmp_path / "small.xml"
    written_ladder([small], file)
    check_structure(ET.parse(file).getroot())
    broken = file.read_text().replace("<inOutVariables />", "")
    with pytest.raises(InputError, match="its elements are"):
        check_structure(ET.fromstring(broken))


def _boxes(file: Path, pou: str) -> list[tuple[int, int, int, int]]:
    found = []
    for one in _body(file, pou):
        (place,) = [part for part in one if local(part) == "position"]
        corner = [int(place.get(axis, "")) for axis in "xy"]
        size = [int(one.get(name, "")) for name in ("width", "height")]
        found.append((corner[0], corner[1], corner[0] + size[0], corner[1] + size[1]))
    return found


@pytest.mark.exhaustive(but=["01_power_up", "05_jog_panel", "17_conveyor"])
@pytest.mark.parametrize("name", _NAMES)
def test_the_elements_of_a_drawing_do_not_overlap(name: str, tmp_path: Path) -> None:
    """Source: docs/how-to/export.md, Ladder."""
    written_ladder([examples()[name].folder], tmp_path / "ladder.xml")
    _check_places(tmp_path / "ladder.xml")


def test_parallel_contacts_at_two_pins_do_not_overlap(small: Path, tmp_path: Path) -> None:
    """Source: docs/how-to/export.md, Ladder."""
    small.write_text(_program("A, B, C, D : BOOL; F : SR;", "  F(S1 := A OR B, R := C OR D);"))
    written_ladder([small], tmp_path / "ladder.xml")
    _check_places(tmp_path / "ladder.xml")


def _check_places(file: Path) -> None:
    """Check that no two elements of a POU overlap."""
    root = ET.parse(file).getroot()
    pous = [one for one in root.iter() if local(one) == "pou"]
    drawn = [one.get("name", "") for one in pous if any(local(sub) == "LD" for sub in one.iter())]
    assert drawn
    for pou in drawn:
        for one, other in itertools.combinations(_boxes(file, pou), 2):
            apart = one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1]
            assert apart or other[3] <= one[1], (pou, one, other)


def test_a_line_begins_and_ends_at_the_pins(small: Path, tmp_path: Path) -> None:
    """Tools find the pin of a power rail by the last point of the line.

    Source: PLCopen TC6 XML 2.01, connection: from the input back to the output.
    """
    small.write_text(_program("A, B, C, D : BOOL;", "  D := (A OR B) AND C;"))
    written_ladder([small], tmp_path / "small.xml")
    corners, starts = {}, {}
    for one in _body(tmp_path / "small.xml"):
        place = next(part for part in one if local(part) == "position")
        corners[one.get("localId")] = (int(place.get("x", "")), int(place.get("y", "")))
        starts[one.get("localId")] = [
            tuple(a + int(point[0].get(axis, "")) for a, axis in zip(corner, "xy", strict=True))
            for corner in [corners[one.get("localId")]]
            for point in one
            if local(point) == "connectionPointOut"
        ]
    checked = 0
    for one in _body(tmp_path / "small.xml"):
        for point in one:
            if local(point) != "connectionPointIn":
                continue
            x, y = corners[one.get("localId")]
            end = (x + int(point[0].get("x", "")), y + int(point[0].get("y", "")))
            for line in point:
                if local(line) == "connection":
                    path = [(int(p.get("x", "")), int(p.get("y", ""))) for p in line]
                    assert path[0] == end
                    assert path[-1] in starts[line.get("refLocalId")]
                    checked += 1
    assert checked == 6  # A and B at the rail, C behind both, D behind C, the right rail behind D


# --- behaviour ---


@pytest.mark.exhaustive(but=["03_general_io"])
@pytest.mark.parametrize("name", _NAMES)
def test_an_example_behaves_as_its_source(name: str, tmp_path: Path) -> None:
    """The ladder is read back; all variables have equal values in each scan with random inputs.

    Source: docs/how-to/export.md, Ladder.
    """
    assert Compared([examples()[name].folder], tmp_path).scans(200, seed=1) == []


@pytest.mark.exhaustive(but=_QUICK)
@pytest.mark.parametrize("name", _NAMES)
def test_an_example_as_ladder_gives_its_recorded_trace(name: str, tmp_path: Path) -> None:
    """Source: docs/how-to/export.md, Ladder."""
    example = examples()[name]
    files = read_back([example.folder], tmp_path)
    assert trace_of(example, files, tmp_path) == recorded(example)


_TYPES = "TYPE COLOUR : (RED, GREEN, BLUE); END_TYPE\nTYPE FEW : ARRAY [1..3] OF INT; END_TYPE\n"


@pytest.mark.parametrize(
    ("variables", "statements"),
    [
        ("A, B, C, D, X : BOOL;", "X := NOT (A AND (B OR NOT C)) OR D;"),
        ("A, B, C, X : BOOL;", "X := (A XOR B) AND NOT (B XOR C);"),
        ("A, B, X : BOOL; N : INT;", "X := (N = 1 OR A) AND (N < 3 OR B) AND NOT (N > 2 XOR A);"),
        ("A, X, Y : BOOL;", "X := A; Y := X; X := NOT A;"),
        ("A, X, Y : BOOL;", "X := Y; Y := A;"),
        ("A, X, Y : BOOL;", "X := TRUE; Y := FALSE; IF A THEN X := FALSE; END_IF;"),
        ("A, B, X : BOOL;", "IF A THEN X := B; END_IF;"),
        ("A, B, X, Y : BOOL;", "IF A THEN X := TRUE; ELSE X := FALSE; Y := B; END_IF;"),
        ("A, X : BOOL; N : INT;", "IF A AND N < 100 THEN N := N + 1; X := N = 7; END_IF;"),
        ("A, X : BOOL;", "IF X THEN X := A; ELSE X := NOT A; END_IF;"),
        ("A, B, C, X, Y : BOOL;", "IF A THEN X := B; IF X THEN Y := C; END_IF; END_IF; Y := X;"),
        (
            "A, B, C : BOOL; N, M : INT;",
            "IF A THEN N := 1; ELSIF B AND N = 1 THEN N := 2; ELSIF C THEN M := M + N; N := 0; "
            "ELSE N := 3; END_IF;",
        ),
        ("A, X : BOOL; E : R_TRIG; T : TP;", "E(CLK := A); T(E.Q OR X, T#30ms); X := T.Q;"),
        ("A, B : BOOL; F : SR; C : CTU;", "F(A, B); C(CU := F.Q1, R := B, PV := 3, Q => B);"),
        ("A : BOOL; C : COLOUR; X : BOOL;", "IF A THEN C := GREEN; END_IF; X := C = GREEN;"),
        (
            "A, B, X : BOOL; C : COLOUR; E : R_TRIG;",
            "E(CLK := A); CASE C OF RED: IF E.Q THEN C := BLUE; END_IF; GREEN, BLUE: X := NOT X; "
            "IF B THEN C := RED; END_IF; END_CASE;",
        ),
        ("N, I : INT; F : FEW;", "FOR I := 1 TO 3 DO F[I] := F[I] + N; END_FOR; N := F[2];"),
        ("A : BOOL; N, M : INT;", "IF A THEN M := 12 / (N + 1); END_IF;"),
        ("A : BOOL; F, G : FEW; N : INT;", "F[1] := N; IF A THEN G := F; END_IF;"),
    ],
)
def test_a_program_behaves_as_its_source(
    small: Path, tmp_path: Path, variables: str, statements: str
) -> None:
    """Source: IEC 61131-3, 3.3 and 4.2: text and rungs have the same order of execution."""
    small.write_text(_program(variables, f"  {statements}", _TYPES))
    assert Compared([small], tmp_path).scans(500, seed=2) == []


# --- what stays in Structured Text ---


def test_statements_that_are_not_rungs_become_a_block(small: Path, tmp_path: Path) -> None:
    """The block gets what the statements use; the note has file, line and reason.

    Source: docs/how-to/export.md, Ladder.
    """
    small.write_text(
        _program(
            "A, Lamp : BOOL; C : COLOUR; Edge : R_TRIG;",
            "  Edge(CLK := A);\n"
            "  IF Edge.Q THEN\n    C := GREEN;  (* go *)\n  END_IF;\n"
            "  Lamp := C = GREEN;",
            _TYPES,
        )
    )
    file = tmp_path / "small.xml"
    (note,) = written_ladder([small], file)
    assert note == (
        f"{small}:10: PROGRAM Small: stays in Structured Text, in Small_Text: "
        "C is an enumeration, and MOVE with a condition is not for its type"
    )
    (block,) = [one for one in imported(file, tmp_path / "back") if one.stem == "Small_Text"]
    expected = (
        "(* Statements of Small that are not rungs. *) FUNCTION_BLOCK Small_Text "
        "VAR_IN_OUT C : COLOUR; END_VAR VAR_INPUT Edge_Q : BOOL; END_VAR "
        "IF Edge_Q THEN C := GREEN; (* go *) END_IF; END_FUNCTION_BLOCK"
    )
    assert block.read_text().split() == expected.split()
    assert "6 block #2 Small_Text Text1 C: <4 Edge_Q: <5 C:" in _elements(file)


@pytest.mark.parametrize(
    ("statements", "line", "reason"),
    [
        ("  Lamp := A;\n  IF A THEN\n    RETURN;\n  END_IF;", 10, "RETURN ends the whole POU"),
        (
            "  IF A THEN\n    Edge(CLK := A);\n  END_IF;",
            9,
            "a block that is called under a condition cannot be a rung",
        ),
        ("  IF A THEN\n    C := RED;\n    Edge.CLK := A;\n  END_IF;", 10, "cannot be passed"),
    ],
)
def test_a_whole_program_stays_text_if_a_statement_needs_it(
    small: Path, tmp_path: Path, statements: str, line: int, reason: str
) -> None:
    """The statements begin in line 8 of the file.

    Source: docs/how-to/export.md, Ladder.
    """
    text = _program("A, Lamp : BOOL; C : COLOUR; Edge : R_TRIG;", statements, _TYPES)
    small.write_text(text)
    file = tmp_path / "small.xml"
    (note,) = written_ladder([small], file)
    assert note.startswith(f"{small}:{line}: PROGRAM Small stays in Structured Text: ")
    assert reason in note
    assert statements.strip() in file.read_text()


def test_an_added_name_is_new(small: Path, tmp_path: Path) -> None:
    """Variables and blocks of the program may already have the names that the export adds."""
    variables = "A, B, C, Branch1 : BOOL; Text1 : COLOUR; N : INT;"
    branches = "IF A THEN N := 1; ELSIF B THEN N := 2; ELSE N := 3; END_IF; Branch1 := N = 2;"
    moved = "IF C THEN Text1 := BLUE; END_IF;"
    small.write_text(_program(variables, f"  {branches}\n  {moved}", _TYPES))
    assert Compared([small], tmp_path).scans(100, seed=3) == []
    file = next(one for one in (tmp_path / "back").rglob("Small.st"))
    declared = file.read_text().partition("END_VAR\n  VAR\n")[2].partition("END_VAR")[0].split()
    assert [word for word in declared if word not in (":", "BOOL;", "Small_Text;")] == [
        "Branch2",
        "Branch3",
        "Branch4",
        "Text2",
    ]


def test_ladder_is_only_for_plcopen_and_a_program(small: Path) -> None:
    """Source: docs/how-to/export.md, Ladder."""
    small.write_text(_program("A : BOOL;", "  A := NOT A;"))
    with pytest.raises(InputError, match="--ladder is not possible for scl"):
        export("scl", program=[small], only_needed=True, ladder=True)
    with pytest.raises(InputError, match="--ladder requires a program"):
        export("plcopen", ladder=True)


@pytest.mark.exhaustive
def test_the_library_stays_text(tmp_path: Path) -> None:
    """Only the user's program and blocks are ladder: in example 12 FB_Carry and TwoRobots."""
    written_ladder([examples()["12_two_robots"].folder], tmp_path / "ladder.xml")
    root = ET.parse(tmp_path / "ladder.xml").getroot()
    pous: Sequence[ET.Element] = [one for one in root.iter() if local(one) == "pou"]
    drawn = {one.get("name") for one in pous if any(local(sub) == "LD" for sub in one.iter())}
    assert drawn == {"FB_Carry", "TwoRobots"}


def test_a_retained_variable_keeps_its_value(small: Path, tmp_path: Path) -> None:
    """A coil in the branch of an IF that is not executed leaves its variable unchanged.

    A is TRUE in scan 1 only, so that X is set in scan 1 and N is counted once.
    """
    small.write_text(
        _program("A, X : BOOL; N : INT;", "  IF A THEN\n    X := TRUE; N := N + 1;\n  END_IF;")
    )
    program = BuiltinProgram.build(load(read_back([small], tmp_path)))
    got = []
    for scan, value in enumerate([False, True, False, False]):
        program.write("Main.A", value)
        program.scan(scan * 10_000)
        got.append((program.read("Main.X"), program.read("Main.N")))
    assert got == [(False, 0), (True, 1), (True, 1), (True, 1)]
