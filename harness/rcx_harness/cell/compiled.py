"""A program that is compiled once, for one cell after the other."""

from __future__ import annotations

from rcx_harness.cell.sources import SourceFiles
from rcx_harness.engine.base import Program
from rcx_harness.engine.builtin.coverage import collecting
from rcx_harness.engine.load import build
from rcx_harness.watch.calls_source import call_plan, steady_instances

__all__ = ["Compiled"]


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
        self.notice = "\n".join(filter(None, (*self.files.notes, built.notice)))
        self.steady = steady_instances(self.files.own, self.files.lib)
        self.calls = call_plan(*self.files.users)
        self._first = self.program.snapshot()

    def fresh(self) -> Program:
        """The program before its first scan; there is one at a time."""
        self.program.restore(self._first)
        return self.program

    def close(self) -> None:
        """Free the program."""
        self.program.close()
