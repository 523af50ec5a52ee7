"""Few response times are stored exactly; many are stored to half a per cent, in constant memory."""

from __future__ import annotations

import sys

import pytest

from rcx_harness.look.judge.follow import Times


def test_few_times_are_exact() -> None:
    """Few times are exact: of five, the third is the median, and the fifth is the 99 % limit."""
    times = Times()
    for one in (40, 10, 50, 20, 30):
        times.add(one)
    assert (times.count, times.percentile_us(0.5), times.percentile_us(0.99)) == (5, 30, 50)
    assert times.longest_us == 50
    assert times.exact
    assert Times().percentile_us(0.5) == 0


def test_many_times_are_correct_to_half_a_per_cent() -> None:
    """The median of many times is correct to half a per cent.

    The times are 1 to 100,000 us in a random order, so the median is 50,000 us.
    """
    times = Times()
    for k in range(100_000):
        times.add(k * 7919 % 100_000 + 1)
    assert times.count == 100_000
    assert times.longest_us == 100_000
    assert not times.exact
    assert times.percentile_us(0.5) == pytest.approx(50_000, rel=0.006)
    assert times.percentile_us(0.99) == pytest.approx(99_000, rel=0.006)
    assert times.percentile_us(1.0) <= times.longest_us


def test_memory_does_not_grow_with_the_number_of_times() -> None:
    """A day of response times between 0 us and an hour is stored in some thousand numbers."""

    def kept(times: Times) -> int:
        return sum(sys.getsizeof(part) for part in vars(times).values())

    few, many = Times(), Times()
    for k in range(5_000):
        few.add(k * 1_000_003 % 3_600_000_000)
    for k in range(100_000):
        many.add(k * 1_000_003 % 3_600_000_000)
    assert kept(many) <= 4 * kept(few)
    assert kept(many) < 500_000
