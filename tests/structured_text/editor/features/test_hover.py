"""Hover shows declaration, section, comment, initial value and pins."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from cursor import at_cursor
from structured_text.editor.features.hover import hover

_PUMP = """(* Moves water.
 * Call it in every scan. *)
FUNCTION_BLOCK Pump
VAR_INPUT
  Speed : INT := 3; (* [1/min] *)
END_VAR
VAR_OUTPUT
  // TRUE while it runs
  Busy : BOOL;
END_VAR
END_FUNCTION_BLOCK
"""
_PINS = "VAR_INPUT\n  Speed : INT := 3;\nVAR_OUTPUT\n  Busy : BOOL;"


def _hover(text: str, typed: str | None = None) -> str | None:
    found = hover(*at_cursor(text, typed, Pump=_PUMP).args)
    if found is None:
        return None
    assert isinstance(found.contents, lsp.MarkupContent)
    return found.contents.value


def _main(body: str, declared: str = "") -> str:
    return f"PROGRAM Main\nVAR P : Pump; {declared}\nEND_VAR\n{body}\nEND_PROGRAM\n"


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        (_main("P(Sp|eed := 2);"), "```iecst\nVAR_INPUT\nSpeed : INT := 3\n```\n\n[1/min]"),
        (
            _main("IF P.Busy| THEN END_IF"),
            "```iecst\nVAR_OUTPUT\nBusy : BOOL\n```\n\nTRUE while it runs",
        ),
        (_main("|P();"), f"```iecst\nVAR\nP : Pump\n{_PINS}\n```"),
        (
            _main("", "Q : Pu|mp;"),
            f"```iecst\nFUNCTION_BLOCK Pump\n{_PINS}\n```\n\nMoves water.\nCall it in every scan.",
        ),
        (_main("", "S : STRING[8] := 'a;b'; // text\n").replace("S :", "S| :"), None),
        (_main("t|1();", "t1 : TON;"), None),
        (
            _main("a := MA|X(1, 2);", "a : INT;"),
            "```iecst\nMAX(IN1 : ANY, IN2 : ANY, ...) : ANY\n```",
        ),
        (_main("|;"), None),
    ],
)
def test_hover_shows_what_is_declared(text: str, shown: str | None) -> None:
    """The texts are those of the declarations above, in Markdown."""
    if "STRING[8]" in text:
        shown = "```iecst\nVAR\nS : STRING[8] := 'a;b'\n```\n\ntext"
    if "TON" in text:
        pins = "  IN : BOOL;\n  PT : TIME;\n  Q : BOOL;\n  ET : TIME;"
        shown = f"```iecst\nVAR\nt1 : TON\n{pins}\n```"
    assert _hover(text) == shown


@pytest.mark.parametrize(
    ("body", "shown"),
    [
        ("t1(I|N := TRUE);", "VAR_INPUT\nIN : BOOL"),
        ("t1(Q| => b);", "VAR_OUTPUT\nQ : BOOL"),
        ("b := t1.E|T > T#1s;", "VAR_OUTPUT\nET : TIME"),
        ("t1(IN := Q|);", None),
    ],
)
def test_hover_of_a_pin_of_the_standard_shows_its_type(body: str, shown: str | None) -> None:
    """A TON has the pins IN, PT, Q and ET; the last Q is an unknown variable."""
    text = _main(body, "t1 : TON; b : BOOL;")
    assert _hover(text) == (None if shown is None else f"```iecst\n{shown}\n```")


def test_hover_of_a_member_shows_its_number() -> None:
    """AUTO has the number 5 that its declaration gives it."""
    text = "TYPE Mode : (OFF, AUTO := 5); END_TYPE\n" + _main("M := AU|TO;", "M : Mode;")
    assert _hover(text) == "```iecst\nMode#AUTO = 5\n```"


def test_hover_works_in_a_text_that_is_newer_than_the_index() -> None:
    """Three lines were inserted since the index was made, and the last statement is unfinished."""
    typed = _main("\n\n\nP(Spe|ed := 1);\nP(").replace("END_PROGRAM", "")
    assert _hover(_main("P();"), typed) == "```iecst\nVAR_INPUT\nSpeed : INT := 3\n```\n\n[1/min]"


def test_hover_appends_the_text_of_extras() -> None:
    """The extra gets the definition of the name."""
    place = at_cursor(_main("|P();"), Pump=_PUMP)
    found = hover(*place.args, extra=lambda name: f"page of {name.key}")
    assert found is not None
    assert isinstance(found.contents, lsp.MarkupContent)
    assert found.contents.value.endswith("\n\npage of MAIN.P")
    assert found.range == lsp.Range(lsp.Position(3, 0), lsp.Position(3, 1))
