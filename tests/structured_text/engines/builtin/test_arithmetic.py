"""Arithmetic and conversions, with values worked out by hand."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram

Run = Callable[..., Any]


@pytest.mark.parametrize(
    ("kind", "low", "high"),
    [
        ("SINT", -128, 127),
        ("INT", -32768, 32767),
        ("DINT", -(2**31), 2**31 - 1),
        ("LINT", -(2**63), 2**63 - 1),
        ("USINT", 0, 255),
        ("UINT", 0, 65535),
        ("UDINT", 0, 2**32 - 1),
        ("ULINT", 0, 2**64 - 1),
    ],
)
def test_integers_wrap_around_at_both_ends(run: Run, kind: str, low: int, high: int) -> None:
    values = run(
        f"Top : {kind} := {high}; Bottom : {kind} := {low}; Square : {kind} := {high};",
        "Top := Top + 1; Bottom := Bottom - 1; Square := Square * Square;",
        "Top Bottom Square",
    )

    assert values == (low, high, 1)


def test_an_intermediate_result_has_its_type_too(run: Run) -> None:
    assert run(
        "A : UINT := 3; B : UINT := 5; Less : BOOL; Half : UINT; I : INT := 32767; Q : INT;",
        "Less := A - B > 60000; Half := (A - B) / 2; Q := (I + 1) / 2;",
        "Less Half Q",
    ) == (True, 32767, -16384)


def test_the_elapsed_part_of_a_wrapped_counter_is_right(run: Run) -> None:
    variables = "Now : UINT := 4; Start : UINT := 65530; Gone : UINT;"

    assert run(variables, "Gone := Now - Start;", "Gone") == 10


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


def test_the_least_integer_divided_by_minus_one_wraps(run: Run) -> None:
    assert run("A : INT := -32768; B : INT := -1;", "A := A / B;", "A") == -32768


def test_modulo_zero_is_zero_as_the_standard_says(run: Run) -> None:
    assert run(
        "A : INT := 7; B : INT; U : UINT := 7; V : UINT;", "A := A MOD B; U := U MOD V;", "A U"
    ) == (0, 0)


def test_a_number_without_a_type_takes_that_of_what_it_is_calculated_with(run: Run) -> None:
    """Also in a comparison, where nothing else says which; 32767 + 1 wraps as INT."""
    assert run(
        "I : INT := 32767; T1 : TIME := T#2s; B, C, D : BOOL;",
        "B := 1 + I = -32768; C := -1 < 2 * I + 1; D := MAX(1, I) = I;",
        "B C D",
    ) == (True, False, True)


def test_real_is_single_and_lreal_double_precision(run: Run) -> None:
    single, double, large = run(
        "A : REAL := 0.1; B : REAL := 0.2; L : LREAL := 0.1; M : LREAL := 0.2;"
        "C : REAL := 16777216.0;",
        "A := A + B; L := L + M; C := C + REAL#1.0;",
        "A L C",
    )

    assert single == 0.30000001192092896
    assert double == 0.30000000000000004
    assert large == 16777216.0


def test_precedence_is_that_of_the_standard(run: Run) -> None:
    assert run(
        "I : INT; B : BOOL; C : BOOL; R : REAL; D : BOOL;",
        "I := 2 + 3 * 4 - 10 / 5; B := TRUE OR FALSE AND FALSE; C := 1 + 1 = 2 AND NOT FALSE;\n"
        "R := -2.0 ** 2.0; D := TRUE XOR TRUE AND FALSE;",
        "I B C R D",
    ) == (12, True, True, 4.0, True)


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
def test_a_literal_means_what_the_standard_says(
    run: Run, literal: str, kind: str, value: Any
) -> None:
    assert run(f"X : {kind}; Y : {kind} := {literal};", f"X := {literal};", "X Y") == (value, value)


@pytest.mark.parametrize(
    ("conversion", "kind", "value", "result"),
    [
        ("INT_TO_SINT", "SINT", "300", 44),
        ("INT_TO_UINT", "UINT", "-1", 65535),
        ("DINT_TO_INT", "INT", "40000", -25536),
        ("WORD_TO_INT", "INT", "16#FFFF", -1),
        ("INT_TO_WORD", "WORD", "-2", 0xFFFE),
        ("SINT_TO_DWORD", "DWORD", "-1", 0xFFFFFFFF),
        ("BOOL_TO_INT", "INT", "TRUE", 1),
        ("INT_TO_BOOL", "BOOL", "256", True),
        ("WORD_TO_BOOL", "BOOL", "0", False),
        ("INT_TO_REAL", "REAL", "-3", -3.0),
        ("DINT_TO_REAL", "REAL", "16777217", 16777216.0),
        ("REAL_TO_INT", "INT", "2.4", 2),
        ("REAL_TO_INT", "INT", "-2.6", -3),
        ("REAL_TO_INT", "INT", "2.5", 2),
        ("REAL_TO_INT", "INT", "3.5", 4),
        ("LREAL_TO_REAL", "REAL", "0.1", 0.10000000149011612),
        ("DINT_TO_STRING", "STRING", "-12", "-12"),
        ("WORD_TO_STRING", "STRING", "255", "16#ff"),
        ("BOOL_TO_STRING", "STRING", "TRUE", "TRUE"),
        ("REAL_TO_STRING", "STRING", "1.5", "1.5"),
        ("TIME_TO_STRING", "STRING", "T#61s500ms", "T#0d0h1m1s500ms"),
        ("STRING_TO_INT", "INT", "'-12'", -12),
        ("STRING_TO_DINT", "DINT", "'16#1F'", 31),
        ("STRING_TO_REAL", "REAL", "'2.5'", 2.5),
        ("STRING_TO_BOOL", "BOOL", "'true'", True),
        ("DT_TO_STRING", "STRING", "DT#2024-02-29-13:30:00", "DT#2024-02-29-13:30:00"),
    ],
)
def test_a_conversion_gives_what_fits_the_target(
    run: Run, conversion: str, kind: str, value: str, result: Any
) -> None:
    source = conversion.split("_TO_")[0]
    assert run(f"A : {source} := {value}; X : {kind};", f"X := {conversion}(A);", "X") == result


@pytest.mark.parametrize("depth", [1, 29, 30, 59, 60, 61, 150])
def test_code_in_more_brackets_than_lines_of_python_take_has_its_value(
    run: Run, depth: int
) -> None:
    code = "(" * depth + "X" + " + X)" * depth
    assert run("X : DINT := 3; Y : DINT;", f"Y := {code};", "Y") == 3 * (depth + 1)


def test_trunc_cuts_towards_zero(run: Run) -> None:
    assert run(
        "A : REAL := -2.9; I : INT; D : DINT;", "I := TRUNC(A); D := TRUNC(2.9);", "I D"
    ) == (-2, 2)


def test_bit_strings_are_combined_bit_by_bit(run: Run) -> None:
    assert run(
        "A : WORD := 16#F0F0; B : WORD := 16#FF00; C : WORD; D : WORD; E : WORD; F : WORD;",
        "C := A AND B; D := A OR B; E := A XOR B; F := NOT A;",
        "C D E F",
    ) == (0xF000, 0xFFF0, 0x0FF0, 0x0F0F)


def test_shifts_fill_with_zero_and_rotations_keep_all_bits(run: Run) -> None:
    assert run(
        "A : WORD := 16#8001; N : INT := 4; C : WORD; D : WORD; E : WORD; F : WORD; G : WORD;",
        "C := SHL(A, 1); D := SHR(A, N); E := ROL(A, N); F := ROR(A, 1); G := SHL(A, 16);",
        "C D E F G",
    ) == (0x0002, 0x0800, 0x0018, 0xC000, 0)


def test_durations_are_added_scaled_and_compared(run: Run) -> None:
    assert run(
        "A : TIME := T#1s; N : INT := 3; S1, D, M, Q1, H : TIME; L : BOOL;",
        "S1 := A + T#250ms; D := T#250ms - A; M := A * N; Q1 := A / 4; L := D < T#0s;H := A * 0.5;",
        "S1 D M Q1 L H",
    ) == (
        timedelta(milliseconds=1250),
        timedelta(milliseconds=-750),
        timedelta(seconds=3),
        timedelta(milliseconds=250),
        True,
        timedelta(milliseconds=500),
    )


def test_a_number_without_a_type_may_stand_on_either_side_of_a_comparison(run: Run) -> None:
    variables = "X : INT := 7; R : REAL := 0.5; A, B, C, D : BOOL;"
    body = "A := 5 < X; B := X < 5; C := 1.5 > R; D := R > 1.5;"
    assert run(variables, body, "A B C D") == (True, False, True, False)


def test_a_part_of_a_duration_is_cut_to_whole_nanoseconds(run: Run) -> None:
    """Half of one is none, also 4000 times; as matiec does."""
    body = "FOR I := 1 TO 4000 DO S1 := S1 + A * F; Q1 := Q1 + A / G; END_FOR;"
    variables = "A : TIME := T#1ms; F : REAL := 5.0E-7; G : REAL := 2.0E6; S1, Q1 : TIME; I : INT;"
    assert run(variables, body, "S1 Q1") == (timedelta(0), timedelta(0))


@pytest.mark.parametrize(
    ("call", "kind", "value"),
    [
        ("ABS(-5)", "INT", 5),
        ("SQRT(REAL#2.25)", "REAL", 1.5),
        ("MAX(3, 9, 5)", "INT", 9),
        ("MIN(T#3s, T#2s)", "TIME", timedelta(seconds=2)),
        ("LIMIT(0, -4, 10)", "INT", 0),
        ("LIMIT(MN := 0, IN := 14, MX := 10)", "INT", 10),
        ("LIMIT(0.0, 4.5, 2.5)", "REAL", 2.5),
        ("LIMIT(0.0, -4.5, 2.5)", "LREAL", 0.0),
        ("MAX(0.5, 2.5, 1.5)", "REAL", 2.5),
        ("MIN(2.5, 0.5, 1.5)", "LREAL", 0.5),
        ("SEL(TRUE, 1, 2)", "INT", 2),
        ("SEL(FALSE, 1.5, 2.5)", "REAL", 1.5),
        ("MUX(2, 0.5, 1.5, 2.5)", "REAL", 2.5),
        ("MUL(0.5, 3.0, 4.0)", "LREAL", 6.0),
        ("MUX(1, 'a', 'b', 'c')", "STRING", "b"),
        ("ADD(1, 2, 3)", "INT", 6),
        ("EXPT(LREAL#2.0, 10)", "LREAL", 1024.0),
        ("GT(3, 2, 1)", "BOOL", True),
        ("NE('a', 'b')", "BOOL", True),
        ("XOR(TRUE, TRUE, TRUE)", "BOOL", True),
        ("AND(BYTE#16#FC, BYTE#16#3F)", "BYTE", 0x3C),
        ("LEN('abc')", "INT", 3),
        ("LEFT('abc', 2)", "STRING", "ab"),
        ("RIGHT('abc', 2)", "STRING", "bc"),
        ("MID('abcde', 2, 3)", "STRING", "cd"),
        ("CONCAT('a', 'b', 'c')", "STRING", "abc"),
        ("INSERT('abc', 'X', 1)", "STRING", "aXbc"),
        ("DELETE('abcde', 2, 2)", "STRING", "ade"),
        ("REPLACE('abcde', 'XY', 2, 2)", "STRING", "aXYde"),
        ("FIND('abcd', 'cd')", "INT", 3),
        ("MOVE(7)", "INT", 7),
    ],
)
def test_a_standard_function_gives_what_the_standard_says(
    run: Run, call: str, kind: str, value: Any
) -> None:
    assert run(f"X : {kind};", f"X := {call};", "X") == value


def test_a_string_is_cut_at_126_characters(build: Callable[[str], BuiltinProgram]) -> None:
    program = build(
        "PROGRAM P1\nVAR S1 : STRING := 'ab'; END_VAR\nS1 := CONCAT(S1, S1);\nEND_PROGRAM"
    )
    for k in range(10):
        program.scan(k)

    assert program.read("Main.S1") == "ab" * 63
