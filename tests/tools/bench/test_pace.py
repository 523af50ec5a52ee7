"""CPU time of a quiet processor: what the known work takes longer, a figure is made shorter."""

from __future__ import annotations

import pytest

from rcx_tools.bench.pace import REFERENCE_S, Cost, beside, paced, reference


def _takes(*factors: float) -> list[float]:
    return [REFERENCE_S * factor for factor in factors]


@pytest.mark.parametrize(
    ("before", "after", "quiet"),
    [(1.0, 1.0, 3.0), (2.0, 2.0, 1.5), (1.0, 2.0, 2.0), (0.5, 0.5, 3.0)],
    ids=["quiet", "twice as slow", "slow in its second half", "faster than the quiet one"],
)
def test_a_figure_is_divided_by_what_the_known_work_took_longer(
    before: float, after: float, quiet: float
) -> None:
    """Source: docs/timing.md; never made longer."""
    known = iter(_takes(before, after))
    assert paced(lambda: 3.0, known.__next__) == pytest.approx((3.0, quiet))


def test_the_known_work_is_done_before_and_after() -> None:
    order = []

    def known() -> float:
        order.append("known")
        return REFERENCE_S

    def measure() -> float:
        order.append("measured")
        return 1.0

    paced(measure, known)
    assert order == ["known", "measured", "known"]


def test_what_was_measured_stands_beside_it() -> None:
    costs = [Cost(0.004, 0.002), Cost(0.003, 0.002), Cost(0.006, 0.002)]
    assert beside(costs, "ms", 1000) == "as measured 4 ms, at best 3"


def test_the_known_work_takes_time() -> None:
    assert reference() > 0
