"""All questions, in the order of their risk."""

from __future__ import annotations

from rcx_harness.look.probe.question import Question
from rcx_harness.look.probe.questions import data, handshake, motion, person, reading, signals

__all__ = ["questions"]

_MODULES = (reading, signals, handshake, data, person, motion)


def questions() -> list[Question]:
    """Return all questions by risk; questions without a person at the cell are first."""
    every = [
        one for module in _MODULES for one in vars(module).values() if isinstance(one, Question)
    ]
    return sorted(every, key=lambda one: (one.risk, bool(one.person)))
