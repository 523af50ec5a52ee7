"""The facts from which causes are derived: signals, words, variables and tasks at a time.

Each fact is known or unknown. An unknown signal is None and never counts as OFF, so a rule cannot
draw a conclusion from a value that was not recorded.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

__all__ = ["Change", "Facts", "Moment"]


#: A number at the end of a name in a path.
_NUMBERED = re.compile(r"(?<=[A-Za-z])(\d+)(?=\.|$)")


class Change(NamedTuple):
    """A value, and the time from which on it was valid; None if the time is not known."""

    t_us: int | None
    value: Any


class Facts:
    """Every fact with its changes in the order of time. Keys are `1:SO(10)` or a path."""

    def __init__(self) -> None:
        self._changes: dict[str, list[Change]] = {}
        self.controllers: set[int] = set()
        #: Broken rules: their times and texts.
        self.broken: list[tuple[int, str]] = []
        #: Paths of instances of blocks, and the names of their types.
        self.blocks: dict[str, str] = {}
        self.last_us = 0

    def take(self, key: str, value: Any, t_us: int | None = None) -> None:
        """Add a value; it is stored only if it differs from the last value."""
        changes = self._changes.setdefault(key, [])
        if not changes or changes[-1].value != value:
            changes.append(Change(t_us, value))

    def take_path(self, path: str, value: Any, t_us: int | None = None) -> None:
        """Add a variable. The members of structures and arrays are variables of their own."""
        if isinstance(value, Mapping):
            for name, member in value.items():
                self.take_path(f"{path}.{name}", member, t_us)
        else:
            self.take(path, value, t_us)

    def changes(self, key: str) -> list[Change]:
        """Return all changes of a fact; empty if it is not known."""
        return self._changes.get(key, [])

    def paths(self) -> Iterator[str]:
        """Yield the paths of all variables."""
        return (key for key in self._changes if not key[0].isdigit())


class Moment:
    """The facts of one controller and of the program at a time.

    Args:
        facts: All facts.
        t_us: The time. None is the only moment of a snapshot.
        controller: Number of the controller, from 1.
    """

    def __init__(self, facts: Facts, t_us: int | None, controller: int = 1) -> None:
        self.facts, self.t_us, self.controller = facts, t_us, controller

    def of(self, controller: int) -> Moment:
        """Return the same time at another controller."""
        return Moment(self.facts, self.t_us, controller)

    def earlier(self, t_us: int) -> Moment:
        """Return an earlier time at the same controller."""
        return Moment(self.facts, t_us, self.controller)

    def value(self, key: str) -> Any:
        """Return the value of a variable, or None if it is not known."""
        found = self._change(key)
        return None if found is None else found.value

    def since(self, key: str) -> int | None:
        """Return the time of the last change of a variable; None if the time is not known."""
        found = self._change(key)
        return None if found is None else found.t_us

    def own(self, name: str) -> Any:
        """Return a fact of this controller: `SO(10)`, `SI(06)`, `code`, `status`, `link`."""
        return self.value(f"{self.controller}:{name}")

    def own_since(self, name: str) -> int | None:
        """Return the time of the last change of a fact of this controller."""
        return self.since(f"{self.controller}:{name}")

    def own_changes(self, name: str) -> list[Change]:
        """Return the changes of a fact of this controller up to this time."""
        return self.until(f"{self.controller}:{name}")

    def until(self, key: str) -> list[Change]:
        """Return the changes of a fact up to this time."""
        changes = self.facts.changes(key)
        return changes[: self._number(changes)]

    def is_own(self, path: str) -> bool:
        """Return whether a variable can belong to this controller.

        With several controllers the number at the end of a name decides, as in `Main.Carry2.Lock`.
        """
        several = len(self.facts.controllers)
        if several < 2:
            return True
        numbers = {int(found) for found in _NUMBERED.findall(path)}
        others = set(range(1, several + 1)) & numbers
        return not others or self.controller in others

    def ends(self, *names: str) -> Iterator[tuple[str, Any]]:
        """Yield path and value of each variable with one of these last names."""
        for path in self.facts.paths():
            if path.rpartition(".")[2] in names and (value := self.value(path)) is not None:
                yield path, value

    def _change(self, key: str) -> Change | None:
        changes = self.facts.changes(key)
        number = self._number(changes)
        return changes[number - 1] if number else None

    def _number(self, changes: list[Change]) -> int:
        if self.t_us is None:
            return len(changes)
        return bisect_right(changes, self.t_us, key=_time)


def _time(change: Change) -> int:
    return -1 if change.t_us is None else change.t_us
