"""Pointers and references give values that were calculated by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[[str], BuiltinProgram]
Mistakes = Callable[[str], list[InputError]]

_TYPES = """
TYPE ST_Point : STRUCT X : INT; Y : INT; END_STRUCT; END_TYPE
TYPE ST_Node : STRUCT Value : INT; Next : POINTER TO ST_Node; END_STRUCT; END_TYPE
TYPE ST_Mixed : STRUCT A : BYTE; B : DINT; C : BOOL; END_STRUCT; END_TYPE
FUNCTION FC_Sum : INT
  VAR_INPUT First : POINTER TO INT; Count : INT; END_VAR
  VAR I : INT; END_VAR
  FC_Sum := 0;
  FOR I := 0 TO Count - 1 DO FC_Sum := FC_Sum + First[I]; END_FOR;
END_FUNCTION
FUNCTION FC_Bump : INT
  VAR_INPUT Target : REFERENCE TO INT; END_VAR
  Target := Target + 1;
  FC_Bump := Target;
END_FUNCTION
FUNCTION FC_Local : INT
  VAR_INPUT Start : INT; END_VAR
  VAR Own : INT := 5; P : POINTER TO INT := ADR(Own); END_VAR
  P^ := P^ + Start;
  P := ADR(Start);
  FC_Local := Own * 10 + P^;
END_FUNCTION
FUNCTION_BLOCK FB_Buffer
  VAR_INPUT Data : POINTER TO ARRAY [0..3] OF INT; Limit : REFERENCE TO INT; END_VAR
  VAR_OUTPUT Most : INT; END_VAR
  VAR I : INT; END_VAR
  Most := 0;
  FOR I := 0 TO 3 DO
    IF Data^[I] > Limit THEN Data^[I] := Limit; END_IF;
    IF Data^[I] > Most THEN Most := Data^[I]; END_IF;
  END_FOR;
END_FUNCTION_BLOCK
"""

_VARIABLES = """
  A : ARRAY [0..3] OF INT := [10, 20, 30, 40]; G : ARRAY [1..2, 1..2] OF INT := [1, 2, 3, 4];
  N, M : INT := 7; S, T : ST_Point; Points : ARRAY [1..3] OF ST_Point; One, Two : ST_Node;
  P, Q : POINTER TO INT; PA : POINTER TO ARRAY [0..3] OF INT; PS : POINTER TO ST_Point;
  PP : POINTER TO POINTER TO INT; PN : POINTER TO ST_Node; R, R2 : REFERENCE TO INT;
  RS : REFERENCE TO ST_Point; B : ARRAY [1..4] OF BOOL; X, Y : INT; D : UDINT;
  U : REF_TO INT; Buffer : FB_Buffer; Flag : BOOL; PB : POINTER TO BOOL;
"""


def _run(build: Build, body: str) -> BuiltinProgram:
    program = build(f"{_TYPES}\nPROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    return program


@pytest.mark.parametrize(
    ("body", "want", "expected"),
    [
        ("P := ADR(N); P^ := P^ + 1; X := N;", "X", 8),
        ("P := ADR(A[1]); X := P^; Y := P[2];", "X Y", (20, 40)),
        ("P := ADR(A); P[3] := 5; X := A[3] + P^;", "X", 15),
        ("P := ADR(A[3]); X := P[-3];", "X", 10),
        ("P := ADR(G); X := P[2];", "X", 3),
        ("PA := ADR(A); PA^[2] := 33; X := A[2] + PA^[0];", "X", 43),
        ("PS := ADR(S); PS^.X := 4; PS^.Y := PS^.X + 1; X := S.Y;", "X", 5),
        ("PS := ADR(Points[2]); PS^.X := 9; PS[1].X := 8; X := Points[2].X; Y := Points[3].X;",
         "X Y", (9, 8)),
        ("S.X := 3; PS := ADR(T); PS^ := S; S.X := 99; X := T.X;", "X", 3),
        ("P := ADR(S.Y); P^ := 6; X := S.Y;", "X", 6),
        ("P := ADR(N); PP := ADR(P); PP^^ := 11; X := N;", "X", 11),
        ("Two.Value := 5; One.Next := ADR(Two); PN := ADR(One); X := PN^.Next^.Value;", "X", 5),
        ("PN := ADR(One); One.Next := ADR(Two);"
         " WHILE PN <> 0 DO X := X + 1; PN := PN^.Next; END_WHILE;", "X", 2),
        ("B[1] := P = 0; P := ADR(N); B[2] := P <> 0; P := 0; B[3] := P = NULL; B[4] := 0 = P;",
         "B", [True] * 4),
        ("P := ADR(N); Q := ADR(N); B[1] := P = Q; Q := ADR(M); B[2] := P <> Q;", "B",
         [True, True, False, False]),
        ("P := ADR(A[1]); Q := ADR(A) + SIZEOF(INT); B[1] := P = Q; X := Q^;", "B X",
         ([True, False, False, False], 20)),
        ("P := ADR(A); FOR X := 1 TO 4 DO Y := Y + P^; P := P + SIZEOF(P^); END_FOR;", "Y", 100),
        ("P := ADR(A[3]) - 4; X := P^;", "X", 20),
        ("R REF= N; R := R + 1; X := N;", "X", 8),
        ("R REF= A[2]; R2 REF= R; R2 := 31; X := A[2];", "X", 31),
        ("B[1] := __ISVALIDREF(R); R REF= N; B[2] := __ISVALIDREF(R);"
         " R REF= 0; B[3] := __ISVALIDREF(R);", "B", [False, True, False, False]),
        ("P := ADR(A[1]); R REF= P^; R := 21; X := A[1];", "X", 21),
        ("RS REF= Points[1]; RS.X := 2; X := Points[1].X;", "X", 2),
        ("R REF= N; P := ADR(R); P^ := 1; X := N;", "X", 1),
        ("U := REF(N); U^ := 2; X := N; B[1] := U = NULL;", "X B", (2, [False] * 4)),
        ("X := FC_Sum(ADR(A[1]), 3);", "X", 90),
        ("X := FC_Sum(First := ADR(A), Count := 4);", "X", 100),
        ("X := FC_Bump(N); Y := FC_Bump(Target := A[0]);", "X Y N", (8, 11, 8)),
        ("X := FC_Local(3); Y := FC_Local(4);", "X Y", (83, 94)),
        ("M := 25; Buffer(Data := ADR(A), Limit := M); X := Buffer.Most;", "X A",
         (25, [10, 20, 25, 25])),
        ("Flag := TRUE; PB := ADR(Flag); PB^ := NOT PB^; B[1] := Flag;", "B", [False] * 4),
        ("X := SIZEOF(A); Y := SIZEOF(ST_Mixed); D := SIZEOF(LREAL);", "X Y D", (8, 12, 8)),
        ("X := SIZEOF(S) / 2;", "X", 2),
    ],
)  # fmt: skip
def test_a_pointer_leads_to_its_variable(body: str, want: str, expected: Any, build: Build) -> None:
    program = _run(build, body)
    found = tuple(program.read(f"Main.{name}") for name in want.split())
    assert (found[0] if len(found) == 1 else found) == expected


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("X := P^;", "the pointer is 0"),
        ("P^ := 1;", "the pointer is 0"),
        ("X := P[1];", "the pointer is 0"),
        ("PS^.X := 1;", "the pointer is 0"),
        ("X := R;", "the reference refers to nothing"),
        ("R := 1;", "the reference refers to nothing"),
        ("P := P + 2;", "the pointer is 0"),
        ("P := ADR(A); P[4] := 1;", "element 5 of an array of 4"),
        ("P := ADR(A[0]) - SIZEOF(INT); X := P^;", "element 0 of an array of 4"),
        ("P := ADR(N); X := P[1];", "beyond"),
        ("X := 1; P := ADR(A) + X;", "moved by 1 bytes"),
        ("B[1] := P <> 0 AND P^ > 0;", "the pointer is 0"),
    ],
)
def test_a_pointer_to_nowhere_is_reported(statement: str, message: str, build: Build) -> None:
    with pytest.raises(InputError, match=message) as caught:
        _run(build, f"X := 0;\n{statement}\n")
    line = f"{_TYPES}\nPROGRAM P1\nVAR {_VARIABLES} END_VAR\nX := 0;\n".count("\n") + 1
    assert caught.value.line == line


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("P := N;", "a POINTER TO INT is expected here, not a INT"),
        ("P := 5;", "a POINTER TO INT is expected here"),
        ("X := P;", "a INT is expected here, not a POINTER TO INT"),
        ("X := N^;", "^ needs a pointer, not a INT"),
        ("X := R^;", "^ needs a pointer, not a INT"),
        ("B[1] := ADR(Buffer) < ADR(Buffer);", "< is not defined for POINTER TO FB_Buffer"),
        ("P := P * 2;", "* is not defined for POINTER TO INT"),
        ("P := P + 3;", "not a whole number of INT; write a multiple of SIZEOF, 2 here"),
        ("P := ADR(N + 1);", "ADR needs a variable"),
        ("R REF= 5;", "needs a variable to refer to"),
        ("R REF= Flag;", "cannot lead to a BOOL"),
        ("N REF= M;", "REF= needs a variable of REFERENCE TO"),
        ("B[1] := __ISVALIDREF(N);", "__ISVALIDREF needs"),
        ("X := __NEW(INT);", "__NEW needs a pointer"),
        ("MEMCPY(P, Q);", "MEMCPY takes 3 arguments, not 2"),
        ("MEMCPY(N, Q, 2);", "a POINTER TO BYTE is expected here"),
        ("MEMCPY(P, Q, count := 2);", "MEMCPY has no input count"),
    ],
)
def test_a_wrong_pointer_is_refused(statement: str, message: str, mistakes_of: Mistakes) -> None:
    errors = mistakes_of(
        f"{_TYPES}\nPROGRAM P1\nVAR {_VARIABLES} END_VAR\n{statement}\nEND_PROGRAM\n"
    )
    assert errors, "nothing was refused"
    assert message in str(errors[0])


def test_a_snapshot_contains_the_targets_of_pointers(build: Build) -> None:
    """If another instance restores a snapshot, its pointers lead to its own variables."""
    body = "IF P = 0 THEN P := ADR(A[1]); R REF= S.Y; PS := ADR(Points[3]); END_IF; P^ := P^ + 1;"
    body += " R := R + 2; PS^.X := PS^.X + 3;"
    first = _run(build, body)
    second = first.instance()
    second.restore(first.snapshot())
    second.scan(10_000)
    assert second.snapshot() != first.snapshot()
    assert (second.read("Main.A[1]"), second.read("Main.S.Y")) == (22, 4)
    assert second.read("Main.Points[3].X") == 6
    assert (first.read("Main.A[1]"), first.read("Main.S.Y")) == (21, 2)
    first.scan(10_000)
    assert second.snapshot() == first.snapshot()


def test_a_pointer_is_read_as_the_path_it_leads_to(build: Build) -> None:
    body = "P := ADR(A[2]); Q := ADR(S.Y); PA := ADR(A); PN := ADR(Two); R REF= G[2, 1];"
    program = _run(build, body)
    names = ("P", "Q", "PA", "PN", "R", "PP", "U")
    assert [program.read(f"Main.{name}") for name in names] == ["Main.A[2]", "Main.S.Y", "Main.A",
                                                                "Main.Two", "Main.G[2,1]", "",
                                                                ""]  # fmt: skip
    with pytest.raises(InputError, match="cannot be set"):
        program.write("Main.P", "Main.A[1]")


def test_the_result_of_a_call_can_be_dereferenced(build: Build) -> None:
    program = build(
        "FUNCTION FC_Where : POINTER TO INT VAR_INPUT P : POINTER TO INT; END_VAR\n"
        "FC_Where := P + 2; END_FUNCTION\n"
        "PROGRAM P1 VAR A : ARRAY [0..1] OF INT := [3, 4]; N : INT; END_VAR\n"
        "N := FC_Where(ADR(A))^; END_PROGRAM\n"
    )
    program.scan(0)
    assert program.read("Main.N") == 4


@pytest.mark.parametrize(
    ("body", "message"),
    [("F()();", "a call cannot stand here"), ("N := F()^;", "^ needs a pointer, not a INT")],
)
def test_calls_at_wrong_positions_are_refused(
    body: str, message: str, mistakes_of: Mistakes
) -> None:
    errors = mistakes_of(
        "FUNCTION F : INT F := 1; END_FUNCTION\n"
        f"PROGRAM P1 VAR N : INT; END_VAR {body} END_PROGRAM\n"
    )
    assert message in str(errors[0])


def test_super_of_a_missing_base_is_one_message(mistakes_of: Mistakes) -> None:
    errors = mistakes_of(
        "FUNCTION_BLOCK FB1 EXTENDS Nowhere VAR N : INT; END_VAR N := SUPER^.N; END_FUNCTION_BLOCK"
    )
    assert [error.message for error in errors] == [
        "Nowhere is not a function block of these sources"
    ]
