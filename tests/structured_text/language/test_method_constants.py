"""Declarations of methods and blocks may use constants, SIZEOF and bounds of arrays."""

from __future__ import annotations

from collections.abc import Callable

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_BLOCK = """\
TYPE S : STRUCT a : DINT; b : DINT; c : ARRAY [0..2] OF WORD; END_STRUCT END_TYPE
TYPE E : (LOW := 2, HIGH := 4) INT; END_TYPE
VAR_GLOBAL CONSTANT gN : INT := 3; END_VAR
VAR_GLOBAL gBuffer : ARRAY [1..5] OF DWORD; END_VAR
FUNCTION_BLOCK Base
VAR CONSTANT cBase : INT := 2; END_VAR
END_FUNCTION_BLOCK
FUNCTION_BLOCK A EXTENDS Base
VAR CONSTANT cMax : INT := cBase * 2; END_VAR
VAR cmd : S; inner : Base; list : ARRAY [0..3] OF S; END_VAR
METHOD Sizes
VAR_OUTPUT o : ARRAY [1..11] OF UDINT; END_VAR
VAR CONSTANT cOwn : INT := cMax + 1; END_VAR
VAR
  p1 : ARRAY [1..SIZEOF(cmd)] OF BYTE;
  p2 : ARRAY [0..cOwn] OF ARRAY [0..cLate] OF INT;
  p3 : ARRAY [0..SIZEOF(cmd.c) - 1] OF BYTE;
  p4 : ARRAY [E.LOW..E.HIGH] OF INT;
  p5 : ARRAY [0..UPPER_BOUND(p3, 1)] OF WORD;
  p6 : ARRAY [0..inner.cBase] OF BYTE;
  p7 : ARRAY [0..Base.cBase] OF WORD;
  p8 : ARRAY [1..SIZEOF(list[0].c)] OF BYTE;
  p9 : ARRAY [1..SIZEOF(gBuffer)] OF BYTE;
  p10 : ARRAY [1..SIZEOF(DWORD) * 2] OF BYTE;
  p11 : STRING(cMax);
END_VAR
VAR CONSTANT cLate : INT := 9; END_VAR
o[1] := SIZEOF(p1); o[2] := SIZEOF(p2); o[3] := SIZEOF(p3); o[4] := SIZEOF(p4);
o[5] := SIZEOF(p5); o[6] := SIZEOF(p6); o[7] := SIZEOF(p7); o[8] := SIZEOF(p8);
o[9] := SIZEOF(p9); o[10] := SIZEOF(p10); o[11] := SIZEOF(p11);
END_METHOD
METHOD Values : INT
VAR_INPUT k : INT := cMax + 1; END_VAR
VAR CONSTANT cOwn : INT := cMax + 10; END_VAR
VAR i : INT := cOwn; copy : S := cmd; row : ARRAY [1..gN] OF INT := [gN(7)]; END_VAR
Values := k * 1000 + i * 10 + DINT_TO_INT(copy.a) + row[3] * 10000 / 7 * 0;
END_METHOD
METHOD Other : UDINT
VAR cMax : INT; q : ARRAY [0..cBase] OF BYTE; END_VAR
Other := SIZEOF(q);
END_METHOD
END_FUNCTION_BLOCK
"""


def test_constants_of_a_method_and_of_its_block_are_bounds(
    build: Callable[[str], BuiltinProgram],
) -> None:
    """Constants of a method, and of its block, may be array bounds in the method.

    Source: help of CODESYS, SIZEOF and constants.

    The size of S is 16: 4 + 4 + 6 bytes, and 2 bytes so that each DINT is at a multiple of 4.
    """
    program = build(
        f"{_BLOCK}PROGRAM P1\nVAR a : A; o : ARRAY [1..11] OF UDINT; n : UDINT; END_VAR\n"
        "a.Sizes(o => o); n := a.Other();\nEND_PROGRAM\n"
    )
    program.scan(0)
    sizes = [16, 6 * 10 * 2, 6, 3 * 2, 6 * 2, 3, 3 * 2, 6, 20, 8, 5]
    assert program.read("Main.o") == sizes
    assert program.read("Main.n") == 3


def test_constants_of_the_block_are_defaults_and_initial_values(
    build: Callable[[str], BuiltinProgram],
) -> None:
    program = build(
        f"{_BLOCK}PROGRAM P1\nVAR a : A; x, y : INT; c : S := (a := 6); d : S := c; z : DINT;"
        " END_VAR\na.cmd.a := 3; x := a.Values(); y := a.Values(k := 1); z := d.a;\nEND_PROGRAM\n"
    )
    program.scan(0)
    # Expected: k = 5, i = 14, copy.a = 3. The declaration of the array only has to be accepted.
    assert [program.read(f"Main.{name}") for name in ("x", "y", "z")] == [5143, 1143, 6]


def test_the_size_of_a_type_with_an_error_is_no_second_message(
    mistakes_of: Callable[[str], list[InputError]],
) -> None:
    (error,) = mistakes_of(
        "TYPE S : STRUCT a : MISSING; END_STRUCT END_TYPE\n"
        "FUNCTION_BLOCK A\nVAR p : ARRAY [1..SIZEOF(S)] OF BYTE; END_VAR\nEND_FUNCTION_BLOCK\n"
    )
    assert (error.message, error.line) == ("there is no type MISSING", 1)


def test_a_bound_that_is_not_constant_has_its_line(
    mistakes_of: Callable[[str], list[InputError]],
) -> None:
    found = mistakes_of(
        "FUNCTION_BLOCK A\nVAR n : INT; END_VAR\nMETHOD Go\n"
        "VAR CONSTANT c : INT := c; END_VAR\n"
        "VAR p : ARRAY [1..n] OF BYTE;\nq : ARRAY [1..nope] OF BYTE;\n"
        "r : ARRAY [1..SIZEOF(r)] OF BYTE;\ns : ARRAY [1..SIZEOF(THIS^)] OF BYTE; END_VAR\n"
        "END_METHOD\nEND_FUNCTION_BLOCK\n"
    )
    assert [one.line for one in found] == [4, 5, 6, 7, 8]
    assert found[0].message == "the constant C uses itself"
    assert {one.message for one in found[1:]} == {"a constant is expected here"}
