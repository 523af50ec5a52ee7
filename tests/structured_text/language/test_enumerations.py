"""Enumerations are numbers of their base type, as bits, indices, arguments and labels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_TYPES = """\
TYPE Code : (OK := 0, THREE := 3, BAD := 16#8001) WORD; END_TYPE
TYPE Mode : (Off, Slow, Fast); END_TYPE
TYPE Large : (A0, B0, C0) DINT; END_TYPE
{attribute 'qualified_only'}
{attribute 'strict'}
TYPE Strict : (S0, S1); END_TYPE
{attribute 'to_string'}
TYPE Named : (N0, N1); END_TYPE
FUNCTION Twice : WORD
VAR_INPUT w : WORD; END_VAR
VAR_OUTPUT half : WORD; END_VAR
Twice := SHL(w, 1); half := SHR(w, 1);
END_FUNCTION
FUNCTION_BLOCK Box
VAR_INPUT i : DINT; END_VAR
VAR_OUTPUT o : INT; c : Code; END_VAR
o := DINT_TO_INT(i) + 1; c := Code.BAD;
METHOD Pass : WORD
VAR_INPUT w : WORD; END_VAR
VAR_OUTPUT k : WORD; END_VAR
Pass := w OR 16#10; k := w;
END_METHOD
END_FUNCTION_BLOCK
"""
_VARIABLES = """\
W : WORD; D : DWORD; I : INT; J : INT; L : DINT; R : REAL; B : BOOL; S : STRING;
C : Code := Code.BAD; M : Mode := Mode.Slow; X : Large; T : Strict; N : Named; F : Box;
Y : BYTE; A : ARRAY [0..2] OF INT := [5, 6, 7]; P : POINTER TO INT;
"""

_USES: list[tuple[str, str, Any]] = [
    ("W := Code.BAD;", "W", 0x8001),
    ("W := C;", "W", 0x8001),
    ("D := C;", "D", 0x8001),
    ("L := M;", "L", 1),
    ("R := Mode.Fast;", "R", 2.0),
    ("B := C.0 AND C.15 AND NOT C.1;", "B", True),
    ("C := Code.OK; C.1 := TRUE; C.0 := TRUE;", "C", "THREE"),
    ("Y := C.%B1;", "Y", 0x80),
    ("I := A[M];", "I", 6),
    ("I := A[Mode.Fast];", "I", 7),
    ("P := ADR(A[0]); I := P[M];", "I", 6),
    ("C := THREE; W := Twice(C);", "W", 6),
    ("C := THREE; W := Twice(C, half => C);", "C", 1),
    ("F(i := M, o => M);", "M", "Fast"),
    ("F(i := 0, c => W);", "W", 0x8001),
    ("W := F.Pass(w := Code.THREE, k => C);", "C", "THREE"),
    ("W := F.Pass(Code.THREE);", "W", 0x13),
    ("B := C = 16#8001;", "B", True),
    ("W := 16#8001; B := C = W;", "B", True),
    ("X := C0; B := M < X;", "B", True),
    ("X := B0; B := M = X;", "B", True),
    ("B := M <> Large.B0;", "B", False),
    ("W := C AND 16#F000;", "W", 0x8000),
    ("W := NOT C;", "W", 0x7FFE),
    ("C := THREE; W := SHL(C, 2);", "W", 12),
    ("W := SHL(WORD#1, M);", "W", 2),
    ("I := MAX(M, 0);", "I", 1),
    ("I := LIMIT(0, Mode.Fast, 1);", "I", 1),
    ("S := TO_STRING(M);", "S", "1"),
    ("N := N1; S := TO_STRING(N);", "S", "N1"),
    ("X := M;", "X", "B0"),
    ("M := Large.C0;", "M", "Fast"),
    ("W := 3; C := W;", "C", "THREE"),
    ("T := Strict.S1; I := T;", "I", 1),
    ("FOR M := Mode.Off TO Mode.Fast DO I := I + M; END_FOR;", "I", 3),
    ("CASE C OF 16#8001: I := 4; END_CASE;", "I", 4),
    ("CASE M OF 0: I := 1; Mode.Slow..Mode.Fast: I := 2; END_CASE;", "I", 2),
    ("CASE I OF Mode.Off: I := 8; END_CASE;", "I", 8),
]


@pytest.mark.parametrize(("body", "name", "expected"), _USES, ids=[body for body, _, _ in _USES])
def test_an_enumeration_is_a_number_of_its_base_type(
    body: str, name: str, expected: Any, build: Callable[[str], BuiltinProgram]
) -> None:
    """An enumeration can be used as a number of its base type.

    Source: help of CODESYS and TwinCAT, enumerations and bit access; values by hand.
    """
    program = build(f"{_TYPES}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    assert program.read(f"Main.{name}") == expected


def test_an_enumeration_is_an_initial_value_and_a_bound(
    build: Callable[[str], BuiltinProgram],
) -> None:
    program = build(
        f"{_TYPES}PROGRAM P1\nVAR W : WORD := Code.BAD; R : REAL := Mode.Fast; M : Mode := 2;\n"
        "K : Mode := Large.B0; A : ARRAY [Mode.Slow..Mode.Fast] OF INT; END_VAR\n"
        "A[1] := 1; A[2] := 2;\nEND_PROGRAM\n"
    )
    program.scan(0)
    names = ("W", "R", "M", "K", "A")
    assert [program.read(f"Main.{name}") for name in names] == [0x8001, 2.0, "Fast", "Slow", [1, 2]]


_WRONG = [
    ("Y := M;", "a BYTE is expected here, not a Mode"),
    ("S := M;", "a STRING is expected here, not a Mode"),
    ("B := M;", "a BOOL is expected here, not a Mode"),
    ("B := M.16;", "a INT has no BOOL 16"),
    ("I := A[3 + M];", ""),
    ("T := M;", "a Strict is expected here, not a Mode"),
    ("T := Mode.Off;", "a Strict is expected here, not a Mode"),
    ("CASE T OF 7: I := 1; END_CASE;", "a Strict is expected here"),
    ("M := 2.5;", "a Mode is expected here"),
]


@pytest.mark.parametrize(("body", "message"), _WRONG, ids=[body for body, _ in _WRONG])
def test_a_wrong_use_of_an_enumeration_has_its_line(
    body: str, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    """A wrong use of an enumeration is refused with its line.

    Source: help of TwinCAT, attribute 'strict'.
    """
    variables = _VARIABLES.replace("\n", " ")
    found = mistakes_of(f"{_TYPES}PROGRAM P1\nVAR {variables} END_VAR\n{body}\nEND_PROGRAM\n")
    if not message:
        assert found == []
        return
    line = _TYPES.count("\n") + 3
    assert [(one.message.startswith(message), one.line) for one in found] == [(True, line)]
