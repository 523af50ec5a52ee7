"""Asks the solver: does a claim follow from what is assumed?"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import z3

__all__ = ["PROVED", "REFUTED", "UNKNOWN", "Answer", "ask"]

#: The claim holds for every value; there are values for which it does not; nothing was found out.
PROVED, REFUTED, UNKNOWN = "proved", "refuted", "unknown"


@dataclass(frozen=True)
class Answer:
    """What the solver says.

    Attributes:
        status: `proved`, `refuted` or `unknown`.
        seconds: How long it took.
        values: Where it is refuted: what was asked for, in the case that was found.
        reason: Where it is unknown: why.
    """

    status: str
    seconds: float
    values: dict[str, Any] = field(default_factory=dict)
    reason: str = ""


def ask(
    assumed: Iterable[Any],
    claim: Any,
    limit_s: float,
    show: Mapping[str, Any] | Callable[[], Mapping[str, Any]] | None = None,
) -> Answer:
    """Whether `claim` holds wherever all of `assumed` does.

    Args:
        assumed: Boolean terms.
        claim: A Boolean term.
        limit_s: Seconds of the solver after which it is unknown.
        show: Terms whose values are of use where the claim does not hold; or what finds them then.
    """
    begin = time.monotonic()
    solver = z3.SolverFor("QF_AUFBVFP")
    solver.set("timeout", max(int(limit_s * 1000), 1))
    for one in assumed:
        solver.add(one)
    solver.add(z3.Not(claim) if not isinstance(claim, bool) else z3.BoolVal(not claim))
    found = solver.check()
    seconds = time.monotonic() - begin
    if found == z3.unsat:
        return Answer(PROVED, seconds)
    if found == z3.unknown:
        return Answer(UNKNOWN, seconds, reason=solver.reason_unknown())
    model = solver.model()
    shown = show() if callable(show) else show or {}
    values = {name: _told(model, term) for name, term in shown.items()}
    return Answer(REFUTED, seconds, values)


def _told(model: Any, term: Any) -> Any:
    if isinstance(term, (bool, int, float)):
        return term
    value = model.eval(term, model_completion=True)
    if z3.is_bool(value):
        return bool(z3.is_true(value))
    return value.as_long() if z3.is_bv_value(value) else str(value)
