"""A failing run made short: storms and acts that it does not need are taken out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rcx_tools.evidence.campaign.run import Failure, Storm, run_storms
from rcx_tools.evidence.campaign.schedule import Act, Conditions
from rcx_tools.evidence.campaign.station import Compiled

__all__ = ["shrink"]

#: Runs that are tried at most.
MOST_TRIES = 250


def shrink(
    compiled: Compiled,
    conditions: Conditions,
    storms: Sequence[Storm],
    seed: int,
    failure: Failure,
    tries: int = MOST_TRIES,
    tried: Callable[[], None] = lambda: None,
) -> tuple[list[Storm], Failure]:
    """Find a shorter run that fails in the same way.

    Args:
        compiled: The program.
        conditions: Of the run.
        storms: Of the run.
        seed: Of the run.
        failure: How it fails; a shorter run must fail with the same kind.
        tries: How many runs may be tried.
        tried: Called after each of them.

    Returns:
        The storms of the shortest run found, and how it fails.
    """
    best, found = list(storms), failure

    def fails(candidate: Sequence[Storm]) -> bool:
        nonlocal best, found, tries
        if tries <= 0:
            return False
        tries -= 1
        try:
            run_storms(compiled, conditions, candidate, seed)
        except Failure as now:
            if now.kind == failure.kind:
                best, found = list(candidate), now
                return True
        finally:
            tried()
        return False

    for count in range(1, len(best) + 1):
        if fails(storms[:count]):
            break
    if len(best) > 1:
        fails(best[-1:])
    _thin_out(best, fails)
    last = max((act.t_us for act in best[-1].acts), default=0) if best else 0
    if best:
        fails([*best[:-1], Storm(best[-1].acts, min(best[-1].length_us, last + 1_000_000))])
    return best, found


def _thin_out(storms: list[Storm], fails: Callable[[list[Storm]], bool]) -> None:
    """Take out acts of the last storm, in ever smaller pieces (delta debugging)."""
    if not storms:
        return
    *before, last = storms
    acts: list[Act] = list(last.acts)
    piece = max(1, len(acts) // 2)
    while True:
        at = 0
        shorter = False
        while at < len(acts):
            rest = acts[:at] + acts[at + piece :]
            if fails([*before, Storm(rest, last.length_us)]):
                acts, shorter = rest, True
            else:
                at += piece
        if piece == 1 and not shorter:
            return
        piece = max(1, piece // 2) if piece > 1 else 1
