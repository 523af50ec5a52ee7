"""The bench's arithmetic; what it measures is measured by `make bench` only."""

from __future__ import annotations

from rcx_harness.bench import Measured, figures, percentile

RUN = Measured(10_000, 60.0, 6000, 0, 9_999, 10_200, 10_100)


def test_a_run_without_a_missing_packet_meets_its_targets() -> None:
    found = figures(RUN)
    assert list(found) == [
        "cyclic_10ms_missing",
        "cyclic_10ms_rate",
        "cyclic_10ms_gap_median",
        "cyclic_10ms_gap_p99",
    ]
    assert all(one.met for one in found.values())
    assert found["cyclic_10ms_rate"].value == 1.0
    assert found["cyclic_10ms_gap_p99"].value == 1.01


def test_missing_packets_a_low_rate_and_wide_gaps_do_not() -> None:
    bad = Measured(10_000, 60.0, 5800, 2, 9_999, 30_000, 10_100)
    met = {name.rpartition("ms_")[2]: one.met for name, one in figures(bad).items()}
    assert met == {"missing": False, "rate": False, "gap_median": True, "gap_p99": False}


def test_the_percentile_of_a_few_values() -> None:
    assert percentile([], 0.99) == 0
    assert percentile([5], 0.99) == 5
    assert percentile(list(range(1, 101)), 0.99) == 100
    assert percentile(list(range(1, 101)), 0.5) == 51
