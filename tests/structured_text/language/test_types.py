"""Elementary types of the third edition have the standard's literals and conversions.

Source: IEC 61131-3:2013, tables 5 to 9 (literals), table 10 (elementary types), figure 12 (implicit
conversions).
"""

from __future__ import annotations

from collections.abc import Callable
from datetime import date, datetime, time, timedelta
from typing import Any

import pytest

from structured_text.errors import InputError
from structured_text.language.widening import common, widening

Evaluate = Callable[..., list[Any]]
Errors = Callable[[str, str], list[InputError]]

_S, _MS, _US = 1_000_000_000, 1_000_000, 1_000

_LITERALS = [("LTIME", "LTIME#1s2ms3us4ns", timedelta(seconds=1, milliseconds=2, microseconds=3)),
             ("LTIME", "LT#-1us", timedelta(microseconds=-1)),
             ("LTIME", "ltime#5d14h12m18s3.5ms", timedelta(5, 18, 500, 3, 12, 14)),
             ("LTIME", "T#1s", timedelta(seconds=1)),
             ("TIME", "TIME#5us", timedelta(microseconds=5)),
             ("LDATE", "LDATE#2024-02-29", date(2024, 2, 29)),
             ("LDATE", "LD#1970-01-02", date(1970, 1, 2)), ("DATE", "D#2024-2-9", date(2024, 2, 9)),
             ("LTOD", "LTOD#15:36:55.360227", time(15, 36, 55, 360227)),
             ("LTOD", "LTIME_OF_DAY#23:59:59", time(23, 59, 59)),
             ("TOD", "TOD#12:30", time(12, 30)),
             ("LDT", "LDT#1984-06-25-15:36:55.360227", datetime(1984, 6, 25, 15, 36, 55, 360227)),
             ("LDT", "LDATE_AND_TIME#2024-01-01-00:00:00", datetime(2024, 1, 1)),
             ("STRING", "STRING#'OK'", "OK"),
             ("STRING", "'$'a$24b$0Ac$R$T$P$L$N$$'", "'a$b\nc\r\t\f\n\n$"),
             ("WSTRING", '"ab$00E4$"$N"', 'ab\u00e4"\n'),
             ("WSTRING", "WSTRING#'a$20AC'", "a\u20ac"), ("CHAR", "'A'", "A"),
             ("CHAR", "CHAR#'$41'", "A"), ("WCHAR", 'WCHAR#"$20AC"', "\u20ac"),
             ("WCHAR", '"B"', "B"), ("REAL", "1E3", 1000.0), ("LREAL", "LREAL#1e-3", 0.001),
             ("LREAL", "LREAL#2", 2.0), ("ULINT", "ULINT#16#FFFF_FFFF_FFFF_FFFF", 2**64 - 1),
             ("LINT", "LINT#-9_223_372_036_854_775_808", -(2**63)), ("LWORD", "LWORD#2#1", 1),
             ("BOOL", "BOOL#0", False), ("SINT", "SINT#-128", -128)]  # fmt: skip


def test_a_literal_has_the_value_of_its_type(evaluate: Evaluate) -> None:
    got = evaluate([(kind, text) for kind, text, _ in _LITERALS])
    wrong = [
        (text, value, expected)
        for (_, text, expected), value in zip(_LITERALS, got, strict=True)
        if (type(value), value) != (type(expected), expected)
    ]
    assert not wrong


_NOTHING = {"LTIME": timedelta(0), "LDATE": date(1970, 1, 1), "LTOD": time(0),
            "LDT": datetime(1970, 1, 1), "WSTRING": "", "CHAR": "\0", "WCHAR": "\0"}  # fmt: skip


def test_a_variable_begins_with_what_the_standard_gives_its_type(evaluate: Evaluate) -> None:
    declared = " ".join(f"V{kind} : {kind};" for kind in _NOTHING)
    assert evaluate([(kind, f"V{kind}") for kind in _NOTHING], declared) == list(_NOTHING.values())


@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("T1 := LTIME#1s;", "a TIME is expected here, not a LTIME"),
        ("L := LTIME#1h1d;", "is not a duration"),
        ("L := LTIME#1xs;", "is not a duration"),
        ("C := 'ab';", "a CHAR is expected here, not a STRING"),
        ("C := CHAR#'ab';", "is not one character"),
        ("C := CHAR#5;", "is not a text"),
        ('S := "wide";', "a STRING is expected here, not a WSTRING"),
        ("W := 'narrow';", 'write "text"'),
        ('S := STRING#"a";', "needs single quotes"),
        ('W := "never closed;', "this string is never closed"),
        ('W := "$4g";', "is not an escape"),
        ("C := 5;", "a CHAR is expected here, not the number 5"),
        ("L := 5;", "write a duration"),
        ("C := C + C;", "+ is not defined for CHAR"),
        ("L := L * L;", "is not defined for LTIME"),
        ("I := R;", "convert it with REAL_TO_INT"),
        ("I := LI;", "convert it with LINT_TO_INT"),
        ("B := W1;", "convert it with WORD_TO_BYTE"),
        ("I := D + I;", "convert it with DINT_TO_INT"),
        ("I := I * D;", "convert it with DINT_TO_INT"),
        ("I := I + R;", "convert it with REAL_TO_INT"),
        ("X := LI > UL;", "no integer type has room for both a LINT and a ULINT"),
        ("I := S;", "convert it with STRING_TO_INT"),
        ("S := I;", "convert it with INT_TO_STRING"),
        ("T1 := L;", "convert it with LTIME_TO_TIME"),
    ],
)
def test_a_wrong_type_is_refused(errors_of: Errors, statement: str, message: str) -> None:
    variables = (
        "T1 : TIME; L : LTIME; C : CHAR; S : STRING; W : WSTRING; I : INT; D : DINT; R : REAL;"
        " LI : LINT; UL : ULINT; B : BYTE; W1 : WORD; X : BOOL; U : UINT;"
    )
    error, *_ = errors_of(statement, variables)
    assert message in str(error)
    assert error.line == 3


#: Figure 12 of the standard: each type with the types to which it converts implicitly, directly or
#: through others.
_FIGURE = {"SINT": "INT DINT LINT REAL LREAL", "INT": "DINT LINT REAL LREAL", "DINT": "LINT LREAL",
           "USINT": "UINT UDINT ULINT INT DINT LINT REAL LREAL",
           "UINT": "UDINT ULINT DINT LINT REAL LREAL", "UDINT": "ULINT LINT LREAL", "REAL": "LREAL",
           "BOOL": "BYTE WORD DWORD LWORD", "BYTE": "WORD DWORD LWORD", "WORD": "DWORD LWORD",
           "DWORD": "LWORD", "TIME": "LTIME", "DATE": "LDATE", "TOD": "LTOD", "DT": "LDT",
           "CHAR": "STRING", "WCHAR": "WSTRING"}  # fmt: skip
_INTEGERS = ["SINT", "INT", "DINT", "LINT", "USINT", "UINT", "UDINT", "ULINT"]
_BITS = ["BYTE", "WORD", "DWORD", "LWORD"]
_ALL = [
    *_INTEGERS,
    *_BITS,
    *["BOOL", "REAL", "LREAL", "TIME", "LTIME", "DATE", "LDATE", "TOD", "LTOD", "DT", "LDT"],
    *["STRING", "WSTRING", "CHAR", "WCHAR"],
]
#: Conversions beyond the figure: between numbers and bit patterns of at least their width, to
#: another sign if no bit is lost, and from any number to REAL.
_WIDTH = dict(zip((*_INTEGERS, *_BITS), (8, 16, 32, 64) * 3, strict=True))


@pytest.mark.parametrize("source", _ALL)
def test_exactly_the_conversions_of_figure_12_count_as_standard(source: str) -> None:
    found = [kind for kind in _ALL if widening(source, kind) == "standard"]
    assert sorted(found) == sorted(_FIGURE.get(source, "").split())


@pytest.mark.parametrize("source", _ALL)
def test_conversions_beyond_figure_12_lose_bits_only_in_a_real(source: str) -> None:
    found = {kind for kind in _ALL if widening(source, kind) == "vendor"}
    expected = set()
    if source in _WIDTH:
        expected = {kind for kind, width in _WIDTH.items() if width >= _WIDTH[source]} - {source}
        expected |= {"REAL", "LREAL"}
    elif source == "LREAL":
        expected = {"REAL"}
    expected -= set(_FIGURE.get(source, "").split())
    assert found == expected


@pytest.mark.parametrize(
    ("one", "other", "expected"),
    [
        ("SINT", "DINT", "DINT"),
        ("USINT", "UDINT", "UDINT"),
        ("INT", "USINT", "INT"),
        ("SINT", "USINT", "INT"),
        ("INT", "UINT", "DINT"),
        ("SINT", "UINT", "DINT"),
        ("DINT", "UDINT", "LINT"),
        ("LINT", "ULINT", ""),
        ("SINT", "ULINT", ""),
        ("LINT", "UDINT", "LINT"),
        ("INT", "REAL", "REAL"),
        ("DINT", "REAL", "REAL"),
        ("ULINT", "LREAL", "LREAL"),
        ("REAL", "LREAL", "LREAL"),
        ("BYTE", "WORD", "WORD"),
        ("BOOL", "BYTE", "BYTE"),
        ("WORD", "INT", "DINT"),
        ("WORD", "UINT", "UINT"),
        ("BYTE", "INT", "INT"),
        ("DWORD", "REAL", "REAL"),
        ("TIME", "LTIME", "LTIME"),
        ("CHAR", "STRING", "STRING"),
        ("BOOL", "INT", ""),
        ("TIME", "INT", ""),
        ("STRING", "WSTRING", ""),
        ("DATE", "DT", ""),
    ],
)
def test_two_numeric_types_have_a_common_type(one: str, other: str, expected: str) -> None:
    assert common(one, other) == common(other, one) == expected


_VARIABLES = """
  SI : SINT := -1; I : INT := -300; D : DINT := 16777217; LI : LINT := -5;
  US : USINT := 200; U : UINT := 65535; UD : UDINT := 4000000000; UL : ULINT := 10;
  B : BYTE := 255; W : WORD := 16#FFFF; DW : DWORD := 16#FFFF_FFFF; X : BOOL := TRUE;
  R : REAL := 0.5; LR : LREAL := 0.1; T1 : TIME := T#1s; LT1 : LTIME := LTIME#1us; C : CHAR := 'c';
  S : STRING := 'ab'; DT1 : DT := DT#2024-02-29-12:00:00;
  LDT1 : LDT := LDT#2024-02-29-12:00:01; TOD1 : TOD := TOD#12:00:00; I7 : INT := 7; U3 : UINT := 3;
"""

_MIXED = [
    # Widening keeps the value; a change of sign keeps the bits.
    ("DINT", "I", -300),
    ("LINT", "UD", 4000000000),
    ("REAL", "I", -300.0),
    ("REAL", "D", 16777216.0),
    ("LREAL", "D", 16777217.0),
    ("LREAL", "R", 0.5),
    ("REAL", "LR", 0.10000000149011612),
    ("UINT", "I", 65236),
    ("INT", "U", -1),
    ("INT", "W", -1),
    ("WORD", "I", 0xFED4),
    ("DWORD", "SI", 0xFFFF_FFFF),
    ("DINT", "W", 65535),
    ("REAL", "B", 255.0),
    ("WORD", "X", 1),
    ("STRING", "C", "c"),
    ("LTIME", "T1", timedelta(seconds=1)),
    ("LDT", "DT1", datetime(2024, 2, 29, 12)),
    ("REAL", "1", 1.0),
    ("LREAL", "REAL#0.1", 0.10000000149011612),
    ("DINT", "INT#-5", -5),
    ("REAL", "DINT#16777217", 16777216.0),
    ("LREAL", "DINT#16777217", 16777217.0),
    # The operation is calculated in the common type.
    ("DINT", "I + U", 65235),
    ("INT", "I + U", -301),
    ("UINT", "I + U", 65235),
    ("INT", "I7 / U3", 2),
    ("INT", "I / U3", -100),
    ("INT", "I MOD U3", 0),
    ("LINT", "D * UD", 67108868000000000),
    ("REAL", "I * R", -150.0),
    ("REAL", "I7 * 1.5", 10.5),
    ("LREAL", "I7 * 1.5", 10.5),
    ("REAL", "I7 / 2", 3.0),
    ("LREAL", "R + LR", 0.6),
    ("DINT", "US + SI", 199),
    ("INT", "US + 100", 44),
    ("INT", "US + 300", 500),
    # The operation has its own type, before it is converted to the type of the target.
    ("DINT", "I7 * 20000", 140000 - 2 * 65536),
    # Bit strings are treated as unsigned integers.
    ("BYTE", "B + 1", 0),
    ("WORD", "W - 1", 0xFFFE),
    ("DWORD", "B * W", 65535 * 255 - 254 * 65536),
    ("WORD", "W / 2", 0x7FFF),
    ("UINT", "-W", 1),
    ("USINT", "-B", 1),
    # Integers are treated as bit patterns.
    ("INT", "I AND 16#FF", 0xD4),
    ("INT", "NOT I", 299),
    ("SINT", "SI XOR SI", 0),
    ("DINT", "D OR I", -299),
    ("WORD", "W AND I", 0xFED4),
    ("UINT", "U XOR 1", 65534),
    # Comparisons use the common type.
    ("BOOL", "I < U", True),
    ("BOOL", "U = W", True),
    ("BOOL", "W > I", True),
    ("BOOL", "SI < US", True),
    ("BOOL", "US < 300", True),
    ("BOOL", "U > -1", True),
    ("BOOL", "R > LR", True),
    ("BOOL", "I7 > 6.5", True),
    ("BOOL", "T1 > LT1", True),
    ("BOOL", "S > C", False),
    ("BOOL", "C = 'c'", True),
    # Durations and dates.
    ("LTIME", "T1 + LT1", timedelta(seconds=1, microseconds=1)),
    ("LTIME", "LT1 * 3", timedelta(microseconds=3)),
    ("LTIME", "LT1 * 2.5", timedelta(microseconds=2)),
    ("TIME", "2 * T1", timedelta(seconds=2)),
    ("TIME", "T1 * W", timedelta(seconds=65535)),
    ("LTIME", "LDT1 - DT1", timedelta(seconds=1)),
    ("LDT", "DT1 + LT1", datetime(2024, 2, 29, 12, 0, 0, 1)),
    ("DT", "DT1 + T1", datetime(2024, 2, 29, 12, 0, 1)),
    ("TIME", "TOD1 - TOD#11:00:00", timedelta(hours=1)),
    ("TOD", "TOD1 - T1", time(11, 59, 59)),
    # Functions.
    ("DINT", "MAX(I, U)", 65535),
    ("REAL", "MIN(I, R)", -300.0),
    ("LREAL", "LIMIT(0, R, LR)", 0.1),
    ("LREAL", "MAX(I7, 7.5)", 7.5),
    ("LREAL", "MAX(I7, 1.5)", 7.0),
    ("INT", "SEL(X, 1, I)", -300),
    ("REAL", "SQRT(U3 + 1)", 2.0),
    ("LREAL", "SQRT(16)", 4.0),
    ("BOOL", "SQRT(2) > 1.4", True),
    ("REAL", "EXPT(2.0, U3)", 8.0),
    ("LREAL", "EXPT(2, I7)", 128.0),
    ("LREAL", "I7 ** 2", 49.0),
    ("INT", "SHL(I7, 2)", 28),
    ("INT", "SHR(I, 2)", -75),
    ("UINT", "SHR(U, 15)", 1),
    ("WORD", "SHL(W, US - 196)", 0xFFF0),
    ("DWORD", "SHL(1, 31)", 1 << 31),
    ("USINT", "ROL(US, 1)", 145),
    ("BOOL", "GT(U, U3, I)", True),
    ("DINT", "ADD(I, U, D)", 16842452),
    ("STRING", "CONCAT(S, C, S)", "abcab"),
    ("INT", "FIND(S, 'b')", 2),
]


def test_mixed_types_are_calculated_in_their_common_type(evaluate: Evaluate) -> None:
    got = evaluate([(kind, code) for kind, code, _ in _MIXED], _VARIABLES)
    wrong = [
        (code, value, expected)
        for (_, code, expected), value in zip(_MIXED, got, strict=True)
        if (type(value), value) != (type(expected), expected)
    ]
    assert not wrong


def test_the_nanoseconds_of_an_ltime_count(evaluate: Evaluate) -> None:
    variables = "A : LTIME := LTIME#1s2ms3us4ns; B : LDT := LDT#1970-01-01-00:00:01.000000002;"
    rows = [("LINT", "LTIME_TO_LINT(A)"), ("BOOL", "A > LTIME#1s2ms3us3ns"),
            ("LINT", "TO_LINT(A - LTIME#1s)"), ("ULINT", "LDT_TO_ULINT(B)"),
            ("STRING", "LTIME_TO_STRING(A)"), ("LINT", "TO_LINT(A / 2)")]  # fmt: skip
    assert evaluate(rows, variables) == [_S + 2 * _MS + 3 * _US + 4, True, 2 * _MS + 3 * _US + 4,
                                         _S + 2, "LT#0d0h0m1s2.003004ms", 501_001_502]  # fmt: skip
