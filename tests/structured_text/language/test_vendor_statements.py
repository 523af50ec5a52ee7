"""Statements and names that only some tools have give values that were calculated by hand."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector
from structured_text.errors import InputError
from structured_text.language.load import analyse, load
from structured_text.language.project import Project

Build = Callable[..., BuiltinProgram]
Mistakes = Callable[..., list[InputError]]

_BEFORE = """
TYPE S1 : STRUCT X : INT; Y : INT; END_STRUCT; END_TYPE
TYPE Flags : STRUCT A, B, C, D, E, F, G, H, I : BIT; W : WORD; Z : BIT; END_STRUCT; END_TYPE
TYPE Both : UNION Bits : Flags; Raw : ARRAY [0..5] OF BYTE; END_UNION END_TYPE
FUNCTION F_Inc : INT VAR_INPUT X : INT; END_VAR F_Inc := X + 1; END_FUNCTION
FUNCTION F_Split : INT VAR_INPUT X : INT; END_VAR VAR_OUTPUT Rest : INT; END_VAR
  Rest := X MOD 10; F_Split := X / 10; END_FUNCTION
FUNCTION F_Own : INT VAR_INPUT EN : BOOL; X : INT; END_VAR VAR_OUTPUT ENO : BOOL; END_VAR
  ENO := NOT EN; F_Own := X * 2; END_FUNCTION
FUNCTION F_First : INT VAR_INPUT X : INT; END_VAR
  F_First := X; RETURN(X > 3); F_First := 0; END_FUNCTION
FUNCTION F_Bound : BOOL VAR_INPUT X : INT; END_VAR VAR N : INT; END_VAR
  F_Bound := (N := X * X) > 10 AND (N := N + 1) > 17; END_FUNCTION
FUNCTION_BLOCK FB1
  VAR_INPUT X : INT; END_VAR VAR_OUTPUT Y : INT; END_VAR VAR N : INT; Flag : BIT; END_VAR
  METHOD Add : INT VAR_INPUT A : INT; END_VAR VAR L : INT; END_VAR
    RETURN(A < 0); Add := (L := A + 1) * L; N := N + L; END_METHOD
  N := N + 1; Y := X + N; Flag := TRUE;
END_FUNCTION_BLOCK
"""
_VARIABLES = """
  I, J, K, N : INT; A : ARRAY [1..4] OF INT := [1, 2, 3, 4]; B, C : BOOL; S, T1 : S1; U : USINT;
  W : WORD; F1 : FB1; U1 : Both; L : ARRAY [0..1] OF FB1; Q : STRING := 'ab'; P : POINTER TO INT;
"""


def _run(build: Build, body: str) -> BuiltinProgram:
    program = build(f"{_BEFORE}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    return program


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        # EN is FALSE: the call is not executed, and only ENO changes.
        ("I := 7; I := F_Inc(EN := FALSE, X := 1, ENO => B);", {"I": 7, "B": False}),
        ("C := TRUE; I := F_Inc(EN := C, X := 1, ENO => B);", {"I": 2, "B": True}),
        ("I := F_Inc(X := 1, ENO => B);", {"I": 2, "B": True}),
        ("J := 5; I := F_Split(EN := TRUE, X := 37, Rest => J);", {"I": 3, "J": 7}),
        ("J := 5; I := F_Split(EN := J < 5, X := 37, Rest => J, ENO => B);", {"I": 0, "J": 5}),
        ("F1(X := 1); F1(EN := FALSE, X := 5, Y => I, ENO => B); J := F1.X;",
         {"I": 0, "B": False, "J": 1, "F1.N": 1}),
        ("F1(EN := TRUE, X := 5, Y => I, ENO => B);", {"I": 6, "B": True, "F1.N": 1}),
        ("L[1](EN := I = 0, X := 5, ENO => L[1].Flag);", {"L[1].Y": 6, "L[1].Flag": True}),
        ("I := F1.Add(EN := B, A := 2); J := F1.Add(EN := NOT B, A := 2);", {"I": 0, "J": 9}),
        ("F1.Add(EN := B, A := 2); F1.Add(A := 3, ENO => B);", {"F1.N": 4, "B": True}),
        ("A[2] := MAX(EN := TRUE, IN1 := 7, IN2 := 9, ENO => W.3);", {"A[2]": 9, "W": 8}),
        # In a function that declares EN and ENO itself, both are ordinary pins.
        ("I := F_Own(EN := FALSE, X := 4, ENO => B);", {"I": 8, "B": True}),
        # Assignments in expressions.
        ("WHILE (I := I + 1) < 5 DO J := J + I; END_WHILE;", {"I": 5, "J": 10}),
        ("REPEAT J := J + 1; UNTIL B := J = 3 END_REPEAT;", {"J": 3, "B": True}),
        ("A[(I := I + 1)] := (J := 5) + J;", {"I": 1, "A": [10, 2, 3, 4]}),
        ("I := 3; J := I + (I := 10) + I;", {"I": 10, "J": 23}),
        ("J := ((I := (K := 2) + 1)) * 4;", {"I": 3, "J": 12, "K": 2}),
        ("IF (I := J := 4) > 3 THEN K := I + J; END_IF;", {"K": 8}),
        ("P := ADR(I); J := F_Inc((P^ := 6)) + F_Inc(X := (A[3] := 8)); K := A[3];",
         {"I": 6, "J": 16, "K": 8}),
        ("T1.Y := 4; I := (S := T1).Y;", None),
        ("Q := 'x'; IF (Q := CONCAT(Q, 'y')) = 'xy' THEN I := 1; END_IF;", {"I": 1}),
        ("B := F_Bound(4); C := F_Bound(5);", {"B": False, "C": True}),
        ("CASE (I := 2) OF 2: J := 1; END_CASE; FOR K := 1 TO (N := 3) DO ; END_FOR;",
         {"J": 1, "K": 4, "N": 3}),
        # RETURN takes a condition.
        ("I := F_First(4); J := F_First(3); K := F1.Add(-1);", {"I": 4, "J": 0, "K": 0}),
        ("FOR I := 1 TO 9 DO RETURN(I = 3); J := I; END_FOR;", {"I": 3, "J": 2}),
        # An unsigned variable counts down: the loop also ends at 0.
        ("FOR U := 3 TO 0 BY -1 DO N := N * 10 + USINT_TO_INT(U); END_FOR;", {"N": 3210}),
        ("FOR U := 5 TO 2 BY -(1 + 1) DO N := N * 10 + USINT_TO_INT(U); END_FOR;", {"N": 53}),
        ("FOR U := 1 TO 2 BY -1 DO N := N + 1; END_FOR;", {"N": 0}),
        ("FOR U := 3 TO 1 BY -1 DO IF U = 2 THEN CONTINUE; END_IF; N := N + 1; END_FOR;", {"N": 2}),
        # Arguments with and without names.
        ("I := FIND(STR1 := 'a.b', '.'); J := FIND('xa', STR2 := 'a');", {"I": 2, "J": 2}),
        ("Q := MID('abcd', 2, POS := 2); I := LIMIT(MN := 1, 9, MX := 4);", {"Q": "bc", "I": 4}),
        # Eight BITs in a row share a byte, the next BIT begins a byte, and W lies at a multiple of
        # 2.
        ("I := SIZEOF(U1.Bits); U1.Raw[0] := 16#82; U1.Raw[1] := 1; B := U1.Bits.B;"
         "C := U1.Bits.A;",
         {"I": 6, "B": True, "C": False, "U1.Bits.H": True, "U1.Bits.I": True}),
        ("U1.Bits.C := TRUE; U1.Bits.A := TRUE; U1.Bits.C := FALSE; U1.Bits.D := TRUE;"
         "U1.Bits.Z := TRUE; U1.Bits.W := 16#0201;",
         {"U1.Raw": [9, 0, 1, 2, 1, 0]}),
    ],
)  # fmt: skip
def test_statements_have_the_values_of_a_hand_calculation(
    build: Build, body: str, expected: dict[str, Any] | None
) -> None:
    """Statements give values that were calculated by hand.

    The rules are from CODESYS help, "ExST Assignment as An Expression" and "Data Type: BIT".
    """
    if expected is None:
        with pytest.raises(InputError):
            _run(build, body)
        return
    program = _run(build, body)
    assert {name: program.read(f"Main.{name}") for name in expected} == expected


@pytest.mark.parametrize(
    "body",
    [
        "B := (I := I + 1) > 0 AND (J := J + 1) > 2; C := B OR (K := K + 1) = 1;",
        "IF B := (I := I + 1) > 1 AND_THEN (J := J + 1) > 0 THEN K := K + 1; END_IF;",
        "WHILE (I := I + 1) < 5 AND NOT (B := I = 3) DO J := J + I; END_WHILE; I := 0;",
        "N := ADD(EN := I > 0 AND J < 2, IN1 := N, IN2 := 1, ENO => B); I := 1; J := J + 1;",
        "N := N + 1; RETURN((I := I + 1) > 1 OR B); K := K + 1;",
        "FOR U := 2 TO 0 BY -1 DO N := N + 1; END_FOR; L[0](EN := N > 3, X := N, ENO => B);",
    ],
)
def test_coverage_does_not_change_the_effects_of_statements(
    project_of: Callable[..., Project], body: str
) -> None:
    project = project_of(f"{_BEFORE}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    seen = []
    for collector in (None, Collector()):
        program = BuiltinProgram.build(project, collector)
        for scan in range(3):
            program.scan(scan)
            seen.append([program.read(f"Main.{name}") for name in ("I", "J", "K", "N", "B", "C")])
    assert seen[:3] == seen[3:]
    assert seen[0] != [0, 0, 0, 0, False, False]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("I := 1 + F_Inc(EN := B, X := 2);", "EN of a call inside an expression"),
        ("IF F_Inc(X := 2, ENO => B) > 1 THEN ; END_IF;", "ENO of a call inside an expression"),
        ("I := ABS(ADD(EN := B, IN1 := 1, IN2 := 2));", "EN of a call inside an expression"),
        ("I := F1.Add(A := F1.Add(EN := B, A := 2));", "EN of a call inside an expression"),
        ("I := F_Inc(EN => B, X := 1);", "EN is an input"),
        ("F1(ENO := B);", "ENO is an output"),
        ("F1(EN := B, EN := C);", "EN is given twice"),
        ("F1(EN := 7);", "7 literal|not the number 7"),
        ("F1(ENO => 3);", "is not expected here"),
        ("F1(ENO => I);", "a INT is expected here|expected here, not a BOOL"),
        ("I := (B := 3);", "a BOOL is expected here"),
        ("IF (I := 3) THEN ; END_IF;", ":= assigns, and does not compare"),
        ("I := (A := 3);", "expected here"),
        ("I := (F_Inc := 3);", "F_Inc"),
        ("B := (W.3 := TRUE);", "a bit is not assigned inside an expression"),
        ("RETURN(I);", "a BOOL is expected here, not a INT"),
        ("FOR U := 3 TO 1 BY -300 DO ; END_FOR;", "a step of -300 leaves USINT"),
        ("I := FIND(STR2 := 'a', 'b');", "STR2 is given twice"),
        ("I := 10#1F;", "10#1F is not a number"),
        ("I := 7#12;", "no meaning here|malformed"),
        ("P := ADR(U1.Bits.A);", "a BIT has no address"),
        ("Q := 'abc;\nI := 3;", "this string is never closed"),
        ("Q := 'abc;\nQ := 'def';\nI := 3;", "this string is never closed"),
        ("{{ x = 5; }} I := 1;", "C code in a pragma is not supported"),
        ("{ __SET_VAR(data__->,I,,5) }", "C code in a pragma is not supported"),
        ("I := 1; { printf(\"hello\"); }", "C code in a pragma is not supported"),
        ("{\n#include <math.h>\n}", "C code in a pragma is not supported"),
    ],
)  # fmt: skip
def test_a_wrong_use_is_refused_with_its_line(
    mistakes_of: Mistakes, body: str, message: str
) -> None:
    found = mistakes_of(f"{_BEFORE}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    first = f"{_BEFORE}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n".count("\n") + 1
    assert found
    assert re.search(message, found[0].message), found[0].message
    assert first <= (found[0].line or 0) <= first + body.count("\n")


@pytest.mark.parametrize(
    "text",
    [
        "{attribute 'qualified_only'} ",
        "{warning 'a; b'} ",
        "{ S7_Optimized_Access := 'TRUE' } ",
        "{ExternalAccessible := 'False'; ExternalVisible := 'False'; } ",
        "{region 'x -> y'} ",
        "{ S7.extern=ReadWrite } ",
    ],
)
def test_a_pragma_of_a_tool_is_not_taken_for_c(build: Build, text: str) -> None:
    program = build(f"PROGRAM P1\nVAR I : INT; END_VAR\n{text}I := 1;\nEND_PROGRAM\n")
    program.scan(0)
    assert program.read("Main.I") == 1


@pytest.mark.parametrize(
    ("place", "line"),
    [
        ("PROGRAM P1\nVAR B : BIT; END_VAR\nEND_PROGRAM", 2),
        ("PROGRAM P1 VAR I : INT; END_VAR\nEND_PROGRAM\nVAR_GLOBAL G : BIT; END_VAR", 3),
        (
            "PROGRAM P1 VAR I : INT; END_VAR\nEND_PROGRAM\nTYPE T9 : ARRAY [1..2] OF BIT; END_TYPE",
            3,
        ),
        ("PROGRAM P1 VAR I : INT; END_VAR\nEND_PROGRAM\nFUNCTION F9 : BIT\nEND_FUNCTION", 3),
    ],
)
def test_a_bit_outside_of_structures_and_blocks_is_refused(
    mistakes_of: Mistakes, place: str, line: int
) -> None:
    """A BIT variable outside of structures and blocks is refused, as in CODESYS (error C0203)."""
    (found,) = mistakes_of(place)
    assert found.line == line
    assert found.message.startswith("BIT is for fields of a structure")


def test_keywords_that_are_needed_in_few_places_may_be_names(build: Build) -> None:
    """Keywords such as RETAIN and TASK may be names of variables, methods and blocks."""
    program = build("""
FUNCTION_BLOCK configuration
  VAR_INPUT Retain, persistent : INT; END_VAR
  VAR Union : INT; Action : ARRAY [0..1] OF INT; END_VAR
  METHOD continue : INT continue := 1; END_METHOD
  METHOD Task : INT Task := THIS^.Action[1] + Union; END_METHOD
  METHOD PUBLIC configuration : INT configuration := 5; END_METHOD
  union := 20; Action[1] := retain + Persistent;
END_FUNCTION_BLOCK
VAR_GLOBAL CONSTANT (* of all *) G : INT := 5; END_VAR
VAR_GLOBAL (* plain *) Retain : INT; END_VAR
TYPE Pair : UNION Constant : INT; End_Union : WORD; END_UNION END_TYPE
PROGRAM Main2
  VAR configuration : configuration; I : INT; continue : INT := 3; P : Pair; Action : INT; END_VAR
  configuration(Retain := 2, Persistent := 3);
  I := configuration.Task() + configuration.configuration() + configuration.continue();
  ACTION := G;
  continue := continue + I; P.Constant := 7;
END_PROGRAM
""")
    program.scan(0)
    assert program.read("Main.I") == 31
    assert program.read("Main.continue") == 34
    assert program.read("Main.Action") == 5
    assert program.read("Main.P.End_Union") == 7


def test_letters_beyond_ascii_work_in_all_kinds_of_names(build: Build) -> None:
    """Names with letters such as ä work for all kinds of declarations.

    In Unicode the same letter can be written in two ways.
    """
    program = build(
        """
TYPE Zustände : (Grün, Gelb); END_TYPE
TYPE Maß : STRUCT Länge : INT; END_STRUCT; END_TYPE
FUNCTION Übertrag : INT VAR_INPUT Größe : INT; END_VAR VAR_IN_OUT Äußeres : INT; END_VAR
  Äußeres := Äußeres + Größe; Übertrag := Äußeres; END_FUNCTION
FUNCTION_BLOCK Zähler VAR_OUTPUT Σ : INT; END_VAR
  METHOD Öffne : INT VAR_INPUT ä : INT; END_VAR VAR Ö2 : INT; END_VAR
   Öffne := (Ö2 := ä + 1) * 2; Σ := Ö2; END_METHOD END_FUNCTION_BLOCK
PROGRAM P1 VAR Zähl : Zähler; M : Maß; I, J : INT; Z : Zustände; äöü : INT := 4; END_VAR
 M.LÄNGE := Übertrag(Größe := 3, Äußeres := ÄÖÜ); I := zähl.Öffne(2); Z := Zustände#Gelb;
 CASE Z OF Grün: J := 1; Gelb: J := 2; END_CASE;
END_PROGRAM
""".replace("zähl.", "za\N{COMBINING DIAERESIS}hl.")
    )
    program.scan(0)
    names = ("M.Länge", "äöü", "I", "J", "Zähl.Σ")
    assert [program.read(f"Main.{name}") for name in names] == [7, 7, 6, 2, 3]


def test_a_source_that_is_not_utf_8_is_read_as_windows_1252(tmp_path: Path) -> None:
    """A source that is not UTF-8 is read as Windows-1252, where ä is 16#E4.

    A note names the first such line.
    """
    file = tmp_path / "old.st"
    text = "PROGRAM P1 VAR S : STRING; END_VAR\n(* für *)\nS := 'ä';\nEND_PROGRAM\n"
    file.write_bytes(text.encode("cp1252"))
    project, errors = analyse([file])
    assert not errors
    assert project is not None
    notes = [one for one in project.uses if one.construct == "a source in Windows-1252"]
    assert [(one.file, one.at.line) for one in notes] == [(file, 2)]
    program = BuiltinProgram.build(load([file]))
    program.scan(0)
    assert program.read("Main.S") == "\xe4"
    file.write_text(text, encoding="utf-8")
    assert "a source in Windows-1252" not in {one.construct for one in load([file]).uses}


@pytest.mark.parametrize(
    "text",
    ["LTIME#213503D23H34M33S709MS551US616NS", "T#106752D", "LTIME#-106752D", "TIME#213503D"],
)
def test_a_duration_beyond_its_type_is_refused(mistakes_of: Mistakes, text: str) -> None:
    """The limits are 2**64 ns, and 2**63 ns = 106,751.99 days."""
    (found,) = mistakes_of(f"PROGRAM P1\nVAR T1 : LTIME := {text}; END_VAR\nEND_PROGRAM")
    assert "is too large" in found.message
