"""The formatter decides indentation, spaces, columns, capitals and empty lines."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from structured_text.editor.format.formatter import formatted
from structured_text.editor.format.items import items_of
from structured_text.editor.format.same import check_same
from structured_text.errors import InputError
from structured_text.language.parser import parse_text

_FILE = Path("Main.st")

_MESSY = """\


function_block   Press extends Base
VAR_INPUT Go:BOOL;(* start *)
Pressure :real:=1.5 ; (* [bar] *)
end_var
var
  Table:array[0..9]of int;
        Motor, Pump:FB_Motor;
END_VAR
if Go and(Pressure>-2.0)then Motor( Speed:=3,Time:=T#5s )  ;end_if ;
case Pressure of
1,2 : Table[ 0 ]:=- 1;
3..5:
for i:=0 to 9 do
Table[i]:=Table[i]*2+1;
end_for;
else
Pump.Go:=false;
end_case;



repeat  Go:=not Go; until Go end_repeat;
end_function_block
type Colour:(Red,Green) ;
Place : struct
X:lreal;
Angle : lreal;
end_struct ;
end_type
"""
_CLEAN = """\
FUNCTION_BLOCK Press EXTENDS Base
  VAR_INPUT
    Go       : BOOL;         (* start *)
    Pressure : REAL := 1.5;  (* [bar] *)
  END_VAR
  VAR
    Table       : ARRAY [0..9] OF INT;
    Motor, Pump : FB_Motor;
  END_VAR
  IF Go AND (Pressure > -2.0) THEN
    Motor(Speed := 3, Time := T#5s);
  END_IF;
  CASE Pressure OF
    1, 2: Table[0] := -1;
    3..5:
      FOR i := 0 TO 9 DO
        Table[i] := Table[i] * 2 + 1;
      END_FOR;
  ELSE
    Pump.Go := FALSE;
  END_CASE;

  REPEAT
    Go := NOT Go;
  UNTIL Go
  END_REPEAT;
END_FUNCTION_BLOCK

TYPE
  Colour : (Red, Green);
  Place : STRUCT
    X     : LREAL;
    Angle : LREAL;
  END_STRUCT;
END_TYPE
"""


def test_a_source_gets_the_layout_of_the_library() -> None:
    """Every rule of the layout is used once."""
    assert formatted(_MESSY, _FILE) == _CLEAN


def test_a_formatted_source_does_not_change() -> None:
    """The formatter accepts its own layout."""
    assert formatted(_CLEAN, _FILE) == _CLEAN


@cache
def _words() -> list[list[str]]:
    """Return the words and signs of each line of the layout."""
    return [[item.text for item in items_of(line, _FILE)] for line in _CLEAN.split("\n")]


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 5), st.integers())
def test_white_space_does_not_decide_the_layout(indent: int, seed: int) -> None:
    """Any number of spaces between words and before lines gives the same text.

    Comments are far from their code, because a comment close to its code is a layout of its own.
    """
    draw = Random(seed)
    lines = []
    for words in _words():
        spaces = [20 if word.startswith("(*") else draw.randint(1, 3) for word in words]
        pairs = zip(words, [indent, *spaces[1:]], strict=False)
        lines.append("".join(f"{' ' * space}{word}" for word, space in pairs))
    assert formatted("\n".join(lines), _FILE) == _CLEAN


@pytest.mark.parametrize(
    "source",
    [
        # A comment of several lines moves as a whole.
        "PROGRAM P\n  (* first\n     second *)\n  A := 1;\nEND_PROGRAM\n",
        # Comments behind statements stay in their columns.
        "PROGRAM P\n  A := 1;        (* one *)\n  Long := 22;    // two\nEND_PROGRAM\n",
        # A comment may be as deep as the word ELSE below it.
        "PROGRAM P\n  IF A THEN\n    B := 1;\n  (* otherwise *)\n  ELSE\n    B := 2;\n"
        "  END_IF;\nEND_PROGRAM\n",
        # Pragmas, regions and excluded text remain.
        "{attribute 'qualified_only'}\nVAR_GLOBAL\n  {attribute 'x'} A : INT;\nEND_VAR\n",
        "PROGRAM P\n  REGION one\n  A := 1;\n  END_REGION\nEND_PROGRAM\n",
        "PROGRAM P\n  {IF defined (Other)}\n a:=1  ;\n  {ELSE}\n  A := 2;\n  {END_IF}\n"
        "END_PROGRAM\n",
        # Arguments are aligned behind the parenthesis, or indented below the call.
        "PROGRAM P\n  Motor(Speed := 3,\n        Time := T#5s);\nEND_PROGRAM\n",
        "PROGRAM P\n  Motor(\n    Speed := 3,\n    Time  := T#5s\n  );\nEND_PROGRAM\n",
        # A condition is aligned behind IF, an operand behind its pin or below the statement.
        "PROGRAM P\n  IF A\n     AND B THEN\n    C := D\n      OR E(F := G\n           OR H);\n"
        "  END_IF;\nEND_PROGRAM\n",
        # Several assignments may be on one line, and aligned below each other.
        "PROGRAM P\n  A := 1; B := 2;\n  Cde   := 3;\n  Fghij := 4;\nEND_PROGRAM\n",
        # A text over several lines and a name with letters beyond ASCII are not changed.
        "PROGRAM P\n  Größe := 'a\n b';\nEND_PROGRAM\n",
        # A sign of one operand is close to it; an operator has spaces.
        "PROGRAM P\n  A := -B - (-1) + AND(C, D) * E^.F[-1];\nEND_PROGRAM\n",
        # Set and reset, references and pointers.
        "PROGRAM P\n  A S= B;\n  C REF= D;\n  THIS^.E := ADR(F)^;\nEND_PROGRAM\n",
        # Object orientation.
        "INTERFACE I EXTENDS J, K\n  METHOD M : BOOL\n    VAR_INPUT\n      A : REF_TO INT;\n"
        "    END_VAR\n  END_METHOD\n\n  PROPERTY P : INT\n    GET\n    END_GET\n  END_PROPERTY\n"
        "END_INTERFACE\n",
        "FUNCTION_BLOCK F\n  __TRY\n    A();\n  __CATCH(E)\n    B();\n  __FINALLY\n    C();\n"
        "  __ENDTRY;\nEND_FUNCTION_BLOCK\n",
    ],
)
def test_these_layouts_remain(source: str) -> None:
    """Each text is already as the formatter writes it."""
    assert formatted(source, _FILE) == source


def test_tabs_become_spaces() -> None:
    """A tab stop is at every fourth column; the lines of a comment keep their distance."""
    source = (
        "PROGRAM P\n\tIF A THEN\n\t\t(* one\n\t\t   two *)\n\t\tB := 1;\n\tEND_IF;\nEND_PROGRAM\n"
    )
    expected = (
        "PROGRAM P\n  IF A THEN\n    (* one\n       two *)\n    B := 1;\n  END_IF;\nEND_PROGRAM\n"
    )
    assert formatted(source, _FILE) == expected


def test_a_long_comment_stands_behind_its_declaration() -> None:
    """The other comments share a column."""
    comment = f"(* {'x' * 80} *)"
    rows = ["A : INT; (* one *)", f"Second : DINT; {comment}", "Third : STRING; (* three *)"]
    source = f"VAR_GLOBAL\n{chr(10).join(rows)}\nEND_VAR\n"
    assert formatted(source, _FILE) == (
        "VAR_GLOBAL\n"
        "  A      : INT;     (* one *)\n"
        f"  Second : DINT;  {comment}\n"
        "  Third  : STRING;  (* three *)\n"
        "END_VAR\n"
    )


def test_a_syntax_error_is_reported_with_its_line() -> None:
    """The message is the one of the parser."""
    with pytest.raises(InputError, match=r"Main\.st:2"):
        formatted("PROGRAM P\n  A := ;\nEND_PROGRAM\n", _FILE)


@pytest.mark.parametrize(
    ("result", "message"),
    [
        ("PROGRAM P\n  A := 2; (* c *)\nEND_PROGRAM\n", "differs at '2'"),
        ("PROGRAM P\n  A := 1; (* d *)\nEND_PROGRAM\n", r"differs at '\(\* d \*\)'"),
        ("PROGRAM P\n  A := 1;\nEND_PROGRAM\n", "differs at 'END_PROGRAM'"),
        ("PROGRAM P\n  A := 1 (* c *)\nEND_PROGRAM\n", "cannot be read again"),
    ],
)
def test_a_layout_that_changes_more_is_refused(result: str, message: str) -> None:
    """Tokens, comments and the syntax tree are compared before a text is used."""
    source = "PROGRAM P\n  A := 1;  (* c *)\nEND_PROGRAM\n"
    with pytest.raises(InputError, match=message):
        check_same(parse_text(source, _FILE), items_of(source, _FILE), result, _FILE)
