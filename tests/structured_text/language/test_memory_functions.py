"""MEMCPY, MEMMOVE, MEMSET and MEMCMP of Tc2_System work on memory with known bytes."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[..., BuiltinProgram]

_TYPES = """
TYPE Pair : STRUCT A : INT; B : DINT; END_STRUCT END_TYPE
INTERFACE Named
METHOD Number : INT
END_METHOD
END_INTERFACE
FUNCTION_BLOCK Base IMPLEMENTS Named
VAR_INPUT V : INT := 4; END_VAR
METHOD Number : INT
Number := V;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Derived EXTENDS Base VAR W : INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK Other VAR_OUTPUT Z : INT; END_VAR END_FUNCTION_BLOCK
TYPE Holder : STRUCT N : INT := 7; I : Named; END_STRUCT END_TYPE
"""
_VARIABLES = """
VAR P, Q : Pair; A : ARRAY [1..4] OF INT := [1, 2, 3, 4]; N, D : DINT; U : UDINT;
  S : STRING := 'abc';
  PB : POINTER TO BYTE; PH : POINTER TO Holder; PO : POINTER TO Other; PBase : POINTER TO Base;
  H : Holder; Deriv : Derived; W : DWORD := 8; X : BOOL; PA, PC : POINTER TO INT; I : INT;
END_VAR
"""


def _run(build: Build, body: str) -> BuiltinProgram:
    program = build(f"{_TYPES}PROGRAM Main{_VARIABLES}{body}\nEND_PROGRAM\n")
    program.scan(0)
    return program


@pytest.mark.parametrize(
    ("body", "name", "expected"),
    [
        ("P.A := 7; P.B := 5; U := MEMCPY(ADR(Q), ADR(P), SIZEOF(P));", "Q", {"A": 7, "B": 5}),
        ("U := MEMCPY(ADR(Q), ADR(P), SIZEOF(P));", "U", 8),
        ("U := Tc2_System.MEMCPY(destAddr := PB, srcAddr := ADR(P), n := 4);", "U", 0),
        ("U := MEMCPY(ADR(P), ADR(Q), 0);", "U", 0),
        ("MEMMOVE(ADR(A[2]), ADR(A[1]), W - 2);", "A", [1, 1, 2, 3]),
        ("MEMSET(n := 2, fillByte := 255, destAddr := ADR(A[3]));", "A", [1, 2, -1, 4]),
        ("U := MEMSET(ADR(S), 65, 2);", "S", "AAc"),
        ("N := MEMCMP(ADR(P), ADR(Q), SIZEOF(P));", "N", 0),
        ("P.A := 1; N := MEMCMP(ADR(P), ADR(Q), SIZEOF(P));", "N", 1),
        # Bytes are compared, the lowest first: 16#0100 is 00 01, and 16#00FF is FF 00.
        ("P.A := 16#0100; Q.A := 16#00FF; N := MEMCMP(ADR(P), ADR(Q), 2);", "N", -1),
        ("N := MEMCMP(PB, ADR(Q), 2);", "N", 255),
    ],
)  # fmt: skip
def test_memory_is_copied_set_and_compared(
    body: str, name: str, expected: Any, build: Build
) -> None:
    """MEMCPY, MEMMOVE, MEMSET and MEMCMP give the expected values.

    Source: Beckhoff InfoSys, PLC library Tc2_System: MEMCPY, MEMMOVE, MEMSET, MEMCMP.
    """
    assert _run(build, body).read(f"Main.{name}") == expected


@pytest.mark.parametrize(
    ("body", "name", "expected"),
    [
        ("PB := ADR(H); PH := PB; I := PH^.N;", "I", 7),
        ("PB := ADR(Deriv); PBase := PB; I := PBase^.Number();", "I", 4),
        ("PB := ADR(Deriv); PBase := PB; X := PB = PBase AND PB = ADR(Deriv);", "X", True),
        ("X := TRUE; PA := SEL(X, ADR(A[1]), ADR(A[2])); I := PA^;", "I", 2),
        ("PA := MUX(1, ADR(A[1]), ADR(A[3])); I := PA^;", "I", 3),
        ("U := TO_UDINT(PA);", "U", 0),
        ("U := SIZEOF(POINTER TO Pair);", "U", 4),
    ],
)
def test_a_pointer_of_another_type_leads_to_the_same_variable(
    body: str, name: str, expected: Any, build: Build
) -> None:
    """A pointer converted to another pointer type still leads to the same variable.

    Source: CODESYS help, POINTER TO: a pointer is an address; values by hand.
    """
    assert _run(build, body).read(f"Main.{name}") == expected


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("MEMSET(ADR(A), 0, 9);", "leads to bytes 1 to 9 of 8"),
        ("PB := ADR(Deriv); PO := PB; I := PO^.Z;", "bytes cannot be accessed as Other"),
        ("PB := ADR(Deriv); PB^ := 1;", "Derived cannot be accessed as bytes"),
        ("U := TO_UDINT(ADR(A));", "the address of a variable has no number here"),
    ],
)
def test_an_access_that_is_not_modelled_ends_the_run_with_its_line(
    body: str, message: str, build: Build
) -> None:
    """An access to memory that is not simulated ends the run with its line.

    Source: docs/reference/language.md.
    """
    with pytest.raises(InputError, match=message) as found:
        _run(build, body)
    assert found.value.line == f"{_TYPES}PROGRAM Main{_VARIABLES}".count("\n") + 1
