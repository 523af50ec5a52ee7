"""References are all places of a name, in all files."""

from __future__ import annotations

from lsprotocol import types as lsp

from cursor import at_cursor
from structured_text.editor.features.references import highlights, references

_PUMP = """FUNCTION_BLOCK Pump
VAR_INPUT Speed : INT; END_VAR
Speed := Speed + 1;
END_FUNCTION_BLOCK
"""
_MAIN = "PROGRAM Main VAR P : Pump; END_VAR\nP(Sp|eed := 1);\nEND_PROGRAM\n"


def _places(found: list[lsp.Location] | None) -> list[tuple[str, int, int]]:
    return [
        (one.uri.rpartition("/")[2], one.range.start.line, one.range.start.character)
        for one in found or []
    ]


def test_references_are_found_in_all_files() -> None:
    """The pin is used in the call, declared in the block and used twice there."""
    place = at_cursor(_MAIN, Pump=_PUMP)
    everywhere = [("Main.st", 1, 2), ("Pump.st", 1, 10), ("Pump.st", 2, 0), ("Pump.st", 2, 9)]
    assert _places(references(*place.args)) == everywhere
    del everywhere[1]
    assert _places(references(*place.args, declared=False)) == everywhere


def test_references_of_a_method_include_its_overrides() -> None:
    """The call through the interface and both declarations are one family."""
    text = """INTERFACE Runs METHOD Run END_METHOD END_INTERFACE
FUNCTION_BLOCK One IMPLEMENTS Runs METHOD Run END_METHOD END_FUNCTION_BLOCK
PROGRAM Main VAR r : Runs; END_VAR
r.R|un();
END_PROGRAM
"""
    lines = [line for _, line, _ in _places(references(*at_cursor(text).args))]
    assert lines == [0, 1, 3]


def test_highlights_tell_reading_from_writing() -> None:
    """In line 3 the pin is written and then read; its declaration is neither."""
    kinds = lsp.DocumentHighlightKind
    text = "PROGRAM Main VAR a : INT; END_VAR\n|a := a + 1;\nEND_PROGRAM\n"
    found = highlights(*at_cursor(text).args)
    assert found is not None
    assert [(one.range.start.line, one.range.start.character, one.kind) for one in found] == [
        (0, 17, kinds.Text),
        (1, 0, kinds.Write),
        (1, 5, kinds.Read),
    ]


def test_an_unknown_name_has_no_references() -> None:
    """The name x is not declared."""
    assert references(*at_cursor("PROGRAM Main\n|x := 1;\nEND_PROGRAM\n").args) is None
