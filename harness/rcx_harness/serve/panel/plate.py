"""One RCX_PANEL variable: what a page presses and chooses there, and what it shows.

The cell's thread calls `exchange` once per scan; everything else is for the page's thread.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from threading import Lock
from typing import Any

from structured_text.engines.base import Program
from structured_text.errors import InputError, did_you_mean
from structured_text.language.types import BlockType, EnumType, StructType

__all__ = ["HOLD_S", "Plate", "plates_of"]

HOLD_S = 0.5
"""A key is released when its page has been silent for so long [s]."""

_TYPE = "RCX_PANEL"
#: The key that is lost neither with a silent page nor with a page that sends too much.
_STOP = frozenset({"Stop"})
#: So many changes of keys wait for their scan; a page that sends more has gone wrong.
_MOST_WAITING = 64
#: So many pages hold keys, and of so many the last message is known.
_MOST_HOLDING, _MOST_PAGES = 16, 256
#: Numbers that a page may choose: lowest and highest.
_RANGES = {
    "RobotNumber": (0, 4),
    "Axis": (0, 6),
    "Percent": (0, 100),
    "Amount": (0, 10_000),
    "Point": (0, 29_999),
    "ProgramNumber": (0, 100),
}
_SWITCHES = ("Automatic", "Stepwise")
_ENUMS = ("Frame", "Units", "Language")
_CHOICES = (*_SWITCHES, *_ENUMS, *_RANGES)


@dataclass
class _Page:
    """What one page holds pressed, by its last message; which one that was outlasts the keys."""

    beat: int = -1
    heard: float = 0.0
    keys: frozenset[str] = field(default_factory=frozenset)


class Plate:
    """What is pressed and shown of one variable.

    Args:
        program: The program; `exchange` alone touches it.
        path: The variable.
        now: Seconds that only grow.
    """

    def __init__(
        self, program: Program, path: str, now: Callable[[], float] = time.monotonic
    ) -> None:
        kind = program.type_of(path)
        assert isinstance(kind, StructType)
        fields = dict(kind.fields)
        keys = fields["Key"]
        assert isinstance(keys, StructType)
        self.path = path
        self.keys = tuple(name for name, _ in keys.fields)
        self._enums = {name: one for name, one in fields.items() if isinstance(one, EnumType)}
        self._program, self._now = program, now
        self._read = program.reader([path])
        self._lock = Lock()
        self._pages: dict[str, _Page] = {}
        #: What each page holds, change by change.
        self._waiting: deque[dict[str, frozenset[str]]] = deque()
        self._written: frozenset[str] = frozenset()
        self._choices: dict[str, Any] = {}
        self._shown: dict[str, Any] = {}

    def press(self, page: str, beat: int, keys: Collection[str]) -> None:
        """A page says which keys it holds; again and again as long as there are any.

        Args:
            page: Which page.
            beat: Grows with each message; one that comes too late does not count.
            keys: Their names.

        Raises:
            InputError: no such key, or too many pages or changes.
        """
        for key in keys:
            if key not in self.keys:
                raise InputError(f"there is no key {key!r:.20}", hint=did_you_mean([*self.keys]))
        with self._lock:
            self._expire()
            one = self._pages.pop(page, None) or _Page()
            if keys and not one.keys and len(self._holding()) >= _MOST_HOLDING:
                self._pages[page] = one
                raise InputError("too many pages hold keys", hint="close some of them")
            self._pages[page] = one  # the last one heard is the last to be forgotten
            if beat > one.beat:
                one.beat, one.heard, one.keys = beat, self._now(), frozenset(keys)
                self._queue()
            if len(self._pages) > _MOST_PAGES:
                del self._pages[next(name for name, old in self._pages.items() if not old.keys)]

    def choose(self, name: str, value: object) -> None:
        """Write a selection.

        Raises:
            InputError: no such selection, or a value that it does not take.
        """
        if name not in _CHOICES:
            raise InputError(f"there is no selection {name!r:.20}", hint=", ".join(_CHOICES))
        if name in _SWITCHES:
            fits, takes = isinstance(value, bool), "true or false"
        elif name in _ENUMS:
            members = self._enums[name].members
            fits, takes = value in members, ", ".join(members)
        else:
            low, high = _RANGES[name]
            fits, takes = type(value) is int and low <= value <= high, f"{low} to {high}"
        if not fits:
            raise InputError(f"{name} cannot be {value!r:.20}", hint=f"it takes {takes}")
        with self._lock:
            self._choices[name] = value

    def exchange(self) -> None:
        """Write what is pressed and chosen, and read what is shown; at most one change of keys.

        So each press and each release is there for at least one scan.
        """
        with self._lock:
            self._expire()
            choices, self._choices = self._choices, {}
            keys = _all_of(self._waiting.popleft()) if self._waiting else self._written
            changed, self._written = keys ^ self._written, keys
        written: dict[str, Any] = dict(choices)
        if changed:
            written["Key"] = {name: name in keys for name in self.keys if name in changed}
        if written:
            self._program.write(self.path, written)
        shown = _readable(self._read()[0])
        with self._lock:
            self._shown = shown

    def shown(self) -> dict[str, Any]:
        """The variable as it was read last, texts as people read them."""
        with self._lock:
            return {"name": self.path, **self._shown}

    def _holding(self) -> dict[str, frozenset[str]]:
        """The pages that hold keys, and which."""
        return {name: one.keys for name, one in self._pages.items() if one.keys}

    def _expire(self) -> None:
        """Pages that are silent hold nothing any more; of what still waits of them, Stop stays."""
        last = self._now() - HOLD_S
        silent = [name for name in self._holding() if self._pages[name].heard < last]
        if not silent:
            return
        waiting, self._waiting = self._waiting, deque()
        for name in silent:
            self._pages[name].keys = frozenset()
        for change in waiting:
            stays = {name: keys & _STOP for name, keys in change.items() if name in silent}
            self._append({**change, **stays})
        self._queue()

    def _queue(self) -> None:
        if len(self._waiting) >= _MOST_WAITING:
            stops = any("Stop" in _all_of(change) for change in self._waiting)
            self._waiting.clear()
            if stops:
                self._append({"": _STOP})
        self._append(self._holding())

    def _append(self, change: dict[str, frozenset[str]]) -> None:
        if _all_of(change) != (_all_of(self._waiting[-1]) if self._waiting else self._written):
            self._waiting.append(change)


def _all_of(change: dict[str, frozenset[str]]) -> frozenset[str]:
    return frozenset[str]().union(*change.values())


def plates_of(program: Program, now: Callable[[], float] = time.monotonic) -> list[Plate]:
    """The panels of a program, in the order of their declaration.

    Raises:
        InputError: it has none.
    """
    found = [Plate(program, path, now) for path in _paths(program)]
    if not found:
        raise InputError(
            "--panel: the program has no variable of the type RCX_PANEL",
            hint="declare Panel : RCX_PANEL and give it to FB_Operator, as example 15_panel does",
        )
    return found


def _paths(program: Program) -> Iterator[str]:
    for path, kind in program.walk():
        if isinstance(kind, StructType) and kind.name.upper() == _TYPE:
            owner, _, name = path.rpartition(".")
            above = program.type_of(owner) if owner else None
            if not (isinstance(above, BlockType) and _passed(above, name)):
                yield path


def _passed(block: BlockType, name: str) -> bool:
    """Is it an in-out pin: somebody else's variable?"""
    return any(
        one.section == "VAR_IN_OUT" and one.name.upper() == name.upper() for one in block.variables
    )


def _readable(value: Any) -> Any:
    """Texts of a PLC are bytes; those of the library are UTF-8."""
    if isinstance(value, dict):
        return {name: _readable(one) for name, one in value.items()}
    if isinstance(value, str):
        try:
            return value.encode("latin-1").decode("utf-8")
        except UnicodeError:
            return value
    if isinstance(value, Sequence):
        return [_readable(one) for one in value]
    return value
