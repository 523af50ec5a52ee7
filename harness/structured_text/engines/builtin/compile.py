"""Compilation of a checked project to Python.

Each POU becomes a Python function (`statements`), each expression a Python expression
(`expression_code`), and each block or structure a class (`storage`). The line of the source is
recorded for each line of a function, so that errors at run time name the user's file and line. The
compiled code is cached as `marshal` writes it.
"""

from __future__ import annotations

import marshal
import re
from collections.abc import Iterator
from functools import lru_cache
from types import CodeType
from typing import Any

from structured_text.engines.builtin.code import Code
from structured_text.engines.builtin.collector import Collector
from structured_text.engines.builtin.coverage import CountingWriter, Plan
from structured_text.engines.builtin.heap import heap_lines
from structured_text.engines.builtin.objects import linking
from structured_text.engines.builtin.statements import Writer
from structured_text.engines.builtin.storage import Storage, slot_name
from structured_text.errors import InputError
from structured_text.language.compiling import deeply
from structured_text.language.project import Project
from structured_text.language.tree import Pou, Symbol

__all__ = ["compiled"]

#: The beginning of a class or function of the generated code.
_PARTS = re.compile(r"^(?=class |def )", re.MULTILINE)


def compiled(project: Project, collector: Collector | None, names: dict[str, Any]) -> Code:
    """Compile a project.

    The generated code can use the objects in `names`. If `collector` is given, its counters are
    added to `names`. Raise InputError if statements or expressions are nested too deeply.
    """
    try:
        return deeply(lambda: _written(project, collector, names))
    except (RecursionError, MemoryError, SyntaxError) as error:
        raise InputError(
            f"the built-in engine cannot compile this: {error}",
            file=project.files[0] if len(project.files) == 1 else None,
            hint="statements or expressions are nested too deeply; divide them",
        ) from None


def _written(project: Project, collector: Collector | None, names: dict[str, Any]) -> Code:
    storage = Storage()
    lines: list[str] = []
    origins: list[tuple[str, int]] = []
    for pou in project.pous.values():
        if pou.block is not None:
            storage.block(pou)
        writer = _writer(project, pou, storage, collector, names)
        writer.write()
        lines += writer.lines
        origins += [(pou.file, line) for line in writer.origins]
    storage.globals(_shared(project))
    lines += linking(project)
    lines += heap_lines(project, storage)
    first = len(storage.lines)
    file = f"<{project.files[0].name} and {len(project.files) - 1} more>"
    text = "\n".join([*storage.lines, *lines, ""])
    return Code(file, first, origins, marshal.dumps(tuple(_code(text, file))))


def _code(text: str, file: str) -> Iterator[CodeType]:
    """Yield the code of a text by its classes and functions.

    Most of them belong to the library. Each is compiled once for all projects that contain it.
    """
    line = 0
    for part in _PARTS.split(text):
        yield _placed(_part(part), file, line)
        line += part.count("\n")


@lru_cache(maxsize=2048)
def _part(text: str) -> CodeType:
    return compile(text, "", "exec", dont_inherit=True)


def _placed(code: CodeType, file: str, line: int) -> CodeType:
    """Return code with its file, and with line numbers that begin after `line`."""
    return code.replace(
        co_filename=file,
        co_firstlineno=code.co_firstlineno + line,
        co_consts=tuple(
            _placed(value, file, line) if isinstance(value, CodeType) else value
            for value in code.co_consts
        ),
    )


def _writer(
    project: Project,
    pou: Pou,
    storage: Storage,
    collector: Collector | None,
    names: dict[str, Any],
) -> Writer:
    if collector is not None:
        plan = Plan.of(pou)
        counts = collector.counts(pou, plan, project)
        if counts is not None:
            name = slot_name(pou.name)
            names.update({f"n_{name}": counts.counters, f"q_{name}": counts.seen})
            return CountingWriter(project, pou, storage, plan)
    return Writer(project, pou, storage)


def _shared(project: Project) -> list[Symbol]:
    located = [
        symbol
        for pou in project.pous.values()
        for symbol in pou.symbols.values()
        if symbol.address is not None
    ]
    return [*project.global_symbols.values(), *located]
