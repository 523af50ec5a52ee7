"""A query to the solver: does a claim follow from assumptions?"""

from __future__ import annotations

import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

import z3

from structured_text.prove.logic import PROVED, REFUTED, UNKNOWN

__all__ = ["Answer", "ask"]


@dataclass(frozen=True)
class Answer:
    """The answer of the solver.

    Attributes:
        status: `proved`, `refuted` or `unknown`.
        seconds: Run time of the solver.
        values: Values of the requested terms in the counterexample, if the claim is refuted.
        reason: If the answer is unknown, the reason that the solver gives.
    """

    status: str
    seconds: float
    values: dict[str, Any] = field(default_factory=dict)
    reason: str = ""


def ask(
    assumed: Iterable[Any],
    claim: Any,
    limit_s: float,
    show: Mapping[str, Any] | None = None,
) -> Answer:
    """Check whether `claim` holds in all cases in which all of `assumed` hold.

    Args:
        assumed: Boolean terms.
        claim: A Boolean term.
        limit_s: Time limit of the solver [s]. After this time the answer is `unknown`.
        show: Terms to evaluate in a counterexample.
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
    values = {name: _told(model, term) for name, term in (show or {}).items()}
    return Answer(REFUTED, seconds, values)


def _told(model: Any, term: Any) -> Any:
    if isinstance(term, (bool, int, float)):
        return term
    value = model.eval(term, model_completion=True)
    if z3.is_bool(value):
        return bool(z3.is_true(value))
    return value.as_long() if z3.is_bv_value(value) else str(value)
