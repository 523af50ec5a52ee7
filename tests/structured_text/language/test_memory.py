"""Unions, pointers to another type and single characters access memory as little-endian bytes.

Every value was calculated by hand. The bits of reals are those of IEEE 754.
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_TYPES = """
TYPE ST_Pair : STRUCT Low : INT; High : INT; END_STRUCT END_TYPE
TYPE ST_Gap : STRUCT A : BYTE; B : DWORD; C : BOOL; END_STRUCT END_TYPE
TYPE U_Value : UNION
  Whole : DWORD; Bytes : ARRAY [0..3] OF BYTE; Number : REAL; Pair : ST_Pair; Word : STRING[3];
END_UNION END_TYPE
TYPE ST_Holder : STRUCT Kind : INT; Value : U_Value; END_STRUCT END_TYPE
FUNCTION FC_Upper : STRING[20]
  VAR_INPUT Text : STRING[20]; END_VAR
  VAR P : POINTER TO BYTE; END_VAR
  FC_Upper := Text;
  P := ADR(FC_Upper);
  WHILE P^ <> 0 DO
    IF P^ >= 97 AND P^ <= 122 THEN P^ := P^ - 32; END_IF
    P := P + 1;
  END_WHILE
END_FUNCTION
FUNCTION FC_Digits : STRING[8]
  VAR_INPUT Number : INT; END_VAR
  VAR P : POINTER TO BYTE; END_VAR
  P := ADR(FC_Digits) + 3;
  P^ := 0;
  REPEAT
    P := P - 1;
    P^ := INT_TO_BYTE(48 + Number MOD 10);
    Number := Number / 10;
  UNTIL P = ADR(FC_Digits) END_REPEAT
END_FUNCTION
"""
_VARIABLES = """
  U, V : U_Value; Given : U_Value := (Whole := 16#04030201); H, H2 : ST_Holder; Gap : ST_Gap;
  Us : ARRAY [1..2] OF U_Value; R : REAL := 1.5; L : LREAL := -2.0; I, N : INT; D : DWORD;
  W : WORD; B : BYTE; Q : ULINT; T1 : TIME := T#1s; S, S2 : STRING; Short : STRING[4];
  A : ARRAY [0..3] OF INT := [16#0102, 16#0304, -1, 7]; F : BOOL; Wide : WSTRING[5];
  PB, PE : POINTER TO BYTE; PW : POINTER TO WORD; PD : POINTER TO DWORD; PR : POINTER TO REAL;
  PQ : POINTER TO ULINT; PI : POINTER TO INT; PP : POINTER TO ST_Pair; PF : POINTER TO BOOL;
  PA : POINTER TO ARRAY [1..8] OF BYTE; PS : POINTER TO STRING[4]; PT : POINTER TO UDINT;
"""
Build = Callable[[str], BuiltinProgram]
Mistakes = Callable[[str], list[InputError]]


def _run(build: Build, body: str, scans: int = 1) -> BuiltinProgram:
    program = build(f"{_TYPES}\nPROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    for scan in range(scans):
        program.scan(scan * 10_000)
    return program


@pytest.mark.parametrize(
    ("body", "path", "value"),
    [
        ("U.Whole := 16#3FC00000;", "U.Number", 1.5),
        ("U.Whole := 16#04030201;", "U.Bytes", [1, 2, 3, 4]),
        ("U.Number := -2.0;", "U.Whole", 0xC0000000),
        ("U.Pair.High := 16#0102;", "U.Bytes", [0, 0, 2, 1]),
        ("U.Bytes[2] := 7; U.Bytes[0] := 1;", "U.Pair", {"Low": 1, "High": 7}),
        ("U.Word := 'ab';", "U.Whole", 0x6261),
        ("U.Whole := 16#636261;", "U.Word", "abc"),
        ("U.Whole := 16#FF; V := U; U.Whole := 1;", "V.Whole", 0xFF),
        ("U.Pair.Low := 5; H.Value := U; H2 := H;", "H2.Value.Bytes", [5, 0, 0, 0]),
        ("Us[2].Whole := 258; U := Us[2];", "U.Bytes", [2, 1, 0, 0]),
        ("", "Given.Bytes", [1, 2, 3, 4]),
        ("", "Given.Pair", {"Low": 0x0201, "High": 0x0403}),
        ("I := SIZEOF(U); N := SIZEOF(H);", "N", 8),
        ("U.Pair.Low := -1; U.Pair := H.Value.Pair;", "U.Whole", 0),
    ],
)
def test_fields_of_a_union_share_memory(body: str, path: str, value: Any, build: Build) -> None:
    assert _run(build, body).read(f"Main.{path}") == value


@pytest.mark.parametrize(
    ("body", "path", "value"),
    [
        ("PD := ADR(R); D := PD^;", "D", 0x3FC00000),
        ("PD := ADR(R); PD^ := 16#40000000;", "R", 2.0),
        ("PQ := ADR(L); Q := PQ^;", "Q", 0xC000000000000000),
        ("PB := ADR(A); B := PB^;", "B", 2),
        ("PB := ADR(A) + 3; PB^ := 16#FF;", "A", [0x0102, -252, -1, 7]),
        ("PB := ADR(A[1]); B := PB[1];", "B", 3),
        ("PD := ADR(A[1]); D := PD^;", "D", 0xFFFF0304),
        ("PA := ADR(A); PA^[8] := 1;", "A", [0x0102, 0x0304, -1, 263]),
        ("PA := ADR(A); PI := ADR(PA^[3]); I := PI^;", "I", 0x0304),
        ("PP := ADR(A); PP^.High := 9;", "A", [0x0102, 9, -1, 7]),
        ("PP := ADR(A[2]); I := PP^.Low; N := PP^.High;", "N", 7),
        ("PB := ADR(Gap) + 4; PB^ := 5; B := 1;", "Gap", {"A": 0, "B": 5, "C": False}),
        ("PB := ADR(Gap) + 8; PB^ := 2;", "Gap.C", True),
        ("Gap.B := 16#04030201; PB := ADR(Gap) + 5; B := PB^;", "B", 2),
        ("Gap.A := 7; Gap.B := 16#04030201; PQ := ADR(Gap); Q := PQ^;", "Q", 0x0403_0201_0000_0007),
        ("PT := ADR(T1); PT^ := PT^ + 500;", "T1", timedelta(milliseconds=1500)),
        ("PW := ADR(A); PD := PW + 2; D := PD^;", "D", 0xFFFF0304),
        ("PB := ADR(S); PB^ := 65; PB := PB + 1; PB^ := 66;", "S", "AB"),
        ("S := 'hello'; PB := ADR(S); PB[2] := 0; I := LEN(S);", "I", 2),
        ("S := 'hello'; PB := ADR(S); PB[2] := 0; PB[2] := 76;", "S", "heLlo"),
        ("S := 'hello'; PB := ADR(S); PB[2] := 0; S2 := CONCAT(S, '!');", "S2", "he!"),
        ("S := 'hello'; PB := ADR(S); PB[2] := 0; F := S = 'he';", "F", True),
        ("Short := 'abcd'; PB := ADR(Short); PB[4] := 88;", "Short", "abcd"),
        ("S := 'abcdefgh'; PS := ADR(S); S2 := PS^;", "S2", "abcd"),
        ("S := FC_Upper('Mix 7z');", "S", "MIX 7Z"),
        ("S := FC_Digits(407);", "S", "407"),
        ("S := 'abc'; S[1] := 16#58; B := S[2];", "S", "aXc"),
        ("S := 'abc'; B := S[3];", "B", 0),
        ('Wide := "ab"; W := Wide[1]; Wide[0] := 16#20AC;', "Wide", "\u20acb"),
        ("PB := ADR(U.Bytes[1]); PB^ := 1;", "U.Whole", 256),
        ("PF := ADR(B); PF^ := TRUE;", "B", 1),
        ("F := ADR(A[1]) > ADR(A);", "F", True),
        (
            "PB := ADR(A); PE := PB + 8; WHILE PB < PE DO I := I + 1; PB := PB + 1; END_WHILE",
            "I",
            8,
        ),
        ("PB := ADR(A); PI := ADR(A); F := PB = PI;", "F", True),
        ("PB := ADR(A); PI := ADR(N); F := PB = PI;", "F", False),
        ("PB := 0; F := PB < ADR(A);", "F", True),
    ],
)
def test_a_pointer_sees_single_bytes(body: str, path: str, value: Any, build: Build) -> None:
    assert _run(build, body).read(f"Main.{path}") == value


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("PB := ADR(R) + 4; B := PB^;", r"byte 5 of 4: outside the variable"),
        ("PD := ADR(R) + 2 * 4; D := PD^;", r"bytes 9 to 12 of 4: outside"),
        ("PB := ADR(A) - 1; PB^ := 1;", r"byte 0 of 8: outside"),
        ("F := ADR(A) < ADR(N);", "pointers to different variables"),
        ("B := PB^;", "the pointer is 0"),
    ],
)
def test_a_pointer_outside_of_its_variable_ends_the_run(
    statement: str, message: str, build: Build
) -> None:
    with pytest.raises(InputError, match=message) as caught:
        _run(build, f"I := 0;\n{statement}")
    assert caught.value.line == f"{_TYPES}\n\nVAR {_VARIABLES}\n\n".count("\n") + 1


@pytest.mark.parametrize(
    ("source", "message"),
    [
        ("TYPE U1 : UNION A : INT; P : POINTER TO INT; END_UNION END_TYPE", "cannot be a POINTER"),
        ("TYPE U1 : UNION A : INT; T : TON; END_UNION END_TYPE", "cannot be a TON"),
        ("TYPE U1 : UNION A : INT := 1; B : INT := 2; END_UNION END_TYPE", "more than one field"),
        ("TYPE U1 : UNION A : INT; B : INT; END_UNION END_TYPE\n"
         "PROGRAM P VAR U : U1 := (A := 1, B := 2); END_VAR ; END_PROGRAM",
         "takes one initial value"),
        ("TYPE U1 : UNION A : INT; U : U1; END_UNION END_TYPE", "cannot contain itself: U1"),
        ("PROGRAM P VAR F : TON; P1 : POINTER TO TOF; END_VAR P1 := ADR(F); END_PROGRAM",
         "a POINTER TO TOF cannot lead to a TON"),
        ("PROGRAM P VAR R : REAL; B : REFERENCE TO DWORD; END_VAR B REF= R; END_PROGRAM",
         "cannot lead to a REAL"),
        ("FUNCTION F1 : STRING F1 := 'a'; END_FUNCTION\n"
         "PROGRAM P VAR B : BYTE; END_VAR B := F1()[0]; END_PROGRAM",
         "only characters of a variable can be accessed by their number"),
    ],
)  # fmt: skip
def test_a_member_without_bytes_is_refused(
    source: str, message: str, mistakes_of: Mistakes
) -> None:
    errors = mistakes_of(source)
    assert errors, "nothing was refused"
    assert any(message in str(error) for error in errors)


def test_a_snapshot_holds_unions_and_where_such_pointers_lead(build: Build) -> None:
    body = (
        "IF PB = 0 THEN PB := ADR(R); PE := ADR(U.Bytes[2]); PA := ADR(A);"
        " PI := ADR(PA^[3]); END_IF; PB^ := PB^ + 1; PE^ := PE^ + 1; PI^ := PI^ + 1;"
    )
    first = _run(build, body)
    second = first.instance()
    second.restore(first.snapshot())
    second.scan(10_000)
    assert (second.read("Main.U.Bytes[2]"), first.read("Main.U.Bytes[2]")) == (2, 1)
    assert (second.read("Main.A[1]"), first.read("Main.A[1]")) == (0x0306, 0x0305)
    assert second.read("Main.PB") == "Main.R"
    assert second.read("Main.PE") == "Main.U+2"
    second.restore(first.snapshot())
    assert second.snapshot() == first.snapshot()


def test_a_union_is_written_from_outside(build: Build) -> None:
    program = _run(build, "D := U.Whole;")
    program.write("Main.U.Number", 1.5)
    program.write("Main.V", {"Bytes": [1, 0, 0, 0]})
    program.scan(10_000)
    assert (program.read("Main.D"), program.read("Main.V.Whole")) == (0x3FC00000, 1)
