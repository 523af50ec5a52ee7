"""The share of the mutants that the quick tests find, compared with all tests."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from rich.console import Console

from structured_text.mutants.report import Judged

__all__ = ["QUICK_GOAL", "print_quick_tier", "quick_tier"]

#: Least share of the found mutants that `make test` must find [%].
QUICK_GOAL = 95.0
_MOST = 12


def quick_tier(judged: Sequence[Judged], exhaustive: Collection[str]) -> dict[str, Any]:
    """Return the share of the killed mutants that the quick tests find.

    Exhaustive tests run last. If an exhaustive test has found a mutant, no quick test finds it.

    Args:
        judged: All mutants, each with the test that has found it.
        exhaustive: Tests that `make test` leaves out.

    Returns:
        `killed`: number of mutants that a quick test kills; `share`: their share of all killed
        mutants [%]; `only_exhaustive`: number of mutants that only exhaustive tests find, for each
        test function.
    """
    killed = [mutant for mutant in judged if mutant.killed]
    late = Counter(mutant.by.partition("[")[0] for mutant in killed if mutant.by in exhaustive)
    quick = len(killed) - late.total()
    share = round(100.0 * quick / len(killed), 2) if killed else 100.0
    return {"killed": quick, "share": share, "only_exhaustive": dict(late.most_common())}


def print_quick_tier(console: Console, kind: str, found: Mapping[str, Any]) -> None:
    """Print the scores of the quick tests and of all tests, and the kills by exhaustive tests."""
    tier = found["quick"]
    score = 100.0 * tier["killed"] / found["mutants"] if found["mutants"] else 100.0
    console.print(
        f"{kind}: make test finds {tier['killed']} of {found['mutants']} ({score:.2f} %), all tests"
        f" find {found['killed']} ({found['score']:.2f} %); quick share {tier['share']:.2f} %",
        highlight=False,
    )
    for function, count in list(tier["only_exhaustive"].items())[:_MOST]:
        console.print(f"  {count:>4} only by {function}", highlight=False, markup=False)
