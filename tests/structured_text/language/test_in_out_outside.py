"""A VAR_IN_OUT that is read outside of its block has the value of the last call, as in matiec."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.matiec.build import Matiec
from structured_text.engines.matiec.program import MatiecProgram
from structured_text.engines.native.toolchain import find_c_compiler
from structured_text.errors import InputError
from structured_text.language.load import analyse, load
from structured_text.language.source import in_dialect

_TEXT = """
FUNCTION_BLOCK FB_Add
VAR_INPUT Extra : INT := 2; Early : BOOL; END_VAR
VAR_IN_OUT Sum : INT; END_VAR
Sum := Sum + Extra;
IF Early THEN RETURN; END_IF;
Sum := Sum * 10;
END_FUNCTION_BLOCK
PROGRAM Main
VAR F : FB_Add; X, Before, After, Later : INT; END_VAR
Before := F.Sum;
F(Sum := X, Early := X > 0);
After := F.Sum;
X := 1;
Later := F.Sum;
END_PROGRAM
CONFIGURATION C
RESOURCE R ON PLC
TASK T1(INTERVAL := T#10ms, PRIORITY := 0);
PROGRAM P WITH T1 : Main;
END_RESOURCE
END_CONFIGURATION
"""
#: Expected values of Before, After and Later in three scans. X is 0, 1, 1 before the calls.
_EXPECTED = [(0, 20, 20), (20, 3, 3), (3, 3, 3)]


def _values(program: BuiltinProgram | MatiecProgram) -> list[tuple[object, ...]]:
    found = []
    for scan in range(3):
        program.scan(scan * 10_000)
        found.append(tuple(program.read(f"P.{name}") for name in ("Before", "After", "Later")))
    return found


def test_a_var_in_out_read_outside_has_the_value_of_the_last_call(
    build: Callable[..., BuiltinProgram],
) -> None:
    """Outside of a call, a VAR_IN_OUT has the value that it had in the last call.

    Source: matiec's C code, __SET_VAR of the instance before and after a call; by hand.
    """
    assert _values(build(_TEXT)) == _EXPECTED


def test_a_snapshot_has_the_value_of_a_var_in_out(build: Callable[..., BuiltinProgram]) -> None:
    """A snapshot contains the VAR_IN_OUT value of the last call."""
    program = build(_TEXT)
    program.scan(0)
    saved = program.snapshot()
    program.scan(10_000)
    other = program.instance()
    other.restore(saved)
    other.scan(10_000)
    assert other.read("P.Before") == 20


def test_matiec_computes_the_same(
    matiec: Matiec, files_of: Callable[..., list[Path]], tmp_path: Path
) -> None:
    """Matiec gives the same values as the built-in engine."""
    compiler = find_c_compiler()
    assert compiler is not None
    program = MatiecProgram.build(load(files_of(_TEXT)), matiec, compiler)
    assert _values(program) == _EXPECTED


@pytest.mark.parametrize("dialect", ["codesys", "twincat"])
def test_other_dialects_refuse_to_read_a_var_in_out_outside(
    dialect: str, files_of: Callable[..., list[Path]]
) -> None:
    """In other dialects, reading a VAR_IN_OUT outside of its block is refused.

    Source: CODESYS help, VAR_IN_OUT: it can be accessed only inside of the block.
    """
    (file,) = files_of(_TEXT)
    _, errors = analyse([in_dialect(file, dialect)])
    assert {error.message for error in errors} == {"Sum is internal to FB_Add"}


def test_a_var_in_out_cannot_be_written_outside_of_a_call(
    mistakes_of: Callable[..., list[InputError]],
) -> None:
    """Writing a VAR_IN_OUT outside of a call is refused.

    The next call would overwrite the written value.
    """
    (error,) = mistakes_of(_TEXT.replace("X := 1;", "F.Sum := 1;"))
    assert error.message == "Sum is a VAR_IN_OUT of FB_Add: give it in the call"
