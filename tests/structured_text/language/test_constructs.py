"""Each construct beyond the portable subset has its meaning and is reported.

Each row is a construct, a program with it, and the values after one scan. The values were
calculated by hand from IEC 61131-3:2013, or from the documentation of CODESYS if the standard does
not have the construct.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from matiec_habits import iec2c_takes
from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import find_matiec
from structured_text.errors import InputError
from structured_text.export.refused import tools
from structured_text.export.targets import TARGETS
from structured_text.language.constructs import CONSTRUCTS, TRANSLATED, refuse
from structured_text.language.load import checked, load
from structured_text.language.portability import lint


class Row(NamedTuple):
    """A construct in a program: its variables, statements and expected values after one scan.

    `before` is the text before the program, and `end` is the last line of the program.
    """

    construct: str
    variables: str
    body: str
    values: dict[str, Any]
    before: str = ""
    end: str = "END_PROGRAM"


_FUNCTION = "FUNCTION F1 : INT VAR_INPUT A : INT; B : INT := 4; END_VAR {} F1 := A * 10 + B; {}"

ROWS = [
    Row("a comment with // or /* */", "I : INT;", "I := 1; // I := 2;\nI := /* 3 */ 4;", {"I": 4}),
    Row("a comment inside a comment", "I : INT;", "I := 1; (* a (* b *) I := 2; *)", {"I": 1}),
    Row("a pragma", "I : INT;", "{warning disable C1} I := 1;", {"I": 1}),
    Row("a REGION", "I : INT;", "REGION Moves := 5\nI := 1;\nEND_REGION", {"I": 1}),
    Row("an empty statement", "I : INT;", ";; I := 1;;", {"I": 1}),
    Row("an empty branch", "I : INT;", "IF TRUE THEN ELSE I := 1; END_IF;", {"I": 0}),
    Row("no ; after END", "I : INT;", "IF TRUE THEN I := 1; END_IF I := I + 1;", {"I": 2}),
    Row("no END of a POU", "I : INT;", "IF TRUE THEN I := 1; END_IF;", {"I": 1}, end=""),
    Row("a name with __ or _ at its end", "a__b : INT;", "a__b := 3;", {"a__b": 3}),
    Row("a reserved word as a name", "Step : INT;", "Step := 3;", {"Step": 3}),
    Row("a variable called as something else", "Len : INT;", "Len := 2 + Len('abc');", {"Len": 5}),
    Row("a number such as 1E3", "R : REAL;", "R := 1E3;", {"R": 1000.0}),
    Row("# before a name", "I : INT;", "#I := 7;", {"I": 7}),
    Row("STRING with a length", "S : STRING(3); T : STRING[5];", "T := S := 'abcd';", {"T": "abc"}),
    Row("a subrange", "I : INT (3..9);", "", {"I": 3}),
    Row("an enumeration with values", "E : EN1; I : INT;", "E := B1; I := E;", {"E": "B1", "I": 8},
        "TYPE EN1 : (A1 := 7, B1, C1 := 16#20); END_TYPE"),
    Row("an enumeration with a base type", "E : EN1; F : EN1;", "E := EN1#B1;",
        {"E": "B1", "F": "C1"}, "TYPE EN1 : (A1, B1, C1) USINT := C1; END_TYPE"),
    Row("an enumeration without a name", "E : (UP, DOWN);", "E := DOWN;", {"E": "DOWN"}),
    Row("a member with the name of its enumeration", "E : EN1; I : INT;",
        "E := EN1.B1; CASE E OF EN1.A1: I := 1; EN1.B1: I := 2; END_CASE;", {"I": 2},
        "TYPE EN1 : (A1, B1); END_TYPE"),
    Row("a structure without a name", "S : STRUCT A : INT; END_STRUCT;", "S.A := 5;", {"S.A": 5}),
    Row("a constant instead of a literal", "L : ARRAY [1..N] OF INT;", "L[N] := 5;",
        {"L": [0, 0, 5]}, "VAR_GLOBAL CONSTANT N : INT := 3; END_VAR"),
    Row("a constant expression", "I : INT := (2 + 3) * 4 - 7 / 2;", "", {"I": 17}),
    Row("an array of blocks", "L : ARRAY [1..2] OF CTU; I : INT;",
        "L[2](CU := TRUE, PV := 1); L[1](CU := FALSE, PV := 1); I := L[2].CV * 10 + L[1].CV;",
        {"I": 10}),
    Row("a block in a structure", "S : ST1; B : BOOL;", "S.Edge(CLK := TRUE); B := S.Edge.Q;",
        {"B": True}, "TYPE ST1 : STRUCT Edge : R_TRIG; END_STRUCT; END_TYPE"),
    Row("an initial value of a block", "C : CTU := (PV := 12); I : INT;", "I := C.PV;", {"I": 12}),
    Row("an initial value without brackets", "L : ARRAY [1..4] OF INT := 1, 2(5), 3;", "",
        {"L": [1, 5, 5, 3]}),
    Row("the assignment of a block", "C : CTU; D : CTU := (PV := 12);", "C := D;", {"C.PV": 12}),
    Row("the name of a POU as a text", "S : STRING := __POUNAME();", "", {"S": "P1"}),
    Row("the size of a block", "E : FB1; U : UDINT;", "U := SIZEOF(E);", {"U": 12},
        "FUNCTION_BLOCK FB1 VAR_INPUT A : INT; B : DINT; END_VAR ; END_FUNCTION_BLOCK"),
    Row("a CASE of texts", "S : STRING := 'b'; I : INT;",
        "CASE S OF 'a': I := 1; 'b': I := 2; END_CASE;", {"I": 2}),
    Row("VAR_STAT", "A : FB1; B : FB1; I : INT;", "A(); B(); I := B.N;", {"I": 2},
        "FUNCTION_BLOCK FB1 VAR_STAT K : INT; END_VAR VAR_OUTPUT N : INT; END_VAR"
        " K := K + 1; N := K; END_FUNCTION_BLOCK"),
    Row("VAR_GLOBAL outside a CONFIGURATION", "I : INT;", "I := source.G1 + 1;", {"I": 4},
        "VAR_GLOBAL G1 : INT := 3; END_VAR"),
    Row("a global without VAR_EXTERNAL", "I : INT;", "G1 := G1 + 1; I := G1;", {"I": 4},
        "VAR_GLOBAL G1 : INT := 3; END_VAR"),
    Row("several qualifiers", "END_VAR VAR RETAIN PERSISTENT I : INT;", "I := 1;", {"I": 1}),
    Row("PERSISTENT", "END_VAR VAR PERSISTENT I : INT;", "I := 1;", {"I": 1}),
    Row("an incomplete address", "I AT %IW* : INT;", "I := 1;", {"I": 1}),
    Row("a located array", "A AT %QW4 : ARRAY [1..2] OF INT; I : INT;",
        "A[2] := 5; I := A[1] + A[2];", {"I": 5, "A[1]": 0, "A[2]": 5}),
    Row("a located structure", "A AT %QW4 : S1; I : INT;", "A.B := 5; I := A.A + A.B;",
        {"I": 5, "A.B": 5}, "TYPE S1 : STRUCT A : INT; B : INT; END_STRUCT; END_TYPE"),
    Row("a section in another place", "END_VAR VAR_INPUT I : INT;", "", {"I": 0}),
    Row("a function without VAR_INPUT", "I : INT;", "I := F0();", {"I": 7},
        "FUNCTION F0 : INT F0 := 7; END_FUNCTION"),
    Row("a function without a result", "I : INT;", "F6(X := I);", {"I": 5},
        "FUNCTION F6 VAR_IN_OUT X : INT; END_VAR X := X + 5; END_FUNCTION"),
    Row("a function that never sets its result", "I : INT := 9;", "I := F0(1);", {"I": 0},
        "FUNCTION F0 : INT VAR_INPUT A : INT; END_VAR END_FUNCTION"),
    Row("a function with VAR_OUTPUT or VAR_IN_OUT", "I : INT; L : ARRAY [0..1] OF INT; K : INT;",
        "I := F2(7, Rest => L[1], Sum := K) + K;", {"I": 3 + 7, "L": [0, 1], "K": 7},
        "FUNCTION F2 : INT VAR_INPUT A : INT; END_VAR VAR_OUTPUT Rest : INT; END_VAR"
        " VAR_IN_OUT Sum : INT; END_VAR Rest := A MOD 2; Sum := Sum + A; F2 := A / 2;"
        " END_FUNCTION"),
    Row("a block in a function", "I : INT;", "I := F3(TRUE);", {"I": 1},
        "FUNCTION F3 : INT VAR_INPUT A : BOOL; END_VAR VAR E : R_TRIG; END_VAR"
        " E(CLK := A); IF E.Q THEN F3 := 1; END_IF; END_FUNCTION"),
    Row("inputs of a function left out", "I : INT;", "I := F1(3);", {"I": 34},
        _FUNCTION.format("", "END_FUNCTION")),
    Row("named and positional arguments together", "I : INT;", "I := F1(3, B := 1);", {"I": 31},
        _FUNCTION.format("", "END_FUNCTION")),
    Row("a result that is not used", "I : INT;", "F1(3, 4); I := 1;", {"I": 1},
        _FUNCTION.format("", "END_FUNCTION")),
    Row("a bit by its number", "W : WORD := 16#8001; I : INT; B : BOOL;",
        "W.3 := W.15; W.%X0 := FALSE; B := W.3; I.15 := TRUE;",
        {"W": 0x8008, "B": True, "I": -32768}),
    Row("a part of a word", "D : DWORD := 16#11223344; Y : BYTE;", "Y := D.%B2; D.%W0 := 16#AABB;",
        {"Y": 0x22, "D": 0x1122AABB}),
    Row("CONTINUE", "I : INT; S : INT; N : INT;",
        "FOR I := 1 TO 6 DO IF I MOD 2 = 0 THEN CONTINUE; END_IF; S := S + I; END_FOR;"
        " REPEAT N := N + 1; IF N < 5 THEN CONTINUE; END_IF; UNTIL N >= 3 END_REPEAT;",
        {"S": 9, "I": 7, "N": 3}),
    Row("AND_THEN or OR_ELSE", "N : INT; A : BOOL; B : BOOL;",
        "A := N <> 0 AND_THEN 10 / N > 1; B := N = 0 OR_ELSE 10 / N > 1;", {"A": False, "B": True}),
    Row("S= or R=", "A : BOOL; B : BOOL := TRUE; C : BOOL := TRUE;", "A S= C; B R= C; C R= FALSE;",
        {"A": True, "B": False, "C": True}),
    Row("a UNION", "U : Both; I : INT;", "U.W := 16#0201; I := U.B[1];", {"I": 2},
        "TYPE Both : UNION W : WORD; B : ARRAY [0..1] OF USINT; END_UNION END_TYPE"),
    Row("an ACTION", "F : FB1; I : INT;", "F(); F.Twice(); I := F.N;", {"I": 12},
        "FUNCTION_BLOCK FB1 VAR N : INT := 2; END_VAR N := N + 1; Twice(); END_FUNCTION_BLOCK\n"
        "ACTION Twice: N := N * 2; END_ACTION"),
    Row("a PROGRAM called by its name", "I : INT;", "Other(A := 5); I := Other.B;", {"I": 6},
        "PROGRAM Other VAR_INPUT A : INT; END_VAR VAR B : INT; END_VAR B := A + 1; END_PROGRAM"),
    Row("several PROGRAMs without a CONFIGURATION", "I : INT;", "Other(); I := 1;", {"I": 1},
        "PROGRAM Other VAR B : INT; END_VAR B := 1; END_PROGRAM"),
    Row("an array of open length", "A : ARRAY [3..5] OF INT := [1, 2, 3]; I : INT;", "I := F1(A);",
        {"I": 532, "A": [1, 2, 9]}, "FUNCTION F1 : INT VAR_IN_OUT X : ARRAY [*] OF INT; END_VAR\n"
        "F1 := 100 * DINT_TO_INT(UPPER_BOUND(X, 1)) + 10 * DINT_TO_INT(LOWER_BOUND(X, 1)) + X[4];\n"
        "X[5] := 9; END_FUNCTION"),
    Row("the time as a function", "T1 : TIME;", "T1 := TIME() + T#1s;",
        {"T1": timedelta(seconds=1)}),
    Row("a calculated initial value", "I : INT := ABS(-7);", "I := I + 1;", {"I": 8}),
    Row("a calculated initial value",
        "P : ARRAY [1..2] OF S1 := [(X := 3), (X := 4)]; Q : S1 := (X := P[2].X, Y := ABS(-7));"
        "R : ARRAY [-1..0, 1..2] OF S1 := [P[1], 2((Y := P[1].X)), P[2]]; A, B, C, D, E : INT;",
        "A := Q.X; B := Q.Y; C := R[-1, 1].X; D := R[0, 1].Y; E := R[0, 2].X;",
        {"A": 4, "B": 7, "C": 3, "D": 3, "E": 4},
        "TYPE S1 : STRUCT X : INT; Y : INT := 9; END_STRUCT; END_TYPE"),
    Row("memory looked at as another type", "P : POINTER TO DWORD; R : REAL := 1.0; D : DWORD;",
        "P := ADR(R); D := P^;", {"D": 0x3F800000}),
    Row("pointers compared by < or >", "A : ARRAY [0..3] OF INT; B : BOOL;",
        "B := ADR(A[1]) < ADR(A[3]);", {"B": True}),
    Row("a character of a text by its number", "S : STRING := 'abc'; B : BYTE;",
        "B := S[1]; S[0] := 16#5A;", {"B": 0x62, "S": "Zbc"}),
    Row("several targets of an assignment", "I : INT; J : INT;", "I := J := 5;", {"I": 5, "J": 5}),
    Row("a member of a call's result", "I : INT;", "I := F5(4).B;", {"I": 4},
        "TYPE ST1 : STRUCT A : INT; B : INT; END_STRUCT; END_TYPE"
        " FUNCTION F5 : ST1 VAR_INPUT X : INT; END_VAR F5.B := X; END_FUNCTION"),
    Row("a CASE of bit strings", "W : WORD := 5; I : INT;",
        "CASE W OF 1..4: I := 1; 5: I := 2; ELSE I := 3; END_CASE;", {"I": 2}),
    Row("a written VAR_INPUT", "A : FB1; I : INT;", "A(X := 3); I := A.X;", {"I": 4},
        "FUNCTION_BLOCK FB1 VAR_INPUT X : INT; END_VAR X := X + 1; END_FUNCTION_BLOCK"),
    Row("a variable of a block that is not a pin", "A : FB1; I : INT;", "A(); I := A.K;", {"I": 1},
        "FUNCTION_BLOCK FB1 VAR K : INT; END_VAR K := K + 1; END_FUNCTION_BLOCK"),
    Row("a FOR counter that is not a plain variable", "L : ARRAY [0..1] OF INT; S : INT;",
        "FOR L[1] := 1 TO 3 DO S := S + L[1]; END_FOR;", {"S": 6}),
    Row("a number as an enumeration", "E : (UP, DOWN); I : INT := 1;", "E := I;", {"E": "DOWN"}),
    Row("an enumeration as a number", "E : (UP, DOWN) := DOWN; I : INT;", "I := E + 4;", {"I": 5}),
    Row("the negative of an unsigned integer", "U : USINT := 1;", "U := -U;", {"U": 255}),
    Row("a keyword in another spelling", "A : FB1; I : INT;", "A(X := 3); I := A.X;", {"I": 3},
        "FUNCTIONBLOCK FB1 VAR_INPUT X : INT; END_VAR END_FUNCTIONBLOCK"),
    Row("a ; behind the name of a POU", "A : FB1; I : INT;", "A(X := 3); I := A.X;", {"I": 3},
        "FUNCTION_BLOCK FB1;\nVAR_INPUT X : INT; END_VAR END_FUNCTION_BLOCK"),
    Row("a comma behind the last argument", "A : FB1; I : INT;", "A(X := 3,); I := MAX(A.X, 2,);",
        {"I": 3}, "FUNCTION_BLOCK FB1 VAR_INPUT X : INT; END_VAR END_FUNCTION_BLOCK"),
    Row("an empty initial value", "E : R_TRIG(); I : INT;", "E(CLK := TRUE); I := SEL(E.Q, 1, 2);",
        {"I": 2}),
    Row("conditional compilation", "I : INT;",
        "{IF defined (Slow)} I := 1; {ELSE} I := 2; {END_IF}", {"I": 2}),
    Row("a name as a statement", "A : FB1; I : INT;", "A.Twice; I; I := A.N;", {"I": 4},
        "FUNCTION_BLOCK FB1 VAR N : INT := 2; END_VAR END_FUNCTION_BLOCK\n"
        "ACTION Twice: N := N * 2; END_ACTION"),
    Row("a CLASS", "A : C1; I : INT;", "I := A.Next();", {"I": 3},
        "CLASS C1 VAR N : INT := 2; END_VAR\n"
        "METHOD PUBLIC Next : INT N := N + 1; Next := N; END_METHOD END_CLASS"),
    Row("VAR_CONFIG", "I : INT;", "I := 1;", {"I": 1},
        "VAR_CONFIG P1.I AT %MW3 : INT; END_VAR"),
    Row("a structure as its base", "A : S1; B : S2; I : INT;", "B.X := 4; A := B; I := A.X;",
        {"I": 4}, "TYPE S1 : STRUCT X : INT; END_STRUCT; END_TYPE\n"
        "TYPE S2 EXTENDS S1 : STRUCT Y : INT; END_STRUCT; END_TYPE"),
    Row("an access specifier", "A : T9;", "A := 3;", {"A": 3}, "TYPE INTERNAL T9 : INT; END_TYPE"),
    Row("a number with 10#", "I : INT := -10#1_2;", "I := I + INT#10#5;", {"I": -7}),
    Row("a text over several lines", "S : STRING; I : INT;", "S := 'N0\nN1$'\n'; I := LEN(S);",
        {"S": "N0\nN1'\n", "I": 7}),
    Row("a name with letters beyond ASCII", "Größe : INT; _Ä : INT;",
        "Größe := 3; _ä := GRÖSSE + 1;", {"Größe": 3, "_Ä": 4}),
    Row("RETURN with a condition", "I : INT;", "I := I + 1; RETURN(I > 0); I := 9;", {"I": 1}),
    Row("the type BIT", "S : ST1; I : INT;", "S.C := TRUE; S.A := S.C; I := SIZEOF(S);",
        {"S.A": True, "S.B": False, "I": 2},
        "TYPE ST1 : STRUCT A, B, C : BIT; D : BYTE; END_STRUCT; END_TYPE"),
    Row("EN or ENO", "I : INT := 4; B : BOOL; C : BOOL := TRUE;",
        "I := ADD(EN := I > 3, IN1 := I, IN2 := 1, ENO => B);"
        " I := MUL(EN := I > 5, IN1 := I, IN2 := 9, ENO => C);", {"I": 5, "B": True, "C": False}),
    Row("a negative step of an unsigned counter", "I : UINT; N : INT;",
        "FOR I := 5 TO 1 BY -2 DO N := N * 10 + UINT_TO_INT(I); END_FOR;", {"N": 531}),
    Row("an assignment in an expression", "I : INT; J : INT; B : BOOL;",
        "IF (I := I + 4) = 4 THEN J := (I := I * 2) + I; END_IF; IF B := J = 16 THEN I := 1;"
        " END_IF;", {"I": 1, "J": 16, "B": True}),
    Row("an LTIME of more than 292 years",
        "T1 : LTIME := LTIME#213503D23H34M33S709MS551US615NS; B : BOOL;",
        "B := T1 > LTIME#106751D;", {"B": True}),
]  # fmt: skip
_IDS = [row.construct for row in ROWS]


@pytest.fixture
def written(tmp_path: Path) -> Callable[[Row], Path]:
    """Return a function that writes the program of a row into a file."""

    def write(row: Row) -> Path:
        file = tmp_path / "source.st"
        text = f"{row.before}\nPROGRAM P1\nVAR {row.variables} END_VAR\n{row.body}\n{row.end}\n"
        file.write_text(text, encoding="utf-8")
        return file

    return write


@pytest.mark.parametrize("row", ROWS, ids=_IDS)
def test_the_built_in_engine_runs_it(row: Row, written: Callable[[Row], Path]) -> None:
    program = BuiltinProgram.build(load([written(row)]))
    start = program.snapshot()
    program.scan(0)
    assert {name: program.read(f"Main.{name}") for name in row.values} == row.values
    program.restore(start)
    program.instance().scan(0)
    program.scan(0)
    assert {name: program.read(f"Main.{name}") for name in row.values} == row.values


@pytest.mark.parametrize("row", ROWS, ids=_IDS)
def test_each_construct_is_named_as_not_portable(row: Row, written: Callable[[Row], Path]) -> None:
    file = written(row)
    project = load([file])
    found = {use.construct for use in project.uses}
    assert row.construct in found
    with pytest.raises(InputError, match="matiec does not take"):
        refuse(project.uses, "matiec")
    left = found - TRANSLATED
    if left:
        with pytest.raises(InputError, match="rcx prove does not take"):
            refuse(project.uses, "rcx prove", TRANSLATED)


#: Constructs with pragmas. matiec ignores the pragmas and compiles the statements of all branches.
_ALL_BRANCHES = ("conditional compilation",)


@pytest.mark.skipif(find_matiec() is None, reason="needs matiec (RCX_MATIEC or PATH)")
@pytest.mark.parametrize("row", ROWS, ids=_IDS)
def test_the_table_of_constructs_agrees_with_iec2c(row: Row, tmp_path: Path) -> None:
    takes = iec2c_takes(row.before, row.variables, row.body, tmp_path, row.end)
    assert takes is (row.construct in {*tools()["matiec"].takes, *_ALL_BRANCHES})


@pytest.mark.exhaustive
@pytest.mark.parametrize("target", sorted(TARGETS))
def test_an_export_names_what_it_leaves_out(target: str, written: Callable[[Row], Path]) -> None:
    row = next(row for row in ROWS if row.construct == "a bit by its number")
    exports = pytest.importorskip("rcx_harness.cell.exports")
    with pytest.raises(InputError, match="rcx export does not take a bit by its number"):
        exports.export(target, program=[written(row)])


#: Constructs that only the checker detects, because the lint reads the syntax of one file.
_OF_TYPES = {"the size of a block", "a variable called as something else", "an array of blocks",
             "a block in a structure",
             "an initial value of a block", "the assignment of a block",
             "a global without VAR_EXTERNAL", "an incomplete address", "a located array",
             "a located structure", "a section in another place", "a function without VAR_INPUT",
             "a function that never sets its result", "a function with VAR_OUTPUT or VAR_IN_OUT",
             "a block in a function", "inputs of a function left out",
             "named and positional arguments together", "a result that is not used",
             "a member with the name of its enumeration", "a member of a call's result",
             "a CASE of bit strings", "a written VAR_INPUT",
             "a variable of a block that is not a pin",
             "a FOR counter that is not a plain variable", "a number as an enumeration",
             "an enumeration as a number", "the negative of an unsigned integer",
             "an enumeration without a name", "a structure without a name",
             "a constant instead of a literal", "a constant expression",
             "a PROGRAM called by its name", "several PROGRAMs without a CONFIGURATION",
             "an array of open length", "the time as a function", "a calculated initial value",
             "memory looked at as another type", "pointers compared by < or >",
             "a character of a text by its number", "a structure as its base", "the type BIT",
             "EN or ENO", "a negative step of an unsigned counter",
             "an LTIME of more than 292 years"}  # fmt: skip


@pytest.mark.parametrize("row", ROWS, ids=_IDS)
def test_the_lint_refuses_the_syntax_of_each_construct(
    row: Row, written: Callable[[Row], Path]
) -> None:
    texts = [finding.text for finding in lint([written(row)], binding=True)]
    if row.construct not in _OF_TYPES:
        assert any(text.startswith(row.construct) for text in texts)


@pytest.mark.exhaustive
def test_library_and_examples_use_only_the_portable_subset(repository: Path) -> None:
    library = sorted((repository / "plc" / "lib").rglob("*.st"))
    assert checked(library).uses == ()
    for folder in sorted((repository / "plc" / "examples").iterdir()):
        programs = sorted(folder.rglob("*.st"))
        if programs:
            assert load([*programs, *library]).uses == ()


def test_each_construct_says_what_to_write_instead() -> None:
    assert all(CONSTRUCTS.values())
    assert set(CONSTRUCTS) >= TRANSLATED
