"""A compiled program that several benches use in sequence."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Hashable, Sequence
from typing import TypeVar

from structured_text.engines.base import Program
from structured_text.engines.builtin.collector import collecting
from structured_text.engines.load import build
from structured_text.language import cache
from structured_text.projects.sources import SourceFiles

__all__ = ["Compiled"]

#: Number of programs of closed benches that this process saves for later benches.
_WAITING = 8
#: Environment variables that influence the choice of an engine.
_CHOICE = ("RCX_MATIEC", "RCX_STRUCPP", "RCX_CACHE", "PATH", "CC", "CXX")

_Made = TypeVar("_Made", bound="Compiled")

_waiting: OrderedDict[Hashable, Compiled] = OrderedDict()


class Compiled:
    """A compiled program with its sources, notes and retained variables.

    Raises:
        InputError: The sources have an error, or the engine cannot run them.
    """

    def __init__(self, files: SourceFiles, engine: str = "auto") -> None:
        self.files = files
        if (collector := collecting()) and files.folder is not None:
            collector.leave_out(files.folder)
        built = build(files.all, engine)
        self.program: Program = built.program
        self.retained = built.retained
        self.notice = "\n".join(filter(None, (*files.notes, built.notice)))
        self.mistakes: Sequence[str] = ()
        self._first = self.program.snapshot()
        self._name: Hashable = None

    @classmethod
    def take(cls: type[_Made], files: SourceFiles, engine: str = "auto") -> _Made:
        """Return the cached program for these sources and options, or compile a new one.

        A cached program is reset to its state before the first scan.

        Raises:
            InputError: The sources have an error, or the engine cannot run them.
        """
        key = "" if collecting() else cache.sources_key(files.all)
        name = (cls, key, files, engine, *map(os.environ.get, _CHOICE)) if key else None
        found = _waiting.pop(name, None)
        if isinstance(found, cls):
            found.fresh()
            return found
        made = cls(files, engine)
        made._name = name
        return made

    def leave(self) -> None:
        """Release the program: cache it for the next bench of the same sources, or close it."""
        if self._name is None or self._name in _waiting:
            self.close()
            return
        _waiting[self._name] = self
        if len(_waiting) > _WAITING:
            _waiting.popitem(last=False)[1].close()

    def fresh(self) -> Program:
        """Reset the program to its state before the first scan, and return it.

        All users of this object share the program.
        """
        self.program.restore(self._first)
        return self.program

    def close(self) -> None:
        """Free the program."""
        self.program.close()
