"""Violations of the manual by the master, as the controller observes them."""

from __future__ import annotations

from structured_text.errors import Violation

__all__ = ["Findings"]


class Findings:
    """All violations in order of time; `drain` returns each violation once."""

    def __init__(self) -> None:
        self.every: list[Violation] = []
        self._drained = 0

    def add(self, t_us: int, rule: str, text: str) -> None:
        """Record a violation of a rule at a time."""
        self.every.append(Violation(t_us, rule, text))

    def drain(self) -> list[Violation]:
        """Return the violations that are new since the last call."""
        new = self.every[self._drained :]
        self._drained = len(self.every)
        return new
