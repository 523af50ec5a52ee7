"""The front end's two questions: what do these sources mean, and what is wrong with them."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from rcx_harness.engine.base import Located
from rcx_harness.engine.compiling import deeply, uncollected
from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.bodies import check_body
from rcx_harness.engine.frontend.constants import constant
from rcx_harness.engine.frontend.declare import Declarations, Scope
from rcx_harness.engine.frontend.parser import parse
from rcx_harness.engine.frontend.project import Project, Run, Task, Unit
from rcx_harness.engine.frontend.registry import Declared, Registry, parts_of
from rcx_harness.engine.frontend.scalars import TIME
from rcx_harness.engine.frontend.tree import Pou
from rcx_harness.engine.types import BlockType, Variable
from rcx_harness.errors import InputError

__all__ = ["Schedule", "add_globals", "check", "checked", "configure", "load", "located"]

#: Parses one source.
Read = Callable[[Path], s.Source]

#: Priority that the standard gives a task without one: the lowest comes last.
_LOWEST = 65535


@dataclass(frozen=True)
class Schedule:
    """The instances, tasks, base tick and running order of a project."""

    instances: dict[str, BlockType]
    tasks: tuple[Task, ...]
    tick_us: int | None
    runs: tuple[Run, ...]


def configure(registry: Registry, declarations: Declarations) -> Schedule:
    """Work out what runs when.

    Sources without a CONFIGURATION run their only PROGRAM in every scan, as `Main`.

    Raises:
        InputError: no program to run, more than one without a CONFIGURATION, or a mistake in
            the CONFIGURATION.
    """
    declared = registry.configuration
    if declared is None:
        programs = [pou for pou in declarations.pous.values() if pou.kind == "PROGRAM"]
        if len(programs) > 1:
            second = registry.pous[programs[1].name.upper()]
            raise second.error(
                "several programs and no CONFIGURATION", second.node.name.at, "add one"
            )
        blocks = [pou.block for pou in programs if pou.block is not None]
        instances = dict(zip(("Main",), blocks, strict=False))
        return Schedule(instances, (), None, tuple(Run(name, 1) for name in instances))
    return _configured(declared, registry, declarations)


def _configured(declared: Declared, registry: Registry, declarations: Declarations) -> Schedule:
    node = declared.node
    assert isinstance(node, s.Configuration)
    if node.resources > 1:
        raise declared.error("more than one RESOURCE is not supported", node.at)
    intervals: dict[str, tuple[s.Name, int, int]] = {}
    for task in node.tasks:
        if task.name.key in intervals:
            raise declared.error(f"the task {task.name.text} is declared twice", task.at)
        intervals[task.name.key] = (task.name, *_settings(task, declared, declarations))
    instances: dict[str, BlockType] = {}
    members: dict[str, list[str]] = {key: [] for key in intervals}
    free: list[str] = []
    for program in node.programs:
        instances[program.name.text] = _instance(
            program, instances, declared, registry, declarations
        )
        if program.task is None:
            free.append(program.name.text)
        elif program.task.key not in members:
            raise declared.error(f"there is no task {program.task.text}", program.task.at)
        else:
            members[program.task.key].append(program.name.text)
    if not instances:
        raise declared.error("the CONFIGURATION has no PROGRAM", node.at)
    tasks = tuple(
        Task(name.text, interval, priority, tuple(members[key]))
        for key, (name, interval, priority) in intervals.items()
    )
    tick = math.gcd(*(task.interval_us for task in tasks)) if tasks else None
    runs = [
        Run(instance, task.interval_us // (tick or 1))
        for task in sorted(tasks, key=lambda task: task.priority)
        for instance in task.instances
    ]
    return Schedule(instances, tasks, tick, (*runs, *(Run(name, 1) for name in free)))


def _settings(task: s.Task, declared: Declared, declarations: Declarations) -> tuple[int, int]:
    interval, priority = 0, _LOWEST
    for name, value in task.settings:
        if name.key == "INTERVAL":
            nanoseconds = constant(value, TIME, declarations.types, declared).value
            interval, rest = divmod(int(nanoseconds), 1000)
            if interval <= 0 or rest:
                raise declared.error("an interval must be whole microseconds above 0", value.at)
        elif name.key == "PRIORITY":
            if not isinstance(value, s.Literal) or not value.text.isdigit():
                raise declared.error("a priority must be a whole number", value.at)
            priority = int(value.text)
        else:
            raise declared.error(f"{name.text} of a task is not supported", name.at)
    if not interval:
        raise declared.error(
            f"the task {task.name.text} has no INTERVAL", task.at, "write (INTERVAL := T#10ms)"
        )
    return interval, priority


def _instance(
    program: s.ProgramInstance,
    instances: dict[str, BlockType],
    declared: Declared,
    registry: Registry,
    declarations: Declarations,
) -> BlockType:
    name, kind = program.name, program.program
    if program.connected:
        raise declared.error(
            "connections of a PROGRAM are not supported", program.at, "use VAR_GLOBAL"
        )
    if name.key in (known.upper() for known in instances):
        raise declared.error(f"the program instance {name.text} is declared twice", name.at)
    clash = registry.variable_clash(name.key)
    if clash:
        raise declared.error(f"{name.text} {clash}", name.at, "choose another instance name")
    if name.key in declarations.globals:
        raise declared.error(f"{name.text} is also a global variable", name.at)
    pou = declarations.pous.get(kind.key)
    if pou is None or pou.kind != "PROGRAM" or pou.block is None:
        raise declared.error(f"there is no program {kind.text}", kind.at)
    return pou.block


def located(instances: dict[str, BlockType], declarations: Declarations) -> tuple[Located, ...]:
    """Directly represented variables: the global ones, then those of each program instance."""
    found = [
        Located(symbol.address, symbol.name, symbol.type)
        for symbol in declarations.globals.values()
        if symbol.address is not None
    ]
    for instance, block in instances.items():
        pou: Pou = declarations.pous[block.name.upper()]
        found += [
            Located(symbol.address, f"{instance}.{symbol.name}", symbol.type)
            for symbol in pou.symbols.values()
            if symbol.address is not None
        ]
    return tuple(found)


def add_globals(declared: Declared | None, declarations: Declarations) -> None:
    """Resolve the global variables of the CONFIGURATION, reporting what is wrong."""
    if declared is not None and isinstance(declared.node, s.Configuration):
        for section in declared.node.globals:
            declarations.add_section(section, "CONFIGURATION", declarations.globals, declared)


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


def checked(paths: Sequence[Path], read: Read | None = None) -> Project:
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
    paths: Sequence[Path], read: Read | None = None
) -> tuple[Project | None, list[InputError]]:
    read = read or parse
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
def _analysed(paths: Sequence[Path], read: Read) -> tuple[Project | None, list[InputError]]:
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
