"""Counting coverage never changes a program's behaviour, tested with random conditions."""

from __future__ import annotations

import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector
from structured_text.errors import InputError
from structured_text.language.load import load
from structured_text.language.project import Project
from structured_text.language.source import in_dialect

#: Conditions for random programs. Some have effects (calls), some cause errors for some values.
_LEAVES = (
    *("A", "B", "N > 2", "F_Count(A)", "F_Count(N = 1)", "F_Set(K := N) > 2", "Field[N] > 0"),
    *("10 / N > 1", "SQRT(X) > 1.0", "REAL_TO_INT(Big * X) > 0", "N MOD 2 = 0"),
    *("F_Raise(N)", "Worker.Step() > 1", "INT_TO_REAL(N) > 1.0"),
    *("T#1s * Big > T#0s", "Texts[N] = 'a'"),
)  # fmt: skip
_HEAD = """
VAR_GLOBAL Calls : INT; END_VAR
FUNCTION F_Count : BOOL
VAR_INPUT Given : BOOL; END_VAR
Calls := Calls + 1; F_Count := NOT Given;
END_FUNCTION
FUNCTION F_Set : INT
VAR_IN_OUT K : INT; END_VAR
K := K + 1; F_Set := K;
END_FUNCTION
FUNCTION F_Raise : BOOL
VAR_INPUT Given : INT; END_VAR
F_Raise := 6 / (Given - 2) > 0;
END_FUNCTION
FUNCTION_BLOCK Stepping
VAR Steps : INT; END_VAR
METHOD Step : INT
Steps := Steps + 1; Step := Steps MOD 3;
END_METHOD
END_FUNCTION_BLOCK
PROGRAM Main
VAR
  A, B, R, Q : BOOL; N, Round, Chosen : INT; X : REAL; Big : REAL := 3.0E38; Worker : Stepping;
  Field : ARRAY[1..3] OF INT := [0, 1, 1]; Texts : ARRAY[0..2] OF STRING[3]; Fast : INT;
END_VAR
Round := Round + 1; N := (Round + {start}) MOD 5; A := Round MOD 2 = 0; B := NOT B;
X := INT_TO_REAL(N) - 1.0;
R := {first};
IF {second} THEN Chosen := 1; ELSIF {third} THEN Chosen := 2; END_IF
Fast := 0;
WHILE Fast < 2 AND ({second}) DO Fast := Fast + 1; END_WHILE
Q := SEL(R, F_Count({first}), NOT ({third}));
END_PROGRAM
"""
_CONDITIONS = st.recursive(
    st.sampled_from(_LEAVES),
    lambda inner: st.one_of(
        st.builds(
            "({} {} {})".format,
            inner,
            st.sampled_from(("AND", "OR", "XOR", "AND_THEN", "OR_ELSE")),
            inner,
        ),
        st.builds("NOT ({})".format, inner),
    ),
    max_leaves=5,
)


def _behaviour(project: Project, collector: Collector | None) -> list[str]:
    """Return the values after each scan, up to the first error, with the position of the error."""
    program = BuiltinProgram.build(project, collector)
    paths = ["Calls", *(f"Main.{one}" for one in ("R", "Q", "N", "Chosen", "Worker.Steps", "Fast"))]
    seen: list[str] = []
    for scan in range(6):
        try:
            program.scan(scan * 1000)
        except InputError as error:
            return [*seen, f"{error.line}: {error.message}", str(program.reader(paths)())]
        seen.append(str(program.reader(paths)()))
    return seen


def _check(dialect: str, start: int, first: str, second: str, third: str) -> None:
    text = _HEAD.format(start=start, first=first, second=second, third=third)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "program.st"
        file.write_text(text, encoding="utf-8")
        project = load([in_dialect(file, dialect)])
        assert _behaviour(project, Collector()) == _behaviour(project, None)


_GIVEN = given(
    dialect=st.sampled_from(("iec", "codesys", "tia")),
    start=st.integers(0, 4),
    first=_CONDITIONS,
    second=_CONDITIONS,
    third=_CONDITIONS,
)


@pytest.mark.exhaustive
@_GIVEN
@settings(max_examples=40, deadline=None, derandomize=True)
def test_a_counted_program_does_the_same(
    dialect: str, start: int, first: str, second: str, third: str
) -> None:
    """A program gives the same values with and without coverage counting.

    Source: docs/how-to/coverage.md.
    """
    _check(dialect, start, first, second, third)


@pytest.mark.exhaustive
@_GIVEN
@settings(max_examples=500, deadline=None)
def test_many_counted_programs_do_the_same(
    dialect: str, start: int, first: str, second: str, third: str
) -> None:
    """Many random programs give the same values with and without coverage counting.

    Source: docs/how-to/coverage.md.
    """
    _check(dialect, start, first, second, third)


@pytest.mark.parametrize("counted", [False, True])
@pytest.mark.parametrize(("dialect", "calls"), [("iec", 0), ("twincat", 5)])
def test_a_function_on_the_right_of_and_is_called_as_often_with_coverage_as_without(
    tmp_path: Path, dialect: str, calls: int, counted: bool
) -> None:
    """Coverage counting does not change whether AND calls the function on its right.

    Source: docs/reference/language.md, AND, OR of BOOL.
    """
    file = tmp_path / "program.st"
    file.write_text(
        "VAR_GLOBAL Calls : INT; END_VAR\n"
        "FUNCTION F_Count : BOOL VAR_INPUT X : BOOL; END_VAR\n"
        "Calls := Calls + 1; F_Count := TRUE; END_FUNCTION\n"
        "PROGRAM Main VAR Ok, R : BOOL; END_VAR R := Ok AND F_Count(TRUE); END_PROGRAM\n",
        encoding="utf-8",
    )
    collector = Collector() if counted else None
    program = BuiltinProgram.build(load([in_dialect(file, dialect)]), collector)
    for scan in range(5):
        program.scan(scan)
    assert program.read("Calls") == calls
