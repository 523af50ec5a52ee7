"""Constructs beyond the portable subset are accepted, and noted by name."""

from __future__ import annotations

from pathlib import Path

import pytest

from structured_text.engines.load import build
from structured_text.engines.matiec.build import Matiec
from structured_text.language.load import load
from structured_text.language.portability import lint

_VARIABLES = (
    "I : INT; J : INT; D : DINT; U : UINT; W : WORD; R : REAL; L : LREAL; B : BOOL; T1 : TIME;"
    " S1 : STRING; N : SR; Day : DATE; Clock : TOD; Stamp : DT;"
)
_CONVERSION = "an implicit conversion"
_FUNCTION = "a standard function beyond the second edition"
_RARE = "a standard function of dates or BCD"
_TYPE = "a type of the third edition"


def _noted(tmp_path: Path, statement: str, variables: str = "") -> list[tuple[str, int, str]]:
    file = tmp_path / "loose.st"
    file.write_text(f"PROGRAM P1\nVAR {_VARIABLES} {variables} END_VAR\n{statement}\nEND_PROGRAM\n")
    return [(one.construct, one.at.line, one.detail) for one in load([file]).uses]


@pytest.mark.parametrize(
    ("statement", "construct", "detail"),
    [
        ("D := I;", _CONVERSION, "a INT where a DINT is expected: write INT_TO_DINT"),
        ("R := I;", _CONVERSION, "a INT where a REAL is expected: write INT_TO_REAL"),
        ("L := R;", _CONVERSION, "a REAL where a LREAL is expected: write REAL_TO_LREAL"),
        ("W := I;", _CONVERSION, "a INT where a WORD is expected: write INT_TO_WORD"),
        ("I := W;", _CONVERSION, "a WORD where a INT is expected: write WORD_TO_INT"),
        ("U := I;", _CONVERSION, "a INT where a UINT is expected: write INT_TO_UINT"),
        ("D := INT#5;", _CONVERSION, "a INT where a DINT is expected: write INT_TO_DINT"),
        ("R := 1;", _CONVERSION, "1 where a REAL is expected: write 1.0"),
        ("R := SQRT(I);", _CONVERSION, "a INT where a REAL is expected: write INT_TO_REAL"),
        ("I := DINT_TO_INT(I);", _CONVERSION, "a INT where a DINT is expected: write INT_TO_DINT"),
        ("B := I = D;", _CONVERSION, "a INT where a DINT is expected: write INT_TO_DINT"),
        ("I := SHL(I, 1);", "a bitwise operation of integers", "SHL of a INT"),
        ("I := I AND 3;", "a bitwise operation of integers", "AND of a INT"),
        ("I := NOT I;", "a bitwise operation of integers", "NOT of a INT"),
        ("U := W + WORD#1;", "arithmetic of bit strings", "+ of a WORD"),
        ("T1 := 2 * T1;", "a number times a duration", "write the TIME first"),
        ("I := TO_INT(R);", _FUNCTION, "TO_INT"),
        ("I := TRUNC_INT(R);", _FUNCTION, "TRUNC_INT"),
        ("R := ATAN2(R, R);", _FUNCTION, "ATAN2"),
        ("U := WORD_BCD_TO_UINT(W);", _RARE, "WORD_BCD_TO_UINT"),
        ("W := TO_BCD_WORD(U);", _FUNCTION, "TO_BCD_WORD"),
        ("Stamp := CONCAT_DATE_TOD(Day, Clock);", _RARE, "CONCAT_DATE_TOD"),
        ("T1 := STRING_TO_TIME(S1);", _FUNCTION, "STRING_TO_TIME"),
        ("B := T1 > LTIME#1us;", _TYPE, "LTIME"),
        ('I := LEN("wide");', _TYPE, "WSTRING"),
        ("N(SET1 := TRUE);", "another name of a pin", "SET1 is S1"),
        ("B := LEFT(STR := S1, SIZE := 1) = 'a';", "another name of a pin", "STR is IN"),
    ],
)
def test_a_construct_that_is_not_portable_is_noted(
    tmp_path: Path, statement: str, construct: str, detail: str
) -> None:
    assert (construct, 3, detail) in _noted(tmp_path, statement)


@pytest.mark.parametrize(
    "kind", ["LTIME", "LDATE", "LTOD", "LDT", "WSTRING", "CHAR", "WCHAR", "LTIME_OF_DAY"]
)
def test_a_type_of_the_third_edition_is_noted_by_its_name(tmp_path: Path, kind: str) -> None:
    ((construct, line, detail),) = _noted(tmp_path, "I := 1;", f"X : {kind};")
    assert (construct, line) == (_TYPE, 2)
    assert detail in (kind, "LTOD")


def test_a_block_of_the_third_edition_is_noted(tmp_path: Path) -> None:
    assert _noted(tmp_path, "X(IN := TRUE);", "X : LTON;") == [
        ("a standard block of the third edition", 2, "LTON")
    ]


_ADDER = """\
FUNCTION_BLOCK Adder
METHOD Sum : INT
  VAR_INPUT A, B : INT; END_VAR
  Sum := A + B;
END_METHOD
END_FUNCTION_BLOCK
"""
_HALF = """\
FUNCTION Half
  VAR_INPUT A : INT; END_VAR
  VAR_OUTPUT Q : INT; END_VAR
  Q := A / 2;
END_FUNCTION
"""
_METHOD = ("a METHOD", "")
_BOTH = ("named and positional arguments together", "")
_NO_RESULT = [
    ("a function without a result", ""),
    ("a section in another place", ""),
    ("a function with VAR_OUTPUT or VAR_IN_OUT", ""),
]


@pytest.mark.parametrize(
    ("before", "variable", "statement", "noted"),
    [
        ("", "X : LTIME;", "X := LTIME();", [(_TYPE, "LTIME"), ("the time as a function", "")]),
        (_ADDER, "F : Adder;", "I := F.Sum(1, B := 2);", [_METHOD, _BOTH]),
        (_ADDER, "F : Adder;", "I := F.Sum(A := 1, B := 2);", [_METHOD]),
        (_ADDER, "F : Adder;", "I := F.Sum(1, 2);", [_METHOD]),
        (_HALF, "", "Half(A := 4, Q => I);", _NO_RESULT),
    ],
)
def test_only_the_constructs_of_the_statement_are_noted(
    tmp_path: Path, before: str, variable: str, statement: str, noted: list[tuple[str, str]]
) -> None:
    """Only the listed constructs are noted.

    A function without a result gets no second note about its result.
    """
    file = tmp_path / "loose.st"
    program = f"PROGRAM P1\nVAR I : INT; {variable} END_VAR\n{statement}\nEND_PROGRAM\n"
    file.write_text(before + program)
    assert [(one.construct, one.detail) for one in load([file]).uses] == noted


@pytest.mark.parametrize(
    "statement",
    [
        "D := INT_TO_DINT(I) + 1;",
        "R := INT_TO_REAL(I) * 2.0;",
        "W := SHL(W, I) AND 16#FF;",
        "I := TRUNC(R) + LEN(S1) + 7 / 2;",
        "T1 := T1 * 2 + T#1s; B := T1 > T#1s AND NOT B;",
        "S1 := CONCAT(LEFT(S1, 2), 'a', INT_TO_STRING(I));",
        "L := MAX(L, 1.5) ** 2; D := MUX(I, D, 5);",
        "N(S1 := B, R := FALSE);",
    ],
)
def test_portable_statements_are_not_noted(tmp_path: Path, statement: str) -> None:
    assert _noted(tmp_path, statement) == []


@pytest.mark.exhaustive
def test_the_library_has_nothing_that_is_not_portable() -> None:
    plc = Path(__file__).parents[3] / "plc"
    program = plc / "examples"
    example = next(iter(sorted(program.glob("01*/*.st"))))
    files = [*sorted((plc / "lib").rglob("*.st")), *sorted(example.parent.glob("*.st"))]
    assert load(files).uses == ()


def test_matiec_runs_functions_of_the_second_edition(tmp_path: Path, matiec: Matiec) -> None:
    """Functions for dates and BCD are part of the second edition, so matiec runs them."""
    del matiec
    file = tmp_path / "rare.st"
    file.write_text(
        "PROGRAM P1\nVAR W : WORD := 16#42; U : UINT; END_VAR\n"
        "U := WORD_BCD_TO_UINT(W);\nEND_PROGRAM\n"
    )
    built = build([file])
    built.program.scan(0)
    assert (built.program.engine, built.program.read("Main.U")) == ("matiec", 42)


def test_auto_says_why_it_does_without_matiec(tmp_path: Path, matiec: Matiec) -> None:
    del matiec
    file = tmp_path / "loose.st"
    file.write_text("PROGRAM P1\nVAR L : LTIME; END_VAR\nL := LTIME#1us;\nEND_PROGRAM\n")
    built = build([file])
    assert built.program.engine == "builtin"
    assert "a type of the third edition" in built.notice


@pytest.mark.parametrize(
    ("variable", "name"),
    [
        ("X : LTIME;", "LTIME came with the third edition"),
        ("X : WSTRING;", "WSTRING came with the third edition"),
        ("X : TIME := LT#1s;", "LTIME came with the third edition"),
        ('X : STRING := "a";', "WSTRING came with the third edition"),
        ("X : TIME := T#5us;", "T#5us: write a TIME with one whole number and unit"),
        ("X : DATE := D#2024-2-9;", "D#2024-2-9: write each number of a date"),
        ("X : TOD := TOD#12:30;", "TOD#12:30: write each number of a date"),
    ],
)
def test_the_lint_of_a_single_file_also_names_the_construct(
    tmp_path: Path, variable: str, name: str
) -> None:
    """`rcx check --lint` also names these constructs, although it does not check types."""
    file = tmp_path / "one.st"
    file.write_text(f"PROGRAM P1\n  VAR\n    {variable}\n  END_VAR\n  X := X;\nEND_PROGRAM\n")
    assert any(name in str(one) for one in lint([file], binding=True))


def test_the_dates_of_the_second_edition_are_portable(tmp_path: Path) -> None:
    file = tmp_path / "dates.st"
    initial = "DT#2024-02-29-12:00:00.5"
    file.write_text(
        f"PROGRAM P1\n  VAR\n    X : DT := {initial};\n  END_VAR\n  X := X;\nEND_PROGRAM\n"
    )
    assert lint([file], binding=True) == []
