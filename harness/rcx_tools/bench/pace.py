"""CPU time as a quiet processor would have taken it.

On a shared machine the same work takes up to twice as long from one second to the next, because
others compute on the other half of a processor's core. So a piece of work whose time on the quiet
processor of docs/explanation/timing.md is known is done before and after what is measured, on the
same
processor, and what is measured is divided by how much longer that took; of long work each slice is
divided by itself. It is never made longer: on a faster machine a figure is what was measured.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Callable, Sequence
from statistics import median
from typing import NamedTuple

__all__ = ["REFERENCE_S", "Cost", "Slower", "beside", "paced", "paced_throughout", "reference"]

#: What `reference` takes on the quiet processors that the targets are for; timing.md says how
#: it was found [s].
REFERENCE_S = 0.0094
_STEPS, _NAMES = 40_000, 977
_SLICE_S = 0.25


class Cost(NamedTuple):
    """CPU time as it was measured, and as a quiet processor takes it [s]."""

    measured: float
    quiet: float


def paced(measure: Callable[[], float], known: Callable[[], float] | None = None) -> Cost:
    """What `measure` gives [s], and what a quiet processor would have made of it.

    Args:
        measure: Does something, here or in a process on the same processor; its CPU time [s].
        known: Instead of `reference`.
    """
    known = known or reference
    before = known()
    return _quiet(measure(), before, known())


def paced_throughout(
    work: Callable[[], object],
    known: Callable[[], float] | None = None,
    clock: Callable[[], float] = time.process_time,
) -> Cost:
    """CPU time of long work in this process, the known work done after each 0.25 s of it.

    A timer of the process interrupts it, in the main thread; its other threads go on meanwhile.

    Args:
        work: What is measured.
        known: Instead of `reference`.
        clock: CPU time of this process so far [s].
    """
    slices: list[Cost] = []
    known = known or reference
    before, begun = known(), clock()

    def over(*_: object) -> None:
        nonlocal before, begun
        measured, after = clock() - begun, known()
        slices.append(_quiet(measured, before, after))
        before, begun = after, clock()

    former = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, _SLICE_S, _SLICE_S)
    try:
        work()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, former)
    over()
    return Cost(sum(one.measured for one in slices), sum(one.quiet for one in slices))


def beside(costs: Sequence[Cost], unit: str = "s", factor: float = 1.0) -> str:
    """What was measured, for the peer of a figure: the median, and the best of all."""
    every = [cost.measured * factor for cost in costs]
    return f"as measured {median(every):.3g} {unit}, at best {min(every):.3g}"


def _quiet(measured: float, before: float, after: float) -> Cost:
    """What was measured between two times of the known work."""
    return Cost(measured, measured / max(1.0, (before + after) / 2 / REFERENCE_S))


def reference() -> float:
    """CPU time of the known work: names, a dictionary, lists [s]."""
    begun = time.process_time()
    held: dict[str, int] = {}
    last: list[object] = []
    for number in range(_STEPS):
        name = f"{number % _NAMES}"
        held[name] = held.get(name, 0) + len(name)
        if number % 3 == 0:
            last = [name, number, held[name], last[:1]]
    return time.process_time() - begun


class Slower:
    """How much longer this process takes than on a quiet processor; measured after each 0.25 s.

    Args:
        known: CPU time of the known work [s].
        clock: CPU time of this process so far [s].
    """

    def __init__(
        self,
        known: Callable[[], float] = reference,
        clock: Callable[[], float] = time.process_time,
    ) -> None:
        self._known, self._clock = known, clock
        self._measured_s, self._slower = float("-inf"), 1.0

    def __call__(self) -> float:
        """At least 1."""
        now = self._clock()
        if now - self._measured_s > _SLICE_S:
            self._measured_s, self._slower = now, max(1.0, self._known() / REFERENCE_S)
        return self._slower
