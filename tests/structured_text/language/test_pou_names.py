"""`__POUNAME()`, `__POSITION()`, sizes of blocks and constants of structures have their values.

The results of both operators are from the help of CODESYS and TwinCAT ("Operator __POUNAME",
"Operator __POSITION").
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[..., BuiltinProgram]

_NAMES = """FUNCTION F1 : STRING
F1 := __POUNAME();
END_FUNCTION
FUNCTION_BLOCK FB1
VAR Own : STRING := __POUNAME(); END_VAR
VAR_OUTPUT Inside : STRING; Read : STRING; Acted : STRING; END_VAR
METHOD PROTECTED FINAL M : STRING
M := __POUNAME();
END_METHOD
PROPERTY P : INT
GET
Read := __pouname();
P := 1;
END_GET
END_PROPERTY
Inside := M();
A1();
ACTION A1:
Acted := __POUNAME();
END_ACTION
END_FUNCTION_BLOCK
PROGRAM Main
VAR B : FB1; F : STRING; N : INT; Here : STRING; Own : STRING; END_VAR
B();
N := B.P;
F := F1();
Own := B.Own;
Here := __POUNAME();
END_PROGRAM
"""


def test_the_name_of_a_pou_is_qualified_with_its_block(build: Build) -> None:
    """In a method, __POUNAME() contains the name of the block.

    Source: help of CODESYS, "Operator __POUNAME": in a method, qualified with the block.
    """
    program = build(_NAMES)
    program.scan(0)
    names = ["Main.F", "Main.Own", "Main.Here", "Main.B.Inside", "Main.B.Read", "Main.B.Acted"]
    assert [program.read(name) for name in names] == [
        *("F1", "FB1", "Main", "FB1.M", "FB1.P.Get", "FB1.A1"),
    ]


def test_pouname_in_a_list_of_globals_and_in_a_structure_gives_its_own_name(build: Build) -> None:
    """In a list of globals, __POUNAME() gives the name of the list.

    In a structure it gives the name of the structure.

    Source: help of CODESYS, "Operator __POUNAME".
    """
    program = build(
        "VAR_GLOBAL G : STRING := __POUNAME(); END_VAR\n"
        "TYPE ST1 : STRUCT N : STRING := __POUNAME(); END_STRUCT; END_TYPE\n"
        "PROGRAM Main VAR S : ST1; T : STRING; END_VAR T := G; END_PROGRAM"
    )
    program.scan(0)
    assert (program.read("Main.T"), program.read("Main.S.N")) == ("source0", "ST1")


def test_a_position_names_the_line_and_in_statements_the_column(build: Build) -> None:
    """__POSITION() gives the line, and in statements also the column.

    Source: Beckhoff Infosys, "__POSITION": Line 1 (Decl); Line 1, Column 1 (Impl).
    """
    program = build(
        "PROGRAM Main\nVAR\n  D : STRING := __POSITION();\n  I : STRING;\nEND_VAR\n"
        "  I := __POSITION();\nEND_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.D") == "Line 3 (Decl)"
    assert program.read("Main.I") == "Line 6, Column 8 (Impl)"


@pytest.mark.parametrize(
    ("argument", "size"),
    [
        ("X", 10),  # an ARRAY of five INT
        ("INT", 2),
        ("B", 16),  # pointer to the methods: 4 bytes; BYTE: 1 + 3; DINT: 4; BOOL: 1 + 3
        ("L", 32),  # two blocks of 16 bytes
        ("FB1", 16),
        ("S", 20),  # INT: 2 + 2 bytes, then the block
        ("D", 20),  # the variables of the base, then DINT: 4 bytes
    ],
)
def test_sizes_of_blocks_are_those_of_structures_with_a_pointer_before_them(
    argument: str, size: int, build: Build
) -> None:
    """A block has the size of a structure that begins with a pointer.

    Each tool differs, so this layout is assumed.

    Source: help of CODESYS, "XSIZEOF".
    """
    program = build(
        "FUNCTION_BLOCK FB1 VAR_INPUT A : BYTE; C : DINT; E : BOOL; END_VAR ; END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK FB2 EXTENDS FB1 VAR F : DINT; END_VAR ; END_FUNCTION_BLOCK\n"
        "TYPE ST1 : STRUCT I : INT; B : FB1; END_STRUCT; END_TYPE\n"
        "PROGRAM Main VAR X : ARRAY [0..4] OF INT; B : FB1; L : ARRAY [1..2] OF FB1; S : ST1;"
        f" D : FB2; U : ULINT; V : INT; END_VAR"
        f" U := XSIZEOF({argument}); V := SIZEOF({argument}); END_PROGRAM"
    )
    program.scan(0)
    assert (program.read("Main.U"), program.read("Main.V")) == (size, size)


_CONSTANTS = """TYPE ST1 : STRUCT A : INT; B : INT := 2; END_STRUCT; END_TYPE
TYPE AL1 : ST1; END_TYPE
VAR_GLOBAL CONSTANT
  C1 : ST1 := (A := 5);
  L1 : ARRAY [1..2] OF INT := [7, 8];
END_VAR
FUNCTION_BLOCK FB1
VAR_INPUT S : AL1 := C1; END_VAR
VAR_OUTPUT Sum : INT; END_VAR
Sum := S.A * 10 + S.B;
END_FUNCTION_BLOCK
PROGRAM Main
VAR CONSTANT K : ST1 := (A := 1, B := 1); END_VAR
VAR B : FB1; L : ARRAY [1..2] OF INT := L1; M : ST1 := source0.C1; N : ST1 := K; R : INT; END_VAR
B();
R := L[2] * 1000 + M.A * 100 + M.B * 10 + N.A;
L[1] := L1[1] + 1;
END_PROGRAM
"""


def test_a_constant_structure_or_array_is_an_initial_value(build: Build) -> None:
    program = build(_CONSTANTS)
    program.scan(0)
    assert (program.read("Main.B.Sum"), program.read("Main.R")) == (52, 8521)
    assert program.read("Main.L") == [8, 8]  # The copy changes; the constant still has 7.
    program.scan(1000)
    assert program.read("Main.L") == [8, 8]


def test_a_structure_of_another_type_is_no_initial_value(
    mistakes_of: Callable[..., list[InputError]],
) -> None:
    found = mistakes_of(
        "TYPE ST1 : STRUCT A : INT; END_STRUCT; ST2 : STRUCT A : INT; END_STRUCT; END_TYPE\n"
        "VAR_GLOBAL CONSTANT C1 : ST1 := (A := 5); END_VAR\n"
        "PROGRAM Main VAR S : ST2 := C1; END_VAR ; END_PROGRAM"
    )
    assert [error.message for error in found] == ["a ST2 is expected here, not a ST1"]


def test_a_final_method_of_an_interface_is_implemented(build: Build) -> None:
    """A FINAL method of an interface has an implementation. A block cannot override it."""
    program = build(
        "INTERFACE I1 METHOD FINAL M : INT END_METHOD END_INTERFACE\n"
        "FUNCTION_BLOCK FB1 IMPLEMENTS I1 METHOD FINAL M : INT M := 6; END_METHOD"
        " END_FUNCTION_BLOCK\nPROGRAM Main VAR B : FB1; N : INT; END_VAR N := B.M(); END_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.N") == 6


def test_a_bit_string_has_a_subrange(build: Build) -> None:
    program = build("PROGRAM Main VAR B : BYTE (2..7); W : WORD (0..16#FF); END_VAR ; END_PROGRAM")
    assert (program.read("Main.B"), program.read("Main.W")) == (2, 0)
