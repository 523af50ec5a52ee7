"""The questions to a controller: their kinds and risks."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import IntEnum
from functools import partial

from rcx_harness.look.probe.asker import Asker

__all__ = ["Question", "Risk", "moving", "reading", "still"]


class Risk(IntEnum):
    """The risk of a question at the cell, the lowest first."""

    READING = 1
    STILL = 2
    MOTION = 3

    @property
    def text(self) -> str:
        """Return a description of the risk for the person at the cell."""
        return {
            Risk.READING: "reading only: SI(00) and SI(06) are OFF, nothing is changed",
            Risk.STILL: "no motion: the servos stay off; signals, data and settings are changed",
            Risk.MOTION: "motion: the servos go on, axes or programs run",
        }[self]


@dataclass(frozen=True)
class Question:
    """One question of a probe.

    Attributes:
        risk: The highest risk at the cell.
        title: The question in one line.
        does: Description of the action at the cell, for the person who confirms it.
        decides: Maps each rule that the answer decides to its keys; a rule may have no keys.
        ask: Function that asks the question and reports findings.
        person: Action that the person must take; empty if none.
    """

    id: str
    risk: Risk
    title: str
    does: str
    decides: Mapping[str, tuple[str, ...]]
    ask: Callable[[Asker], None] = field(compare=False)
    person: str = ""


def _asked(
    risk: Risk, decides: Mapping[str, tuple[str, ...]], *, does: str = "", person: str = ""
) -> Callable[[Callable[[Asker], None]], Question]:
    """Register a function as a question.

    The docstring of the function is the title of the question.
    """

    def made(ask: Callable[[Asker], None]) -> Question:
        name = ask.__name__.replace("_", "-")
        return Question(name, risk, ask.__doc__ or "", does, decides, ask, person)

    return made


#: Decorators that make a function a question, one decorator for each risk.
reading, still, moving = (partial(_asked, risk) for risk in Risk)
