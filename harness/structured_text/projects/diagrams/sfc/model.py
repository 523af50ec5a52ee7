"""The model of a Sequential Function Chart, which no form or file format determines.

Source: IEC 61131-3, 2.6 (third edition: 6.7).
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from structured_text.language.source import Line

__all__ = ["PULSES", "QUALIFIERS", "STORED", "TIMED", "Action", "Association", "Chart", "Step"]
__all__ += ["Transition", "has_chart"]

#: Qualifiers with a time.
TIMED = ("L", "D", "SD", "DS", "SL")
#: Qualifiers that look at the edges of a step.
PULSES = ("P", "P1", "P0")
#: Qualifiers whose effect lasts longer than the step, until R.
STORED = ("S", "SD", "DS", "SL")
QUALIFIERS = ("N", "R", "S", *PULSES, *TIMED)
_CHART = re.compile(r"\bINITIAL_STEP\b", re.IGNORECASE)


def has_chart(text: str) -> bool:
    """Return whether a source may contain a chart; the word may also be in a comment."""
    return _CHART.search(text) is not None


@dataclass(frozen=True)
class Association:
    """An action block: a step's relation to an action or Boolean variable.

    Attributes:
        action: The name of the action or Boolean variable.
        qualifier: One of `QUALIFIERS`.
        time: The time of a qualifier in `TIMED`, as an expression; otherwise empty.
        at: Line in the file.
    """

    action: str
    qualifier: str = "N"
    time: str = ""
    at: int = 1


@dataclass(frozen=True)
class Step:
    """A step; exactly one step of a chart is `initial`."""

    name: str
    initial: bool = False
    associations: tuple[Association, ...] = ()
    at: int = 1


@dataclass(frozen=True)
class Transition:
    """A transition from steps that must all be active to steps that become active.

    Attributes:
        sources: Names of the steps before the transition; several in a simultaneous convergence.
        targets: Names of the steps behind it; several in a simultaneous divergence.
        condition: The lines of a Boolean expression.
        priority: A lower number comes first; transitions without a number come last.
        name: Its name; may be empty.
        at: Line in the file.
    """

    sources: tuple[str, ...]
    targets: tuple[str, ...]
    condition: tuple[Line, ...]
    priority: int | None = None
    name: str = ""
    at: int = 1

    @property
    def label(self) -> str:
        """Return the transition as comments and messages show it."""
        named = f"{self.name}: " if self.name else ""
        return f"{named}{_listed(self.sources)} -> {_listed(self.targets)}"


def _listed(names: tuple[str, ...]) -> str:
    return names[0] if len(names) == 1 else f"({', '.join(names)})"


@dataclass(frozen=True)
class Action:
    """An action with statements. A Boolean variable as an action has no `Action`."""

    name: str
    body: tuple[Line, ...] = ()
    at: int = 1


@dataclass(frozen=True)
class Chart:
    """A chart; steps, transitions and actions are in the order of the file.

    `before` are statements that are executed in every scan before the transitions, such as the
    networks that conditions are connected to.
    """

    steps: tuple[Step, ...]
    transitions: tuple[Transition, ...] = ()
    actions: tuple[Action, ...] = ()
    before: tuple[Line, ...] = field(default=())
