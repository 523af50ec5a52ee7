"""Durations are read as people write them, as ST literals, and from Python values."""

from __future__ import annotations

from datetime import timedelta

import pytest

from structured_text.errors import InputError
from structured_text.output.units import parse_us

_YEAR_US = 365 * 24 * 3600 * 1_000_000


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ("10ms", 10_000),
        ("1.5s", 1_500_000),
        ("T#1s500ms", 1_500_000),
        ("time#1m_30s", 90_000_000),
        (" 2h ", 7_200_000_000),
        ("7us", 7),
        ("0s", 0),
        ("365d", _YEAR_US),
        (5, 5),
        (_YEAR_US, _YEAR_US),
        (timedelta(milliseconds=20), 20_000),
    ],
)
def test_a_duration_is_whole_microseconds(given: str | int | timedelta, expected: int) -> None:
    assert parse_us(given) == expected


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("", "'' is not a duration; write it as 10ms, 1.5s or 1m30s"),
        ("5", "'5' is not a duration; write it"),
        ("\u0661s", "'\u0661s' is not a duration; write it"),
        ("nan", "'nan' is not a duration; write it"),
        ("1e9s", "'1e9s' is not a duration; write it"),
        ("-1s", "'-1s' is not a duration; write it"),
        ("9" * 5_000 + "s", f"{'9' * 40}... is not a duration; use 0s to 365d"),
        ("1s2", "'1s2' is not a duration; write it"),
        ("s" * 50, f"'{'s' * 40}...' is not a duration; write it"),
        ("9" * 21 + "s", f"{'9' * 21}s... is not a duration; use 0s to 365d"),
        ("0.5us", "a duration in whole microseconds is expected, not '0.5us'"),
        ("364d25h", "'364d25h' is too long for a duration; use 0s to 365d"),
        (_YEAR_US + 1, "a duration is too long; use 0s to 365d"),
        (timedelta(days=366), "a duration is too long; use 0s to 365d"),
        (-1, "a duration cannot be negative: -1 us"),
        (timedelta(seconds=-1), "a duration cannot be negative: -1000000 us"),
    ],
)
def test_any_other_text_is_refused_as_a_duration(
    given: str | int | timedelta, message: str
) -> None:
    with pytest.raises(InputError) as refused:
        parse_us(given)
    assert str(refused.value).startswith(message)
