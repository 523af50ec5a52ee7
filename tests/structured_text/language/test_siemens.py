"""Tests of constructs of SIMATIC AX and TIA Portal, such as the characters of a text."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.dialects import using
from structured_text.language.load import load

Files = Callable[..., list[Path]]


@pytest.fixture
def scanned(files_of: Files) -> Callable[..., BuiltinProgram]:
    """Return a function that compiles sources in a dialect and runs one scan."""

    def run(*sources: str, dialect: str = "ax") -> BuiltinProgram:
        with using(dialect):
            program = BuiltinProgram.build(load(files_of(*sources)))
        program.scan(0)
        return program

    return run


@pytest.mark.parametrize("dialect", ["ax", "tia"])
def test_characters_of_texts_count_from_one(
    dialect: str, scanned: Callable[..., BuiltinProgram]
) -> None:
    """In the dialects of Siemens, S[1] is the first character of a text.

    Source: manual of STEP 7, "STRING": the first character has the index 1 and is a CHAR.
    """
    program = scanned(
        "PROGRAM Main VAR S : STRING := 'abc'; C : CHAR; T : STRING; U : STRING := 'abc'; END_VAR\n"
        "C := S[2]; T := S[3]; U[1] := 'x'; U[2] := C; IF S[1] = 'a' THEN U[3] := S[1]; END_IF;\n"
        "END_PROGRAM",
        dialect=dialect,
    )
    assert [program.read(f"Main.{name}") for name in "CTU"] == ["b", "c", "xba"]


def test_in_codesys_characters_of_texts_are_bytes_counted_from_zero(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    program = scanned(
        "PROGRAM Main VAR S : STRING := 'abc'; B : BYTE; END_VAR B := S[0]; END_PROGRAM",
        dialect="codesys",
    )
    assert program.read("Main.B") == 97


def test_members_of_an_enumeration_with_a_base_type_are_numbers_in_declarations(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    program = scanned(
        "TYPE Lim : INT (MOST := INT#3, LOW := 1); V : USINT (A1 := USINT#1); END_TYPE\n"
        "PROGRAM Main VAR L : ARRAY [0..Lim#MOST] OF INT; S : INT := Lim#LOW;"
        " D : DINT := Lim#MOST; E : V := USINT#16#FF; U : USINT; W : INT; END_VAR\n"
        "L[3] := 5; U := V# A1; W := Lim# MOST; END_PROGRAM"
    )
    assert program.read("Main.L") == [0, 0, 0, 5]
    assert [program.read(f"Main.{name}") for name in "SDUW"] == [1, 3, 1, 3]


def test_only_in_ax_may_a_for_loop_start_with_a_value_of_a_wider_type(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    source = (
        "PROGRAM Main VAR I : INT; D : DINT := 2; N : INT; END_VAR "
        "FOR I := D TO 4 DO N := N + I; END_FOR; END_PROGRAM"
    )
    assert scanned(source).read("Main.N") == 9
    with pytest.raises(InputError, match="a INT is expected here, not a DINT"):
        scanned(source, dialect="codesys")


def test_pins_of_a_block_start_with_variables(scanned: Callable[..., BuiltinProgram]) -> None:
    """A block's initial values may contain variables of the outer block.

    E := E gives the pin E of the inner block the value of the outer block's E.
    """
    program = scanned(
        "TYPE E1 : (A1, B1); END_TYPE\n"
        "FUNCTION_BLOCK F VAR_INPUT E : E1; N : INT; END_VAR VAR_OUTPUT O : INT; END_VAR"
        " O := N * 10; IF E = B1 THEN O := O + 1; END_IF; END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK G VAR_INPUT E : E1 := B1; K : INT := 4; END_VAR"
        " VAR Inner : F := (E := E, N := K); END_VAR VAR_OUTPUT O : INT; END_VAR"
        " Inner(); O := Inner.O; END_FUNCTION_BLOCK\n"
        "PROGRAM Main VAR B : G; N : INT; END_VAR B(); N := B.O; END_PROGRAM",
        dialect="twincat",
    )
    assert program.read("Main.N") == 41


_OVERLOADS = """FUNCTION ToS : STRING VAR_INPUT V : INT; END_VAR
ToS := CONCAT('I', INT_TO_STRING(V));
END_FUNCTION
FUNCTION ToS : STRING VAR_INPUT V : REAL; END_VAR ToS := 'R'; END_FUNCTION
FUNCTION ToS : STRING VAR_INPUT V : ARRAY [*] OF INT; END_VAR ToS := ToS(V := V[1]); END_FUNCTION
FUNCTION Check VAR_INPUT V : BOOL; END_VAR VAR_IN_OUT N : INT; END_VAR N := N + 1; END_FUNCTION
FUNCTION Check VAR_INPUT V : INT; END_VAR VAR_IN_OUT N : INT; END_VAR N := N + 10; END_FUNCTION
FUNCTION Get : BOOL VAR_INPUT S : STRING; END_VAR VAR_OUTPUT V : SINT; END_VAR V := 1;
END_FUNCTION
FUNCTION Get : BOOL VAR_INPUT S : STRING; END_VAR VAR_OUTPUT V : DINT; END_VAR V := 2;
END_FUNCTION
PROGRAM Main
VAR A : STRING; B : STRING; C : STRING; D : STRING; I : SINT := 3;
  L : ARRAY [1..2] OF INT := [7, 8]; N : INT; X : SINT; Y : DINT; END_VAR
A := ToS(V := I); B := ToS(1.5); C := ToS(L); D := ToS(5);
Check(V := TRUE, N := N); Check(V := 4, N := N);
Get('', V => X); Get('', V => Y);
END_PROGRAM
"""


def test_the_arguments_choose_among_functions_of_one_name(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    """The types of the arguments choose among functions of the same name.

    A SINT widens to an INT.
    """
    program = scanned(_OVERLOADS)
    assert [program.read(f"Main.{name}") for name in "ABCD"] == ["I3", "R", "I7", "I5"]
    assert [program.read(f"Main.{name}") for name in "NXY"] == [11, 1, 2]


def test_in_other_dialects_a_second_function_of_the_same_name_is_refused(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    with pytest.raises(InputError, match="ToS is declared twice"):
        scanned(_OVERLOADS, dialect="codesys")


def test_a_function_with_the_same_pins_is_declared_twice(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    function = "FUNCTION F : INT VAR_INPUT A : INT; END_VAR F := A; END_FUNCTION\n"
    with pytest.raises(InputError, match="F is declared twice"):
        scanned(function, function, "PROGRAM Main VAR N : INT; END_VAR N := F(1); END_PROGRAM")


def test_namespaces_may_declare_the_same_names(scanned: Callable[..., BuiltinProgram]) -> None:
    """A name means the declaration in its own namespace, or else in a namespace that is used."""
    program = scanned(
        "NAMESPACE A.X TYPE K : INT (V := 1); END_TYPE FUNCTION F : INT VAR_INPUT I : INT; END_VAR"
        " F := I + K#V; END_FUNCTION END_NAMESPACE",
        "NAMESPACE A.Y TYPE K : INT (V := 20); END_TYPE FUNCTION F : INT VAR_INPUT I : INT; END_VAR"
        " F := I + K#V; END_FUNCTION END_NAMESPACE",
        "USING A.Y;\nNAMESPACE Other FUNCTION G : INT VAR_INPUT I : INT; END_VAR G := F(I);"
        " END_FUNCTION END_NAMESPACE",
        "USING A.X; USING Other;\n"
        "PROGRAM Main VAR N : INT; M : INT; END_VAR N := F(100); M := G(100); END_PROGRAM",
    )
    assert (program.read("Main.N"), program.read("Main.M")) == (101, 120)


def test_an_assignment_attempt_gives_null_if_the_interface_is_missing(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    """An assignment attempt `?=` gives NULL if the block lacks the interface.

    Source: IEC 61131-3:2013, 6.6.6.7: the result is NULL if the attempt fails.
    """
    program = scanned(
        "INTERFACE I1 METHOD A : INT END_METHOD END_INTERFACE\n"
        "INTERFACE I2 METHOD B : INT END_METHOD END_INTERFACE\n"
        "CLASS C1 IMPLEMENTS I1, I2 METHOD PUBLIC A : INT A := 1; END_METHOD"
        " METHOD PUBLIC B : INT B := 2; END_METHOD END_CLASS\n"
        "CLASS C2 IMPLEMENTS I1 METHOD PUBLIC A : INT A := 3; END_METHOD END_CLASS\n"
        "PROGRAM Main VAR C : C1; D : C2; X : I1; Y : I2; N : INT; M : INT; END_VAR\n"
        "X := C; Y ?= X; IF Y <> NULL THEN N := Y.B(); END_IF;\n"
        "X := D; Y ?= X; IF Y = NULL THEN M := 5; END_IF; END_PROGRAM"
    )
    assert (program.read("Main.N"), program.read("Main.M")) == (2, 5)


def test_tia_passes_an_array_with_other_bounds(scanned: Callable[..., BuiltinProgram]) -> None:
    """In TIA, arrays of other bounds may be passed if number and type of the elements agree."""
    source = (
        "FUNCTION F : INT VAR_INPUT A : INT; END_VAR VAR_IN_OUT O : ARRAY [1..3] OF INT; END_VAR"
        " VAR_OUTPUT P : ARRAY [1..3] OF INT; END_VAR O[1] := A; O[3] := O[3] + 7; P[2] := A;"
        " F := 1; END_FUNCTION\n"
        "PROGRAM Main VAR L : ARRAY [0..2] OF INT := [1, 2, 3]; M : ARRAY [0..2] OF INT; N : INT;"
        " END_VAR N := F(A := 5, O := L, P => M); END_PROGRAM"
    )
    program = scanned(source, dialect="tia")
    assert (program.read("Main.L"), program.read("Main.M")) == ([5, 2, 10], [0, 5, 0])
    with pytest.raises(InputError, match=r"needs a ARRAY \[1..3\] OF INT"):
        scanned(source, dialect="codesys")


def test_blocks_of_methods_get_arguments(scanned: Callable[..., BuiltinProgram]) -> None:
    """A block in VAR_INST is initialised once, and a block in VAR is initialised in each call."""
    program = scanned(
        "FUNCTION_BLOCK F VAR N : INT; END_VAR METHOD FB_init : BOOL VAR_INPUT"
        " bInitRetains : BOOL; bInCopyCode : BOOL; K : INT; END_VAR N := K; END_METHOD"
        " METHOD Up : INT N := N + 1; Up := N; END_METHOD END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK G METHOD A : INT VAR_INST B : F(10); END_VAR A := B.Up(); END_METHOD"
        " METHOD C : INT VAR B : F(20); END_VAR C := B.Up(); END_METHOD END_FUNCTION_BLOCK\n"
        "PROGRAM Main VAR B : G; I : INT; J : INT; K : INT; L : INT; END_VAR"
        " I := B.A(); J := B.A(); K := B.C(); L := B.C(); END_PROGRAM",
        dialect="twincat",
    )
    assert [program.read(f"Main.{name}") for name in "IJKL"] == [11, 12, 21, 21]


def test_a_call_in_an_expression_may_have_the_argument_en(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    program = scanned(
        "FUNCTION F : INT VAR_INPUT A : INT := 4; END_VAR F := A; END_FUNCTION\n"
        "PROGRAM Main VAR N : INT; M : INT; END_VAR N := F(EN := TRUE, A := 3) + 1; M := F();"
        " END_PROGRAM",
        dialect="openplc",
    )
    assert (program.read("Main.N"), program.read("Main.M")) == (4, 4)


def test_an_output_of_open_length_is_written_in_the_array_of_the_caller(
    scanned: Callable[..., BuiltinProgram],
) -> None:
    program = scanned(
        "FUNCTION F : INT VAR_OUTPUT O : ARRAY [*] OF INT; E : BOOL; END_VAR"
        " VAR_IN_OUT B : ARRAY [*] OF INT; END_VAR O[1] := B[2]; E := TRUE;"
        " F := TO_INT(UPPER_BOUND(O, 1)); END_FUNCTION\n"
        "PROGRAM Main VAR L : ARRAY [1..2] OF INT; M : ARRAY [1..2] OF INT := [3, 4]; N : INT;"
        " E : BOOL; END_VAR N := F(O => L, E => E, B := M); END_PROGRAM"
    )
    assert program.read("Main.L") == [4, 0]
    assert (program.read("Main.N"), program.read("Main.E")) == (2, True)
