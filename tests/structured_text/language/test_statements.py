"""Names as statements, a comma after the last argument and empty arguments are accepted."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_BOX = """\
FUNCTION_BLOCK Box;
VAR n : INT; END_VAR
VAR_INPUT i : INT; END_VAR
Step;
THIS^.Step;
CASE n OF
1: Step;
2: n; i;
END_CASE
END_FUNCTION_BLOCK
ACTION Step: n := n + 1; END_ACTION
PROPERTY Count : INT
GET
n := n + 10; Count := n;
END_GET
END_PROPERTY
METHOD M : INT
VAR_INPUT a : INT; b : INT; END_VAR
M := a * 10 + b;
END_METHOD
FUNCTION F : INT;
VAR_INPUT a : INT; b : INT; END_VAR
F := a * 10 + b;
END_FUNCTION
FUNCTION_BLOCK Init
VAR k : INT; END_VAR
METHOD FB_init : BOOL
VAR_INPUT bInitRetains : BOOL; bInCopyCode : BOOL; x : INT; END_VAR
k := x;
END_METHOD
END_FUNCTION_BLOCK
TYPE Mode : (Off, On); END_TYPE
"""
_VARIABLES = (
    "b : Box(); c : ARRAY [0..1] OF Box; t : TON := (); i : Init(x := 4,); x : INT; w : WORD;"
    " e : R_TRIG(); m : Mode; q : BOOL;"
)

_USES: list[tuple[str, str, Any]] = [
    ("b();", "b.n", 2),
    ("b.Step;", "b.n", 1),
    ("b.Count;", "b.n", 10),
    ("b.Count; x := b.Count;", "x", 20),
    ("c[1].Step; c[1].Step;", "c[1].n", 2),
    ("x := 3; x; b; b.n; c[0]; w.3; m; Mode.On; On;", "x", 3),
    ("b(i := 3,);", "b.i", 3),
    ("b(\n  i := 3,\n);", "b.n", 2),
    ("x := b.M(1, 2,);", "x", 12),
    ("x := b.M(b := 1, a := 2,);", "x", 21),
    ("x := F(3, 4,);", "x", 34),
    ("x := MAX(3, 4,);", "x", 4),
    ("x := i.k;", "x", 4),
    ("e(CLK := TRUE); q := e.Q;", "q", True),
    ("t(IN := TRUE, PT := T#0s,); q := t.Q;", "q", False),
]


@pytest.mark.parametrize(("body", "name", "expected"), _USES, ids=[body for body, _, _ in _USES])
def test_a_statement_has_the_effect_that_it_has_in_the_tools(
    body: str, name: str, expected: Any, build: Callable[[str], BuiltinProgram]
) -> None:
    """A name as a statement, and a call with empty arguments, have the effect of the tools.

    Source: help of TwinCAT, object action (2530340747); values by hand.
    """
    program = build(f"{_BOX}PROGRAM P1;\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    program.scan(0)
    assert program.read(f"Main.{name}") == expected


_WRONG = [
    ("b.M;", "the method Box.M is named without parentheses"),
    ("F;", "F is named without parentheses"),
    ("ABS;", "ABS is named without parentheses"),
    ("b.nope;", "Box has no method nope"),
    ("nope;", "nope is not declared"),
    ("x.20;", "a INT has no BOOL 20"),
    ("x := MAX(,);", "',' is not expected here"),
    ("b(i := 1,,);", "',' is not expected here"),
]


@pytest.mark.parametrize(("body", "message"), _WRONG, ids=[body for body, _ in _WRONG])
def test_a_wrong_statement_is_refused_with_its_line(
    body: str, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    """Each wrong statement gives one message with its line.

    Source: compiler error C0130 of CODESYS and TwinCAT, a method without parentheses.
    """
    (error,) = mistakes_of(f"{_BOX}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    assert (error.message, error.line) == (message, _BOX.count("\n") + 3)


@pytest.mark.parametrize(
    ("variables", "message"),
    [
        ("x : INT();", "a INT takes no arguments in ( )"),
        ("x : ARRAY [0..1] OF BOOL();", "a BOOL takes no arguments in ( )"),
        ("x : Init();", "x gives FB_init of Init no arguments"),
    ],
)
def test_empty_arguments_belong_to_blocks(
    variables: str, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    (error,) = mistakes_of(f"{_BOX}PROGRAM P1\nVAR {variables} END_VAR\nEND_PROGRAM\n")
    assert (error.message, error.line) == (message, _BOX.count("\n") + 2)
