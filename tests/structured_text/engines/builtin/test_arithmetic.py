"""Arithmetic and conversions give values that were calculated by hand."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram

Run = Callable[..., Any]


@pytest.mark.parametrize(
    ("a", "b", "quotient", "rest"),
    [(7, 2, 3, 1), (-7, 2, -3, -1), (7, -2, -3, 1), (-7, -2, 3, -1), (6, 3, 2, 0)],
)
def test_division_cuts_towards_zero_and_the_rest_has_the_sign_of_the_dividend(
    run: Run, a: int, b: int, quotient: int, rest: int
) -> None:
    assert run(
        f"A : INT := {a}; B : INT := {b}; Q1 : INT; R1 : INT;",
        "Q1 := A / B; R1 := A MOD B;",
        "Q1 R1",
    ) == (quotient, rest)


@pytest.mark.parametrize(
    ("a", "b", "quotient", "rest"),
    [(7, 2, 3, 1), (-7, 2, -3, -1), (7, -2, -3, 1), (-7, -2, 3, -1), (-6, 3, -2, 0)],
)
def test_numbers_without_a_type_are_divided_in_the_same_way(
    run: Run, a: int, b: int, quotient: int, rest: int
) -> None:
    body = f"Q1 := {a} / ({b}); R1 := {a} MOD ({b}); S1 := 1 + {a} / ({b}) * 2;"
    found = run("Q1, R1 : INT; S1 : DINT;", body, "Q1 R1 S1")
    assert found == (quotient, rest, 1 + 2 * quotient)


@pytest.mark.parametrize(
    ("variables", "body", "want", "values"),
    [
        pytest.param("A : INT := 7; B : INT; U : UINT := 7; V : UINT;",
                     "A := A MOD B; U := U MOD V;", "A U", (0, 0), id="modulo 0 is 0"),
        # If a comparison has only INT operands, the sum is an INT, too: 32767 + 1 wraps.
        pytest.param("I : INT := 32767; T1 : TIME := T#2s; B, C, D : BOOL;",
                     "B := 1 + I = -32768; C := -1 < 2 * I + 1; D := MAX(1, I) = I;",
                     "B C D", (True, False, True), id="an untyped number has the other's type"),
        pytest.param("X : INT := 7; R : REAL := 0.5; A, B, C, D : BOOL;",
                     "A := 5 < X; B := X < 5; C := 1.5 > R; D := R > 1.5;",
                     "A B C D", (True, False, True, False), id="an untyped number on either side"),
        pytest.param("I : INT; B : BOOL; C : BOOL; R : REAL; D : BOOL;",
                     "I := 2 + 3 * 4 - 10 / 5; B := TRUE OR FALSE AND FALSE; R := -2.0 ** 2.0;"
                     "C := 1 + 1 = 2 AND NOT FALSE; D := TRUE XOR TRUE AND FALSE;",
                     "I B C R D", (12, True, True, 4.0, True), id="precedence"),
        pytest.param("A : WORD := 16#F0F0; B : WORD := 16#FF00; C, D, E, F : WORD;",
                     "C := A AND B; D := A OR B; E := A XOR B; F := NOT A;",
                     "C D E F", (0xF000, 0xFFF0, 0x0FF0, 0x0F0F), id="bit by bit"),
        # A fraction of a nanosecond is dropped in each of 4000 additions, as in matiec.
        pytest.param("A : TIME := T#1ms; F : REAL := 5.0E-7; G : REAL := 2.0E6; S1, Q1 : TIME;"
                     "I : INT;",
                     "FOR I := 1 TO 4000 DO S1 := S1 + A * F; Q1 := Q1 + A / G; END_FOR;",
                     "S1 Q1", (timedelta(0), timedelta(0)), id="durations are whole nanoseconds"),
    ],
)  # fmt: skip
def test_an_expression_has_the_values_of_the_standard(
    run: Run, variables: str, body: str, want: str, values: tuple[Any, ...]
) -> None:
    assert run(variables, body, want) == values


@pytest.mark.parametrize(
    ("literal", "kind", "value"),
    [
        ("16#FF_FF", "WORD", 65535),
        ("2#1010_0101", "BYTE", 0xA5),
        ("8#17", "INT", 15),
        ("1_000", "INT", 1000),
        ("INT#-5", "INT", -5),
        ("WORD#16#00ff", "WORD", 255),
        ("-32768", "INT", -32768),
        ("BOOL#1", "BOOL", True),
        ("1.5E-3", "LREAL", 0.0015),
        ("REAL#0.1", "REAL", 0.10000000149011612),
        ("T#1s500ms", "TIME", timedelta(seconds=1.5)),
        ("T#1.5s", "TIME", timedelta(seconds=1.5)),
        ("time#-1d2h3m4s5.5ms", "TIME", -timedelta(1, 4, 5500, 0, 3, 2)),
        ("T#90m", "TIME", timedelta(minutes=90)),
        ("'it$'s $4100$$'", "STRING", "it's A00$"),
        ("''", "STRING", ""),
    ],
)
def test_a_literal_has_its_standard_value(run: Run, literal: str, kind: str, value: Any) -> None:
    assert run(f"X : {kind}; Y : {kind} := {literal};", f"X := {literal};", "X Y") == (value, value)


@pytest.mark.parametrize(
    ("conversion", "kind", "value", "result"),
    [
        ("INT_TO_UINT", "UINT", "-1", 65535),
        ("INT_TO_WORD", "WORD", "-2", 0xFFFE),
        ("SINT_TO_DWORD", "DWORD", "-1", 0xFFFFFFFF),
        ("WORD_TO_BOOL", "BOOL", "0", False),
        ("DINT_TO_STRING", "STRING", "-12", "-12"),
        ("REAL_TO_STRING", "STRING", "1.5", "1.5"),
        ("TIME_TO_STRING", "STRING", "T#61s500ms", "T#0d0h1m1s500ms"),
        ("STRING_TO_DINT", "DINT", "'16#1F'", 31),
        ("STRING_TO_BOOL", "BOOL", "'true'", True),
        ("DT_TO_STRING", "STRING", "DT#2024-02-29-13:30:00", "DT#2024-02-29-13:30:00"),
    ],
)
def test_a_conversion_gives_the_calculated_value(
    run: Run, conversion: str, kind: str, value: str, result: Any
) -> None:
    """A conversion gives the value that was calculated by hand.

    These conversions are not in `standard_table`.
    """
    source = conversion.split("_TO_")[0]
    assert run(f"A : {source} := {value}; X : {kind};", f"X := {conversion}(A);", "X") == result


@pytest.mark.parametrize("depth", [1, 29, 30, 59, 60, 61, 150])
def test_code_in_many_brackets_has_its_value(run: Run, depth: int) -> None:
    code = "(" * depth + "X" + " + X)" * depth
    assert run("X : DINT := 3; Y : DINT;", f"Y := {code};", "Y") == 3 * (depth + 1)


@pytest.mark.parametrize(
    ("call", "kind", "value"),
    [
        ("LIMIT(0.0, 4.5, 2.5)", "REAL", 2.5),
        ("LIMIT(0.0, -4.5, 2.5)", "LREAL", 0.0),
        ("MAX(0.5, 2.5, 1.5)", "REAL", 2.5),
        ("MIN(2.5, 0.5, 1.5)", "LREAL", 0.5),
        ("SEL(FALSE, 1.5, 2.5)", "REAL", 1.5),
        ("MUX(2, 0.5, 1.5, 2.5)", "REAL", 2.5),
        ("MUL(0.5, 3.0, 4.0)", "LREAL", 6.0),
        ("MUX(1, 'a', 'b', 'c')", "STRING", "b"),
        ("ADD(1, 2, 3)", "INT", 6),
        ("TRUNC(2.9)", "DINT", 2),
        ("NE('a', 'b')", "BOOL", True),
        ("MOVE(7)", "INT", 7),
    ],
)
def test_functions_take_untyped_numbers(run: Run, call: str, kind: str, value: Any) -> None:
    """Standard functions such as LIMIT and MUX accept untyped numbers.

    `standard_table` has the other functions with untyped numbers.
    """
    assert run(f"X : {kind};", f"X := {call};", "X") == value


def test_a_string_is_cut_at_126_characters(build: Callable[[str], BuiltinProgram]) -> None:
    source = "PROGRAM P1 VAR S1 : STRING := 'ab'; END_VAR S1 := CONCAT(S1, S1); END_PROGRAM"
    program = build(source)
    for k in range(10):
        program.scan(k)
    assert program.read("Main.S1") == "ab" * 63
