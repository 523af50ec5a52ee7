"""The front end's two questions: what do these sources mean, and what is wrong with them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from rcx_harness.engine.collecting import uncollected
from rcx_harness.engine.deep import deeply
from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.bodies import check_body
from rcx_harness.engine.frontend.configure import add_globals, configure, located
from rcx_harness.engine.frontend.declare import Declarations
from rcx_harness.engine.frontend.expressions import Scope
from rcx_harness.engine.frontend.parser import parse
from rcx_harness.engine.frontend.project import Project, Unit
from rcx_harness.engine.frontend.registry import Declared, Registry, parts_of
from rcx_harness.engine.types import Variable
from rcx_harness.errors import InputError

__all__ = ["check", "checked", "load"]


def load(paths: Sequence[Path]) -> Project:
    """Parse and check Structured Text sources.

    Args:
        paths: The files, in any order; a file given twice counts once.

    Returns:
        The checked project.

    Raises:
        InputError: the first mistake, with file, line and what to do.
    """
    project = checked(paths)
    if not project.instances:
        raise InputError(
            "there is no PROGRAM in the sources", hint="name the file of the program to run"
        )
    return project


def checked(paths: Sequence[Path], read: Callable[[Path], s.Source] = parse) -> Project:
    """The same for sources that may also be a library without a PROGRAM.

    Args:
        paths: The files.
        read: What parses one of them.

    Raises:
        InputError: the first mistake.
    """
    project, errors = _analyse(paths, read)
    if errors:
        raise errors[0]
    assert project is not None
    return project


def check(paths: Sequence[Path]) -> list[InputError]:
    """Everything that is wrong with the sources, in the order of the files given.

    Sources without a PROGRAM are a library and are checked as such. A syntax error hides the
    rest of its file, an error in a declaration the bodies of all files.
    """
    return _analyse(paths)[1]


def _analyse(
    paths: Sequence[Path], read: Callable[[Path], s.Source] = parse
) -> tuple[Project | None, list[InputError]]:
    try:
        return deeply(partial(_analysed, paths, read))
    except RecursionError:
        return None, [_too_deep([read(path) for path in paths])]


def _too_deep(sources: Sequence[s.Source]) -> InputError:
    """Where the most pieces of syntax lie inside each other."""
    waiting: list[tuple[int, Path, s.Position, Any]]
    waiting = [(0, one.file, s.Position(1, 1), one.declarations) for one in sources]
    deepest = waiting[0]
    while waiting:
        depth, file, at, node = waiting.pop()
        at = getattr(node, "at", at)
        if depth > deepest[0]:
            deepest = depth, file, at, node
        parts = (
            node if isinstance(node, tuple) else [getattr(node, name) for name in parts_of(node)]
        )
        waiting += [(depth + 1, file, at, part) for part in parts]
    return InputError(
        "too many operators, brackets or calls inside each other",
        file=deepest[1],
        line=deepest[2].line,
        hint="assign parts of the expression to variables first",
    )


@uncollected()
def _analysed(
    paths: Sequence[Path], read: Callable[[Path], s.Source]
) -> tuple[Project | None, list[InputError]]:
    errors: list[InputError] = []
    sources: list[s.Source] = []
    for path in dict.fromkeys(paths):
        try:
            sources.append(read(path))
        except InputError as error:
            errors.append(error)
    project = None if errors else _resolve(sources, errors)
    ranks = {str(path): rank for rank, path in enumerate(paths)}
    errors.sort(key=lambda error: (ranks.get(error.file or "", -1), error.line or 0))
    return project, errors


def _resolve(sources: list[s.Source], errors: list[InputError]) -> Project | None:
    registry = Registry(sources, errors.append)
    ordered = registry.ordered()
    if errors:
        return None
    declarations = Declarations(registry, errors.append)
    for declared in ordered:
        if isinstance(declared.node, s.TypeDecl):
            declarations.add_type(declared.node, declared)
    add_globals(registry.configuration, declarations)
    for declared in ordered:
        if isinstance(declared.node, s.Pou):
            declarations.add_pou(declared.node, declared)
    if errors:
        return None
    for declared in ordered:
        if isinstance(declared.node, s.Pou):
            pou = declarations.pous[declared.node.name.key]
            scope = Scope(pou, declared, registry, declarations)
            check_body(scope, declared.node.body, errors.append)
    if errors:
        return None
    try:
        schedule = configure(registry, declarations)
    except InputError as error:
        errors.append(error)
        return None
    return Project(
        files=_files(ordered),
        units=tuple(_unit(declared) for declared in ordered),
        types=declarations.types,
        blocks=declarations.blocks,
        pous=declarations.pous,
        initial=declarations.initial,
        instances=schedule.instances,
        configured=registry.configuration is not None,
        globals={
            key: Variable(symbol.name, symbol.type, "VAR_GLOBAL", symbol.address)
            for key, symbol in declarations.globals.items()
        },
        global_symbols=declarations.globals,
        located=located(schedule.instances, declarations),
        tasks=schedule.tasks,
        tick_us=schedule.tick_us,
        schedule=schedule.runs,
    )


def _unit(declared: Declared) -> Unit:
    node = declared.node
    kind = "TYPE" if isinstance(node, s.TypeDecl) else "CONFIGURATION"
    if isinstance(node, s.Pou):
        kind = node.kind
    return Unit(kind, node.name.text, declared.file, node.at.line)


def _files(ordered: list[Declared]) -> tuple[Path, ...]:
    """Each file where its last declaration stands in the dependency order."""
    last = {declared.file: rank for rank, declared in enumerate(ordered)}
    return tuple(sorted(last, key=lambda file: last[file]))
