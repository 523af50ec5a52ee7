"""CPU time of a quiet processor: what the known work takes longer, a figure is made shorter."""

from __future__ import annotations

import signal
from itertools import accumulate

import pytest

from rcx_tools.bench.pace import (
    REFERENCE_S,
    Cost,
    Slower,
    beside,
    paced,
    paced_throughout,
    reference,
)


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
    """Source: docs/explanation/timing.md; never made longer."""
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


def test_of_long_work_each_slice_is_divided_by_itself() -> None:
    """Quiet for 3 s, then 3 s between quiet and twice as slow, then 2 s twice as slow."""
    known = iter(_takes(1.0, 1.0, 2.0, 2.0))
    # Of the clock: begun, over, begun again, and so on; the known work between takes 7 s.
    clock = accumulate([0.0, 3.0, 7.0, 3.0, 7.0, 2.0, 7.0])

    def work() -> None:
        for _ in range(2):
            signal.raise_signal(signal.SIGPROF)

    former = signal.getsignal(signal.SIGPROF)
    cost = paced_throughout(work, known.__next__, clock.__next__)
    assert cost == pytest.approx((8.0, 3.0 + 3.0 / 1.5 + 2.0 / 2))
    assert signal.getsignal(signal.SIGPROF) == former
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)


def test_of_long_work_the_timer_is_taken_back_after_an_error() -> None:
    def work() -> None:
        raise ValueError("of the work")

    former = signal.getsignal(signal.SIGPROF)
    with pytest.raises(ValueError, match="of the work"):
        paced_throughout(work)
    assert signal.getsignal(signal.SIGPROF) == former
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)


def test_how_much_slower_a_process_is_is_asked_again_after_a_quarter_of_a_second() -> None:
    known, clock = iter(_takes(2.0, 0.5)), iter([10.0, 10.25, 10.3])
    slower = Slower(known.__next__, clock.__next__)
    assert [slower() for _ in range(3)] == pytest.approx([2.0, 2.0, 1.0])


def test_what_was_measured_stands_beside_it() -> None:
    costs = [Cost(0.004, 0.002), Cost(0.003, 0.002), Cost(0.006, 0.002)]
    assert beside(costs, "ms", 1000) == "as measured 4 ms, at best 3"


def test_the_known_work_takes_time() -> None:
    assert reference() > 0
