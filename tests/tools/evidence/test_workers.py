"""Work in several processes: all results, or an end that is told."""

from __future__ import annotations

import math
import os

import pytest

from rcx_harness.enip.errors import ProcessDiedError
from rcx_tools.evidence.workers import results


def test_all_results_come_in_any_order() -> None:
    assert sorted(results(math.factorial, range(6), 2)) == [1, 1, 2, 6, 24, 120]


def test_a_worker_that_dies_is_told_and_nothing_waits_for_it() -> None:
    with pytest.raises(ProcessDiedError, match="a worker has ended by itself"):
        list(results(os._exit, [3, 3], 1))


def test_a_result_that_fails_is_raised() -> None:
    with pytest.raises(ValueError, match="not defined for negative"):
        list(results(math.factorial, [-1], 1))
