"""Compiles a project to a Python module that every instance of the program shares."""

from __future__ import annotations

import marshal
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import TracebackType
from typing import Any

from rcx_harness.engine import cache
from rcx_harness.engine.builtin import memory, references
from rcx_harness.engine.builtin.blocks import BODIES, CLASSES
from rcx_harness.engine.builtin.coverage import (
    Collector,
    CountingWriter,
    Plan,
    collecting,
)
from rcx_harness.engine.builtin.objects import linking
from rcx_harness.engine.builtin.runtime import NAMES
from rcx_harness.engine.builtin.statements import Writer
from rcx_harness.engine.builtin.storage import Storage, slot_name
from rcx_harness.engine.compiling import deeply
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.tree import Pou, Symbol
from rcx_harness.errors import InputError

__all__ = ["Module", "module_of"]


@dataclass(frozen=True)
class _Code:
    """The Python of a project.

    Attributes:
        file: Name under which it is compiled.
        first: Lines before those of the POUs.
        origins: File and line of the source for each line of the POUs.
        body: The compiled code, as `marshal` writes it.
    """

    file: str
    first: int
    origins: list[tuple[str, int]]
    body: bytes


class Module:
    """The code of a project.

    Args:
        project: What to compile.
        collector: Where its sources count what is executed; None: nowhere.

    Attributes:
        project: What it was compiled from.
        names: Everything the module defines: classes, `f_POU`, `save_T` and so on.
    """

    def __init__(self, project: Project, collector: Collector | None = None) -> None:
        self.project = project
        self._collector = collector
        self.names: dict[str, Any] = {**NAMES, **references.NAMES, **memory.NAMES}
        self.names.update({f"b_{name}": found for name, found in CLASSES.items()})
        self.names.update({f"body_{name}": found for name, found in BODIES.items()})
        self._noted: set[str] = set()
        # Bounded, since instances that nobody watches are noted, too.
        self._calls: deque[tuple[int, int]] = deque(maxlen=100_000)
        key = "" if self._collector is not None else project.key
        self._code = cache.kept("code", key, self._compiled)
        exec(marshal.loads(self._code.body), self.names)

    def _compiled(self) -> _Code:
        try:
            return deeply(self._written)
        except (RecursionError, MemoryError, SyntaxError) as error:
            file = self.project.files[0] if len(self.project.files) == 1 else None
            raise InputError(
                f"the built-in engine cannot compile this: {error}",
                file=file,
                hint="statements or expressions lie too deep inside each other; divide them",
            ) from None

    def _written(self) -> _Code:
        project = self.project
        storage = Storage()
        lines: list[str] = []
        origins: list[tuple[str, int]] = []
        for pou in project.pous.values():
            if pou.block is not None:
                storage.block(pou)
            writer = self._writer(pou, storage)
            writer.write()
            lines += writer.lines
            origins += [(pou.file, line) for line in writer.origins]
        storage.globals(_shared(project))
        lines += linking(project)
        first = len(storage.lines)
        file = f"<{project.files[0].name} and {len(project.files) - 1} more>"
        text = "\n".join([*storage.lines, *lines, ""])
        return _Code(file, first, origins, marshal.dumps(compile(text, file, "exec")))

    def _writer(self, pou: Pou, storage: Storage) -> Writer:
        if self._collector is not None:
            plan = Plan.of(pou)
            counts = self._collector.counts(pou, plan, self.project)
            if counts is not None:
                name = slot_name(pou.name)
                self.names.update({f"n_{name}": counts.counters, f"q_{name}": counts.seen})
                return CountingWriter(self.project, pou, storage, plan)
        return Writer(self.project, pou, storage)

    def note_calls(self, blocks: Mapping[str, int | None]) -> deque[tuple[int, int]]:
        """Let the calls of these blocks be noted, by the identity of instance and variable."""
        for name, place in blocks.items():
            if name not in self._noted and f"f_{name}" in self.names:
                self._noted.add(name)
                self.names[f"f_{name}"] = _noting(self.names[f"f_{name}"], place, self._calls)
        return self._calls

    def origin(self, trace: TracebackType | None) -> tuple[str, int] | None:
        """File and line of the Structured Text that an exception was raised from."""
        found = None
        while trace is not None:
            if trace.tb_frame.f_code.co_filename == self._code.file:
                found = trace.tb_lineno
            trace = trace.tb_next
        index = -1 if found is None else found - 1 - self._code.first
        return self._code.origins[index] if 0 <= index < len(self._code.origins) else None


def _noting(
    body: Callable[..., Any], place: int | None, calls: deque[tuple[int, int]]
) -> Callable[..., Any]:
    """The function of a block that notes its calls."""

    def noted(instance: Any, *in_outs: Any) -> Any:
        calls.append((id(instance), 0 if place is None else id(in_outs[place])))
        return body(instance, *in_outs)

    return noted


def module_of(project: Project) -> Module:
    """The code of a project, compiled once, and once more where what is executed is counted."""
    return _module_of(project, collecting())


@lru_cache(maxsize=24)
def _module_of(project: Project, collector: Collector | None) -> Module:
    return Module(project, collector)


def _shared(project: Project) -> list[Symbol]:
    located = [
        symbol
        for pou in project.pous.values()
        for symbol in pou.symbols.values()
        if symbol.address is not None
    ]
    return [*project.global_symbols.values(), *located]
