"""What SIMATIC AX and TIA Portal accept: characters of texts, enumerations with a base type."""

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
    """Source: manual of STEP 7, "STRING": the first character has the index 1 and is a CHAR."""
    program = scanned(
        "PROGRAM Main VAR S : STRING := 'abc'; C : CHAR; T : STRING; U : STRING := 'abc'; END_VAR\n"
        "C := S[2]; T := S[3]; U[1] := 'x'; U[2] := C; IF S[1] = 'a' THEN U[3] := S[1]; END_IF;\n"
        "END_PROGRAM",
        dialect=dialect,
    )
    assert [program.read(f"Main.{name}") for name in "CTU"] == ["b", "c", "xba"]


def test_elsewhere_they_are_bytes_that_count_from_zero(
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


def test_a_start_of_a_wider_type_is_converted_in_ax_only(
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
    """E := E names the pin of the inner block and the variable of the outer one."""
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
