"""Values that tests and tools write are checked, and are never wrapped or cut."""

from __future__ import annotations

from datetime import date, datetime, time, timedelta
from typing import Any

import pytest

from structured_text.errors import InputError
from structured_text.language.types import ArrayType, ElementaryType, EnumType, StructType, Type
from structured_text.language.values import from_python, scalar_to_python

COLOUR = EnumType("Colour", ("RED", "GREEN"))
INT = ElementaryType("INT")
GRID = ArrayType("Grid", ((0, 1), (1, 3)), INT)
PAIR = StructType("Pair", (("First", INT), ("Second", COLOUR)))


def _elementary(name: str) -> ElementaryType:
    return ElementaryType(name)


@pytest.mark.parametrize(
    ("kind", "value", "held"),
    [
        (_elementary("BOOL"), True, True),
        (_elementary("SINT"), -128, -128),
        (_elementary("LWORD"), 2**64 - 1, 2**64 - 1),
        (_elementary("REAL"), 1, 1.0),
        (_elementary("REAL"), 0.1, 0.10000000149011612),
        (_elementary("LREAL"), 0.1, 0.1),
        (_elementary("STRING"), "abc", "abc"),
        (_elementary("TIME"), timedelta(milliseconds=1500), 1_500_000_000),
        (_elementary("TIME"), "T#-1m2s", -62_000_000_000),
        (_elementary("DATE"), date(1970, 1, 2), 86_400_000_000_000),
        (_elementary("TOD"), time(0, 1, 0, 5), 60_000_005_000),
        (_elementary("DT"), datetime(1970, 1, 1, 0, 0, 1), 1_000_000_000),
        (COLOUR, "green", 1),
        (COLOUR, "Colour#RED", 0),
        (GRID, [[1, 2, 3], [4, 5, 6]], [1, 2, 3, 4, 5, 6]),
        (PAIR, {"second": "GREEN"}, {"Second": 1}),
    ],
)
def test_a_value_of_the_type_is_taken(kind: Type, value: Any, held: Any) -> None:
    assert from_python(kind, value, "Main.X") == held


@pytest.mark.parametrize(
    ("kind", "value", "message"),
    [
        (_elementary("BOOL"), 1, "use true or false"),
        (_elementary("SINT"), 128, "use a whole number from -128 to 127"),
        (_elementary("UINT"), -1, "use a whole number from 0 to 65535"),
        (INT, True, "use a whole number"),
        (INT, 1.0, "use a whole number"),
        (_elementary("REAL"), 1e39, "use a number"),
        (_elementary("REAL"), "1", "use a number"),
        (_elementary("STRING"), 5, "use up to 126 single-byte characters"),
        (_elementary("CHAR"), 5, "use one single-byte character"),
        (_elementary("STRING"), "x" * 127, "use up to 126 single-byte characters"),
        (_elementary("STRING"), "\u20ac", "use up to 126 single-byte characters"),
        (_elementary("TIME"), 5, "use a timedelta or a literal such as T#1500ms"),
        (_elementary("TIME"), "5", "Main.X is of type TIME and cannot be '5'"),
        (_elementary("DATE"), datetime(2024, 1, 1), "use a datetime.date"),
        (_elementary("TOD"), 5, "use a datetime.time"),
        (COLOUR, "BLUE", "use one of RED, GREEN"),
        (COLOUR, 1, "use one of RED, GREEN"),
        (GRID, [1, 2, 3, 4, 5, 6], "cannot take 6 elements; give a list of 2"),
        (GRID, [[1, 2], [3, 4]], "Main.X[0] is of type Grid and cannot take 2 elements"),
        (PAIR, {"Third": 1}, "has no field Third; use First, Second"),
        (PAIR, 5, "give a dict of its fields"),
        (PAIR, {"First": 40000}, "Main.X.First is of type INT and cannot be 40000"),
    ],
)
def test_any_other_value_is_refused_with_the_path(kind: Type, value: Any, message: str) -> None:
    with pytest.raises(InputError) as caught:
        from_python(kind, value, "Main.X")
    assert message in str(caught.value)
    assert "Main.X" in str(caught.value)


@pytest.mark.parametrize(
    ("name", "held", "value"),
    [
        ("TIME", 1_500_000_999, timedelta(microseconds=1_500_000)),
        ("TIME", -1_999, timedelta(microseconds=-1)),
        ("DATE", 86_400_000_000_000, date(1970, 1, 2)),
        ("TOD", 60_000_005_000, time(0, 1, 0, 5)),
        ("DT", 1_000_000_000, datetime(1970, 1, 1, 0, 0, 1)),
        ("BOOL", 0, False),
    ],
)
def test_values_are_read_in_whole_microseconds(name: str, held: Any, value: Any) -> None:
    assert scalar_to_python(_elementary(name), held) == value
