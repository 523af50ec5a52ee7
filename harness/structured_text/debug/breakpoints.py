"""Where to stop: lines with a condition, a count or a message, blocks, variables that change."""

from __future__ import annotations

import re
from bisect import bisect_left, insort
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from operator import eq, ge, gt, le, lt
from typing import Any

from structured_text.debug.expressions import Compiled
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
    """At which of its hits a breakpoint stops: `5` the fifth, `>= 5`, `% 10` each tenth."""

    compare: Callable[[int, int], bool]
    number: int

    @classmethod
    def of(cls, text: str) -> Counting:
        """Read it.

        Raises:
            InputError: it is none.
        """
        found = _COUNT.fullmatch(text)
        if found is None:
            raise InputError(f"{text!r} is no count of hits", hint="write 5, >= 5 or % 10")
        return cls(_COMPARE[found[1] or "=="], int(found[2]))


@dataclass(frozen=True)
class Message:
    """What a logpoint says: texts, and expressions between them."""

    parts: tuple[str | Compiled, ...]


def message_of(text: str, compiled: Callable[[str], Compiled]) -> Message:
    """A message with expressions in braces.

    Raises:
        InputError: an expression is wrong.
    """
    parts: list[str | Compiled] = []
    for number, part in enumerate(_BRACES.split(text)):
        parts.append(compiled(part) if number % 2 else part)
    return Message(tuple(parts))


@dataclass(eq=False)
class Breakpoint:
    """Statements before which to stop.

    Attributes:
        number: By which the client knows it.
        lines: Lines of the module, by the upper-case name of the POU.
        conditions: By POU; without one it always stops.
        counting: Which of its hits stops.
        messages: By POU: what to say instead of stopping.
        entry: Only the first statement of a call counts.
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
        """A scan begins, perhaps once more."""
        self._here = scan, 0

    def hit(self, pou: str, variables: Mapping[str, Any]) -> bool:
        """Its place is reached: does it stop, or say something?

        Raises:
            InputError: its condition cannot be evaluated.
        """
        condition = self.conditions.get(pou)
        if condition is not None and not condition.value(variables):
            return False
        if self.counting is None:
            return True
        # A hit that is run again is the same hit.
        self._here = self._here[0], self._here[1] + 1
        place = bisect_left(self._seen, self._here)
        if place == len(self._seen) or self._seen[place] != self._here:
            insort(self._seen, self._here)
        return self.counting.compare(place + 1, self.counting.number)

    def forget_after(self, scan: int) -> None:
        """What was hit after a scan has not happened."""
        self._seen = [one for one in self._seen if one[0] <= scan]


class DataWatch:
    """A variable that is compared with what it was.

    Attributes:
        number: By which the client knows it; 0 of one that is looked for in the past.
        name: Its path.
    """

    def __init__(
        self, number: int, name: str, get: Callable[[], Any], text: Callable[[Any], str]
    ) -> None:
        self.number, self.name = number, name
        self._get, self._text = get, text
        self.before: Any = None

    def begin(self) -> None:
        """Remember what it is now."""
        self.before = self._now()

    def _now(self) -> Any:
        held = self._get()
        return list(held) if isinstance(held, list) else held

    def changed(self) -> str:
        """What it was and is, where that is no longer the same; else empty."""
        now = self._now()
        if now == self.before:
            return ""
        before, self.before = self.before, now
        return f"{self.name}: {self._text(before)} -> {self._text(now)}"
