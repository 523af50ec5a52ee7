"""Conditional compilation selects statements, and wrong conditions are refused."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_USES = [
    ("{IF defined (A)} x := 1; {END_IF}", 0),
    ("{IF NOT defined (A)} x := 1; {END_IF}", 1),
    ("{define A} {IF defined (a)} x := 1; {ELSE} x := 2; {END_IF}", 1),
    ("{define A} {undefine A} {IF defined (A)} x := 1; {ELSE} x := 2; {END_IF}", 2),
    ("{define A '7'} {IF hasvalue (A, '7')} x := 1; {ELSE} x := 2; {END_IF}", 1),
    ("{define A '7'} {IF hasvalue (A, '8')} x := 1; {ELSE} x := 2; {END_IF}", 2),
    ("{define A} {IF project_defined (A)} x := 1; {ELSE} x := 2; {END_IF}", 2),
    ("{define B}{IF defined (A)} x := 1; {ELSIF defined (B)} x := 2; {ELSIF defined (B)} x := 3;"
     " {ELSE} x := 4; {END_IF} x := x + 10;", 12),
    ("{define B}{IF defined (A) AND defined (B)} x := 1; {ELSIF defined (A) OR defined (B)} x := 2;"
     " {END_IF}", 2),
    ("{define B}{IF NOT (defined (A) OR defined (B))} x := 1; {ELSE} x := 2; {END_IF}", 2),
    ("{IF defined (A)} {IF defined (A)} x := 1; {ELSE} x := 2; {END_IF} x := 3; {ELSE} x := 4;"
     " {END_IF}", 4),
    ("{define B}{IF defined (B)} {IF defined (A)} x := 1; {ELSE} x := 2; {END_IF} {ELSE} x := 4;"
     " {END_IF}", 2),
    ("{IF defined (A)} (* {END_IF} *) x := 1; // {END_IF}\n s := '{END_IF}'; x := 2;\n{END_IF}", 0),
    ("{IF defined (A)} this is no Structured Text {ELSE} x := 5; {END_IF}", 5),
    ("{if defined (A)} {define B} {end_if} {if defined (B)} x := 1; {end_if}", 0),
    ("IF x = 0 THEN {IF defined (A)} x := 1; {END_IF} END_IF", 0),
]  # fmt: skip


@pytest.mark.parametrize(("body", "expected"), _USES, ids=[body for body, _ in _USES])
def test_the_statements_of_one_branch_remain(
    body: str, expected: int, build: Callable[[str], BuiltinProgram]
) -> None:
    """Conditional compilation keeps the statements of exactly one branch.

    Source: help of CODESYS and TwinCAT, conditional pragmas.
    """
    program = build(f"PROGRAM P1\nVAR x : INT; s : STRING; END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    assert program.read("Main.x") == expected


def test_a_branch_may_hold_variables_and_methods(build: Callable[[str], BuiltinProgram]) -> None:
    """A branch of conditional compilation may contain variables and methods.

    Source: help of TwinCAT, conditional pragmas: in declarations from 4024 on.
    """
    program = build(
        "{define A}\nFUNCTION_BLOCK B\nVAR {IF defined (A)} n : INT := 3; {ELSE} n : REAL; {END_IF}"
        " END_VAR\n{IF defined (A)}\nMETHOD M : INT\nM := n;\nEND_METHOD\n{END_IF}\n"
        "END_FUNCTION_BLOCK\nPROGRAM P1\nVAR b : B; x : INT; END_VAR\nx := b.M();\nEND_PROGRAM\n"
    )
    program.scan(0)
    assert program.read("Main.x") == 3


_WRONG = [
    ("{IF defined (variable: x)}\nx := 1;\n{END_IF}", 3,
     "the condition defined (variable: …) is not supported"),
    ("{IF hastype (variable: x, INT)}\n{END_IF}", 3,
     "the condition hastype (variable: …) is not supported"),
    ("{IF defined A}\n{END_IF}", 3, "'(' is expected in this condition, not 'A'"),
    ("{IF defined (A) x}\n{END_IF}", 3, "'x' is not expected in this condition"),
    ("{IF}\n{END_IF}", 3, "this condition ends in the middle"),
    ("x := 1;\n{ELSE}", 4, "{ELSE} without {IF}"),
    ("x := 1;\n{END_IF}", 4, "{END_IF} without {IF}"),
    ("{define}", 3, "{define} needs a name"),
    ("x := 1;\n{IF NOT defined (A)}\nx := 2;", 4, "this {IF} has no {END_IF}"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "line", "message"), _WRONG, ids=[one[2] for one in _WRONG])
def test_a_wrong_condition_has_its_line(
    body: str, line: int, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    (error,) = mistakes_of(f"PROGRAM P1\nVAR x : INT; END_VAR\n{body}\nEND_PROGRAM\n")
    assert (error.message, error.line) == (message, line)
