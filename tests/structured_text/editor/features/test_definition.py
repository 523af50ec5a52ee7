"""Go to the definition of a name, to the block of an instance, and to implementations."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from cursor import FOLDER, at_cursor
from structured_text.editor.features.definition import (
    definition,
    implementations,
    type_definition,
)

_PUMP = "FUNCTION_BLOCK Pump VAR_INPUT Speed : INT; END_VAR END_FUNCTION_BLOCK\n"


def _main(body: str, declared: str = "P : Pump;") -> str:
    return f"PROGRAM Main\nVAR {declared} END_VAR\n{body}\nEND_PROGRAM\n"


def _place(found: lsp.Location | None) -> tuple[str, int, int, int] | None:
    if found is None:
        return None
    assert found.range.start.line == found.range.end.line
    file = found.uri.rpartition("/")[2]
    return file, found.range.start.line, found.range.start.character, found.range.end.character


@pytest.mark.parametrize(
    ("text", "place"),
    [
        (_main("P|(Speed := 1);"), ("Main.st", 1, 4, 5)),
        (_main("P(Spe|ed := 1);"), ("Pump.st", 0, 30, 35)),
        (_main("P.Speed| := 1;"), ("Pump.st", 0, 30, 35)),
        (_main("", "P : P|ump;"), ("Pump.st", 0, 15, 19)),
        (_main("", "|P : Pump;"), ("Pump.st", 0, 15, 19)),
        (_main("", "|a : INT;"), ("Main.st", 1, 4, 5)),
        (_main("a| := 1;"), None),
        (_main("P( |);"), None),
    ],
)
def test_the_definition_of_a_name_is_its_declaration(
    text: str, place: tuple[str, int, int, int] | None
) -> None:
    """At its own declaration, the definition of an instance is its block."""
    assert _place(definition(*at_cursor(text, Pump=_PUMP).args)) == place


def test_the_type_of_an_instance_is_its_block() -> None:
    """The block begins at character 15 of its file."""
    found = type_definition(*at_cursor(_main("|P();"), Pump=_PUMP).args)
    assert _place(found) == ("Pump.st", 0, 15, 19)
    assert found is not None
    assert found.uri == (FOLDER / "Pump.st").as_uri()


def test_the_implementations_of_a_method_are_its_overrides() -> None:
    """Run of the interface is implemented in line 2."""
    text = """INTERFACE Runs METHOD R|un END_METHOD END_INTERFACE
FUNCTION_BLOCK One IMPLEMENTS Runs METHOD Run END_METHOD END_FUNCTION_BLOCK
"""
    assert [_place(one) for one in implementations(*at_cursor(text).args)] == [
        ("Main.st", 1, 42, 45)
    ]


def test_the_implementations_of_an_interface_are_its_blocks() -> None:
    """The block One is declared in line 2."""
    text = """INTERFACE R|uns END_INTERFACE
FUNCTION_BLOCK One IMPLEMENTS Runs END_FUNCTION_BLOCK
"""
    assert [_place(one) for one in implementations(*at_cursor(text).args)] == [
        ("Main.st", 1, 15, 18)
    ]


def test_a_tab_and_an_emoji_are_counted_as_the_editor_counts() -> None:
    """The tab is one unit and the emoji two, so that P is at 1 + 9 characters."""
    text = "PROGRAM Main\nVAR\n\t(* 😀 *) P : INT;\nEND_VAR\n|P := 1;\nEND_PROGRAM\n"
    assert _place(definition(*at_cursor(text).args)) == ("Main.st", 2, 10, 11)
