"""The search for shorter storms with the same failure (delta debugging)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TypeVar

from rcx_harness.cell.stimulus import Entry
from rcx_harness.verify.storm.storms import Failure, Storm

__all__ = ["shrink", "thin_out"]

#: Greatest number of runs to shorten one failure.
MOST_TRIES = 250
#: Times are rounded to multiples of these times [us]. The greatest of them is tried first.
_ROUND_US = (1_000_000, 500_000, 100_000, 10_000, 1_000)

_Item = TypeVar("_Item")


def shrink(
    run: Callable[[Sequence[Storm]], object],
    storms: Sequence[Storm],
    failure: Failure,
    tries: int = MOST_TRIES,
    tried: Callable[[], None] = lambda: None,
) -> tuple[list[Storm], Failure]:
    """Find a shorter run that fails in the same way.

    `run` runs storms and raises the failure that they cause. At most `tries` runs are made. `tried`
    is called after each run.

    Returns:
        The storms of the shortest run that was found, and the failure of this run.
    """
    best, found = list(storms), failure

    def fails(candidate: Sequence[Storm]) -> bool:
        nonlocal best, found, tries
        if tries <= 0:
            return False
        tries -= 1
        try:
            run(candidate)
        except Failure as now:
            if now.kind == failure.kind:
                best, found = list(candidate), now
                return True
        finally:
            tried()
        return False

    # First storms at the end are removed, because the failure ends the run. Then storms before
    # the last are removed. Finally actions are removed from each storm, its duration is reduced,
    # and its times are rounded. `fails` updates `best` whenever a shorter run fails with the same
    # kind.
    for count in range(len(best)):
        if fails(storms[:count]):
            break
    if len(best) > 1 and not fails(best[-1:]):
        thin_out(best, fails)
    for number in range(len(best) - 1, -1, -1):
        if number >= len(best):
            continue

        def with_acts(acts: Sequence[Entry], number: int = number) -> bool:
            return fails(_with(best, number, Storm(acts, best[number].length_us)))

        thin_out(best[number].acts, with_acts)
        ends_us = [part.t_us for act in best[number].acts for part in act.parts()]
        for longer_us in (0, 1_000_000):
            length_us = max(ends_us, default=0) + longer_us
            if length_us >= best[number].length_us:
                break
            if fails(_with(best, number, Storm(best[number].acts, length_us))):
                break
        _make_round(best, number, with_acts)
    return best, found


def _with(storms: Sequence[Storm], number: int, one: Storm) -> list[Storm]:
    """Return a copy of the storms in which the storm at index `number` is replaced."""
    return [*storms[:number], one, *storms[number + 1 :]]


def thin_out(items: Sequence[_Item], fails: Callable[[list[_Item]], bool]) -> list[_Item]:
    """Remove items in smaller and smaller groups. A group stays if the failure needs it."""
    left = list(items)
    piece = max(1, len(left) // 2)
    while True:
        at = 0
        shorter = False
        while at < len(left):
            rest = left[:at] + left[at + piece :]
            if fails(rest):
                left, shorter = rest, True
            else:
                at += piece
        if piece == 1 and not shorter:
            return left
        piece = max(1, piece // 2)


def _make_round(
    best: Sequence[Storm], number: int, fails: Callable[[Sequence[Entry]], bool]
) -> None:
    """Round the times and durations of the remaining actions if the storm still fails."""
    acts = list(best[number].acts)
    for place in range(len(acts)):
        for round_us in _ROUND_US:
            act = acts[place]
            t_us = round(act.t_us / round_us) * round_us
            held_us = act.held_us and max(round_us, round(act.held_us / round_us) * round_us)
            rounded = replace(act, t_us=t_us, held_us=held_us)
            if (t_us, held_us) == (act.t_us, act.held_us):
                break
            if fails([*acts[:place], rounded, *acts[place + 1 :]]):
                acts[place] = rounded
                break
