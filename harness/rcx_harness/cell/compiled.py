"""A program that is compiled once, for one cell after the other."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Hashable

from rcx_harness.watch.calls_source import call_plan, steady_instances
from rcx_harness.watch.first_mistakes import first_mistakes
from rcx_harness.watch.image_source import image_use
from structured_text.engines.base import Program
from structured_text.engines.builtin.collector import collecting
from structured_text.engines.load import build
from structured_text.language import cache
from structured_text.projects.sources import SourceFiles

__all__ = ["Compiled"]

#: So many programs of closed cells wait in this process for the next cell of theirs.
_WAITING = 8
#: What else an engine is chosen by.
_CHOICE = ("RCX_MATIEC", "RCX_STRUCPP", "RCX_CACHE", "PATH", "CC", "CXX")

_waiting: OrderedDict[Hashable, Compiled] = OrderedDict()


class Compiled:
    """A program with what is known of its sources.

    Args:
        files: Its sources.
        engine: `"auto"`, `"matiec"`, `"builtin"` or `"strucpp"`.

    Raises:
        InputError: anything wrong with the sources or the engine.
    """

    def __init__(self, files: SourceFiles, engine: str = "auto") -> None:
        self.files = files
        if collector := collecting():
            collector.leave_out(self.files.folder)
        built = build(self.files.all, engine)
        self.program: Program = built.program
        self.retained = built.retained
        use = image_use(*self.files.users)
        self.located = use.located
        self.mistakes = (
            *map(str, first_mistakes(*self.files.users)),
            *(
                f"{one.file}:{one.at.line}:{one.at.column}: warning: {one.text}"
                for one in use.findings
            ),
        )
        notes = (*self.files.notes, built.notice, *self.mistakes)
        self.notice = "\n".join(filter(None, notes))
        self.steady = steady_instances(self.files.own, self.files.lib)
        self.calls = call_plan(*self.files.users)
        self._first = self.program.snapshot()
        self._name: Hashable = None

    @classmethod
    def take(cls, files: SourceFiles, engine: str = "auto") -> Compiled:
        """One that another cell of the same sources has left, from its beginning, or a new one.

        Raises:
            InputError: anything wrong with the sources or the engine.
        """
        key = "" if collecting() else cache.sources_key(files.all)
        name = (key, files, engine, *map(os.environ.get, _CHOICE)) if key else None
        found = _waiting.pop(name, None)
        if found is None:
            found = cls(files, engine)
            found._name = name
        else:
            found.fresh()
        return found

    def leave(self) -> None:
        """The cell needs it no longer."""
        if self._name is None or self._name in _waiting:
            self.close()
            return
        _waiting[self._name] = self
        if len(_waiting) > _WAITING:
            _waiting.popitem(last=False)[1].close()

    def fresh(self) -> Program:
        """The program before its first scan; there is one at a time."""
        self.program.restore(self._first)
        return self.program

    def close(self) -> None:
        """Free the program."""
        self.program.close()
