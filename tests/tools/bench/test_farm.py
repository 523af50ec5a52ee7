"""The verdicts of seeds do not depend on who gives them; how fast they come is not judged here."""

from __future__ import annotations

import pytest

from rcx_tools.bench.farm import Timed, busy, measure, verdict
from rcx_tools.bench.figure import Options


@pytest.mark.exhaustive
def test_workers_give_the_verdicts_of_this_process() -> None:
    """Source: docs/how-to/cluster.md, what is the same."""
    found = measure(Options(quick=True))
    assert found["farm_verdicts_that_differ"].value == 0
    assert found["farm_verdicts_that_differ"].peer == "12 seeds without workers and with 1, 2, 4"


def test_each_seed_is_a_cell_of_its_own_that_is_as_fast_as_it_can_be() -> None:
    """Source: docs/explanation/timing.md."""
    seen = [verdict(seed) for seed in range(8)]
    assert len({one.case for one in seen}) == 8
    assert all(one.took == one.minimum for one in seen)


def test_the_share_of_a_workers_time_counts_from_its_first_end_to_the_last_one() -> None:
    """Worker 1 has an item in 6 of 8 s (2 to 10), worker 2 in 4 of 5 s (5 to 10): 10 of 13."""
    one = verdict(0)
    times = [(1, 0, 2), (1, 2, 5), (2, 1, 5), (1, 6, 9), (2, 6, 10)]
    run = [Timed(one, worker, begin, end, 1.0) for worker, begin, end in times]
    assert busy(run) == 10 / 13
