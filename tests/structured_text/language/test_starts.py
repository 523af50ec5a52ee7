"""Tests of blocks with arguments in lists of globals and in outputs, and of VAR_INST."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[..., BuiltinProgram]

_BLOCKS = """
FUNCTION_BLOCK Part
VAR_OUTPUT Text : STRING; Sum : INT := 1; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains, bInCopyCode : BOOL; T : STRING; N : INT; END_VAR
Text := T; Sum := Sum + N;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Whole
VAR_OUTPUT Inner : Part('in', 2); END_VAR
END_FUNCTION_BLOCK
INTERFACE Counting
METHOD Next : INT
END_METHOD
END_INTERFACE
FUNCTION_BLOCK Counter IMPLEMENTS Counting
VAR_INPUT Step : POINTER TO INT; END_VAR
VAR N : INT; Own : INT := 5; END_VAR
METHOD Next : INT
VAR_INST Other : Adder := (Addend := ADR(THIS^.Own)); Calls : POINTER TO INT := ADR(N); END_VAR
Other();
Calls^ := Calls^ + 1;
Next := Other.Total;
END_METHOD
END_FUNCTION_BLOCK
FUNCTION_BLOCK Adder
VAR_INPUT Addend : POINTER TO INT; END_VAR
VAR_OUTPUT Total : INT; END_VAR
Total := Total + Addend^;
END_FUNCTION_BLOCK
"""
_LIST = """
VAR_GLOBAL
  Base : INT := 40;
  G : Part(T := 'list', N := Base + 1);
  W : Whole;
  P : POINTER TO INT := ADR(Base);
  I : Counting := C;
  C : Counter;
END_VAR
"""


def test_a_block_of_a_list_of_globals_gets_its_arguments(build: Build) -> None:
    """A block in a list of globals gets the arguments of its declaration.

    G.Sum is 1 + 41, and Inner.Sum is 1 + 2.

    Source: CODESYS help, methods FB_Init, FB_Reinit and FB_Exit; values by hand.
    """
    program = build(
        f"{_BLOCKS}{_LIST}PROGRAM Main\nVAR A, B, D, E : INT; T : STRING; END_VAR\n"
        "A := G.Sum; T := G.Text; B := W.Inner.Sum; D := P^; E := I.Next();\nEND_PROGRAM\n"
    )
    program.scan(0)
    assert [program.read(f"Main.{name}") for name in "ABDET"] == [42, 3, 40, 5, "list"]


def test_a_snapshot_of_another_instance_leads_to_its_own_globals(build: Build) -> None:
    """After a restored snapshot, references of an instance lead to its own globals."""
    program = build(
        f"{_BLOCKS}{_LIST}PROGRAM Main\nVAR D : INT; END_VAR\nP^ := P^ + 1; D := P^;\nEND_PROGRAM\n"
    )
    program.scan(0)
    other = program.instance()
    other.restore(program.snapshot())
    other.scan(10_000)
    assert (other.read("Base"), program.read("Base")) == (42, 41)


def test_a_var_inst_starts_once_with_its_block(build: Build) -> None:
    """A VAR_INST keeps its value between three calls of the method: 5, 10, 15.

    Source: CODESYS help, VAR_INST: the values are kept between the calls of the method.
    """
    program = build(
        f"{_BLOCKS}PROGRAM Main\nVAR C : Counter; A : INT; END_VAR\nA := C.Next();\nEND_PROGRAM\n"
    )
    for scan in range(3):
        program.scan(scan * 10_000)
    assert [program.read(f"Main.{name}") for name in ("A", "C.N")] == [15, 3]


def test_missing_arguments_have_their_line(mistakes_of: Callable[..., list[InputError]]) -> None:
    """A missing argument of FB_init is reported at the line of the declaration."""
    (error,) = mistakes_of(
        f"{_BLOCKS}VAR_GLOBAL\n  G : Part('x');\nEND_VAR\nPROGRAM Main\nEND_PROGRAM\n"
    )
    assert error.message == "the argument N of Part.FB_init is missing"
    assert error.line == _BLOCKS.count("\n") + 2


def test_a_program_names_its_own_parts(build: Build) -> None:
    """A program can access its own variables by its own name.

    Source: Beckhoff InfoSys, TwinCAT 3 PLC, PROGRAM: access by the name of the program.
    """
    program = build(
        "PROGRAM Main\nVAR A, B : INT; END_VAR\nMETHOD Two : INT\nTwo := Main.B + 2;\nEND_METHOD\n"
        "Main.B := 5; A := Main.Two();\nEND_PROGRAM\n"
    )
    program.scan(0)
    assert program.read("Main.A") == 7


def test_a_second_declaration_of_a_calculated_value_is_reported(build: Build) -> None:
    with pytest.raises(InputError, match="B is declared twice"):
        build("PROGRAM Main VAR A : INT; B : INT := A + 1; B : INT; END_VAR END_PROGRAM")
