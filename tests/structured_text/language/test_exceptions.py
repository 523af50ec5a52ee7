"""Tests of `__TRY`, `__CATCH` and `__FINALLY`: executed statements, and exception numbers."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector, counting
from structured_text.errors import InputError
from structured_text.language.constructs import refuse
from structured_text.language.load import load
from structured_text.language.project import Project
from structured_text.language.walk import statements

Build = Callable[..., BuiltinProgram]

_BLOCKS = """
FUNCTION_BLOCK Worker
VAR_INPUT Divisor : DINT; END_VAR
VAR_OUTPUT Result : DINT; Done : INT; END_VAR
METHOD Work : DINT
Work := 100 / Divisor;
Done := Done + 1;
END_METHOD
Result := Work();
END_FUNCTION_BLOCK
FUNCTION Early : STRING
VAR_INPUT Way : INT; END_VAR
VAR K : INT; Zero : INT; END_VAR
FOR K := 1 TO 3 DO
  Early := CONCAT(Early, 'b');
  __TRY
    CASE Way OF
      1: RETURN;
      2: EXIT;
      3: CONTINUE;
      4: K := K / Zero;
    END_CASE
    Early := CONCAT(Early, 'e');
  __CATCH
    Early := CONCAT(Early, 'c');
  __FINALLY
    Early := CONCAT(Early, 'f');
  __ENDTRY
END_FOR
END_FUNCTION
"""
_VARIABLES = """
VAR S : STRING; E, E2 : __SYSTEM.ExceptionCode; I, Z, N : INT; L : LREAL; D : DINT;
  A : ARRAY [1..3] OF INT; P : POINTER TO INT; R : REFERENCE TO INT; W : Worker;
END_VAR
"""


def _run(build: Build, body: str, scans: int = 1) -> BuiltinProgram:
    program = build(f"{_BLOCKS}PROGRAM Main{_VARIABLES}{body}\nEND_PROGRAM\n")
    for scan in range(scans):
        program.scan(scan * 10_000)
    return program


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("I := 1;", "tefn"),  # without an exception, __CATCH is not executed
        ("I := 1 / Z;", "tcfn"),  # the rest of __TRY is not executed
        ("W();", "tcfn"),  # the exception occurs in a called function
    ],
)
def test_finally_runs_with_and_without_an_exception(
    statement: str, expected: str, build: Build
) -> None:
    """The statements of __FINALLY run with and without an exception.

    Source: Beckhoff InfoSys, TwinCAT 3 PLC, __TRY, __CATCH, __FINALLY, __ENDTRY (2529187211).
    """
    add = "S := CONCAT(S, '{}');"
    program = _run(
        build,
        f"__TRY\n{add.format('t')}{statement}{add.format('e')}\n__CATCH(E)\n"
        f"{add.format('c')}\n__FINALLY\n{add.format('f')}\n__ENDTRY\n{add.format('n')}",
    )
    assert program.read("Main.S") == expected


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("I := 1 / Z;", "DIVIDEBYZERO"),
        ("L := 1.0 / INT_TO_LREAL(Z);", "FPU_DIVIDEBYZERO"),
        ("A[Z] := 1;", "ARRAYBOUNDS"),
        ("P^ := 1;", "ACCESS_VIOLATION"),
        ("R := 1;", "ACCESS_VIOLATION"),
        ("F_RaiseException(__SYSTEM.ExceptionCode.RTSEXCPT_USER_EXCEPTION_BASE);",
         "USER_EXCEPTION_BASE"),
        ("Tc2_System.F_RaiseException(exceptionCode := 16#103);", "OVERFLOW"),
    ],
)  # fmt: skip
def test_the_variable_of_catch_is_the_number_of_the_exception(
    statement: str, expected: str, build: Build
) -> None:
    """The variable in __CATCH(…) gets the number of the exception.

    Source: Beckhoff InfoSys, data type __SYSTEM.ExceptionCode (6753940235).
    """
    program = _run(build, f"__TRY {statement} __CATCH(E) __ENDTRY;")
    assert program.read("Main.E") == f"RTSEXCPT_{expected}"


def test_the_numbers_of_exceptions_are_those_of_the_help(build: Build) -> None:
    """The exception numbers are those of the manufacturer's documentation.

    Source: Beckhoff InfoSys, data type __SYSTEM.ExceptionCode (6753940235).
    """
    body = "__TRY I := 1 / Z; __CATCH(E) D := E; __ENDTRY"
    assert _run(build, body).read("Main.D") == 0x102


def test_an_exception_in_a_handler_goes_to_the_try_around_it(build: Build) -> None:
    """An exception in a handler is handled by the outer __TRY. The inner __FINALLY runs first.

    Source: Beckhoff InfoSys, __TRY; by hand.
    """
    body = (
        "__TRY\n__TRY P^ := 1; __CATCH(E) S := 'c'; A[5 + Z] := 1; __FINALLY S := CONCAT(S, 'f');\n"
        "__ENDTRY\n__CATCH(E2) S := CONCAT(S, 'C'); __ENDTRY"
    )
    program = _run(build, body)
    codes = [program.read(f"Main.{name}") for name in ("E", "E2")]
    assert codes == ["RTSEXCPT_ACCESS_VIOLATION", "RTSEXCPT_ARRAYBOUNDS"]
    assert program.read("Main.S") == "cfC"


@pytest.mark.parametrize(
    ("way", "expected"),
    [(0, "befbefbef"), (1, "bf"), (2, "bf"), (3, "bfbfbf"), (4, "bcfbcfbcf")],
)
def test_finally_runs_if_the_try_is_left(way: int, expected: str, build: Build) -> None:
    """__FINALLY also runs if RETURN, EXIT or CONTINUE leaves the __TRY.

    Source: Beckhoff InfoSys, __TRY: statements below __FINALLY.
    """
    assert _run(build, f"S := Early({way});").read("Main.S") == expected


def test_the_block_continues_in_the_next_scan(build: Build) -> None:
    """A block that was interrupted by an exception runs normally in the next scan.

    The divisor is 0 in the first scan and 5 in the second.
    """
    body = "W.Divisor := N; N := 5; __TRY W(); __CATCH I := I + 1; __ENDTRY"
    program = _run(build, body, scans=2)
    assert [program.read(f"Main.{name}") for name in ("I", "W.Result", "W.Done")] == [1, 20, 1]


@pytest.mark.parametrize(
    ("body", "message"),
    [
        ("I := 1;\nI := 1 / Z;", "divi"),
        (
            "__TRY\nF_RaiseException(E); __CATCH(E) F_RaiseException(E); __ENDTRY",
            "raises exception",
        ),
        ("__TRY\nWHILE TRUE DO I := 1; END_WHILE; __CATCH __ENDTRY", "this loop has not ended"),
    ],
)
def test_an_exception_that_is_not_caught_ends_the_run_with_its_line(
    body: str, message: str, build: Build
) -> None:
    """An exception outside of __TRY ends the run and is reported with its line.

    Source: Beckhoff InfoSys, F_RaiseException: outside of __TRY the controller stops.
    """
    with pytest.raises(InputError, match=message) as found:
        _run(build, body)
    line = f"{_BLOCKS}PROGRAM Main{_VARIABLES}".count("\n") + 2
    assert found.value.line == line


def test_coverage_counts_the_statements_that_ran(files_of: Callable[..., list[Path]]) -> None:
    """Coverage counts the statements of the __TRY up to the error, and those of the handler."""
    body = "__TRY\nI := 1;\nI := 1 / Z;\nN := 2;\n__CATCH(E)\nD := 1;\n__ENDTRY"
    collector = Collector()
    with counting(collector):
        files = files_of(f"{_BLOCKS}PROGRAM Main{_VARIABLES}{body}\nEND_PROGRAM\n")
        BuiltinProgram.build(load(files)).scan(0)
    counted = next(one for one in collector.counted if one.pou.name == "Main")
    ran = [
        counted.counts.counters[counted.plan.run[id(one)]] for one in statements(counted.pou.body)
    ]
    assert ran == [1, 1, 1, 0, 1]


def test_the_engine_matiec_refuses_try_by_its_name(project_of: Callable[..., Project]) -> None:
    """The engine matiec refuses __TRY with its line.

    Source: docs/reference/language.md.
    """
    project = project_of(
        "PROGRAM Main\nVAR I : INT; END_VAR\nI := 1;\n__TRY\nI := 2;\n__CATCH\nI := 3;\n__ENDTRY\n"
        "END_PROGRAM\n"
    )
    with pytest.raises(InputError, match="matiec does not take __TRY") as found:
        refuse(project.uses, "matiec")
    assert found.value.line == 4
