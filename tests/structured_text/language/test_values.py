"""Values are shown as in Structured Text, and variables are divided into elements and members."""

from __future__ import annotations

from datetime import date, datetime, time, timedelta
from typing import Any

import pytest

from structured_text.language.displayed import LONGEST, described, literal, parts, typed, value_text
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    Variable,
)

INT = ElementaryType("INT")
STATE = EnumType("STATE", ("IDLE", "RUN"), (0, 10))
GRID = ArrayType("GRID", ((1, 2), (0, 1)), INT)
LONG = ArrayType("LONG", ((1, LONGEST + 1),), INT)
POINT = StructType("POINT", (("X", INT), ("Grid", GRID)))
BLOCK = BlockType("BLOCK", (Variable("Go", ElementaryType("BOOL"), "VAR_INPUT"),
                            Variable("Robot", POINT, "VAR_IN_OUT"),
                            Variable("Limit", INT, "VAR_EXTERNAL"),
                            Variable("Count", INT, "VAR")))  # fmt: skip


@pytest.mark.parametrize(
    ("kind", "value", "text"),
    [
        (ElementaryType("BOOL"), True, "TRUE"),
        (INT, -7, "-7"),
        (ElementaryType("BYTE"), 10, "16#0A"),
        (ElementaryType("LWORD"), 1, "16#0000000000000001"),
        (ElementaryType("REAL"), 0.10000000149011612, "0.1"),
        (ElementaryType("LREAL"), 0.1, "0.1"),
        (ElementaryType("LREAL"), 1 / 3, "0.333333333333333"),
        (ElementaryType("REAL"), float("inf"), "inf"),
        (ElementaryType("STRING", 20), "a b", "'a b'"),
        (ElementaryType("STRING"), "it's\n5 $\x00\x1b\xe9", "'it$'s$0A5 $$$00$1B\xe9'"),
        (ElementaryType("WSTRING"), "\ud83d\ude00 \ud83d", "'\U0001f600 \ufffd'"),
        (ElementaryType("TIME"), timedelta(milliseconds=1500), "T#1500ms"),
        (ElementaryType("LTIME"), timedelta(microseconds=-1500), "T#-1.5ms"),
        (ElementaryType("DATE"), date(2024, 12, 31), "D#2024-12-31"),
        (ElementaryType("TOD"), time(13, 30, 0, 250_000), "TOD#13:30:00.25"),
        (ElementaryType("DT"), datetime(2024, 12, 31, 13, 30), "DT#2024-12-31-13:30:00"),
        (STATE, "RUN", "RUN"),
        (STATE, 3, "3"),
        (ReferenceType("POINTER", INT), "Main.X", "Main.X"),
        (ReferenceType("POINTER", INT), None, "NULL"),
        (InterfaceType("I_RUN"), None, "NULL"),
        (GRID, [[1, 2], [3, 4]], "[1, 2, 3, 4]"),
        (LONG, list(range(LONGEST + 1)), "[0, 1, 2, 3, 4, 5, 6, 7, ...]"),
        (POINT, {"X": 1, "Grid": [[1, 2], [3, 4]]}, "(X := 1, Grid := [1, 2, 3, 4])"),
    ],
)
def test_values_are_shown_as_structured_text(kind: Type, value: Any, text: str) -> None:
    assert value_text(kind, value) == text


def test_a_structure_is_made_of_its_members_and_an_array_of_its_elements() -> None:
    value = {"X": 9, "Grid": [[1, 2], [3, 4]]}
    assert {part.path: part.of(value) for part in parts("P", POINT)} == {
        "P.X": 9,
        "P.Grid[1,0]": 1,
        "P.Grid[1,1]": 2,
        "P.Grid[2,0]": 3,
        "P.Grid[2,1]": 4,
    }


def test_only_members_with_values_of_their_own_are_parts_of_a_block() -> None:
    assert [part.path for part in parts("B", BLOCK)] == ["B.Go", "B.Count"]


def test_an_array_of_very_many_elements_is_one_value() -> None:
    assert [part.path for part in parts("L", LONG)] == ["L"]
    shorter = ArrayType("", ((1, LONGEST),), INT)
    assert len(list(parts("L", shorter))) == LONGEST


def test_the_header_of_a_trace_describes_types() -> None:
    assert described(POINT) == {
        "struct": "POINT",
        "members": {"X": "INT", "Grid": {"array": [[1, 2], [0, 1]], "of": "INT"}},
    }
    assert described(STATE) == {"enum": "STATE", "members": {"IDLE": 0, "RUN": 10}}
    assert described(BLOCK) == {"struct": "BLOCK", "members": {"Go": "BOOL", "Count": "INT"}}
    assert described(ElementaryType("STRING", 20)) == "STRING"
    assert described(ReferenceType("POINTER", INT)) == "POINTER TO INT"


def test_values_unknown_to_json_become_literals() -> None:
    values = {"A": [timedelta(seconds=1), date(2024, 1, 2)], "B": float("nan"), "C": 5}
    assert literal(values) == {"A": ["T#1000ms", "D#2024-01-02"], "B": "nan", "C": 5}
    assert literal("\xe9\ud83d\ude00\ude00") == "\xe9\U0001f600\ufffd", (
        "half a surrogate pair is replaced"
    )


def test_a_type_comes_back_from_its_description() -> None:
    """A type is restored from its description.

    Only a block becomes a structure, because the description does not say that it is a block.
    """
    for kind in (INT, STATE, LONG, GRID, POINT):
        again = typed(described(kind))
        assert described(again) == described(kind)
        assert [part.path for part in parts("X", again)] == [p.path for p in parts("X", kind)]
    assert isinstance(typed(described(BLOCK)), StructType)


@pytest.mark.parametrize("description", [7, None, [], {"enum": "E"}, {"array": 1, "of": "INT"}])
def test_a_wrong_description_of_a_type_is_refused(description: Any) -> None:
    with pytest.raises((AttributeError, KeyError, TypeError, ValueError)):
        typed(description)
