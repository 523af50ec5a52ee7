"""In an SCL source of STEP 7, a constant of CONST … END_CONST takes the type of its use."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.projects.siemens import read_scl
from structured_text.projects.texts import st_texts

_SOURCE = """\
FUNCTION_BLOCK fb1
VAR_INPUT a : REAL; Mode : INT; END_VAR
VAR_OUTPUT o : BYTE; p : INT; END_VAR
CONST
  Lim := 100.0; // limit
  "N" := 3;
  M := "N" * 2;
  Mask := 16#0F;
  T1 := T#2s;
  NEG := -1;
END_CONST
VAR b : REAL; f : ARRAY [1..N] OF INT; t : TIME; g : ARRAY [0..M] OF INT; END_VAR
BEGIN
 b := a * Lim;
 #b := #b + #Lim;
 o := Mask;
 t := T1;
 CASE Mode OF
   N: p := NEG;
   NEG: p := 5;
 END_CASE;
 g[M] := M - NEG;
END_FUNCTION_BLOCK
FUNCTION_BLOCK fb2
VAR_INPUT Lim : INT; END_VAR
VAR x : INT; END_VAR
BEGIN
 x := Lim;
END_FUNCTION_BLOCK
ORGANIZATION_BLOCK Main
CONST Lim := 7; END_CONST
VAR x : fb1; y : fb2; END_VAR
BEGIN
 x(a := 2.0, Mode := 3);
 y(Lim := Lim);
END_ORGANIZATION_BLOCK
"""


def test_a_constant_takes_the_type_of_its_place(
    tmp_path: Path, build: Callable[..., BuiltinProgram]
) -> None:
    """A constant of CONST takes the type that its use requires.

    Source: SCL for S7-300/S7-400, A5E00324650, constants; values by hand.
    """
    file = tmp_path / "source.scl"
    file.write_text(_SOURCE, encoding="utf-8")
    program = build(*st_texts(read_scl(file)).values())
    program.scan(0)
    names = ("x.b", "x.o", "x.p", "x.g[6]", "y.x")
    assert [program.read(f"Main.{name}") for name in names] == [300.0, 15, -1, 7, 7]


@pytest.mark.parametrize(
    ("section", "message"),
    [
        ("CONST a 5; END_CONST", "a constant needs a name and a value"),
        ("CONST a := 5;", "this CONST has no END_CONST"),
        ("CONST a := 5 END_CONST", "a ';' is missing"),
    ],
)
def test_a_wrong_constant_has_its_line(section: str, message: str, tmp_path: Path) -> None:
    file = tmp_path / "source.scl"
    file.write_text(f"FUNCTION_BLOCK f\n{section}\nBEGIN\nEND_FUNCTION_BLOCK\n", encoding="utf-8")
    with pytest.raises(InputError) as found:
        read_scl(file)
    assert (found.value.message, found.value.line) == (message, 2)
