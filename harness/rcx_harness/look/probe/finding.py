"""The meaning of the answer to a question, or the reason why it has none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

__all__ = ["Finding", "SkipError"]


class SkipError(Exception):
    """The question cannot be asked here, or its answer decides nothing; the reason in words."""


@dataclass(frozen=True)
class Finding:
    """The meaning of an answer.

    Attributes:
        rule: The name of the rule.
        knob: The key of the rule; empty if the rule has none.
        values: Possible values at the controller; (least, most) if `between`.
        expected: The assumed value.
        text: The evidence, in words.
        between: The value lies between the two values, and is not the first.
    """

    rule: str
    knob: str
    values: tuple[Any, ...]
    expected: Any
    text: str
    between: bool = False

    @property
    def verdict(self) -> str:
        """Return `confirmed`, `refuted`, or `open` if several values are possible."""
        if self.between:
            low, high = self.values
            return "confirmed" if low < self.expected <= high else "refuted"
        if self.expected not in self.values:
            return "refuted"
        return "confirmed" if len(self.values) == 1 else "open"
