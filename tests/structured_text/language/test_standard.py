"""Functions and blocks of later editions give values calculated by hand, also at limits.

Source: IEC 61131-3:2013, tables 22 to 46; extensions of tools are marked.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import date, datetime, time, timedelta
from pathlib import Path
from typing import Any

import pytest

from structured_text.engines.builtin import BuiltinProgram
from structured_text.errors import InputError
from structured_text.language.load import load

Evaluate = Callable[..., list[Any]]
Errors = Callable[[str, str], list[InputError]]

_VARIABLES = """
  B : BOOL := TRUE; I : INT := -3; U : UINT := 1234; D : DINT := 100000; W : WORD := 16#1234;
  B9 : BYTE := 16#99; R : REAL := 2.5; LR : LREAL := -2.5; T1 : TIME := T#90s;
  LT1 : LTIME := LTIME#1500ns; S : STRING := 'abc'; WS : WSTRING := "a$20AC"; C : CHAR := 'A';
  WC : WCHAR := "$20AC"; DAY1 : DATE := D#2024-02-29; TOD1 : TOD := TOD#12:30:15.5;
  DT1 : DT := DT#2024-02-29-23:59:59; LDT1 : LDT := LDT#2024-02-29-00:00:00.000001;
  LTOD1 : LTOD := LTOD#01:00:00; LDAY1 : LDATE := LDATE#1970-01-02;
"""

_HALF = math.pi / 2

_ROWS = [
    # Overloaded conversions (table 22, feature 2) take the source type from the argument.
    ("INT", "TO_INT(R)", 2),
    ("INT", "TO_INT(LR)", -2),
    ("INT", "TO_INT(3.5)", 4),
    ("SINT", "TO_SINT(U)", -46),
    ("REAL", "TO_REAL(I)", -3.0),
    ("LREAL", "TO_LREAL(R)", 2.5),
    ("BOOL", "TO_BOOL(I)", True),
    ("WORD", "TO_WORD(I)", 0xFFFD),
    ("STRING", "TO_STRING(I)", "-3"),
    ("STRING", "TO_STRING(B)", "TRUE"),
    ("STRING", "TO_STRING(S)", "abc"),
    ("WSTRING", "TO_WSTRING(S)", "abc"),
    ("UINT", "TO_UINT('16#1F')", 31),
    ("TIME", "TO_TIME('T#1h')", timedelta(hours=1)),
    ("DATE", "TO_DATE(DT1)", date(2024, 2, 29)),
    ("LTIME", "TO_LTIME(T1)", timedelta(seconds=90)),
    ("INT", "TO_INT(IN := 7)", 7),
    # Truncation (table 22, features 3 and 4; TRUNC_INT is from CODESYS).
    ("DINT", "TRUNC(LR)", -2),
    ("DINT", "TRUNC_DINT(R)", 2),
    ("INT", "TRUNC_INT(R)", 2),
    ("INT", "REAL_TRUNC_INT(R)", 2),
    ("DINT", "LREAL_TRUNC_DINT(LR)", -2),
    ("SINT", "TRUNC_SINT(-2.9)", -2),
    # BCD (table 24).
    ("UINT", "WORD_BCD_TO_UINT(W)", 1234),
    ("USINT", "BYTE_BCD_TO_USINT(B9)", 99),
    ("INT", "BCD_TO_INT(W)", 1234),
    ("ULINT", "LWORD_BCD_TO_ULINT(LWORD#16#9999_9999_9999_9999)", 9_999_999_999_999_999),
    ("WORD", "UINT_TO_BCD_WORD(U)", 0x1234),
    ("BYTE", "USINT_TO_BCD_BYTE(USINT#42)", 0x42),
    ("DWORD", "TO_BCD_DWORD(U)", 0x1234),
    # Durations and dates (tables 25, 26, 35, 36).
    ("DT", "DATE_TO_DT(DAY1)", datetime(2024, 2, 29)),
    ("TIME", "TOD_TO_TIME(TOD1)", timedelta(hours=12, minutes=30, seconds=15.5)),
    ("TOD", "TIME_TO_TOD(T1)", time(0, 1, 30)),
    ("LDATE", "DT_TO_LDATE(DT1)", date(2024, 2, 29)),
    ("DATE", "LDT_TO_DATE(LDT1)", date(2024, 2, 29)),
    ("LTOD", "LDT_TO_LTOD(LDT1)", time(0, 0, 0, 1)),
    ("TOD", "LTOD_TO_TOD(LTOD1)", time(1)),
    ("DT", "LDT_TO_DT(LDT1)", datetime(2024, 2, 29, 0, 0, 0, 1)),
    ("TIME", "LTIME_TO_TIME(LT1)", timedelta(microseconds=1)),
    ("LTIME", "LINT_TO_LTIME(1000)", timedelta(microseconds=1)),
    ("TIME", "STRING_TO_TIME('T#1m30s')", timedelta(seconds=90)),
    ("TIME", "STRING_TO_TIME('5s')", timedelta(seconds=5)),
    ("TIME", "STRING_TO_TIME('soon')", timedelta(0)),
    ("DT", "STRING_TO_DT('DT#2024-02-29-00:00:00')", datetime(2024, 2, 29)),
    ("TOD", "ADD_TOD_TIME(TOD1, T1)", time(12, 31, 45, 500000)),
    ("DT", "ADD_DT_TIME(IN1 := DT1, IN2 := T#1s)", datetime(2024, 3, 1)),
    ("LTIME", "ADD_LTIME(LT1, LTIME#500ns)", timedelta(microseconds=2)),
    ("LDT", "ADD_LDT_LTIME(LDT1, LTIME#1us)", datetime(2024, 2, 29, 0, 0, 0, 2)),
    ("TIME", "SUB_DATE_DATE(D#2024-03-01, DAY1)", timedelta(days=1)),
    ("TOD", "SUB_TOD_TIME(TOD1, T#30m)", time(12, 0, 15, 500000)),
    ("TIME", "SUB_TOD_TOD(TOD1, TOD#12:00:00)", timedelta(minutes=30, seconds=15.5)),
    ("DT", "SUB_DT_TIME(DT1, T#59s)", datetime(2024, 2, 29, 23, 59)),
    ("TIME", "SUB_DT_DT(DT1, DT#2024-02-28-23:59:59)", timedelta(days=1)),
    ("LTIME", "SUB_LDATE_LDATE(LDAY1, LDATE#1970-01-01)", timedelta(days=1)),
    ("TIME", "MUL_TIME(T1, 2)", timedelta(minutes=3)),
    ("TIME", "DIV_TIME(T1, 4)", timedelta(seconds=22.5)),
    ("LTIME", "MUL_LTIME(LT1, R)", timedelta(microseconds=3)),
    ("LTIME", "DIV_LTIME(LT1, 3)", timedelta(0)),
    ("BOOL", "DIV_LTIME(LT1, 3) = LTIME#500ns", True),
    ("DT", "CONCAT_DATE_TOD(DAY1, TOD1)", datetime(2024, 2, 29, 12, 30, 15, 500000)),
    ("LDT", "CONCAT_DATE_LTOD(DAY1, LTOD1)", datetime(2024, 2, 29, 1)),
    ("DATE", "CONCAT_DATE(2024, 2, 29)", date(2024, 2, 29)),
    ("DATE", "CONCAT_DATE(YEAR := 1970, MONTH := 1, DAY := 1)", date(1970, 1, 1)),
    ("TOD", "CONCAT_TOD(23, 59, 59, 999)", time(23, 59, 59, 999000)),
    ("DT", "CONCAT_DT(2024, 2, 29, 12, 0, 0, 1)", datetime(2024, 2, 29, 12, 0, 0, 1000)),
    ("LDT", "CONCAT_LDT(2024, 2, 29, 12, 0, 0, 1)", datetime(2024, 2, 29, 12, 0, 0, 1000)),
    ("INT", "DAY_OF_WEEK(DAY1)", 4),
    ("INT", "DAY_OF_WEEK(D#2024-03-03)", 0),
    ("INT", "DAY_OF_WEEK(D#1970-01-01)", 4),
    # Characters (tables 23 and 34).
    ("STRING", "CHAR_TO_STRING(C)", "A"),
    ("CHAR", "STRING_TO_CHAR(S)", "a"),
    ("CHAR", "STRING_TO_CHAR('')", "\0"),
    ("BYTE", "CHAR_TO_BYTE(C)", 65),
    ("CHAR", "BYTE_TO_CHAR(16#7A)", "z"),
    ("WORD", "WCHAR_TO_WORD(WC)", 0x20AC),
    ("WCHAR", "WORD_TO_WCHAR(16#20AC)", "\u20ac"),
    ("CHAR", "WCHAR_TO_CHAR(WC)", "?"),
    ("WCHAR", "CHAR_TO_WCHAR(C)", "A"),
    ("STRING", "WSTRING_TO_STRING(WS)", "a?"),
    ("WSTRING", "STRING_TO_WSTRING(S)", "abc"),
    ("INT", "LEN(WS)", 2),
    ("WSTRING", 'CONCAT(WS, "x", WS)', "a\u20acxa\u20ac"),
    ("WSTRING", "RIGHT(WS, 1)", "\u20ac"),
    ("INT", 'FIND(WS, "$20AC")', 2),
    ("WSTRING", 'REPLACE(WS, "b", 1, 1)', "b\u20ac"),
    ("WSTRING", 'INSERT(WS, "-", 1)', "a-\u20ac"),
    ("WSTRING", "DELETE(WS, 1, 1)", "\u20ac"),
    ("BOOL", 'WS > "a"', True),
    ("CHAR", "SEL(B, CHAR#'x', C)", "A"),
    ("CHAR", "MAX(C, CHAR#'B')", "B"),
    # Pin names of CODESYS.
    ("STRING", "LEFT(STR := S, SIZE := 2)", "ab"),
    ("STRING", "MID(STR := S, LEN := 1, POS := 2)", "b"),
    ("STRING", "CONCAT(STR1 := S, STR2 := S)", "abcabc"),
    # Numbers.
    ("REAL", "ATAN2(REAL#1.0, REAL#0.0)", 1.5707963705062866),
    ("LREAL", "ATAN2(Y := 0.0, X := -1.0)", math.pi),
    ("LREAL", "ATAN2(LREAL#-1.0, LREAL#0.0)", -_HALF),
    ("LREAL", "ABS(LR)", 2.5),
    ("DINT", "ABS(IN := D)", 100000),
    ("DINT", "ADD(IN1 := D, IN2 := 1)", 100001),
    ("DINT", "MOVE(IN := D)", 100000),
    ("DINT", "MOD(IN1 := D, IN2 := 7)", 5),
    ("REAL", "EXPT(IN1 := R, IN2 := 2)", 6.25),
    ("LTIME", "MAX(LT1, LTIME#2us)", timedelta(microseconds=2)),
    ("LTIME", "LIMIT(LTIME#0s, LT1, LTIME#1us)", timedelta(microseconds=1)),
    ("DATE", "MUX(1, DAY1, D#2024-03-01)", date(2024, 3, 1)),
    ("BOOL", "LE(LTIME#0s, LT1, LTIME#1h)", True),
]


def test_a_function_gives_what_the_standard_says(evaluate: Evaluate) -> None:
    got = evaluate([(kind, code) for kind, code, _ in _ROWS], _VARIABLES)
    wrong = [
        (code, value, expected)
        for (_, code, expected), value in zip(_ROWS, got, strict=True)
        if (type(value), value) != (type(expected), expected)
    ]
    assert not wrong


_LENGTHS = [("USINT", "SIZEOF(BOOL)", 1), ("UDINT", "SIZEOF(LREAL)", 8),
            ("UDINT", "SIZEOF(A1)", 24), ("UDINT", "SIZEOF(Mixed)", 16),
            ("UDINT", "SIZEOF(M1)", 16), ("UDINT", "SIZEOF(S1)", 127),
            ("DINT", "LOWER_BOUND(A1, 1)", -1), ("DINT", "UPPER_BOUND(A1, 1)", 1),
            ("INT", "UPPER_BOUND(A1, 2)", 5)]  # fmt: skip


def test_sizes_and_bounds_are_constants(evaluate: Evaluate) -> None:
    before = "TYPE Mixed : STRUCT A : BYTE; L : LREAL; END_STRUCT; END_TYPE"
    variables = "A1 : ARRAY [-1..1, 2..5] OF INT; M1 : Mixed; S1 : STRING;"
    rows = [(kind, code) for kind, code, _ in _LENGTHS]
    assert evaluate(rows, variables, before) == [value for *_, value in _LENGTHS]


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("I := TO_INT(E);", "TO_INT is not defined for Words"),
        ("I := TO_INT();", "TO_INT takes 1 arguments, not 0"),
        ("I := TO_INT(OTHER := 1);", "TO_INT has no input OTHER"),
        ("D := DATE_TO_TOD(D);", "there is no function DATE_TO_TOD"),
        ("D := TO_DATE(C);", "TO_DATE is not defined for CHAR"),
        ("I := TRUNC_INT(S);", "a LREAL is expected here, not a STRING"),
        ("I := BCD_TO_INT(I);", "BCD_TO_INT is not defined for INT"),
        ("W := TO_BCD_WORD(R);", "TO_BCD_WORD is not defined for REAL"),
        ("R := ATAN2(1.0);", "ATAN2 takes 2 arguments, not 1"),
        ("I := SIZEOF(5);", "SIZEOF needs a variable"),
        ("I := UPPER_BOUND(I, 1);", "a INT has no bounds"),
        ("I := UPPER_BOUND(E, 2);", "the dimension must be a number from 1 to 1"),
        ("D := ADD_DT_TIME(D, T#1s);", "a DT is expected here, not a DATE"),
        ("D := CONCAT_DATE(2024, 2);", "CONCAT_DATE takes 3 arguments, not 2"),
        ("X := LEN(WS) > LEN(I);", "LEN is not defined for INT"),
        ("S := CONCAT(S, WS);", "is expected here, not a"),
        ("T2 := DIV_TIME(T2, 0);", "division by zero"),
    ],
)
def test_a_wrong_argument_is_refused(errors_of: Errors, statement: str, message: str) -> None:
    variables = (
        "I : INT; D : DATE; C : CHAR; S : STRING; WS : WSTRING; W : WORD; R : REAL; X : BOOL;"
        " E : ARRAY [1..2] OF WORD; T1 : TON; T2 : TIME;"
    )
    errors = errors_of(statement.replace("Words", "ARRAY"), variables)
    assert len(errors) == 1
    assert message.replace("Words", "ARRAY [1..2] OF WORD") in str(errors[0])


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("U := WORD_BCD_TO_UINT(W);", "16#1a is not a BCD number"),
        ("W := UINT_TO_BCD_WORD(U);", "10000 is not a number of 4 BCD digits"),
        ("D := CONCAT_DATE(2023, 2, N + 29);", "there is no date 2023-02-29"),
        ("T1 := CONCAT_TOD(N + 24, 0, 0, 0);", "there is no time of day 24:00:00.000"),
    ],
)
def test_a_missing_value_is_a_fault(tmp_path: Path, statement: str, message: str) -> None:
    file = tmp_path / "fault.st"
    variables = "W : WORD := 16#1A; U : UINT := 10000; D : DATE; T1 : TOD; N : INT;"
    file.write_text(f"PROGRAM P1 VAR {variables} END_VAR {statement} END_PROGRAM")
    program = BuiltinProgram.build(load([file]))
    with pytest.raises(InputError, match=message):
        program.scan(0)


def test_own_functions_win_over_those_of_the_third_edition(evaluate: Evaluate) -> None:
    before = (
        "FUNCTION TO_INT : INT VAR_INPUT A : INT; END_VAR TO_INT := A * 2; END_FUNCTION\n"
        "FUNCTION ATAN2 : INT VAR_INPUT A : INT; END_VAR ATAN2 := A + 1; END_FUNCTION\n"
        "TYPE LTIME : STRUCT A : INT; END_STRUCT; END_TYPE\n"
    )
    variables = "L : LTIME; WCHAR : INT := 5;"
    rows = [("INT", "TO_INT(3)"), ("INT", "ATAN2(3)"), ("INT", "L.A + WCHAR")]
    assert evaluate(rows, variables, before) == [6, 4, 5]


# --- blocks ---


def _trace(folder: Path, kind: str, inputs: list[dict[str, Any]], outputs: str) -> list[Any]:
    """Return the outputs after each scan of 10 ms. A pin keeps its value until it is set again."""
    file = folder / "block.st"
    file.write_text(f"PROGRAM P1 VAR B1 : {kind}; END_VAR B1(); END_PROGRAM")
    program = BuiltinProgram.build(load([file]))
    rows = []
    for k, values in enumerate(inputs):
        for pin, value in values.items():
            program.write(f"Main.B1.{pin}", value)
        program.scan(k * 10_000)
        rows.append(tuple(program.read(f"Main.B1.{pin}") for pin in outputs.split()))
    return rows


@pytest.mark.parametrize("kind", ["TON", "TON_TIME", "TON_LTIME", "LTON"])
def test_a_timer_is_the_same_by_each_of_its_names(kind: str, tmp_path: Path) -> None:
    inputs: list[dict[str, Any]] = [{"IN": True, "PT": "T#20ms"}, {}, {}, {"IN": False}]
    ms = [timedelta(milliseconds=k) for k in (0, 10, 20)]
    assert _trace(tmp_path, kind, inputs, "Q ET") == [
        (False, ms[0]),
        (False, ms[1]),
        (True, ms[2]),
        (False, ms[0]),
    ]


@pytest.mark.parametrize(
    ("kind", "levels"),
    [("TOF", "1111000"), ("LTOF", "1111000"), ("TP", "1110000"), ("LTP", "1110000")],
)
def test_tof_and_tp_and_their_long_variants_have_the_right_outputs(
    kind: str, levels: str, tmp_path: Path
) -> None:
    """The input is on for two scans of 10 ms."""
    inputs: list[dict[str, Any]] = [{"IN": True, "PT": "T#15ms"}, {}, {"IN": False}, {}, {}, {}, {}]
    if kind.endswith("P"):
        inputs[0]["PT"] = "T#25ms"
    rows = _trace(tmp_path, kind, inputs, "Q")
    assert "".join("1" if q else "0" for (q,) in rows) == levels


def test_an_own_ctu_has_its_own_pins(build: Callable[[str], BuiltinProgram]) -> None:
    """A user's block named CTU has its own pins. RESET means R only for the standard CTU."""
    program = build(
        "FUNCTION_BLOCK CTU_Own VAR_INPUT RESET : BOOL; END_VAR VAR_OUTPUT Q : BOOL; END_VAR\n"
        "Q := RESET;\nEND_FUNCTION_BLOCK\n"
        "PROGRAM P1 VAR A : CTU_Own; END_VAR\nA(RESET := TRUE);\nEND_PROGRAM\n"
    )
    program.scan(0)
    assert program.read("Main.A.Q") is True


@pytest.mark.parametrize(
    ("call", "pin", "value"),
    [
        ("SR : B1(SET1 := TRUE, RESET := TRUE);", "Q1", True),
        ("RS : B1(SET := TRUE, RESET1 := TRUE);", "Q1", False),
        ("SR : B1(S1 := FALSE, R := FALSE);", "Q1", False),
        ("CTU : B1(CU := TRUE, RESET := FALSE, PV := 5);", "CV", 1),
        ("CTD : B1(CD := FALSE, LOAD := TRUE, PV := 5);", "CV", 5),
        ("CTUD : B1(CU := FALSE, CD := FALSE, RESET := FALSE, LOAD := TRUE, PV := 7);", "CV", 7),
        ("CTU_ULINT : B1(CU := TRUE, RESET := FALSE, PV := 5);", "CV", 1),
    ],
)
def test_a_pin_has_two_names(call: str, pin: str, value: Any, tmp_path: Path) -> None:
    kind, _, statement = call.partition(" : ")
    file = tmp_path / "pins.st"
    file.write_text(f"PROGRAM P1 VAR B1 : {kind}; END_VAR {statement} END_PROGRAM")
    program = BuiltinProgram.build(load([file]))
    program.scan(0)
    assert program.read(f"Main.B1.{pin}") == value
