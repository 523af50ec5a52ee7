"""A derived structure can be used as its base, and __ISVALIDREF takes a VAR_IN_OUT."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

_TYPES = """\
TYPE B : STRUCT n : INT; t : ARRAY [0..1] OF INT; END_STRUCT END_TYPE
TYPE D EXTENDS B : STRUCT m : INT; END_STRUCT END_TYPE
TYPE D2 EXTENDS D : STRUCT k : INT; END_STRUCT END_TYPE
TYPE Holder : STRUCT b : B; END_STRUCT END_TYPE
FUNCTION Sum : INT VAR_INPUT v : B; END_VAR Sum := v.n + v.t[1]; END_FUNCTION
FUNCTION Inc : INT VAR_IN_OUT v : B; END_VAR v.n := v.n + 1; Inc := v.n; END_FUNCTION
FUNCTION_BLOCK Box
VAR_INPUT v : B; END_VAR
VAR_IN_OUT w : B; END_VAR
VAR_IN_OUT s : BOOL; END_VAR
VAR_OUTPUT o : INT; inside : BOOL; END_VAR
o := v.n; w.n := w.n + 10; inside := __ISVALIDREF(w) AND __ISVALIDREF(s);
METHOD Take : INT
VAR_INPUT v : B; END_VAR
VAR_IN_OUT u : B; END_VAR
v.n := v.n + 1; u.n := u.n + 100; Take := v.n;
IF NOT __ISVALIDREF(u) THEN Take := -1; END_IF
END_METHOD
METHOD Known : BOOL Known := __ISVALIDREF(w); END_METHOD
METHOD KnownBit : BOOL Known := __ISVALIDREF(s); IF KnownBit THEN s := TRUE; END_IF END_METHOD
END_FUNCTION_BLOCK
""".replace("Known := __ISVALIDREF(s)", "KnownBit := __ISVALIDREF(s)")
_VARIABLES = (
    "b : B; d : D; d2 : D2; h : Holder; a : ARRAY [1..2] OF B; c : ARRAY [1..2] OF D; f : Box;"
    " x, y : INT; s, p, q : BOOL; r : REFERENCE TO B;"
)

_USES: list[tuple[str, str, Any]] = [
    ("b := d;", "b.n", 5),
    ("b := d;", "b.t", [0, 7]),
    ("b := d; d.n := 6;", "b.n", 5),
    ("b := d2;", "b.n", 50),
    ("d := d2;", "d.n", 50),
    ("h.b := d;", "h.b.n", 5),
    ("a[2] := d;", "a[2].n", 5),
    ("a[2] := c[1];", "a[2].n", 8),
    ("x := Sum(d);", "x", 12),
    ("x := Sum(v := d2);", "x", 50),
    ("x := Inc(d);", "d.n", 6),
    ("f(v := d2, w := d, s := s);", "f.o", 50),
    ("f(v := d2, w := d, s := s);", "d.n", 15),
    ("x := f.Take(d2, d);", "x", 51),
    ("x := f.Take(v := d2, u := d); y := d2.n;", "y", 50),
    ("x := f.Take(v := d2, u := d);", "d.n", 105),
    ("r REF= d2; r.n := r.n + 1;", "d2.n", 51),
    ("p := f.Known();", "p", False),
    ("p := f.KnownBit();", "p", False),
    ("f(v := b, w := b, s := s); p := f.Known() AND f.KnownBit();", "p", True),
    ("f(v := b, w := b, s := s);", "f.inside", True),
]


@pytest.mark.parametrize(("body", "name", "expected"), _USES, ids=[f"{b} {n}" for b, n, _ in _USES])
def test_a_derived_structure_can_be_used_as_its_base(
    body: str, name: str, expected: Any, build: Callable[[str], BuiltinProgram]
) -> None:
    """A variable of a derived structure is accepted where its base is needed.

    Source: help of TwinCAT, extending a structure; values by hand.
    """
    start = "d.n := 5; d.t[1] := 7; d2.n := 50; c[1].n := 8;"
    program = build(f"{_TYPES}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{start}{body}\nEND_PROGRAM\n")
    program.scan(0)
    assert program.read(f"Main.{name}") == expected


_WRONG = [
    ("d := b;", "a D is expected here, not a B"),
    ("a := c;", "a ARRAY [1..2] OF B is expected here, not a ARRAY [1..2] OF D"),
    ("x := Sum(h);", "a B is expected here, not a Holder"),
    ("p := __ISVALIDREF(b);", "__ISVALIDREF needs a variable of REFERENCE TO, or a VAR_IN_OUT"),
]


@pytest.mark.parametrize(("body", "message"), _WRONG, ids=[body for body, _ in _WRONG])
def test_a_base_structure_cannot_be_used_as_a_derived_structure(
    body: str, message: str, mistakes_of: Callable[[str], list[InputError]]
) -> None:
    (error,) = mistakes_of(f"{_TYPES}PROGRAM P1\nVAR {_VARIABLES} END_VAR\n{body}\nEND_PROGRAM\n")
    assert (error.message, error.line) == (message, _TYPES.count("\n") + 3)
