"""An RCX_PANEL variable: the keys and selections from its pages, and its displayed values.

The cell's thread calls `exchange` once per scan. All other methods are for the page's thread.
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
"""The time without a message from a page after which its keys are released [s]."""

_TYPE = "RCX_PANEL"
#: The key whose press is never dropped, even if its page falls silent or a page sends too much.
_STOP = frozenset({"Stop"})
#: Maximum number of changes of keys that wait for a scan; only a faulty page sends more.
_MOST_WAITING = 64
#: Maximum number of pages that hold keys, and of pages with a stored last message.
_MOST_HOLDING, _MOST_PAGES = 16, 256
#: Ranges of the numbers that a page may choose.
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
    """The keys that a page holds according to its last message.

    `beat` is the number of the page's last message. It remains stored after the keys are released.
    """

    beat: int = -1
    heard: float = 0.0
    keys: frozenset[str] = field(default_factory=frozenset)


class Plate:
    """The pressed keys, selections and displayed values of one variable.

    Each change of keys is queued and reaches the program in a separate scan. A key that is pressed
    and released between two scans is therefore visible for one scan. A page repeats its message
    while it holds keys. If it falls silent for `HOLD_S`, its keys are released; a waiting Stop is
    delivered all the same.
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
        #: The queued changes: the keys that each page holds after each change.
        self._waiting: deque[dict[str, frozenset[str]]] = deque()
        self._written: frozenset[str] = frozenset()
        self._choices: dict[str, Any] = {}
        self._shown: dict[str, Any] = {}

    def press(self, page: str, beat: int, keys: Collection[str]) -> None:
        """Store the keys that a page holds; a page repeats its message while it holds keys.

        `beat` grows with each message of a page; a late message is ignored.
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
            # A page that sends a message becomes the last page. The first page is dropped first.
            self._pages[page] = one
            if beat > one.beat:
                one.beat, one.heard, one.keys = beat, self._now(), frozenset(keys)
                self._queue()
            if len(self._pages) > _MOST_PAGES:
                del self._pages[next(name for name, old in self._pages.items() if not old.keys)]

    def choose(self, name: str, value: object) -> None:
        """Store a selection for the next scan."""
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
            raise InputError(f"{name} cannot be {value!r:.20}", hint=f"use {takes}")
        with self._lock:
            self._choices[name] = value

    def exchange(self) -> None:
        """Write keys and selections to the program, and read the displayed values.

        Each call writes at most one change of keys, so each press and release is visible for at
        least one scan.
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
        """Return the last read values of the variable, with texts decoded."""
        with self._lock:
            return {"name": self.path, **self._shown}

    def _holding(self) -> dict[str, frozenset[str]]:
        """Return the keys that are held, by page."""
        return {name: one.keys for name, one in self._pages.items() if one.keys}

    def _expire(self) -> None:
        """Release the keys of silent pages; remove their waiting keys except Stop."""
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
        """Add the held keys to the queue of changes.

        If the queue is full, all queued changes are dropped first, except a Stop.
        """
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
    """Return the panels of a program, in the order of their declaration."""
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
    """Return whether the variable is a VAR_IN_OUT, which refers to another variable."""
    return any(
        one.section == "VAR_IN_OUT" and one.name.upper() == name.upper() for one in block.variables
    )


def _readable(value: Any) -> Any:
    """Decode texts: PLC texts are bytes, and the texts of the library are UTF-8."""
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
