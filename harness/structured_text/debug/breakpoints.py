"""Breakpoints: lines with a condition, a count or a message, blocks, and watched variables."""

from __future__ import annotations

import re
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import eq, ge, gt, le, lt
from typing import Any

from structured_text.debug.watch_expressions import Compiled
from structured_text.errors import InputError

__all__ = ["Breakpoint", "Counting", "DataWatch", "Message", "message_of"]

_COUNT = re.compile(r"\s*(==|=|>=|>|<=|<|%)?\s*(\d+)\s*")
_COMPARE: dict[str, Callable[[int, int], bool]] = {
    "==": eq,
    "=": eq,
    ">=": ge,
    ">": gt,
    "<=": le,
    "<": lt,
    "%": lambda hits, number: number > 0 and hits % number == 0,
}
_BRACES = re.compile(r"\{([^{}]*)\}")


@dataclass(frozen=True)
class Counting:
    """A condition on the number of hits.

    `5` is the fifth hit, `>= 5` the fifth and all later hits, `% 10` each tenth hit.
    """

    compare: Callable[[int, int], bool]
    number: int

    @classmethod
    def of(cls, text: str) -> Counting:
        """Parse the text of a count, or raise InputError."""
        found = _COUNT.fullmatch(text)
        if found is None:
            raise InputError(f"{text!r} is not a count of hits", hint="write 5, >= 5 or % 10")
        return cls(_COMPARE[found[1] or "=="], int(found[2]))


@dataclass(frozen=True)
class Message:
    """The message of a logpoint: texts, and expressions between them."""

    parts: tuple[str | Compiled, ...]


def message_of(text: str, compiled: Callable[[str], Compiled]) -> Message:
    """Parse a message with expressions in braces, or raise InputError."""
    parts: list[str | Compiled] = []
    for number, part in enumerate(_BRACES.split(text)):
        parts.append(compiled(part) if number % 2 else part)
    return Message(tuple(parts))


@dataclass(eq=False)
class Breakpoint:
    """A breakpoint: the statements before which the run stops.

    Attributes:
        number: Its identifier for the client.
        lines: Lines of the generated Python module, by the upper-case name of the POU.
        conditions: Conditions by POU. Without a condition, the breakpoint always stops.
        counting: Condition on the number of hits; None if every hit takes effect.
        messages: Messages by POU. With a message, the breakpoint prints it and does not stop.
        entry: Whether only the first statement of a call counts.
    """

    number: int
    lines: Mapping[str, frozenset[int]]
    conditions: Mapping[str, Compiled] = field(default_factory=dict)
    counting: Counting | None = None
    messages: Mapping[str, Message] = field(default_factory=dict)
    entry: bool = False
    _seen: list[tuple[int, int]] = field(default_factory=list)
    _here: tuple[int, int] = (-1, 0)

    def begin(self, scan: int) -> None:
        """Begin a scan, or the repetition of a scan."""
        self._here = scan, 0

    def hit(self, pou: str, variables: Mapping[str, Any]) -> bool:
        """Count a hit and return whether the breakpoint takes effect, or raise InputError.

        The effect is a stop, or the output of the breakpoint's message.
        """
        condition = self.conditions.get(pou)
        if condition is not None and not condition.value(variables):
            return False
        if self.counting is None:
            return True
        # The debugger repeats scans, so a hit is identified by its scan and its number in this
        # scan. A repeated hit is not counted again.
        self._here = self._here[0], self._here[1] + 1
        place = bisect_left(self._seen, self._here)
        if place == len(self._seen) or self._seen[place] != self._here:
            insort(self._seen, self._here)
        return self.counting.compare(place + 1, self.counting.number)

    def forget_after(self, scan: int) -> None:
        """Remove all hits after a scan, because the run continues differently after this scan."""
        self._seen = [one for one in self._seen if one[0] <= scan]


class DataWatch:
    """A variable whose changes are watched.

    Attributes:
        number: The identifier of the watch for the client; 0 for a search backwards.
    """

    def __init__(
        self, number: int, name: str, get: Callable[[], Any], text: Callable[[Any], str]
    ) -> None:
        self.number, self.name = number, name
        self._get, self._text = get, text
        self.before: Any = None

    def begin(self) -> None:
        """Store the current value for comparison."""
        self.before = self._now()

    def _now(self) -> Any:
        held = self._get()
        return list(held) if isinstance(held, list) else held

    def changed(self) -> str:
        """Return old and new value as text if the variable has changed, else an empty text."""
        now = self._now()
        if now == self.before:
            return ""
        before, self.before = self.before, now
        return f"{self.name}: {self._text(before)} -> {self._text(now)}"
