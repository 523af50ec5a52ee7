"""Checks of a chart that its translation relies on."""

from __future__ import annotations

from structured_text.errors import near
from structured_text.projects.diagrams.sfc.model import Chart

__all__ = ["ChartError", "check"]


class ChartError(Exception):
    """The error for a chart that cannot be translated: the message, its line and a hint."""

    def __init__(self, message: str, at: int, hint: str) -> None:
        super().__init__(message)
        self.message, self.at, self.hint = message, at, hint


def check(chart: Chart) -> None:
    """Raise ChartError if names are missing or not unique, or there is not one initial step."""
    known: dict[str, int] = {}
    for step in chart.steps:
        if step.name.upper() in known:
            text = f"there are two steps with the name {step.name}"
            raise ChartError(text, step.at, "give each step a name of its own")
        known[step.name.upper()] = step.at
    initial = [step for step in chart.steps if step.initial]
    if len(initial) != 1:
        at = initial[1].at if initial else min((step.at for step in chart.steps), default=1)
        names = f": {', '.join(step.name for step in initial)}" if initial else ""
        text = f"a chart has exactly one initial step, this chart has {len(initial)}{names}"
        raise ChartError(text, at, "make one step the initial step")
    for one in chart.transitions:
        for name in (*one.sources, *one.targets):
            if name.upper() not in known:
                text = f"there is no step {name}"
                steps = [step.name for step in chart.steps]
                raise ChartError(text, one.at, near(name, steps, "the steps are"))
    seen: set[str] = set()
    for action in chart.actions:
        if action.name.upper() in seen:
            text = f"there are two actions with the name {action.name}"
            raise ChartError(text, action.at, "give each action a name of its own")
        seen.add(action.name.upper())
