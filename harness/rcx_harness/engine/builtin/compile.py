"""Compiles a project to a Python module that every instance of the program shares."""

from __future__ import annotations

from types import TracebackType
from typing import Any

from rcx_harness.engine.builtin.blocks import BODIES, CLASSES
from rcx_harness.engine.builtin.coverage import Collector, CountingWriter, environment_collector
from rcx_harness.engine.builtin.probes import Plan
from rcx_harness.engine.builtin.runtime import NAMES
from rcx_harness.engine.builtin.statements import Writer
from rcx_harness.engine.builtin.storage import Storage
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.tree import Pou, Symbol

__all__ = ["Module"]


class Module:
    """The code of a project.

    Args:
        project: What to compile.
        collector: Where its sources count what is executed; None to go by the environment.

    Attributes:
        project: What it was compiled from.
        names: Everything the module defines: classes, `f_POU`, `save_T` and so on.
    """

    def __init__(self, project: Project, collector: Collector | None = None) -> None:
        self.project = project
        self._collector = collector or environment_collector()
        self.names: dict[str, Any] = dict(NAMES)
        self.names.update({f"b_{name}": found for name, found in CLASSES.items()})
        self.names.update({f"body_{name}": found for name, found in BODIES.items()})
        storage = Storage()
        lines: list[str] = []
        self._origins: list[tuple[str, int]] = []
        for pou in project.pous.values():
            if pou.block is not None:
                storage.block(pou)
            writer = self._writer(pou, storage)
            writer.write()
            lines += writer.lines
            self._origins += [(pou.file, line) for line in writer.origins]
        storage.globals(_shared(project))
        self._first = len(storage.lines)
        self._file = f"<{project.files[0].name} and {len(project.files) - 1} more>"
        text = "\n".join([*storage.lines, *lines, ""])
        exec(compile(text, self._file, "exec"), self.names)

    def _writer(self, pou: Pou, storage: Storage) -> Writer:
        if self._collector is not None:
            plan = Plan.of(pou)
            counts = self._collector.counts(pou, plan)
            if counts is not None:
                name = pou.name.upper()
                self.names.update({f"n_{name}": counts.counters, f"q_{name}": counts.seen})
                return CountingWriter(self.project, pou, storage, plan)
        return Writer(self.project, pou, storage)

    def origin(self, trace: TracebackType | None) -> tuple[str, int] | None:
        """File and line of the Structured Text that an exception was raised from."""
        found = None
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == self._file:
                found = trace.tb_lineno
            trace = trace.tb_next
        index = -1 if found is None else found - 1 - self._first
        return self._origins[index] if 0 <= index < len(self._origins) else None


def _shared(project: Project) -> list[Symbol]:
    located = [
        symbol
        for pou in project.pous.values()
        for symbol in pou.symbols.values()
        if symbol.address is not None
    ]
    return [*project.global_symbols.values(), *located]
