"""Conditions and MC/DC of a decision, from the vectors in which it was evaluated."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from rcx_harness.engine.builtin.probes import Decision

__all__ = ["Judged", "judge"]


@dataclass(frozen=True)
class Judged:
    """What is known about one condition of a decision.

    Attributes:
        values: The values it has had.
        masking: It has decided the outcome as TRUE and as FALSE.
        unique: So in two evaluations that differ in nothing else.
    """

    values: frozenset[bool]
    masking: bool
    unique: bool


def judge(decision: Decision, vectors: Collection[int]) -> list[Judged]:
    """Judge the conditions of a decision.

    Args:
        decision: The decision.
        vectors: All vectors in which it was evaluated; bit k is the condition k.
    """
    outcomes = {vector: decision.outcome(vector) for vector in vectors}
    return [_judge(decision, outcomes, 1 << k) for k in range(len(decision.conditions))]


def _judge(decision: Decision, outcomes: dict[int, bool], bit: int) -> Judged:
    decides: set[tuple[bool, bool]] = set()
    for vector, outcome in outcomes.items():
        if decision.outcome(vector ^ bit) != outcome:
            decides.add((bool(vector & bit), outcome))
    return Judged(
        values=frozenset(bool(vector & bit) for vector in outcomes),
        masking=any((not value, not outcome) in decides for value, outcome in decides),
        unique=any(
            vector ^ bit in outcomes and outcomes[vector ^ bit] != outcome
            for vector, outcome in outcomes.items()
        ),
    )
