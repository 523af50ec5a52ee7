"""A short test for many values is one item, and names each value that fails."""

from __future__ import annotations

import pytest

from for_each import for_each


def test_each_value_that_fails_is_named() -> None:
    tried = []

    @for_each("number", [1, 2, 3, 4])
    def check(number: int) -> None:
        tried.append(number)
        assert number % 2, "even"

    with pytest.raises(
        AssertionError, match=r"^2 of 4 values failed:\n2: even[^\n]*\n.*\n?4: even"
    ):
        check()
    assert tried == [1, 2, 3, 4]


@for_each("name", ["a", "b"])
@for_each("low, high", [(1, 2), (3, 4)])
def test_fixtures_and_several_values_are_given(
    low: int, high: int, name: str, request: pytest.FixtureRequest
) -> None:
    assert high - low == 1
    assert name in ("a", "b")
    assert request.node.name == "test_fixtures_and_several_values_are_given"


def test_a_list_without_values_is_refused() -> None:
    with pytest.raises(AssertionError, match="without values"):
        for_each("name", [])
