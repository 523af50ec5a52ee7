"""The front end reports each error with its line.

Each case has one error in a program that is otherwise correct.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from mistakes import check
from structured_text.errors import InputError

Errors = Callable[..., list[InputError]]

_FRAME = """\
TYPE Colour : (RED, GREEN, BLUE); END_TYPE
TYPE Mood : (CALM, BLUE_MOOD); END_TYPE
TYPE Words : ARRAY [1..4] OF WORD; END_TYPE
TYPE Grid : ARRAY [0..1, 0..2] OF INT; END_TYPE
TYPE Pair : STRUCT First : INT; Second : INT; END_STRUCT; END_TYPE
FUNCTION Twice : INT VAR_INPUT Value : INT; END_VAR Twice := Value * 2; END_FUNCTION
FUNCTION_BLOCK Step1
  VAR_IN_OUT Data : Pair; END_VAR
  VAR_INPUT Go : BOOL; END_VAR
  VAR_OUTPUT Done : BOOL; END_VAR
  VAR Hidden : INT; END_VAR
  Done := Go; Hidden := Data.First;
END_FUNCTION_BLOCK
PROGRAM Test
VAR CONSTANT Limit1 : INT := 5; END_VAR
VAR
  I : INT; J : INT; U : UINT; D : DINT; W : WORD; B : BOOL; R : REAL; L : LREAL; T1 : TIME;
  S1 : STRING; C : Colour; M : Mood; P : Pair; Q1 : Pair; List : Words; Cells : Grid; F : Step1;
  Timer : TON; Day : DATE;
END_VAR
{body}
END_PROGRAM
"""
_LINE = _FRAME[: _FRAME.index("{body}")].count("\n") + 1

_STATEMENTS = [
    ("X := 1;", "X is not declared"),
    ("Limit2 := 1;", "Limit2 is not declared; did you mean Limit1"),
    ("P.Third := 1;", "Pair has no member Third"),
    ("I.First := 1;", "a INT has no members"),
    ("I[1] := 1;", "a INT has no elements"),
    ("I := D;", "a INT is expected here, not a DINT; convert it with DINT_TO_INT"),
    ("I := B;", "convert it with BOOL_TO_INT"),
    ("B := I;", "convert it with INT_TO_BOOL"),
    ("I := 1.0;", "a INT is expected here, not the number 1.0"),
    ("I := 40000;", "40000 is outside INT (-32768 to 32767)"),
    ("R := REAL#3.4028236E38;", "REAL#3.4028236E38 is too large"),
    ("I := 32767 + 1;", "32768 is outside INT"),
    ("U := -1;", "-1 is outside UINT"),
    ("W := 16#1FFFF;", "131071 is outside WORD"),
    ("B := 2;", "a BOOL is expected here, not the number 2"),
    ("T1 := 5;", "write a duration"),
    ("T1 := 'a';", "a TIME is expected here, not a STRING"),
    ("T1 := T#5x;", "T#5x is not a duration"),
    ("T1 := T#5ms3s;", "not a duration"),
    ("T1 := T#106752d;", "T#106752d is too large; a TIME holds 106,751 days"),
    ("T1 := TOD#12:60:00;", "TOD#12:60:00 is not a time of day"),
    ("Day := D#2023-02-29;", "not a date"),
    ("I := INT#99999;", "outside INT"),
    ("I := 2#12;", "is not a number"),
    ("S1 := 'a$zb';", "$z is not an escape"),
    ("C := Colour#PINK;", "Colour has no member PINK"),
    ("RED := 1;", "RED is a member of an enumeration"),
    ("P := List;", "a Pair is expected here, not a Words"),
    ("List[5] := WORD#0;", "index 5 is outside 1..4"),
    ("List[0] := WORD#0;", "index 0 is outside 1..4"),
    ("List[-1] := WORD#0;", "index -1 is outside 1..4"),
    ("List[R] := WORD#0;", "an index must be an integer, not a REAL"),
    ("List[1, 2] := WORD#0;", "Words has 1 dimensions, not 2"),
    ("Cells[1] := 0;", "Grid has 2 dimensions, not 1"),
    ("Cells[1, 3] := 0;", "index 3 is outside 0..2"),
    ("Limit1 := 6;", "Limit1 is CONSTANT"),
    ("F.Done := TRUE;", "Done is an output of Step1"),
    ("B := F;", "a block of type Step1 is not a value"),
    ("F(Go := TRUE);", "the VAR_IN_OUT Data of Step1 is missing"),
    ("F(Data := P, Went := TRUE);", "Step1 has no input Went"),
    ("F(Data := P, Done := B);", "write Done => variable"),
    ("F(Data := P, Go => B);", "Step1 has no output Go"),
    ("F(Data := P, Done => I);", "Done is a BOOL, its target a INT"),
    ("F(Data := P, Go := 7);", "a BOOL is expected here"),
    ("F(Data := P, Go := B, Go := B);", "Go is given twice"),
    ("F(P, Data := P, Go := TRUE);", "Data is given twice"),
    ("F(P);", "Step1 takes 2 arguments, not 1"),
    ("F(Data := I);", "Data of Step1 needs a Pair, not a INT"),
    ("F(Data := 5);", "the VAR_IN_OUT Data of Step1 needs a variable"),
    ("Step1(Data := P);", "Step1 is a type of block"),
    ("TON(IN := TRUE);", "TON is a type of block"),
    ("I(3);", "a INT cannot be called"),
    ("I := Twice(1, 2);", "Twice takes 1 arguments, not 2"),
    ("I := Twice(Other := 1);", "Twice has no input OTHER"),
    ("I := Twice(D);", "a INT is expected here, not a DINT"),
    ("I := Thrice(1);", "there is no function Thrice"),
    ("I := Step1(1);", "Step1 is a block, not a function"),
    ("I := Step1(1) + 1;", "Step1 is a block, not a function"),
    ("I := MAX(I);", "MAX takes at least 2 arguments, not 1"),
    ("I := MAX(I, D);", "a INT is expected here, not a DINT"),
    ("I := LIMIT(0, I);", "LIMIT takes 3 arguments, not 2"),
    ("W := SHL(W, B);", "a number is expected here, not a BOOL"),
    ("W := SHL(W, R);", "a number is expected here, not a REAL"),
    ("W := SHL(W, List);", "a number is expected here, not a Words"),
    ("S1 := LEFT(S1, P);", "a number is expected here, not a Pair"),
    ("I := INT_TO_INT(I);", "there is no function INT_TO_INT"),
    ("B := NOT I;", "a BOOL is expected here, not a INT"),
    ("T1 := -T1;", "- is not defined for TIME"),
    ("R := R MOD 2.0;", "MOD is not defined for REAL"),
    ("I := I / 0;", "division by zero"),
    ("I := 7 / 0;", "division by zero"),
    ("I := 7 MOD 0;", "division by zero"),
    ("L := 7.0 / 0.0;", "division by zero"),
    ("I := I ** 2;", "a INT is expected here, not a LREAL"),
    ("B := P = Q1;", "= is not defined for Pair"),
    ("T1 := T1 * T1;", "* is not defined for TIME"),
    ("T1 := Day + Day;", "+ is not defined for DATE"),
    ("Day := Day * 2;", "* is not defined for DATE"),
    ("T1 := 5 / T1;", "/ is not defined for TIME"),
    ("T1 := 5 - T1;", "- is not defined for TIME"),
    ("U := -UINT#5;", "- is not defined for UINT"),
    ("S1 := SIZEOF(I);", "a STRING is expected here, not a UDINT"),
    ("IF I THEN I := 1; END_IF;", "a BOOL is expected here, not a INT"),
    ("WHILE I DO I := 1; END_WHILE;", "a BOOL is expected here"),
    ("FOR R := 1.0 TO 2.0 DO I := 1; END_FOR;", "a FOR needs an integer counter"),
    ("FOR I := 0 TO D DO J := 1; END_FOR;", "a INT is expected here, not a DINT"),
    ("FOR I := 0 TO 5 BY 0 DO J := 1; END_FOR;", "a FOR loop with a step of 0 never ends"),
    ("CASE R OF 1: I := 1; END_CASE;", "CASE needs an integer or enumeration, not a REAL"),
    ("CASE I OF 1, 2: J := 1; 2: J := 2; END_CASE;", "this label occurs twice"),
    ("CASE I OF 1..5: J := 1; 3: J := 2; END_CASE;", "this label occurs twice"),
    ("CASE I OF 5..1: J := 1; END_CASE;", "the range 5..1 is empty"),
    ("CASE I OF 40000: J := 1; END_CASE;", "40000 is outside INT"),
    ("EXIT;", "EXIT stands outside a loop"),
    ("WHILE B DO B := FALSE; END_WHILE; EXIT;", "EXIT stands outside a loop"),
    (
        "FOR I := 1 TO 2 DO REPEAT EXIT; UNTIL B END_REPEAT; END_FOR; EXIT;",
        "EXIT stands outside a loop",
    ),
    ("I := 1", "a ';' is missing"),
    ("I := ;", "an expression is expected"),
    ("I := (1 + 2;", "';' is not expected here"),
    ("WHILE B I := 1; END_WHILE;", "DO is missing; write it after 'B'"),
    ("F(Data := P Go := B);", "a ',' is missing; write it after 'P'"),
    ("I := 1; (* never ends", "this comment is never closed"),
    ("S1 := 'never ends;", "this string is never closed"),
    ('S1 := "wide";', "a STRING is expected here, not a WSTRING"),
    ("I := 1E3;", "a INT is expected here, not the number 1000.0"),
    ("I := %IW3;", "'%IW3' is not expected here"),
    ("P^ := 1;", "^ needs a pointer"),
    ("CONTINUE;", "CONTINUE stands outside a loop"),
    ("JMP done;", "JMP is not supported"),
    ("LD I", "Instruction List is not supported"),
    ("F(Data := P, EN => B);", "EN is an input"),
    ("IF := 1;", "an expression is expected"),
]


@pytest.mark.parametrize(("statement", "message"), _STATEMENTS, ids=[s for s, _ in _STATEMENTS])
def test_a_wrong_statement_has_its_line(statement: str, message: str, mistakes_of: Errors) -> None:
    errors = mistakes_of(_FRAME.replace("{body}", f"I := 1;\n{statement}\nI := 2;"))
    assert errors, "nothing was refused"
    assert message in str(errors[0])
    assert [error.line for error in errors] == [_LINE + 1]


_DECLARATIONS = [
    ("VAR A : INT; a : BOOL; END_VAR", 2, "a is declared twice"),
    ("VAR A : WIDGET; END_VAR", 2, "there is no type WIDGET"),
    ("VAR\nA : INT := 'x';\nEND_VAR", 3, "a INT is expected here, not a STRING literal"),
    ("VAR A : INT := 70000; END_VAR", 2, "70000 is outside INT"),
    ("VAR A : BYTE := 16#100; END_VAR", 2, "256 is outside BYTE"),
    ("VAR A : ARRAY [5..1] OF INT; END_VAR", 2, "the bounds 5..1 are empty"),
    ("VAR A : ARRAY [0..N] OF INT; END_VAR", 2, "a constant is expected here"),
    ("VAR A : ARRAY [3000000000..3000000001] OF INT; END_VAR", 2, "3000000000 is outside DINT"),
    ("VAR A : INT := -INT#5; END_VAR", 2, "only a number can be negative here"),
    ("VAR A : BOOL := -TRUE; END_VAR", 2, "only a number can be negative here"),
    ("VAR A : STRING := -'a'; END_VAR", 2, "only a number can be negative here"),
    ("VAR A : ARRAY [0..1] OF INT := [1, 2, 3]; END_VAR", 2, "3 values are given for 2 elements"),
    ("VAR A : RTC; END_VAR", 2, "the block RTC is not supported"),
    ("VAR A : Main; END_VAR", 2, "Main uses Main"),
    ("VAR A : TON := 5; END_VAR", 2, "this is not an initial value for a TON"),
    ("VAR to : INT; END_VAR", 2, "to is a keyword"),
    ("VAR A AT %IX0.0 : INT; END_VAR", 2, "a INT does not fit the address %IX0.0"),
    ("VAR A AT %IX0.0 : ARRAY [0..1] OF BOOL; END_VAR", 2, "does not fit the address %IX0.0"),
    ("VAR A AT %IX5 : ARRAY [0..1] OF BOOL; END_VAR", 2, "does not fit the address %IX5"),
    ("VAR A AT %IW0 : ARRAY [0..1] OF BYTE; END_VAR", 2, "does not fit the address %IW0"),
    ("VAR A AT %IW0.1 : ARRAY [0..1] OF WORD; END_VAR", 2, "does not fit the address %IW0.1"),
    ("VAR A AT %ZW0 : WORD; END_VAR", 2, "%ZW0 is not an address"),
    ("VAR A AT %MW0 : WORD; B AT %MW0 : INT; END_VAR", 2, "%MW0 is also declared as WORD"),
    ("VAR_GLOBAL A : INT; END_VAR", 2, "VAR_GLOBAL is not supported in a PROGRAM"),
    ("VAR_EXTERNAL A : INT; END_VAR", 2, "there is no global variable A"),
    ("VAR_ACCESS A : INT; END_VAR", 2, "VAR_ACCESS is not supported"),
    ("VAR A : INT END_VAR", 2, "a ';' is missing"),
    ("VAR A : INT; ", 2, "the VAR section has no END_VAR"),
]


@pytest.mark.parametrize(
    ("section", "line", "message"), _DECLARATIONS, ids=[case[0] for case in _DECLARATIONS]
)
def test_a_wrong_variable_is_refused_with_its_line(
    section: str, line: int, message: str, mistakes_of: Errors
) -> None:
    errors = mistakes_of(f"PROGRAM Main\n{section}\nEND_PROGRAM\n")
    assert errors, "nothing was refused"
    assert message in str(errors[0])
    assert errors[0].line == line or message.startswith("Main uses")


_UNITS = [
    ("TYPE Speed : REAL; END_TYPE\nTYPE speed : INT; END_TYPE", 2, "speed is declared twice"),
    ("TYPE A1 : STRUCT B : A1; END_STRUCT; END_TYPE", 1, "a type cannot contain itself"),
    ("TYPE A1 : STRUCT B : INT; b : INT; END_STRUCT; END_TYPE", 1, "the field b is declared twice"),
    ("TYPE A1 : (ONE, one); END_TYPE", 1, "the member one is declared twice"),
    ("TYPE A1 : INT;", 1, "the file ends too early"),
    ("TYPE A1 : (ONE := 32767, TWO); END_TYPE", 1, "a member is outside INT (-32768 to 32767)"),
    ("TYPE A1 : (ONE := 255, TWO) USINT; END_TYPE", 1, "a member is outside USINT (0 to 255)"),
    ("FUNCTION F1 : INT VAR_IN_OUT A : INT; END_VAR VAR_INPUT B : INT; END_VAR\n"
     "F1 := A + B; END_FUNCTION\n" "PROGRAM P1 VAR I : INT; END_VAR\nI := F1(B := 1);\nEND_PROGRAM",
     4, "the input A of F1 is missing"),
    ("TYPE A1 : STRUCT B : TON; END_STRUCT; END_TYPE\n"
     "PROGRAM P1 VAR A : A1; C : BOOL; END_VAR\nC := A.B();\nEND_PROGRAM", 3,
     "this is not a method, and has no value"),
    ("PROGRAM P1\nVAR CONSTANT N : BOOL := TRUE; END_VAR VAR A : INT := N; END_VAR\n"
     "A := A;\nEND_PROGRAM", 2, "a INT is expected here, not a BOOL"),
    ("PROGRAM P1\nVAR CONSTANT A : TON; END_VAR\nEND_PROGRAM", 2,
     "a block cannot stand in VAR CONSTANT of a PROGRAM"),
    ("FUNCTION F1 : INT VAR_INPUT A : INT; END_VAR\nF1 := F1(A);\nEND_FUNCTION", 1,
     "recursion is not supported: F1 uses F1"),
    ("FUNCTION_BLOCK B1 VAR A : B2; END_VAR\nEND_FUNCTION_BLOCK\n"
     "FUNCTION_BLOCK B2 VAR A : B1; END_VAR\nEND_FUNCTION_BLOCK", 1,
     "recursion is not supported: B1 uses B2 uses B1"),
    ("CLASS A1 VAR A : INT; END_VAR\nA2(); END_CLASS", 2, "'A2' is not expected here"),
    ("PROGRAM P1\nEND_PROGRAM\nPROGRAM P2\nEND_PROGRAM", 3, "several programs"),
    ("INITIAL_STEP A1:", 1, "INITIAL_STEP is not supported (Sequential Function Chart)"),
]  # fmt: skip


@pytest.mark.parametrize(("source", "line", "message"), _UNITS, ids=[case[2] for case in _UNITS])
def test_a_wrong_declaration_is_refused_with_its_line(
    source: str, line: int, message: str, mistakes_of: Errors
) -> None:
    errors = mistakes_of(source)
    assert errors, "nothing was refused"
    assert message in str(errors[0])
    assert errors[0].line == line


_CONFIGURATION = """\
PROGRAM P1
VAR_EXTERNAL Shared : INT; END_VAR
Shared := 1;
END_PROGRAM
CONFIGURATION Cell
VAR_GLOBAL Shared : INT; END_VAR
RESOURCE Plc ON Computer
TASK Fast(INTERVAL := T#10ms, PRIORITY := 1);
PROGRAM Main WITH Fast : P1;
END_RESOURCE
END_CONFIGURATION
"""
_CONFIGURATIONS = [
    ("WITH Fast", "WITH Slow", 9, "there is no task Slow"),
    (": P1;", ": P2;", 9, "there is no program P2"),
    (": P1;", ": P1(A := 1);", 9, "connections of a PROGRAM are not supported"),
    ("PROGRAM Main", "PROGRAM Shared", 9, "Shared is also a global variable"),
    ("INTERVAL := T#10ms, ", "", 8, "the task Fast has no INTERVAL"),
    ("T#10ms", "10", 8, "a TIME is expected here"),
    ("T#10ms", "T#0ms", 8, "an interval must be whole microseconds above 0"),
    ("INTERVAL", "SINGLE", 8, "SINGLE of a task is not supported"),
    ("PROGRAM Main WITH Fast : P1;", "", 5, "the CONFIGURATION has no PROGRAM"),
    ("Shared : INT; END_VAR\nRES", "Shared : DINT; END_VAR\nRES", 2, "the global Shared is a DINT"),
    ("END_RESOURCE", "END_RESOURCE RESOURCE R2 ON C END_RESOURCE", 5, "more than one RESOURCE"),
]


@pytest.mark.parametrize(
    ("right", "wrong", "line", "message"), _CONFIGURATIONS, ids=[c[3] for c in _CONFIGURATIONS]
)
def test_a_wrong_configuration_is_refused_with_its_line(
    right: str, wrong: str, line: int, message: str, mistakes_of: Errors
) -> None:
    errors = mistakes_of(_CONFIGURATION.replace(right, wrong))
    assert mistakes_of(_CONFIGURATION) == []
    assert message in str(errors[0])
    assert errors[0].line == line


def test_one_variable_under_two_names_is_refused(mistakes_of: Errors) -> None:
    """Engines that copy, and engines that pass references, would give different results."""
    block = (
        "TYPE Pair : STRUCT A : INT; B : INT; END_STRUCT; END_TYPE\n"
        "TYPE List1 : ARRAY [1..3] OF INT; END_TYPE\n"
        "FUNCTION_BLOCK Swap VAR_IN_OUT X : INT; Y : INT; END_VAR\n"
        "X := Y;\nEND_FUNCTION_BLOCK\n"
        "PROGRAM Main\nVAR S1 : Swap; P : Pair; L1 : List1; I : INT; J : INT; END_VAR\n"
    )

    def errors(call: str) -> list[int | None]:
        return [error.line for error in mistakes_of(f"{block}{call}\nEND_PROGRAM\n")]

    assert errors("S1(X := I, Y := J);") == []
    assert errors("S1(X := P.A, Y := P.B);") == []
    assert errors("S1(X := L1[1], Y := L1[2]);") == []
    assert errors("S1(X := I, Y := I);") == [8]
    assert errors("S1(X := P.A, Y := P.A);") == [8]
    assert errors("S1(X := L1[I], Y := L1[2]);") == [8]


def test_a_block_cannot_be_given_a_global_that_it_uses(mistakes_of: Errors) -> None:
    source = (
        "FUNCTION_BLOCK Inner VAR_EXTERNAL Shared : INT; END_VAR\nShared := 2;\n"
        "END_FUNCTION_BLOCK\n"
        "FUNCTION_BLOCK Outer VAR_IN_OUT X : INT; END_VAR VAR Part : Inner; END_VAR\n"
        "Part(); X := 1;\nEND_FUNCTION_BLOCK\n"
        "PROGRAM P1 VAR_EXTERNAL Shared : INT; END_VAR VAR O : Outer; END_VAR\n"
        "O(X := Shared);\nEND_PROGRAM\n"
        "CONFIGURATION C1 VAR_GLOBAL Shared : INT; END_VAR\n"
        "RESOURCE R1 ON Plc PROGRAM Main : P1; END_RESOURCE END_CONFIGURATION\n"
    )
    (error,) = mistakes_of(source)
    assert error.line == 8
    assert "Outer also uses the global variable Shared itself" in str(error)


@pytest.mark.parametrize(
    ("source", "lines"),
    [
        # Text outside of declarations is one error that extends to the next declaration.
        ("END_VAR;\nX\nPROGRAM P1\nVAR I : INT; END_VAR\nI := TRUE;\nEND_PROGRAM\n", [1, 5]),
        # The next declaration begins at the start of a line.
        ("END_VAR; TYPE T1 : NONE1; END_TYPE\nTYPE T2 : NONE2; END_TYPE\n", [1, 2]),
        # If the last word is wrong, the text before it is still read.
        ("PROGRAM P1\nVAR I : INT; END_VAR\nI := TRUE;\nI := 1 :=", [3, 4]),
    ],
)
def test_behind_a_mistake_the_rest_of_the_file_is_checked(
    source: str, lines: list[int], mistakes_of: Errors
) -> None:
    assert [error.line for error in mistakes_of(source)] == lines


def test_two_programs_are_reported_only_if_there_is_no_other_error(mistakes_of: Errors) -> None:
    """Two programs without a CONFIGURATION are reported only if there is no other error."""
    source = "PROGRAM P1\nVAR I : {0}; END_VAR\nEND_PROGRAM\nPROGRAM P2\nEND_PROGRAM\n"
    assert [
        "there is no type NONE1" in str(one) for one in mistakes_of(source.format("NONE1"))
    ] == [True]
    assert ["several programs" in str(one) for one in mistakes_of(source.format("INT"))] == [True]


def test_every_error_of_all_files_is_listed_in_their_order(mistakes_of: Errors) -> None:
    errors = mistakes_of(
        "PROGRAM Main\nVAR I : INT; END_VAR\nI := TRUE;\nIF I = 1 THEN\nI := X;\nEND_IF;\n"
        "END_PROGRAM",
        "FUNCTION_BLOCK B1\nVAR W : WORD; END_VAR\nW := 1.0;\nEND_FUNCTION_BLOCK",
    )
    assert [(str(error.file)[-10:], error.line) for error in errors] == [
        ("source0.st", 3),
        ("source0.st", 5),
        ("source1.st", 3),
    ]


def test_a_file_that_cannot_be_read_is_named(tmp_path: Path) -> None:
    (missing,) = check([tmp_path / "none.st"])
    (tmp_path / "binary.st").write_bytes(b"\xef\xbb\xbfPRO \xff")
    (binary,) = check([tmp_path / "binary.st"])
    assert "cannot be read" in str(missing)
    assert "byte 4 is not UTF-8" in str(binary)
    assert missing.file == str(tmp_path / "none.st")


@pytest.mark.parametrize("at", ["", "CONSTANT"])
def test_a_constant_of_a_configuration_stays_constant(at: str, mistakes_of: Errors) -> None:
    """VAR_EXTERNAL of a program may add or omit CONSTANT.

    In both cases the constant cannot be written.
    """
    source = _CONFIGURATION.replace("VAR_EXTERNAL", f"VAR_EXTERNAL {at}")
    constant = source.replace("VAR_GLOBAL Shared : INT;", "VAR_GLOBAL CONSTANT Shared : INT := 3;")
    for text, refused in ((source, bool(at)), (constant, True)):
        errors = mistakes_of(text)
        assert [error.line for error in errors] == [3] * refused
        assert all("Shared is CONSTANT" in str(error) for error in errors)


def test_a_global_that_a_block_does_not_use_may_be_given(mistakes_of: Errors) -> None:
    """The program may pass its own variable with the name of a global that the block uses."""
    frame = (
        "FUNCTION_BLOCK Inner VAR_IN_OUT X : INT; END_VAR{uses}\nX := 2;\nEND_FUNCTION_BLOCK\n"
        "PROGRAM P1 {declares} VAR I1 : Inner; END_VAR\nI1(X := Shared);\nEND_PROGRAM\n"
        "CONFIGURATION C1 VAR_GLOBAL Shared : INT; END_VAR\n"
        "RESOURCE R1 ON Plc PROGRAM Main : P1; END_RESOURCE END_CONFIGURATION\n"
    )
    external, own = "VAR_EXTERNAL Shared : INT; END_VAR", "VAR Shared : INT; END_VAR"
    assert mistakes_of(frame.format(uses="", declares=external)) == []
    assert mistakes_of(frame.format(uses=f" {external}", declares=own)) == []


@pytest.mark.parametrize(
    ("digits", "refused"), [(200, False), (201, True)], ids=["200 characters", "201 characters"]
)
def test_a_literal_has_at_most_200_letters(digits: int, refused: bool, mistakes_of: Errors) -> None:
    literal = "0." + "1".rjust(digits - 2, "0")
    errors = mistakes_of(f"PROGRAM P1\nVAR L : LREAL; END_VAR\nL := {literal};\nEND_PROGRAM\n")
    assert [f"the literal has {digits} characters" in str(error) for error in errors] == (
        [True] * refused
    )


@pytest.mark.parametrize(
    ("source", "line", "column"),
    [
        ("PROGRAM P1 VAR A : NONE1; END_VAR\nEND_PROGRAM\n", 1, 20),
        ("PROGRAM P1\nVAR\n  A : NONE1;\nEND_VAR\nEND_PROGRAM\n", 3, 7),
        ("PROGRAM P1 VAR A : INT; END_VAR\n\n  A := TRUE;\nEND_PROGRAM\n", 3, 8),
        ("PROGRAM P1 VAR A : INT; END_VAR\nA := Missing;\nEND_PROGRAM\n", 2, 6),
        ("PROGRAM P1 VAR A : INT; END_VAR A := A +* 1;\nEND_PROGRAM\n", 1, 41),
    ],
)
def test_a_mistake_has_the_column_where_it_begins(
    source: str, line: int, column: int, mistakes_of: Errors
) -> None:
    """The column of an error is that of its first character, counted from 1."""
    (error,) = mistakes_of(source)
    assert (error.line, error.column) == (line, column)
