"""The power of a rung at each place, and the statements that use it.

A condition is a part of each expression that uses the power behind it, as long as no statement in
between writes a variable of the condition. Otherwise, and if several statements use the power of
more than one contact, the power is calculated at its place and kept in a variable.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from structured_text.projects.rockwell.expression_reader import bare
from structured_text.projects.rockwell.ladder.paths import Path, meet, paths_of

__all__ = ["FALSE", "POWER", "TRUE", "Action", "Flow", "Power", "negated"]

TRUE, FALSE = "TRUE", "FALSE"
#: The power of an instruction in its trace.
POWER = "?"
_PASSED = re.compile(r"^[^?]*:= \?(?:;$|[,)][^?]*$)")
_NOT = "NOT "
_INDENT = "  "
_NAME = re.compile(r"[\w.]+(?:\[[\w, ]*\][\w.]*)*")
#: A condition up to this length is written again instead of kept in a variable.
_SHORT = 60

Statements: TypeAlias = Callable[[str], Iterable[str]]
"""A function from the text of the power to the lines of the statements."""


@dataclass(eq=False)
class Power:
    """The power at a place of a rung: the power of another place AND a condition or a branch.

    Attributes:
        place: Number of actions in front of the place.
        base: The power of the other place; None at the beginning of the rung.
        condition: The condition, an operand of AND; empty for a branch.
        legs: The power at the end of each leg of a branch, which begins with the power of `base`.
        variable: The variable that holds the power, if it is needed.
    """

    place: int
    base: Power | None = None
    condition: str = TRUE
    legs: tuple[Power, ...] = ()
    variable: str = ""

    @property
    def constant(self) -> str:
        """Return TRUE or FALSE if the power never changes, otherwise an empty text."""
        before = self.base.constant if self.base is not None else TRUE
        if before == FALSE or self.condition == FALSE:
            return FALSE
        return TRUE if before == self.condition == TRUE else ""


@dataclass(eq=False)
class Action:
    """Statements at a place of a rung.

    Attributes:
        power: The power of the place.
        statements: The function that makes the statements.
        guarded: Whether the statements are executed only if the power is TRUE.
        writes: The variables that they may write; None for any variable.
        named: Whether the power must be a single name or contact, because the statements use it
            several times.
        leaves: The condition on which the rest of the rung is not executed; empty for never.
    """

    power: Power
    statements: Statements
    guarded: bool
    writes: frozenset[Path] | None
    named: bool = False
    leaves: str = ""


@dataclass
class _Use:
    """An expression that contains a power: its place, and the power that is left out of it.

    The actions in front of the place are executed before the expression.
    """

    place: int
    until: Power | None = None


class Flow:
    """The power of a rung from left to right.

    Args:
        start: The power at the left rail: TRUE, FALSE or a variable.
    """

    def __init__(self, start: str = TRUE) -> None:
        self.start = Power(0, condition=start)
        self._powers: list[Power] = [self.start]
        self._actions: list[Action] = []

    # --- the rung -------------------------------------------------------------------------

    @property
    def count(self) -> int:
        """Return the number of actions so far."""
        return len(self._actions)

    def trace(self, before: Power, behind: Power, number: int) -> str:
        """Return what an instruction became: a condition, or a line of its statements.

        Args:
            before: The power in front of the instruction.
            behind: The power behind it.
            number: The number of actions in front of it.

        The line is the first one, or the one that only assigns or passes the power, which is `?`
        in it. The text is empty if there is none.
        """
        for action in self._actions[number:]:
            if action.guarded:
                return next(iter(action.statements(TRUE)), "")
            lines = list(action.statements(POWER))
            return next((line for line in lines if _PASSED.search(line)), "")
        if behind is not before and behind.base is before:
            return behind.condition
        return ""

    def both(self, power: Power, condition: str) -> Power:
        """Return a power AND a condition, which is an operand of AND."""
        if condition == TRUE:
            return power
        return self._new(Power(len(self._actions), power, condition))

    def joined(self, power: Power, legs: Sequence[Power]) -> Power:
        """Return the power behind a branch that begins with `power`."""
        if any(leg is power for leg in legs):
            return power
        live = tuple(leg for leg in legs if leg.constant != FALSE)
        if not live:
            return self.both(power, FALSE)
        if len(live) == 1:
            return live[0]
        return self._new(Power(len(self._actions), power, "", live))

    def _new(self, power: Power) -> Power:
        self._powers.append(power)
        return power

    def act(self, action: Action) -> None:
        """Add statements."""
        self._actions.append(action)

    # --- the statements -------------------------------------------------------------------

    def lines(self, named: Callable[[int], str]) -> Iterator[str]:
        """Yield the lines of the rung; `named` makes the variable of a power from a number."""
        self._choose_variables(named)
        kept = [power for power in self._powers if power.variable]
        indent, number = "", 0
        left: list[str] = []
        while number <= len(self._actions):
            for power in kept:
                if power.place == number and power is not self.start:
                    yield f"{indent}{power.variable} := {_text(power, own=True)};"
            if number == len(self._actions):
                break
            together = self._together(number)
            for text in self._statements(together):
                yield f"{indent}{text}"
            number += len(together)
            leaves = together[-1].leaves
            if leaves and number < len(self._actions):
                yield f"{indent}IF {negated(leaves)} THEN"
                left.append(indent)
                indent += _INDENT
        while left:
            yield f"{left.pop()}END_IF;"

    def _together(self, number: int) -> list[Action]:
        """Return an action, and the actions behind it that the same IF guards."""
        found = [self._actions[number]]
        for action in self._actions[number + 1 :]:
            before = found[-1]
            if not (before.guarded and action.guarded and action.power is before.power):
                break
            if before.leaves or any(power.place == number + len(found) for power in self._powers):
                break
            found.append(action)
        return found

    def _statements(self, actions: Sequence[Action]) -> Iterator[str]:
        power = actions[0].power
        if not actions[0].guarded:
            yield from actions[0].statements(_text(power))
        elif power.constant == TRUE:
            for action in actions:
                yield from action.statements(TRUE)
        elif power.constant != FALSE:
            inner = [text for action in actions for text in action.statements(TRUE)]
            if inner:
                yield f"IF {_text(power)} THEN"
                yield from (f"{_INDENT}{text}" for text in inner)
                yield "END_IF;"

    # --- the choice of variables ----------------------------------------------------------

    def _choose_variables(self, named: Callable[[int], str]) -> None:
        uses: dict[int, list[_Use]] = {id(power): [] for power in self._powers}
        must = set()
        number = 0
        while number < len(self._actions):
            together = self._together(number)
            action = together[0]
            if not (action.guarded and action.power.constant):
                uses[id(action.power)].append(_Use(number))
            if action.named:  # the power is used again after the first of its statements
                must.add(id(action.power))
                uses[id(action.power)].append(_Use(number + 1))
            number += len(together)
        chosen = []
        for power in reversed(self._powers):
            found = uses[id(power)]
            if not found or power.constant:
                continue
            single = _is_single(power)
            kept = self._is_changed(power, found) or (
                not single and (len(found) > 1 or id(power) in must)
            )
            if kept and power is not self.start:
                chosen.append(power)
                power.variable = "?"
                found = [_Use(power.place)]
            for use in found:
                if power.base is not None and power.base is not use.until:
                    uses[id(power.base)].append(use)
                for leg in power.legs:
                    uses[id(leg)].append(_Use(use.place, power.base))
        for number, power in enumerate(reversed(chosen), 1):
            power.variable = named(number)

    def _is_changed(self, power: Power, uses: Iterable[_Use]) -> bool:
        """Return whether an action writes a variable of a condition before its last use."""
        reads = paths_of(power.condition)
        last = max(use.place for use in uses)
        return bool(reads) and any(
            action.writes is None or meet(action.writes, reads)
            for action in self._actions[power.place : last]
        )


def _is_single(power: Power) -> bool:
    """Return whether the power is a single short condition."""
    alone = power.base is None or power.base.constant == TRUE
    return alone and not power.legs and len(power.condition) <= _SHORT


def _text(power: Power, *, own: bool = False, until: Power | None = None) -> str:
    """Return the expression of a power.

    If `own` is true, the variable of the power itself is not used. The power `until`, of which the
    expression is a part, is left out.
    """
    if power.constant:
        return power.constant
    if power.variable and not own:
        return power.variable
    parts: list[str] = []
    place: Power | None = power
    while place is not None and place is not until:
        if place.variable and not (own and place is power):
            parts.append(place.variable)
            break
        if place.legs:
            legs = [_text(leg, until=place.base) for leg in place.legs]
            parts.append(f"({' OR '.join(legs)})")
        elif place.condition != TRUE:
            parts.append(place.condition)
        place = place.base
    text = " AND ".join(reversed(parts))
    return bare(text) if until is None else text


def negated(text: str) -> str:
    """Return the negation of an expression."""
    if text in (TRUE, FALSE):
        return FALSE if text == TRUE else TRUE
    if text.startswith(_NOT) and _NAME.fullmatch(text[len(_NOT) :]):
        return text[len(_NOT) :]
    return f"{_NOT}{text}" if _NAME.fullmatch(text) else f"{_NOT}({text})"
