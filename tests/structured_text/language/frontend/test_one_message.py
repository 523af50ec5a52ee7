"""Each mistake gives one message, at the place that the user must change.

Lines and columns are counted by hand. The remedies use the terms of IEC 61131-3.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from structured_text.errors import InputError, similar
from structured_text.language.load import analyse

Errors = Callable[..., list[InputError]]

_IF = "the IF of this line has no END_IF"

#: Cases: statements from line 3 on; line, column and text of the message; its hint.
_STATEMENTS = [
    # The end of a statement such as IF or FOR is missing.
    ("IF B THEN\n I := 1;", 3, 1, _IF, "write END_IF before the END_PROGRAM of line 5"),
    ("IF B THEN\n I := 1;\nIF B THEN\n I := 2;\nEND_IF;", 3, 1, _IF,
     "write END_IF before the END_PROGRAM of line 8"),
    ("FOR I := 1 TO 3 DO\n WHILE B DO\n  B := FALSE;\n END_WHILE;", 3, 1,
     "the FOR of this line has no END_FOR", "write END_FOR before the END_PROGRAM of line 7"),
    ("CASE I OF\n1: IF B THEN I := 2;\nEND_CASE;", 4, 4, _IF,
     "write END_IF before the END_CASE of line 5"),
    ("REPEAT\n IF B THEN I := 2; END_IF;\nUNTIL B", 3, 1,
     "the REPEAT of this line has no END_REPEAT",
     "write END_REPEAT before the END_PROGRAM of line 6"),
    # ELSE IF.
    ("IF B THEN\n I := 1;\nELSE IF I = 2 THEN\n I := 3;\nEND_IF;", 5, 1,
     "ELSE IF opens a second IF, so the IF of line 3 has no END_IF", "write ELSIF"),
    # A statement has the end of another statement, or a word of another language.
    ("IF B THEN\n I := 1;\nEND_WHILE;", 5, 1, "END_WHILE does not end the IF of line 3",
     "write END_IF"),
    ("IF B THEN\n I := 1;\nELSEIF I = 2 THEN\n I := 2;\nEND_IF;", 5, 1,
     "ELSEIF is not a word of Structured Text", "write ELSIF"),
    ("IF B THEN\n I := 1;\nENDIF;", 5, 1, "ENDIF is not a word of Structured Text", "write END_IF"),
    # Characters or words are missing or are those of C.
    ("IF I = 1\n I := 2;\nEND_IF;", 3, 9, "THEN is missing", "write it after '1'"),
    ("FOR I := 1 TO 3\n B := TRUE;\nEND_FOR;", 3, 16, "DO is missing", "write it after '3'"),
    ("I = 1;", 3, 3, "= compares, and does not assign", "write :="),
    ("IF I == 1 THEN I := 2; END_IF;", 3, 6, "== is an operator of C", "write = to compare"),
    ("IF B && B THEN I := 2; END_IF;", 3, 6, "&& is an operator of C", "write AND"),
    ("IF I != 1 THEN I := 2; END_IF;", 3, 6, "!= is an operator of C", "write <>"),
    ("IF B || B THEN I := 2; END_IF;", 3, 6, "|| is an operator of C", "write OR"),
    ("IF !B THEN I := 2; END_IF;", 3, 4, "! is an operator of C", "write NOT"),
    ("I := I % 2;", 3, 8, "% is an operator of C", "write MOD"),
    ("I += 1;", 3, 3, "+= is not an operator of Structured Text", "write it as a := a + 1"),
    ("I++;", 3, 2, "++ is not an operator of Structured Text", "write it as a := a + 1"),
    ("B := I =< 2;", 3, 8, "=< is not an operator of Structured Text", "write <="),
    ("IF I => 2 THEN I := 2; END_IF;", 3, 6, "=> is not a comparison", "write >="),
    ("IF I := 1 THEN I := 2; END_IF;", 3, 4, ":= assigns, and does not compare", "write ="),
    ("I : = 1;", 3, 3, "there is a blank in :=", "write :="),
    ("IF B THEN I := 1; END IF;", 3, 19, "END IF is written as one word", "write END_IF"),
    ("IF B THEN I := 1; ELSIF B I := 2; END_IF;", 3, 26, "THEN is missing",
     "write it after 'B'"),
    ("IF B THEN I := 1;\nELSE I := 2;\nELSE I := 3; END_IF;", 5, 1,
     "the IF of line 3 has a second ELSE",
     "write ELSIF and a condition in place of the first one, or remove it"),
    ("REPEAT\n I := I + 1;\nEND_REPEAT;", 5, 1, "REPEAT has no UNTIL",
     "write UNTIL and a condition before it"),
    ("REPEAT\n I := I + 1;\nUNTIL B;\nI := 2;", 3, 1,
     "the REPEAT of this line has no END_REPEAT",
     "write END_REPEAT after the condition of line 5"),
    ("FOR I := 1 TO 3 STEP 2 DO B := TRUE; END_FOR;", 3, 17, "a FOR has no STEP", "write BY"),
    ("WHILE B DO BREAK; END_WHILE;", 3, 12, "BREAK is not a word of Structured Text",
     "write EXIT"),
    ("RETURN 5;", 3, 1, "RETURN takes no value",
     "assign the value to the name of the function before"),
    ("I := (1 + 2));", 3, 13, "there is no ( for this )", "remove it"),
    ("int c = 3;", 3, 1, "variables are declared between VAR and END_VAR",
     "write c : INT there"),
    ("I := 0x1F;", 3, 6, "this number is malformed", "write it as 16#1F"),
    ("I := 5s;", 3, 6, "this number is malformed", "write the duration as T#5s"),
    ("# text", 3, 1, "the character '#' has no meaning here",
     "write a comment as // text or (* text *)"),
    # Exceptions.
    ("__TRY\n I := 1;\n__FINALLY\n I := 2;\n__ENDTRY", 3, 1, "__TRY has no __CATCH",
     "write __CATCH before __FINALLY or __ENDTRY"),
    ("__TRY\n I := 1;\n__CATCH(I)\n I := 2;\n__ENDTRY", 5, 9,
     "__CATCH needs a variable of __SYSTEM.ExceptionCode, not INT", ""),
    # Jumps.
    ("".join(f"l{number}: I := 1;\n" for number in range(123)), 3, 1,
     "labels and jumps are not supported (123 labels in this file)", "use IF, or a loop with EXIT"),
    ("again: I := I + 1;\nIF B THEN JMP again; END_IF;", 3, 1,
     "labels and jumps are not supported (1 label and 1 jump in this file)",
     "use IF, or a loop with EXIT"),
]  # fmt: skip


@pytest.mark.parametrize(("body", "line", "column", "message", "hint"), _STATEMENTS)
def test_a_mistake_in_a_body_is_one_message(
    body: str, line: int, column: int, message: str, hint: str, mistakes_of: Errors
) -> None:
    """An error in statements gives one message with line, column and remedy."""
    source = f"PROGRAM P1\nVAR I : INT; B : BOOL; END_VAR\n{body}\nEND_PROGRAM\n"
    (error,) = mistakes_of(source)
    assert (error.line, error.column) == (line, column)
    assert (error.message, error.hint) == (message, hint)


@pytest.mark.parametrize(
    ("source", "line", "message", "hint"),
    [
        ("PROGRAM P1\nVAR if : INT; type, A : INT; END_VAR\nA := 1;\nEND_PROGRAM", 2,
         "if is a keyword and cannot be a name", "choose another name"),
        ("PROGRAM P1\nVAR\n A : INT;\nA := 1;\nEND_PROGRAM", 2,
         "the VAR section has no END_VAR", "write END_VAR before the A of line 4"),
        ("PROGRAM P1\nVAR\n INT A;\nEND_VAR\nA := 1;\nEND_PROGRAM", 3,
         "the name stands before its type", "write A : INT"),
        ("PROGRAM P1\nVAR A : INTEGER; END_VAR\nA := 1;\nEND_PROGRAM", 2,
         "there is no type INTEGER", "did you mean INT"),
        ("PROGRAM P1\nVAR A : UINT16; END_VAR\nA := 1;\nEND_PROGRAM", 2,
         "there is no type UINT16", "did you mean UINT"),
        ("PROGRAM P1\nVAR A : INT; (* text\nEND_VAR\nA := 1;\nEND_PROGRAM", 2,
         "this comment is never closed", "end it with *)"),
        ("FUNCTION F1\nVAR_INPUT A : INT; END_VAR\nF1 := A;\nEND_FUNCTION", 3,
         "the FUNCTION F1 has no result", "write FUNCTION F1 : and its type"),
        ("FUNCTION_BLOCK B1\nMETHOD M1\n;\n\nMETHOD M2\n;\nEND_METHOD\nEND_FUNCTION_BLOCK", 2,
         "the METHOD of this line has no END_METHOD",
         "write END_METHOD before the METHOD of line 5"),
        ("PROGRAM P1\nVAR T1 : TON; B : BOOL; END_VAR\nT1(IN := B PT := T#1s);\nEND_PROGRAM", 3,
         "a ',' is missing", "write it after 'B'"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_declaration_is_one_message(
    source: str, line: int, message: str, hint: str, mistakes_of: Errors
) -> None:
    """An error in a declaration gives one message with line, column and remedy.

    Each keyword that is used as a name has its own message.
    """
    first, *others = mistakes_of(source)
    assert (first.line, first.message, first.hint) == (line, message, hint)
    assert all("is a keyword" in one.message for one in others)


def test_what_follows_a_missing_end_is_checked_too(mistakes_of: Errors) -> None:
    """A FOR and an IF without an end are reported, and the next POU is still checked."""
    source = (
        "FUNCTION_BLOCK B1\nVAR I : INT; END_VAR\nFOR I := 1 TO 3 DO\nIF I = 1 THEN\nI := 2;\n"
        "END_FUNCTION_BLOCK\nPROGRAM P1\nVAR A : B1; I : INT; END_VAR\nI := Nothing;\nEND_PROGRAM\n"
    )
    assert {(error.line, error.message) for error in mistakes_of(source)} == {
        (3, "the FOR of this line has no END_FOR"),
        (4, "the IF of this line has no END_IF"),
        (9, "Nothing is not declared"),
    }


@pytest.mark.parametrize(
    ("body", "line", "message"),
    [
        ("I.", 4, "'END_PROGRAM' is not expected here"),
        ("I := I.\nIF I = 1 THEN I := 2; END_IF;", 4, "'IF' is not expected here"),
        ("CASE I OF\n1: I := 2;", 3, "the CASE of this line has no END_CASE"),
        ("REPEAT\nI := 1;", 3, "the REPEAT of this line has no END_REPEAT"),
        ("REPEAT\nI := 1;\nEND_WHILE;", 5, "END_WHILE does not end the REPEAT of line 3"),
    ],
)
def test_an_unfinished_statement_leaves_what_follows_readable(
    body: str, line: int, message: str, mistakes_of: Errors
) -> None:
    """A keyword in the next line is not the missing member; a CASE ends with its POU."""
    source = (
        f"PROGRAM P1\nVAR I : INT; END_VAR\n{body}\nEND_PROGRAM\n"
        "FUNCTION_BLOCK B1\nVAR J : INT; K : INT; END_VAR\nJ := K;\nEND_FUNCTION_BLOCK\n"
    )
    (error,) = mistakes_of(source)
    assert (error.line, error.message) == (line, message)


@pytest.mark.parametrize(
    ("source", "line", "message"),
    [
        ("FUNCTION_BLOCK B1\nVAR A : INT; END_VAR\nA := 1;\nEND_PROGRAM\n", 4,
         "END_PROGRAM does not end the FUNCTION_BLOCK of line 1"),
        ("FUNCTION_BLOCK B1\nVAR A : INT; END_VAR\nA := 1;\n", 1,
         "the FUNCTION_BLOCK of this line has no END_FUNCTION_BLOCK"),
        ("TYPE S1 : STRUCT\n A : INT;\nEND_STRUCT;\n", 1, "the TYPE of this line has no END_TYPE"),
        ("TYPE S1 : STRUCT\n A : INT;\nEND_TYPE\n", 1, "the STRUCT of this line has no END_STRUCT"),
    ],
)  # fmt: skip
def test_a_declaration_without_its_end_is_named(
    source: str, line: int, message: str, mistakes_of: Errors
) -> None:
    """The missing end is reported, and the next program is still checked."""
    rest = "PROGRAM P1\nVAR A : INT; END_VAR\nA := Nothing;\nEND_PROGRAM\n"
    first, second = mistakes_of(source + rest)
    assert (first.line, first.message) == (line, message)
    assert second.message == "Nothing is not declared"


@pytest.mark.parametrize(
    ("section", "line", "message", "before"),
    [
        ("VAR I : INT;\nIF TRUE THEN I := 2; END_IF;", 2, "the VAR section", "IF of line 3"),
        ("VAR I : INT;\nVAR_INPUT A : INT; END_VAR", 2, "the VAR section", "VAR_INPUT of line 3"),
        ("VAR_INPUT\n I : INT;", 2, "the VAR_INPUT section", "END_FUNCTION_BLOCK of line 4"),
    ],
)
def test_a_section_without_its_end_is_named(
    section: str, line: int, message: str, before: str, mistakes_of: Errors
) -> None:
    """A section without END_VAR is reported by its keyword, with the place for END_VAR."""
    (error,) = mistakes_of(f"FUNCTION_BLOCK B1\n{section}\nEND_FUNCTION_BLOCK\n")
    assert (error.line, error.message) == (line, f"{message} has no END_VAR")
    assert error.hint == f"write END_VAR before the {before}"


@pytest.mark.parametrize(
    ("source", "said", "name"),
    [
        ('DATA_BLOCK "oscillator"\nVAR\n x : Real;\nEND_VAR\nBEGIN\n x := 5;\nEND_DATA_BLOCK',
         'DATA_BLOCK "oscillator"', "source0.db"),
        ("DATA_BLOCK Motor_DB\nBEGIN\nEND_DATA_BLOCK", "DATA_BLOCK Motor_DB", "source0.db"),
        ('FUNCTION_BLOCK "Motor"\nVERSION : 0.1\nBEGIN\n #n := #n + 1;\nEND_FUNCTION_BLOCK',
         'FUNCTION_BLOCK "Motor"', "source0.scl"),
        ('ORGANIZATION_BLOCK "Main"\nBEGIN\nEND_ORGANIZATION_BLOCK', 'ORGANIZATION_BLOCK "Main"',
         "source0.scl"),
        ('TYPE "UDT_x"\nSTRUCT\n a : Int;\nEND_STRUCT;\nEND_TYPE', 'TYPE "UDT_x"', "source0.udt"),
    ],
)  # fmt: skip
def test_a_source_in_scl_is_recognised(
    source: str, said: str, name: str, mistakes_of: Errors
) -> None:
    """An SCL source with the ending .st is refused with the name that the file needs.

    Source: TIA Portal's external sources; the endings are those that are read as SCL.
    """
    (error,) = mistakes_of(source)
    assert error.line == 1
    assert said in error.message
    assert error.hint == f"name the file {name}, then it is read as SCL"


@pytest.mark.parametrize(
    "body",
    ["DATA_BLOCK := 1;", "ENDIF := 2;", "I := ENDIF + ELSEIF;", "ELSEIF := DATA_BLOCK;"],
)
def test_words_that_are_not_keywords_may_be_names(body: str, mistakes_of: Errors) -> None:
    """Words such as ENDIF and DATA_BLOCK may be names of variables.

    Source: IEC 61131-3: they are no keywords.
    """
    names = "DATA_BLOCK, ENDIF, ELSEIF, I : INT;"
    assert mistakes_of(f"PROGRAM P1\nVAR {names} END_VAR\n{body}\nEND_PROGRAM\n") == []


@pytest.mark.parametrize(
    ("name", "hint"),
    [("FB_Pumps", "did you mean FB_Pump"), ("POSITIONT", "did you mean POSITION_T"),
     ("DIN", "did you mean DINT"), ("R_TRG", "did you mean R_TRIG"),
     ("MC_MoveAbsolute", "name its file, too, or check the spelling")],
)  # fmt: skip
def test_a_similar_name_is_proposed_for_an_unknown_type(
    name: str, hint: str, mistakes_of: Errors
) -> None:
    """The message about an unknown type proposes a similar name."""
    (error,) = mistakes_of(
        "TYPE POSITION_T : STRUCT X : INT; END_STRUCT; END_TYPE\n"
        "FUNCTION_BLOCK FB_Pump VAR N : INT; END_VAR N := 1; END_FUNCTION_BLOCK\n"
        f"PROGRAM P1\nVAR A : {name}; END_VAR\nEND_PROGRAM\n"
    )
    assert (error.message, error.hint) == (f"there is no type {name}", hint)


def test_case_and_underscores_do_not_count_for_similar_names() -> None:
    """Names that differ only in case and underscores are similar."""
    assert similar("FB_MOVE_PTP", ["FB_MovePtp", "FB_Jog"]) == ["FB_MovePtp"]
    assert similar("Axis", ["FB_MovePtp", "FB_Jog"]) == []


def test_keywords_in_initial_values_are_values(tmp_path: Path) -> None:
    """In lists of initial values, TRUE and FALSE are values, also after a comma and nested."""
    file = tmp_path / "Lists.st"
    file.write_text(
        "TYPE Pair : STRUCT A, B : BOOL; C : ARRAY [0..2] OF BOOL; END_STRUCT; END_TYPE\n"
        "PROGRAM P1\nVAR\n  L, M : ARRAY [0..2] OF BOOL := [TRUE, FALSE, TRUE];\n"
        "  S : Pair := (A := TRUE, B := FALSE, C := [FALSE, TRUE, TRUE]);\n  N : INT;\nEND_VAR\n"
        "N := SEL(TRUE, 1, 2);\nEND_PROGRAM\n",
        encoding="utf-8",
    )
    assert analyse([file])[1] == []
