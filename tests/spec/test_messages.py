"""What failures of these tests say: names, and codes, ErrorIDs and words in 16#."""

from __future__ import annotations

import pytest

from shown import differences, hexadecimal_comparison

_PINS = ("Done", "Error", "ErrorID")


def test_a_pin_that_differs_is_named_and_its_error_id_is_in_16() -> None:
    """As docs/reference/errors.md lists it; what agrees is not told."""
    wrong = differences(_PINS, (False, True, 0x8011), (False, True, 0x8015))
    assert wrong == "ErrorID is 16#8011, not 16#8015"
    wrong = differences(_PINS, (True, False, 0), (False, True, 0x8001))
    assert (
        wrong
        == "Done is True, not False; Error is False, not True; ErrorID is 16#0000, not 16#8001"
    )
    assert not differences(_PINS, (True, False, 0), (True, False, 0))


@pytest.mark.parametrize(
    ("op", "left", "right", "told"),
    [
        ("==", 0x8013, 0x8011, ["16#8013 == 16#8011"]),
        ("!=", 0x4000, 0x4000, ["16#4000 != 16#4000"]),
        ("==", 0, 0x8001, ["0 == 16#8001"]),
        ("==", [0x1001, 0, 5], [0x1001, 1, 5], ["different words:", "  [1]: 16#0000, not 16#0001"]),
        (
            "==",
            [0x1001, *[0] * 15],
            [0x1001, 0, 0, 100, *[0] * 12],
            ["different words:", "  [3] (byte 6): 16#0000, not 16#0064"],
        ),
    ],
)
def test_codes_and_words_are_compared_in_16(
    op: str, left: object, right: object, told: list[str]
) -> None:
    """Source: manual, remote command guide 1.2, which writes codes in hexadecimal."""
    assert hexadecimal_comparison(op, left, right) == told


@pytest.mark.parametrize(
    ("left", "right"),
    [(3, 4), (True, False), ("a", "b"), ([1, 2], [1, 3]), ([0x1001], [0x1001, 0]), (-1, 70000)],
)
def test_anything_else_is_compared_as_ever(left: object, right: object) -> None:
    assert hexadecimal_comparison("==", left, right) is None
