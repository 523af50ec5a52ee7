"""Errors during a run are reported with the line of the statement."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[[str], BuiltinProgram]

_FRAME = """\
FUNCTION_BLOCK Inner
VAR_INPUT
  I : INT; R : REAL;
END_VAR
VAR
  A : ARRAY [1..3] OF INT; G : ARRAY [0..1, 0..1] OF INT; K : INT; L : LREAL; S1 : STRING;
  W : WORD; U : UINT; D : DINT; T1 : TIME; B : BYTE; Y : ARRAY [1..255] OF INT;
END_VAR
  K := 1;
  {statement}
  K := 2;
END_FUNCTION_BLOCK
PROGRAM Outer
VAR B1 : Inner; END_VAR
  B1();
END_PROGRAM
"""


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("A[I] := 1;", "index 0 is outside 1..3"),
        ("A[I + 4] := 1;", "index 4 is outside 1..3"),
        ("K := A[I - 1];", "index -1 is outside 1..3"),
        ("Y[BYTE_TO_USINT(B)] := 1;", "index 0 is outside 1..255"),
        ("G[1, I - 1] := 1;", "index -1 is outside 0..1"),
        ("K := K / I;", "division by zero"),
        ("U := U / INT_TO_UINT(I);", "division by zero"),
        ("L := L / REAL_TO_LREAL(R);", "division by zero"),
        ("T1 := T1 / I;", "division by zero"),
        ("WHILE I = 0 DO K := K + 1; END_WHILE;", "this loop has not ended after 1000000 rounds"),
        ("L := SQRT(LREAL#-1.0 + REAL_TO_LREAL(R));", "a function is not defined for its argument"),
        ("L := EXP(LREAL#1000.0);", "a result is too large"),
        ("W := SHL(W, I - 1);", "the shift count -1 is negative"),
        ("S1 := MID('abc', 1, I);", "a STRING function has position 0, but positions begin at 1"),
        ("S1 := LEFT('abc', I - 2);", "a STRING function has the negative length or position -2"),
        ("K := MUX(I + 2, 5, 6);", "MUX selects input 2, but has inputs 0 to 1"),
    ],
)
def test_a_fault_has_the_line_of_its_statement(build: Build, statement: str, message: str) -> None:
    program = build(_FRAME.replace("{statement}", statement))
    with pytest.raises(InputError) as caught:
        program.scan(0)
    assert message in str(caught.value)
    assert caught.value.line == 10
    assert str(caught.value.file).endswith("source0.st")


def test_a_fault_comes_in_the_scan_in_which_it_happens(build: Build) -> None:
    program = build(_FRAME.replace("{statement}", "A[I] := 1;"))
    program.write("Main.B1.I", 1)
    program.scan(0)
    program.write("Main.B1.I", 4)
    with pytest.raises(InputError, match="index 4 is outside"):
        program.scan(10_000)
