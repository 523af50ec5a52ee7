"""Names are found in all files by some of their letters."""

from __future__ import annotations

import pytest
from lsprotocol import types as lsp

from cursor import index_of
from structured_text.editor.features.symbols import symbols

_INDEX = {
    "Main": "PROGRAM Main VAR Pump1 : Pump; END_VAR END_PROGRAM\n",
    "Pump": "FUNCTION_BLOCK Pump VAR_INPUT Speed : INT; END_VAR END_FUNCTION_BLOCK\n",
    "GVL": "VAR_GLOBAL BigPump : INT; END_VAR\n",
}


@pytest.mark.parametrize(
    ("query", "names"),
    [
        ("pump", ["Pump", "Pump1", "BigPump"]),
        ("pmp", ["Pump", "BigPump", "Pump1"]),
        ("spd", ["Speed"]),
        ("x", []),
    ],
)
def test_names_with_the_letters_of_a_query_are_found(query: str, names: list[str]) -> None:
    """A name that begins with the query comes first, and a block before a variable."""
    assert [one.name for one in symbols(index_of(**_INDEX), query)] == names


def test_a_symbol_has_its_place_and_what_is_around_it() -> None:
    """The pin is in the first line of the block's file, at character 30."""
    (found,) = symbols(index_of(**_INDEX), "Speed")
    assert found.container_name == "PUMP"
    assert isinstance(found.location, lsp.Location)
    assert found.location.uri.endswith("/Pump.st")
    assert found.location.range.start.character == 30
