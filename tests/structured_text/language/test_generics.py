"""Function blocks with generic constants have values that were calculated by hand."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_BLOCKS = """
FUNCTION_BLOCK FB_Outer
  VAR_GENERIC CONSTANT N, M : UINT; END_VAR
  VAR A : ARRAY [1..N] OF INT; I : FB_Inner<M>; END_VAR
  METHOD Size : INT Size := UINT_TO_INT(N) * 100 + I.Get(); END_METHOD
  A[N] := A[N] + 1;
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Inner
  VAR_GENERIC CONSTANT K : UINT; END_VAR
  METHOD Get : INT Get := UINT_TO_INT(K); END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Unused VAR_GENERIC CONSTANT K : UINT; END_VAR
  VAR A : ARRAY [0..K] OF INT; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Endless VAR_GENERIC CONSTANT K : UINT; END_VAR
  VAR P : POINTER TO FB_Endless<(K + 1)>; END_VAR END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Plain VAR X : INT; END_VAR END_FUNCTION_BLOCK
INTERFACE I_Sized
METHOD Size : INT END_METHOD
END_INTERFACE
FUNCTION_BLOCK FB_Sized
  VAR_GENERIC CONSTANT K : UINT; END_VAR
IMPLEMENTS I_Sized
  VAR A : ARRAY [0..K - 1] OF INT; Step : INT := 1; END_VAR
  METHOD Size : INT Size := UINT_TO_INT(K) * Step; END_METHOD
  METHOD FB_init : BOOL
  VAR_INPUT bInitRetains, bInCopyCode : BOOL; S : INT; END_VAR
  Step := S;
  END_METHOD
  PROPERTY All : REFERENCE TO ARRAY [0..K - 1] OF INT GET All REF= A; END_GET END_PROPERTY
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Same VAR_GENERIC CONSTANT M : UINT; END_VAR
EXTENDS FB_Sized<(M * 2)>
END_FUNCTION_BLOCK
FUNCTION_BLOCK FB_Three EXTENDS FB_Sized<3>
  VAR Mine : ARRAY [1..K] OF INT; END_VAR
  METHOD Own : INT Mine[K] := 8; Own := Mine[3] + Size(); END_METHOD
END_FUNCTION_BLOCK
"""


def _text(variables: str, body: str) -> str:
    constants = "VAR CONSTANT C : UINT := 4; END_VAR"
    variables = f"VAR {variables} X, Y : INT; END_VAR"
    return f"{_BLOCKS}PROGRAM P1 {constants}\n{variables}\n{body}\nEND_PROGRAM\n"


@pytest.mark.parametrize(
    ("variables", "body", "expected"),
    [
        ("B : FB_Outer<6, 2>;", "B(); B(); X := B.Size(); Y := B.A[6];", {"X": 602, "Y": 2}),
        ("B : ARRAY [0..1] OF FB_Outer<C, (C + 1)>;", "B[1](); X := B[1].Size(); Y := B[0].A[4];",
         {"X": 405, "Y": 0}),
        ("B : FB_Inner<3>; D : FB_Inner<5>;", "X := B.Get(); Y := D.Get();", {"X": 3, "Y": 5}),
        ("B, D : FB_Inner<3>; P : POINTER TO FB_Inner<3>;", "P := ADR(D); X := P^.Get();",
         {"X": 3}),
        ("B : FB_Sized<4>(10); I : I_Sized;", "I := B; X := I.Size();", {"X": 40}),
        ("B : FB_Same<3>(2);", "X := B.Size();", {"X": 12}),
        ("B : FB_Three(5);", "X := B.Own();", {"X": 23}),
        ("B : FB_Sized<2>(1); R : REFERENCE TO ARRAY [0..1] OF INT;",
         "R REF= B.All; R[1] := 6; X := B.A[1];", {"X": 6}),
    ],
)  # fmt: skip
def test_each_list_of_values_is_a_block_of_its_own(
    build: Callable[..., BuiltinProgram], variables: str, body: str, expected: dict[str, Any]
) -> None:
    program = build(_text(variables, body))
    program.scan(0)
    assert {name: program.read(f"Main.{name}") for name in expected} == expected


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ("B : FB_Inner<3, 4>;", "FB_Inner takes 1 generic constants, not 2"),
        ("B : FB_Plain<3>;", "FB_Plain has no VAR_GENERIC"),
        ("B : INT<3>;", "INT has no VAR_GENERIC"),
        ("B : FB_Inner<Q>;", "Q is not declared|a constant is expected here"),
        ("B : FB_Endless<1>;", "more than 200 blocks of generic constants"),
    ],
)
def test_wrong_generic_constants_are_refused(
    mistakes_of: Callable[..., list[InputError]], variables: str, message: str
) -> None:
    found = mistakes_of(_text(variables, ""))
    assert any(one in error.message for error in found for one in message.split("|"))
    assert all(error.line for error in found)
