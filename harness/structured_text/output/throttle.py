"""A throttle for the lines of a log that runs for days: many lines in a short time are counted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

__all__ = ["BURST", "EVERY_US", "Throttle"]

BURST = 30
"""The number of lines of a kind that pass at once."""

EVERY_US = 5_000_000
"""The time [µs] in which one further line of the kind passes."""


@dataclass
class _Kind:
    room: float
    looked_us: int = 0
    held: int = 0
    last: str = ""
    alike: bool = True


class Throttle:
    """A throttle that limits the rate of log lines; the caller gives the time.

    `burst` is the number of lines of one kind that pass without a limit.
    """

    def __init__(self, burst: int = BURST) -> None:
        self._burst = burst
        self._kinds: dict[str, _Kind] = {}

    def let_pass(self, kind: str, lines: Sequence[str], now_us: int) -> list[str]:
        """Return the lines to write now: a summary of the lines held before, and new lines.

        Each kind of line is limited separately, so no kind suppresses another. If the time goes
        back, the latest time counts.
        """
        one = self._kinds.setdefault(kind, _Kind(self._burst))
        passed_us = max(0, now_us - one.looked_us)
        one.room = min(self._burst, one.room + passed_us / EVERY_US)
        one.looked_us += passed_us
        passed = []
        if one.held and one.room >= 1:
            passed.append(_summary(one))
            one.held, one.room = 0, one.room - 1
        for line in lines:
            if one.room >= 1:
                passed.append(line)
                one.room -= 1
            else:
                one.alike = not one.held or (one.alike and line == one.last)
                one.held, one.last = one.held + 1, line
        return passed

    def flush(self, now_us: int) -> list[str]:
        """Return the summaries of held lines of all kinds that may be written now."""
        return [line for kind in self._kinds for line in self.let_pass(kind, (), now_us)]


def _summary(one: _Kind) -> str:
    if one.held == 1:
        return one.last
    if one.alike:
        return f"{one.last} (repeated {one.held} times)"
    return f"{one.last} (the latest of {one.held}, the others are not shown)"
