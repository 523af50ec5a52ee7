"""Statements, functions and blocks have their specified effects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram

Run = Callable[..., Any]
Build = Callable[[str], BuiltinProgram]

_COLOUR = "TYPE Colour : (RED, GREEN, BLUE); END_TYPE\n"
_PAIR = "TYPE Pair : STRUCT A : INT; B : INT := 7; END_STRUCT; END_TYPE\n"
_LIST = "TYPE List1 : ARRAY [1..5] OF INT; END_TYPE\n"


def test_if_takes_the_first_branch_that_holds(run: Run) -> None:
    body = (
        "IF I < 0 THEN K := 1; ELSIF I < 10 THEN K := 2; ELSIF I < 20 THEN K := 3;"
        "ELSE K := 4; END_IF;"
    )
    assert [run(f"I : INT := {i}; K : INT;", body, "K") for i in (-1, 5, 15, 25)] == [1, 2, 3, 4]


def test_case_knows_lists_ranges_and_else(run: Run) -> None:
    body = "CASE I OF 1, 3: K := 10; 5..7: K := 20; -4..-2: K := 30; ELSE K := 40; END_CASE;"
    values = [run(f"I : INT := {i}; K : INT;", body, "K") for i in (1, 3, 5, 7, -3, 2, 8)]
    assert values == [10, 10, 20, 20, 30, 40, 40]


def test_case_of_an_enumeration_steps_through_its_members(build: Build) -> None:
    program = build(
        f"{_COLOUR}PROGRAM P1\nVAR C : Colour := GREEN; END_VAR\n"
        "CASE C OF\n  RED: C := Colour#GREEN;\n  GREEN: C := BLUE;\n  BLUE: C := RED;\nEND_CASE;\n"
        "END_PROGRAM"
    )
    seen = [program.read("Main.C")]
    for k in range(3):
        program.scan(k)
        seen.append(program.read("Main.C"))
    assert seen == ["GREEN", "BLUE", "RED", "GREEN"]


@pytest.mark.parametrize("end", ["Next(C := C)", "1 + Next(C := C)", "Next(C := C) + 1"])
def test_a_call_as_the_end_value_of_a_for_loop_runs_once(run: Run, end: str) -> None:
    """If the end value is a call, it is evaluated before the first iteration.

    Source: IEC 61131-3 (2003), 3.3.2.4.
    """
    before = "FUNCTION Next : INT VAR_IN_OUT C : INT; END_VAR C := C + 1; Next := 2; END_FUNCTION"
    body = f"FOR I := 1 TO {end} DO N := N + 1; END_FOR;"
    assert run("I, N, C : INT;", body, "N C", before) == (3 if "1" in end else 2, 1)


#: Cases: variables, statements, checked variables, their values, and the text before the program.
_CASES = {
    "a FOR loop includes its end and may run no times": (
        "I : INT; N : INT; M : INT; Sum : INT; Z : INT;",
        "FOR I := 1 TO 4 DO Sum := Sum + I; END_FOR; N := I;\n"
        "FOR I := 0 TO 0 DO Z := Z + 1; END_FOR;\n"
        "FOR I := 5 TO 1 DO Z := 100; END_FOR;\n"
        "FOR I := 9 TO 1 BY -3 DO M := M * 10 + I; END_FOR;",
        "Sum N Z M I", (10, 5, 1, 963, 0), "",
    ),
    "a step of a FOR loop may be a variable": (
        "I : INT; By1 : INT := -2; N : INT;",
        "FOR I := 6 TO 1 BY By1 DO N := N + 1; END_FOR;", "N I", (3, 0), "",
    ),
    "WHILE tests before and REPEAT after each iteration": (
        "I : INT := 5; J : INT := 5; N : INT; M : INT;",
        "WHILE I < 5 DO N := N + 1; END_WHILE; REPEAT M := M + 1; UNTIL J >= 5 END_REPEAT;",
        "N M", (0, 1), "",
    ),
    "EXIT leaves the innermost loop only": (
        "I : INT; J : INT; N : INT;",
        "FOR I := 1 TO 3 DO J := 0; WHILE TRUE DO J := J + 1; "
        "IF J = I THEN EXIT; END_IF; END_WHILE; N := N + J; END_FOR;",
        "N I", (6, 4), "",
    ),
    "RETURN leaves the block": (
        "E : Early; Count : INT;",
        "E(Stop := FALSE, Seen := Count); E(Stop := TRUE, Seen := Count);", "E.N Count", (1, 2),
        "FUNCTION_BLOCK Early\nVAR_INPUT Stop : BOOL; END_VAR\nVAR_OUTPUT N : INT; END_VAR\n"
        "VAR_IN_OUT Seen : INT; END_VAR\n"
        "Seen := Seen + 1; IF Stop THEN RETURN; END_IF; N := N + 1;\nEND_FUNCTION_BLOCK",
    ),
    "a function has initial values at every call": (
        "A : DINT; B : DINT; C : DINT;",
        "A := Triangle(4, 0); B := Triangle(N := 4); C := Triangle(Offset := 1, N := 2);",
        "A B C", (10, 110, 4),
        "FUNCTION Triangle : DINT\nVAR_INPUT N : DINT; Offset : DINT := 100; END_VAR\n"
        "VAR I : DINT; Sum : DINT; END_VAR\n"
        "WHILE I < N DO I := I + 1; Sum := Sum + I; END_WHILE;\nTriangle := Sum + Offset;\n"
        "END_FUNCTION",
    ),
    "a function may have structures as input and result": (
        "P : Pair := (A := 1); Q1 : Pair;", "Q1 := Swapped(P);", "Q1 P",
        ({"A": 7, "B": 1}, {"A": 1, "B": 7}),
        f"{_PAIR}FUNCTION Swapped : Pair\nVAR_INPUT P : Pair; END_VAR\n"
        "Swapped.A := P.B; Swapped.B := P.A;\nEND_FUNCTION",
    ),
    "a block keeps its values and instances share nothing": (
        "A : Adder; B : Adder; T1 : INT;",
        "A(); A(X := 5); A(); B(3); A(X := 1, Sum => T1);", "A.Sum B.Sum T1", (13, 3, 13),
        "FUNCTION_BLOCK Adder\nVAR_INPUT X : INT := 2; END_VAR\nVAR_OUTPUT Sum : INT; END_VAR\n"
        "VAR_TEMP Aid : INT; END_VAR\nAid := Aid + X; Sum := Sum + Aid;\nEND_FUNCTION_BLOCK",
    ),
    "members and elements are VAR_IN_OUT of a block in a block": (
        "P : Pair; L1 : List1; O : Outer;", "O(P := P, L1 := L1); O(P := P, L1 := L1);", "P L1",
        ({"A": 2, "B": 7}, [0, 1, 1, 0, 2]),
        f"{_PAIR}{_LIST}"
        "FUNCTION_BLOCK Bump\nVAR_IN_OUT X : INT; END_VAR\nX := X + 1;\nEND_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK Outer\nVAR_IN_OUT P : Pair; L1 : List1; END_VAR\n"
        "VAR B1 : Bump; I : INT := 2; END_VAR\nB1(X := P.A); B1(X := L1[I]); "
        "B1(X := L1[5]); I := I + 1;\nEND_FUNCTION_BLOCK",
    ),
    "an index of a VAR_IN_OUT is evaluated at the call": (
        "L1 : List1; I : INT := 2; B1 : Both;", "B1(X := L1[I], I := I);", "L1 I",
        ([0, 9, 0, 0, 0], 4),
        f"{_LIST}FUNCTION_BLOCK Both\nVAR_IN_OUT I : INT; X : INT; END_VAR\nI := 4; X := 9;\n"
        "END_FUNCTION_BLOCK",
    ),
    "structures and arrays are copied by value": (
        "X : Whole; Y : Whole; P : Pair;",
        "X.Items[1, 0].A := 5; Y := X; X.Items[1, 0].A := 6; X.Name1 := 'x';\n"
        "P := X.Items[1, 0]; P.A := 8; X.Items[0, 1] := P;",
        "X Y",
        (
            {"Items": [[{"A": 0, "B": 7}, {"A": 8, "B": 7}], [{"A": 6, "B": 7}, {"A": 0, "B": 7}]],
             "Name1": "x"},
            {"Items": [[{"A": 0, "B": 7}, {"A": 0, "B": 7}], [{"A": 5, "B": 7}, {"A": 0, "B": 7}]],
             "Name1": ""},
        ),
        f"{_PAIR}TYPE Pairs : ARRAY [0..1, 0..1] OF Pair; END_TYPE\n"
        "TYPE Whole : STRUCT Items : Pairs; Name1 : STRING; END_STRUCT; END_TYPE",
    ),
    "a copy of an array does not change with the array": (
        "A, B : List1; P : ARRAY [0..1] OF List1;",
        "A[1] := 5; B := A; P[1] := A; A[1] := 6; P[1][2] := 7;", "A B P",
        ([6, 0, 0, 0, 0], [5, 0, 0, 0, 0], [[0] * 5, [5, 7, 0, 0, 0]]), _LIST,
    ),
    "initial values of arrays and structures are completed": (
        "A : ARRAY [0..5] OF INT := [1, 2(3), 2(0)]; B : Row; C : Row := [4];P : Pair := (B := 2);",
        "A[5] := 6;", "A B C P",
        ([1, 3, 3, 0, 0, 6], [9, 1, 1, 1], [4, 1, 1, 1], {"A": 0, "B": 2}),
        f"{_PAIR}TYPE Row : ARRAY [1..4] OF INT := [9, 3(1)]; END_TYPE",
    ),
    "arrays have any bounds and several dimensions": (
        "G : ARRAY [-1..1, 2..3] OF INT; N : ARRAY [1..2] OF ARRAY [5..6] OF INT; I, J : INT;",
        "FOR I := -1 TO 1 DO FOR J := 2 TO 3 DO G[I, J] := I * 10 + J; END_FOR; END_FOR;\n"
        "I := 2; N[I][J + 1] := 1; N[1][6] := G[I - 1, 3];",
        "G N", ([[-8, -7], [2, 3], [12, 13]], [[0, 13], [1, 0]]), "",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", _CASES)
def test_a_program_has_these_values_after_one_scan(run: Run, name: str) -> None:
    variables, body, want, values, before = _CASES[name]
    assert run(variables, body, want, before) == values


def test_a_member_name_of_two_enumerations_takes_the_expected_type(run: Run) -> None:
    """IDLE is the first member of one type and the last of the other."""
    before = "TYPE Mode1 : (IDLE, AUTO); END_TYPE\nTYPE Mode2 : (RUN, STOP, IDLE); END_TYPE"
    body = "A := IDLE; B := IDLE; C := A = IDLE; D := B = IDLE; E := Mode2#IDLE;"
    variables = "A : Mode1 := AUTO; B : Mode2; C, D : BOOL; E : Mode2;"
    assert run(variables, body, "A B C D E", before) == ("IDLE", "IDLE", True, True, "IDLE")
    case = "CASE B OF RUN: N := 1; STOP: N := 2; IDLE: N := 3; END_CASE;"
    assert run("B : Mode2; N : INT;", f"B := IDLE; {case}", "N", before) == 3
