"""Long and deeply nested programs run as written, or are refused with the line and a remedy."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_float
from pathlib import Path
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.engines.builtin.collector import Collector
from structured_text.errors import InputError
from structured_text.language.load import load

Run = Callable[..., Any]
_TERMS = 2_000
_F1 = "FUNCTION F1 : DINT\nVAR_INPUT V : DINT; END_VAR\n  F1 := V + 1;\nEND_FUNCTION"


def _nested(opening: str, core: str, closing: str, depth: int) -> str:
    return opening * depth + core + closing * depth


@pytest.mark.exhaustive(but=["((((((((((((-0", "-(-(-(-(-(-(-", "ADD(X, X, X,-", "F1(F1(F1(F1(-",
                             "ABS(ABS(ABS(-1", "ABS(ABS(ABS(-0", "A[A[A[A[A[A[-",
                             "M * M * M * -"])  # fmt: skip
@pytest.mark.parametrize(
    ("expression", "value"),
    [
        (" + ".join(["X"] * 9_999), 3 * 9_999),
        (" - ".join(["X"] * _TERMS), 3 - 3 * (_TERMS - 1)),
        (" * ".join(["M"] * _TERMS), 1),
        (" + ".join(["X * 2 - X"] * 1_000), 3_000),
        (" MOD ".join(["X"] + ["H"] * _TERMS), 3),
        (_nested("(", "X", ")", _TERMS), 3),
        (_nested("(X + ", "X", ")", _TERMS), 3 * (_TERMS + 1)),
        (_nested("(", "X", " + X)", _TERMS), 3 * (_TERMS + 1)),
        (_nested("-(", "X", ")", _TERMS), 3),
        (_nested("F1(", "X", ")", 1_000), 1_003),
        (_nested("ABS(", "M", ")", 1_000), 1),
        (_nested("ABS(", "-7", ")", 1_000), 7),
        (_nested("MAX(X, ", "M", ")", 1_000), 3),
        (_nested("SEL(TRUE, M, ", "X", ")", 1_000), 3),
        (f"ADD({', '.join(['X'] * _TERMS)})", 3 * _TERMS),
        (_nested("A[", "1", "]", 1_000), 1),
    ],
    ids=lambda given: given[:12] if isinstance(given, str) else "",
)
def test_a_long_number_has_the_value_of_its_parts(run: Run, expression: str, value: int) -> None:
    variables = "X : DINT := 3; M : DINT := -1; H : DINT := 5; Y : DINT;"
    variables += " A : ARRAY [0..1] OF DINT := [0, 1];"
    assert run(variables, f"Y := {expression};", "Y", _F1) == value


@pytest.mark.exhaustive
def test_a_long_sum_of_reals_is_rounded_after_each_term_from_the_left(run: Run) -> None:
    value = 0.1
    for _ in range(_TERMS):
        value = c_float(c_float(value).value + c_float(0.1).value).value
    terms = " + ".join(["R"] * (_TERMS + 1))
    added = f"ADD({', '.join(['R'] * (_TERMS + 1))})"
    variables = "R : REAL := 0.1; S : REAL; T1 : REAL;"
    assert run(variables, f"S := {terms};\nT1 := {added};", "S T1") == (value, value)


@pytest.mark.exhaustive(but=["FALSE-NOT (NOT (NO-"])
@pytest.mark.parametrize(
    ("last", "expression", "value"),
    [
        ("TRUE", " AND ".join([*["B"] * _TERMS, "L"]), True),
        ("FALSE", " AND ".join([*["B"] * _TERMS, "L"]), False),
        ("TRUE", " OR ".join([*["N"] * _TERMS, "L"]), True),
        ("FALSE", " XOR ".join([*["B"] * _TERMS, "L"]), False),
        ("TRUE", " = ".join([*["B"] * _TERMS, "L"]), True),
        ("FALSE", _nested("NOT (", "L", ")", _TERMS + 1), True),
        ("TRUE", " AND ".join([*["K > 1"] * _TERMS, "L"]), True),
    ],
    ids=lambda given: given[:12] if isinstance(given, str) else "",
)
def test_a_long_condition_has_the_value_of_its_parts(
    run: Run, last: str, expression: str, value: bool
) -> None:
    variables = f"B : BOOL := TRUE; N : BOOL; L : BOOL := {last}; K : INT := 2; Y : BOOL; Z : BOOL;"
    body = f"Y := {expression};\nIF {expression} THEN Z := TRUE; END_IF;\n"
    body += f"WHILE {expression} DO Z := TRUE; EXIT; END_WHILE;"
    assert run(variables, body, "Y Z") == (value, value)


@pytest.mark.exhaustive
def test_a_long_condition_is_evaluated_only_until_its_value_is_known(run: Run) -> None:
    """After a FALSE, the other operands of AND are not evaluated, as in a short condition."""
    guarded = " AND ".join(["I <= 2", *["A[I] = 0"] * 500])
    variables = "A : ARRAY [1..2] OF INT; I : INT := 3; Y : BOOL := TRUE;"
    assert run(variables, f"Y := {guarded};", "Y") is False


def test_a_fault_inside_a_long_expression_has_its_line(tmp_path: Path) -> None:
    file = tmp_path / "program.st"
    terms = " + ".join([*["X"] * 400, "1 / Z", *["X"] * 400])
    file.write_text(
        f"PROGRAM P1\nVAR X, Y, Z : INT; END_VAR\n  X := 1;\n  Y := {terms};\nEND_PROGRAM\n"
    )
    with pytest.raises(InputError, match="division by zero") as error:
        BuiltinProgram.build(load([file])).scan(0)
    assert (error.value.file, error.value.line) == (str(file), 4)


@pytest.mark.exhaustive(but=["case-500", "case-0", "case-50"])
@pytest.mark.parametrize("chosen", [0, 50, 499, 500])
@pytest.mark.parametrize("form", ["elsif", "case"])
def test_only_the_branch_that_fits_runs(run: Run, form: str, chosen: int) -> None:
    bodies = [f"Y := {k}; N := N + 1;" for k in range(500)]
    if form == "case":
        body = "CASE X OF\n" + "\n".join(f"{k}: {text}" for k, text in enumerate(bodies))
    else:
        tests = [f"X = {k} OR (X > 5000 AND X = 0) THEN {text}" for k, text in enumerate(bodies)]
        body = "IF " + "\nELSIF ".join(tests)
    body += f"\nELSE Y := -1; N := N + 1;\nEND_{'CASE' if form == 'case' else 'IF'};"
    variables = f"X : INT := {chosen}; Y : INT; N : INT;"
    assert run(variables, body, "Y N") == (chosen if chosen < 500 else -1, 1)


def test_only_the_first_branch_that_fits_runs(run: Run) -> None:
    tests = [f"X = {k} THEN X := 150; N := N + 1;" for k in range(300)]
    body = "IF " + "\nELSIF ".join(tests) + "\nEND_IF;"
    assert run("X : INT := 7; N : INT;", body, "X N") == (150, 1)


@pytest.mark.exhaustive
def test_many_statements_variables_labels_and_comments_are_taken(run: Run) -> None:
    variables = "".join(f"V{k} : INT;\n" for k in range(3_000)) + "X : INT; Y : INT;"
    labels = ", ".join(map(str, range(3_000)))
    body = "(* " + "long " * 20_000 + "*)\n" + "X := X + 1;\n" * 3_000
    body += f"V2999 := X;\nCASE X - 1 OF {labels}: Y := 1; END_CASE;"
    assert run(variables, body, "V2999 Y") == (3_000, 1)


@pytest.mark.exhaustive
def test_a_long_list_of_initial_values_is_taken(run: Run) -> None:
    values = ", ".join(str(k % 100) for k in range(6_000))
    before = "TYPE Big : ARRAY [0..5999] OF INT; END_TYPE"
    assert run(f"A : Big := [{values}]; X : INT;", "X := A[5999];", "X", before) == 99


_PROGRAM = "PROGRAM P1\nVAR X, Y : DINT; C : BOOL; {more} END_VAR\n{body}\nEND_PROGRAM\n"
_COUNTERS = " ".join(f"I{k} : INT;" for k in range(17))
_FORS = "\n".join(f"FOR I{k} := 0 TO 1 DO" for k in range(17))
_TOO_DEEP = [
    ("IF C THEN\n" * 65 + "X := 1;" + " END_IF;" * 65, "64 statements", 67),
    ("IF C THEN X := 1; ELSE\n" * 65 + "X := 1;" + " END_IF;" * 65, "64 statements", 66),
    ("CASE X OF 1:\n" * 65 + "X := 1;" + " END_CASE;" * 65, "64 statements", 67),
    ("WHILE C DO\n" * 17 + "X := 1;" + " END_WHILE;" * 17, "16 loops", 20),
    ("REPEAT\n" * 17 + "X := 1;" + " UNTIL C END_REPEAT;" * 17, "16 loops", 20),
    (_FORS + "\nX := 1;" + " END_FOR;" * 17, "16 loops", 20),
    ("\nX := " + " + ".join(["Y"] * 11_000) + ";", "10,000 operators", 4),
    ("\nX := " + "(Y + " * 11_000 + "Y" + ")" * 11_000 + ";", "10,000 operators", 4),
    ("\nX := " + "-(" * 52_000 + "Y" + ")" * 52_000 + ";", "too many operators", 4),
    ("X := 16#" + "F" * 5_000 + ";", "the literal has 5003 characters", 3),
    ("X := " + " * ".join(["999999999"] * 900) + ";", "constant expression is too large", 3),
]


@pytest.mark.exhaustive(but=["check-body4-16 loops-20", "check-body3-16 loops-20",
                             "check-body9-the literal has 5003 characters-3",
                             "check-body5-16 loops-20", "run-body3-16 loops-20",
                             "run-body9-the literal has 5003 characters-3", "run-body4-16 loops-20",
                             "run-body5-16 loops-20", "check-body0-64 statements-67",
                             "run-body0-64 statements-67", "check-body1-64 statements-66",
                             "run-body2-64 statements-67", "check-body2-64 statements-67",
                             "check-body10-constant expression is too large-3"])  # fmt: skip
@pytest.mark.parametrize(("body", "message", "line"), _TOO_DEEP)
@pytest.mark.parametrize("command", ["check", "run"])
def test_too_deep_a_program_is_refused_with_its_line(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    command: str,
    body: str,
    message: str,
    line: int,
) -> None:
    file, lib = tmp_path / "deep.st", tmp_path / "lib"
    lib.mkdir()
    file.write_text(_PROGRAM.format(body=body, more=_COUNTERS))
    options = ["--engine", "builtin"] if command == "run" else []
    app = pytest.importorskip("rcx_harness.cli.app")
    assert app.main([command, str(file), "--lib", str(lib), *options]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert f"{file}:{line}" in said
    assert len(said) < 700


def test_a_program_at_the_limit_of_depth_runs(run: Run) -> None:
    inner = "WHILE C DO\n" * 16 + "X := X + 1; C := FALSE;" + " END_WHILE;" * 16
    body = "IF B THEN\n" * 47 + inner + " END_IF;" * 47
    assert run("X : INT; B : BOOL := TRUE; C : BOOL := TRUE;", body, "X") == 1


def _in_a_row(kind: str, number: int) -> str:
    if kind == "FUNCTION":
        bodies = ["B0 := V;", *(f"B{k} := B{k - 1}(V);" for k in range(1, number))]
        heads = [f"FUNCTION B{k} : INT\nVAR_INPUT V : INT; END_VAR\n" for k in range(number)]
        every = [f"{head}{body}\nEND_FUNCTION\n" for head, body in zip(heads, bodies, strict=True)]
        return "".join(every) + f"PROGRAM P1\nVAR X : INT; END_VAR\nX := B{number - 1}(1);\n"
    if kind == "FUNCTION_BLOCK":
        first = "FUNCTION_BLOCK B0\nVAR Q : INT; END_VAR\nQ := Q + 1;\nEND_FUNCTION_BLOCK\n"
        every = [
            f"FUNCTION_BLOCK B{k}\nVAR I1 : B{k - 1}; END_VAR\nI1();\nEND_FUNCTION_BLOCK\n"
            for k in range(1, number)
        ]
    elif kind == "ARRAY":
        first = "TYPE B0 : INT; END_TYPE\n"
        every = [f"TYPE B{k} : ARRAY [0..0] OF B{k - 1}; END_TYPE\n" for k in range(1, number)]
    else:
        first = "TYPE B0 : INT; END_TYPE\n"
        more = "G : B0; " if kind == "STRUCT and INT" else ""
        every = [
            f"TYPE B{k} : STRUCT F : B{k - 1}; {more}END_STRUCT; END_TYPE\n"
            for k in range(1, number)
        ]
    use = "I1();" if kind == "FUNCTION_BLOCK" else "X := 1;"
    last = f"PROGRAM P1\nVAR I1 : B{number - 1}; X : INT; END_VAR\n{use}\n"
    return "".join([first, *every, last])


@pytest.mark.exhaustive
@pytest.mark.parametrize(
    "kind", ["FUNCTION", "FUNCTION_BLOCK", "ARRAY", "STRUCT", "STRUCT and INT"]
)
def test_declarations_may_use_each_other_up_to_the_limit(tmp_path: Path, kind: str) -> None:
    file = tmp_path / "row.st"
    file.write_text(_in_a_row(kind, 99) + "END_PROGRAM\n")
    program = BuiltinProgram.build(load([file]))
    program.scan(0)
    program.restore(program.snapshot())
    assert list(program.walk())
    for number in (100, 3_000):
        file.write_text(_in_a_row(kind, number) + "END_PROGRAM\n")
        with pytest.raises(InputError, match="more than 100 types, functions and blocks"):
            load([file])


@pytest.mark.exhaustive
def test_the_order_of_declarations_does_not_change_the_depth_limit(tmp_path: Path) -> None:
    file = tmp_path / "row.st"
    types = [f"TYPE B{k} : ARRAY [0..0] OF B{k - 1}; END_TYPE\n" for k in range(3_000, 0, -1)]
    program = "PROGRAM P1\nVAR X : INT; END_VAR\nX := 1;\nEND_PROGRAM\n"
    file.write_text("".join(types) + "TYPE B0 : INT; END_TYPE\n" + program)
    with pytest.raises(InputError, match="more than 100 types, functions and blocks"):
        load([file])


def test_coverage_counts_a_long_decision(tmp_path: Path) -> None:
    file = tmp_path / "program.st"
    condition = " AND ".join(["B"] * 2_000)
    branches = "".join(f"ELSIF X = {k} THEN X := -1;\n" for k in range(120))
    body = f"IF {condition} THEN X := 7;\nEND_IF;\nIF NOT B THEN X := 1;\n{branches}END_IF;\n"
    file.write_text(f"PROGRAM P1\nVAR X : INT; B : BOOL := TRUE; END_VAR\n{body}END_PROGRAM\n")
    collector = Collector()
    program = BuiltinProgram.build(load([file]), collector)
    program.scan(0)
    assert program.read("Main.X") == -1
    (counted,) = collector.counted
    assert list(counted.counts.seen[0]) == [(1 << 2_000) - 1]
