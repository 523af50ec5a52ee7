"""CASE of texts, conversions of durations to dates, and arrays of open length are supported."""

from __future__ import annotations

from collections.abc import Callable
from datetime import date, datetime, timedelta

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError

Build = Callable[..., BuiltinProgram]
Mistakes = Callable[..., list[InputError]]


@pytest.mark.parametrize(
    ("text", "result"), [("a", 1), ("b", 2), ("cc", 2), ("c", 3), ("", 3), ("B", 3)]
)
def test_a_case_of_texts_compares_whole_texts(text: str, result: int, build: Build) -> None:
    program = build(
        f"PROGRAM Main VAR S : STRING := '{text}'; N : INT; END_VAR "
        "CASE S OF 'a': N := 1; 'b', 'cc': N := 2; ELSE N := 3; END_CASE; END_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.N") == result


def test_a_case_of_characters_may_have_ranges(build: Build) -> None:
    program = build(
        "PROGRAM Main VAR C : CHAR := CHAR#'c'; N : INT; M : INT; END_VAR "
        "CASE C OF 'a'..'c': N := 1; 'd': N := 2; END_CASE; "
        "CASE C OF 'd'..'z', 'a': M := 1; END_CASE; END_PROGRAM"
    )
    program.scan(0)
    assert (program.read("Main.N"), program.read("Main.M")) == (1, 0)


def test_a_case_of_texts_calls_no_function_several_times(mistakes_of: Mistakes) -> None:
    (error,) = mistakes_of(
        "PROGRAM Main VAR N : INT; END_VAR CASE LEFT('ab', 1) OF 'a': N := 1; END_CASE; END_PROGRAM"
    )
    assert (error.message, error.hint) == (
        "a CASE of texts needs a variable",
        "assign the result to a variable first",
    )


def test_a_duration_becomes_a_date_counted_from_1970(build: Build) -> None:
    """Durations of 90 s and 25 h become dates counted from 1970-01-01.

    Source: help of CODESYS, "TIME_TO_DT".
    """
    program = build(
        "PROGRAM Main VAR D : DT; T : TIME; A : DATE; U : TIME; END_VAR D := TO_DT(T#90s); "
        "T := DT_TO_TIME(D); A := TIME_TO_DATE(T#25h); U := DATE_TO_TIME(A); END_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.D") == datetime(1970, 1, 1, 0, 1, 30)
    assert program.read("Main.T") == timedelta(seconds=90)
    assert program.read("Main.A") == date(1970, 1, 2)
    assert program.read("Main.U") == timedelta(days=1)


def test_an_array_of_open_length_is_passed_on_to_another_function(build: Build) -> None:
    program = build(
        "FUNCTION F1 : INT VAR_IN_OUT L : ARRAY [*] OF INT; END_VAR F1 := L[2]; END_FUNCTION\n"
        "FUNCTION F2 : INT VAR_INPUT L : ARRAY [*] OF INT; END_VAR F2 := F1(L) * 2; END_FUNCTION\n"
        "PROGRAM Main VAR L : ARRAY [1..2] OF INT := [3, 4]; N : INT; END_VAR "
        "N := F2(L); END_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.N") == 8


def test_globals_of_a_configuration_may_follow_its_tasks(build: Build) -> None:
    program = build(
        "PROGRAM Main VAR_EXTERNAL G1 : INT; END_VAR VAR N : INT; END_VAR N := G1; END_PROGRAM\n"
        "CONFIGURATION C TASK T1(INTERVAL := T#10ms, PRIORITY := 1); PROGRAM P1 WITH T1 : Main; "
        "VAR_GLOBAL G1 : INT := 5; END_VAR END_CONFIGURATION"
    )
    program.scan(0)
    assert program.read("P1.N") == 5


def test_a_block_may_be_called_like_a_word_of_other_languages(build: Build) -> None:
    program = build(
        "FUNCTION_BLOCK Transition VAR_OUTPUT Q : INT; END_VAR Q := 7; END_FUNCTION_BLOCK\n"
        "PROGRAM Main VAR T : Transition; N : INT; END_VAR T(); N := T.Q; END_PROGRAM"
    )
    program.scan(0)
    assert program.read("Main.N") == 7
