"""Completion offers what fits at the cursor, in lines that do not parse."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from cursor import at_cursor
from structured_text.editor.features.completion import completion, resolved

_PUMP = """FUNCTION_BLOCK Pump
VAR_INPUT
  Speed : INT := 3; (* [1/min] *)
  How : Mode;
END_VAR
VAR_OUTPUT Busy : BOOL; END_VAR
VAR Hidden : INT; END_VAR
METHOD Start VAR_INPUT Fast : BOOL; END_VAR END_METHOD
METHOD PRIVATE Own END_METHOD
END_FUNCTION_BLOCK
TYPE
  Mode : (OFF, AUTO := 5);
  Point : STRUCT x : INT; y : Mode; END_STRUCT;
END_TYPE
FUNCTION Twice : INT VAR_INPUT n : INT; END_VAR Twice := n * 2; END_FUNCTION
"""


def _main(body: str) -> str:
    declared = "P : Pump; M : Mode; Q : ARRAY [1..2] OF Point; a : INT;"
    return f"PROGRAM Main\nVAR {declared} END_VAR\n{body}\nEND_PROGRAM\n"


def _items(typed: str) -> list[lsp.CompletionItem]:
    place = at_cursor(_main(""), typed, Pump=_PUMP, GVL="VAR_GLOBAL Level : INT; END_VAR\n")
    found = completion(*place.args) or []
    return sorted(found, key=lambda one: one.sort_text or "")


def _labels(typed: str, rank: str = "0") -> list[str]:
    """Return the labels of the items that fit best."""
    return [one.label for one in _items(typed) if (one.sort_text or "").startswith(rank)]


@pytest.mark.parametrize(
    ("body", "labels"),
    [
        ("P.|", ["Busy", "How", "Speed", "Start"]),
        ("P.Sp|", ["Busy", "How", "Speed", "Start"]),
        ("a := 1;\nIF P.| THEN", ["Busy", "How", "Speed", "Start"]),
        ("Q[a + 1].|", ["x", "y"]),
        ("Q[Twice(n := 1)].|\na := 2;", ["x", "y"]),
        ("GVL.|", ["Level"]),
        ("Mode.|", ["OFF", "AUTO"]),
        ("M := Mode#|", ["OFF", "AUTO"]),
        ("M := |", ["OFF", "AUTO"]),
        ("IF M = |", ["OFF", "AUTO"]),
        ("Q[1].y := A|;", ["OFF", "AUTO"]),
        ("P.Busy := |", ["TRUE", "FALSE"]),
        ("CASE M OF |", ["OFF", "AUTO"]),
        ("CASE M OF OFF: a := 1; |\nEND_CASE", ["OFF", "AUTO"]),
        ("CASE M OF OFF, |", ["OFF", "AUTO"]),
        ("P(|", ["Speed", "How", "Busy"]),
        ("P(Speed := 1, |)", ["How", "Busy"]),
        ("P(|, Speed := 1);", ["How", "Busy"]),
        ("P(How := |", ["OFF", "AUTO"]),
        ("P(Speed := 1, (* , *) How := A|", ["OFF", "AUTO"]),
        ("P.Start(|", ["Fast"]),
        ("a := Twice(|", ["n"]),
        ("Unknown.|", []),
    ],
)
def test_what_fits_best_comes_first(body: str, labels: list[str]) -> None:
    """The names are those of the declarations above, in their order or that of the alphabet."""
    found = _labels(_main(body))
    assert sorted(found) == sorted(labels)
    if found != sorted(found, key=str.upper):
        assert found == labels


def test_a_pin_shows_its_type_default_and_comment() -> None:
    """Speed is an INT with the initial value 3."""
    first = _items(_main("P(|"))[0]
    assert (first.label, first.detail, first.insert_text) == ("Speed", "INT := 3", "Speed := ")
    assert first.documentation == "[1/min]"


def test_an_output_is_inserted_with_its_sign() -> None:
    """An output of a block is given with =>."""
    found = {one.label: one.insert_text for one in _items(_main("P(|"))}
    assert found["Busy"] == "Busy => "


@pytest.mark.parametrize(
    ("body", "label", "snippet"),
    [
        ("|", "P(...)", "P(How := ${1:Mode});"),
        ("P|;", "P(...)", "P(How := ${1:Mode})"),
        ("a := |", "Twice", "Twice(n := ${1:INT})"),
        ("P.|", "Start", "Start(Fast := ${1:BOOL})"),
        ("P.|(", "Start", None),
    ],
)
def test_a_call_is_a_snippet_with_its_required_inputs(
    body: str, label: str, snippet: str | None
) -> None:
    """Speed has an initial value, so that only How is required; a name before ( is left alone."""
    found = {one.label: one.insert_text for one in _items(_main(body))}
    assert found[label] == snippet


def test_names_in_scope_and_keywords_follow() -> None:
    """The variables of the program, a global, and an own function are offered in an expression."""
    labels = {one.label for one in _items(_main("a := |"))}
    assert {"P", "M", "Q", "a", "Level", "GVL", "Twice", "MAX", "NOT"} <= labels
    assert "P(...)" not in labels


def test_types_are_offered_behind_the_colon_of_a_declaration() -> None:
    """A program and a function are not types."""
    typed = "PROGRAM Main\nVAR\n  x : |\nEND_VAR\nEND_PROGRAM\n"
    labels = {one.label for one in _items(typed)}
    assert {"Pump", "Mode", "Point", "INT", "TON", "ARRAY"} <= labels
    assert not labels & {"Main", "Twice", "a"}


@pytest.mark.parametrize(
    ("declared", "labels"),
    [
        ("x : Mode := |", ["OFF", "AUTO"]),
        ("x : Point := (|", ["x", "y"]),
        ("x : Point := (x := (1 + 2), |", ["x", "y"]),
        ("x : Point := (x := 1, y := |", ["OFF", "AUTO"]),
        ("x : Pump := (How := |", ["OFF", "AUTO"]),
        ("a : BOOL; x : Pump := (|", ["Speed", "How", "Busy"]),
    ],
)
def test_an_initial_value_has_the_type_of_its_variable(declared: str, labels: list[str]) -> None:
    """Members of an enumeration, and the fields of structures and blocks, are offered."""
    assert _labels(f"PROGRAM Main\nVAR\n  {declared}\nEND_VAR\nEND_PROGRAM\n") == labels


@pytest.mark.parametrize("body", ["(* P.| *)", "// P.|", "a := 'P.|';"])
def test_nothing_is_offered_in_comments_and_texts(body: str) -> None:
    """The dot belongs to a comment or to a text."""
    assert _items(_main(body)) == []


def test_a_method_sees_the_variables_of_its_block() -> None:
    """Hidden is a variable of the block, Own a private method, Fast an input of the method."""
    typed = _PUMP.replace("END_VAR END_METHOD", "END_VAR\n|\nEND_METHOD")
    place = at_cursor(_PUMP, typed)
    labels = {one.label for one in completion(*place.args) or []}
    assert {"Hidden", "Own", "Fast", "Speed"} <= labels


def test_the_members_of_a_pointer_are_those_of_its_target() -> None:
    """The pointer leads to a Point, which has two fields."""
    main = "PROGRAM Main\nVAR p : POINTER TO Point; END_VAR\n{}\nEND_PROGRAM\n"
    place = at_cursor(main.format(""), main.format("p^.|"), Pump=_PUMP)
    assert [one.label for one in completion(*place.args) or []] == ["x", "y"]


def test_members_and_globals_are_qualified_where_they_must_be() -> None:
    """The pragmas demand the name of the enumeration, and of the list."""
    types = "{attribute 'strict'}\nTYPE Mode : (OFF, AUTO); END_TYPE\n"
    lists = "{attribute 'qualified_only'}\nVAR_GLOBAL Level : INT; END_VAR\n"
    main = "PROGRAM Main\nVAR m : Mode; END_VAR\n{}\nEND_PROGRAM\n"
    place = at_cursor(main.format(""), main.format("m := |"), Types=types, GVL=lists)
    found = {one.label: one.insert_text for one in completion(*place.args) or []}
    assert found["OFF"] == "Mode.OFF"
    assert "GVL" in found
    assert "Level" not in found


def test_an_item_gets_its_declaration_when_it_is_shown() -> None:
    """The editor asks for it when an item is selected."""
    place = at_cursor(_main(""), _main("P.|"), Pump=_PUMP)
    item = next(one for one in completion(*place.args) or [] if one.label == "Speed")
    found = resolved(place.index, item).documentation
    assert isinstance(found, lsp.MarkupContent)
    assert found.value == "```iecst\nSpeed : INT := 3\n```\n\n[1/min]"


@pytest.mark.parametrize(
    "body", ["P.|", "IF P.Busy THEN\n  P.|", "CASE M OF\n  OFF: P.|", "a := 1;\n  P.|"]
)
@pytest.mark.parametrize("behind", ["END_PROGRAM\n", "END_PROGRAM\n" + _PUMP])
def test_members_are_offered_while_the_indexed_text_is_broken(body: str, behind: str) -> None:
    """The index is that of the unfinished text itself; the next line is not the member."""
    typed = f"PROGRAM Main\nVAR P : Pump; M : Mode; END_VAR\n{body}\n{behind}"
    others = {} if _PUMP in behind else {"Pump": _PUMP}
    place = at_cursor(typed, **others)
    labels = [one.label for one in completion(*place.args) or []]
    assert sorted(labels) == ["Busy", "How", "Speed", "Start"]
