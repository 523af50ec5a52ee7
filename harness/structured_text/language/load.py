"""The entry points of the front end: check sources and return the project or the errors.

The order of the steps follows from their dependencies. First all names are registered and ordered
(`Registry`). Then types, the variables of POUs, globals and methods are resolved, so that all
interfaces are known. Only then are the bodies checked, because they may use any interface. Every
step reports its errors and continues. An error that is only the consequence of another error is
left out at the end (`_causes`).
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.bodies import check_body, check_start
from structured_text.language.compiling import deeply, uncollected
from structured_text.language.constructs import Use
from structured_text.language.declare import Declarations, Scope
from structured_text.language.dialects import Dialect, dialect_of, rules_of
from structured_text.language.generics import instantiated
from structured_text.language.located import located
from structured_text.language.namespaces import separated
from structured_text.language.parser import read_text
from structured_text.language.phases import joined
from structured_text.language.project import Project, ScheduledInstance, Task, Unit, runnable
from structured_text.language.registry import (
    ConsequenceError,
    Declared,
    Registry,
    base_name,
    last_name,
)
from structured_text.language.scalars import TIME
from structured_text.language.source import is_narrow, source_text
from structured_text.language.starting import instance_sections
from structured_text.language.system import QUERY, system_declaration
from structured_text.language.tree import Pou
from structured_text.language.types import BlockType, Variable
from structured_text.language.unread import not_executed, refusal, unread_bodies
from structured_text.language.walk import parts
from structured_text.output.limits import MOST_CHARACTERS, MOST_MISTAKES, MOST_TOKENS

__all__ = [
    "Read",
    "Schedule",
    "Visit",
    "analyse",
    "checked",
    "configure",
    "first_errors",
    "load",
    "read_file",
    "survey",
    "too_deep",
]

#: A function that parses one source.
Read = Callable[[Path], s.Source]
#: A function that is called for each body, with the names known in the body and its statements.
Visit = Callable[[Scope, tuple[s.Statement, ...]], None]

#: Priority of a task without PRIORITY. By the standard it is the lowest priority, so the task runs
#: last.
_LOWEST = 65535
#: Longest period [us] of a program that has no task in a project with tasks. A shorter tick of the
#: tasks is the period.
_SCAN_US = 10_000


@dataclass(frozen=True)
class Schedule:
    """The instances, tasks, base tick and running order of a project."""

    instances: dict[str, BlockType]
    tasks: tuple[Task, ...]
    tick_us: int | None
    runs: tuple[ScheduledInstance, ...]


def configure(registry: Registry, declarations: Declarations) -> Schedule:
    """Return the instances, tasks and running order of a project.

    Without a CONFIGURATION, one PROGRAM runs in every scan as `Main` (`_uncalled`).

    Raises:
        InputError: There is no CONFIGURATION and more than one program to run, or the CONFIGURATION
            has a mistake.
    """
    declared = registry.configuration
    if declared is None:
        programs = _uncalled(registry, declarations)
        blocks = [pou.block for pou in programs if pou.block is not None]
        instances = dict(zip(("Main",), blocks, strict=False))
        return Schedule(
            instances, (), None, tuple(ScheduledInstance(name, 1) for name in instances)
        )
    return _configured(declared, registry, declarations)


def _uncalled(registry: Registry, declarations: Declarations) -> list[Pou]:
    """Return the program that runs without a CONFIGURATION; none if all are called.

    The result is the only program that no other program calls. If there are several, the program
    PLC_PRG or MAIN runs; new projects of CODESYS and TwinCAT have these names.
    """
    programs = [pou for pou in declarations.pous.values() if pou.kind == "PROGRAM"]
    if len(programs) > 1:
        first = registry.pous[programs[0].name.upper()]
        first.note("several PROGRAMs without a CONFIGURATION", first.node.name.at)
    free = [pou for pou in programs if pou.name.upper() not in declarations.called]
    usual = [pou for pou in free if pou.name.upper() in ("MAIN", "PLC_PRG")]
    if len(free) > 1 and len(usual) != 1:
        second = registry.pous[free[1].name.upper()]
        raise second.error(
            f"several programs and no CONFIGURATION: {', '.join(pou.name for pou in free)}",
            second.node.name.at,
            "add one; or call the others from one of them, or call that MAIN or PLC_PRG",
        )
    return usual if len(free) > 1 else free


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
    # A program without a task does not depend on the tasks: it runs in every scan.
    own_us = [_SCAN_US] if free else []
    tick = math.gcd(*(task.interval_us for task in tasks), *own_us) if tasks else None
    runs = [
        ScheduledInstance(instance, task.interval_us // (tick or 1))
        for task in sorted(tasks, key=lambda task: task.priority)
        for instance in task.instances
    ]
    return Schedule(instances, tasks, tick, (*runs, *(ScheduledInstance(name, 1) for name in free)))


def _settings(
    task: s.TaskDeclaration, declared: Declared, declarations: Declarations
) -> tuple[int, int]:
    interval, priority = 0, _LOWEST
    for name, value in task.settings:
        if name.key == "INTERVAL":
            nanoseconds = declarations.constant(value, TIME, declared).value
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
    if clash and name.key != kind.key:  # PLC tools give a single instance the name of its program
        raise declared.error(f"{name.text} {clash}", name.at, "choose another instance name")
    if name.key in declarations.globals and name.key not in declarations.programs:
        raise declared.error(f"{name.text} is also a global variable", name.at)
    pou = declarations.pous.get(kind.key)
    if pou is None or pou.kind != "PROGRAM" or pou.block is None:
        raise declared.error(f"there is no program {kind.text}", kind.at)
    others = [one for one, block in instances.items() if block is pou.block]
    if others and kind.key in declarations.programs:
        raise declared.error(
            f"{kind.text} is used by its name, and has the instances {others[0]} and {name.text}",
            name.at,
            "use a program with a single instance",
        )
    return pou.block


def load(paths: Sequence[Path], read: Read | None = None) -> Project:
    """Parse and check Structured Text sources.

    A file that is given twice counts once. `read` replaces `read_file` as the parser.

    Returns:
        The checked project.

    Raises:
        InputError: The sources have a mistake (the first is reported, with file, line and hint), or
            the program executes a body in another language.
    """
    return not_executed(runnable(_whole(paths, read)), paths)


def checked(paths: Sequence[Path], read: Read | None = None) -> Project:
    """Parse and check sources that may also be a library without a PROGRAM, or raise InputError.

    Bodies in other languages are refused.
    """
    if unread := unread_bodies(paths):
        raise refusal(unread)
    return _whole(paths, read)


def _whole(paths: Sequence[Path], read: Read | None) -> Project:
    """Return the checked project, or raise InputError with the first mistake."""
    project, errors = analyse(paths, read)
    if errors:
        raise errors[0]
    assert project is not None
    return project


def analyse(
    paths: Sequence[Path],
    read: Read | None = None,
    most: int | None = None,
    *,
    every: bool = False,
) -> tuple[Project | None, list[InputError]]:
    """Return the checked project, or None with all errors, in the order of the given files.

    Sources without a PROGRAM are checked as a library. Errors that are only the consequence of
    another error are left out. Errors beyond the number `most` (default: `MOST_MISTAKES`) are only
    counted. With `every`, all errors are returned, and consequences are `ConsequenceError`.
    Statistics need all errors, because a file without a returned error counts as accepted.
    """
    read = read or read_file
    try:
        project, errors = deeply(partial(_analysed, paths, read, every=every))
        if every:
            return project, errors
        shown = first_errors(errors, MOST_MISTAKES if most is None else most)
        return project, shown or (errors[:1] if project is None else [])
    except RecursionError:
        return None, [too_deep(paths, read)]


def survey(paths: Sequence[Path], visit: Visit, read: Read | None = None) -> list[InputError]:
    """Check sources, and call `visit` for each body.

    `visit` gets the names that are known in the body, and its statements. It is called after all
    declarations are resolved as far as possible, even if there are errors. Return all errors.
    """
    return deeply(partial(_analysed, paths, read or read_file, visit))[1]


def read_file(path: Path) -> s.Source:
    """Parse a file as far as it can be read, and collect its errors, or raise InputError."""
    text = source_text(path)
    source = read_text(text, path)
    narrow = None if text.isascii() else is_narrow(path)
    if narrow is None:
        return source
    use = Use("a source in Windows-1252", path, s.Position(narrow, 1))
    return replace(source, uses=(*source.uses, use))


def too_deep(paths: Sequence[Path], read: Read | None = None) -> InputError:
    """Return the error for sources that are nested too deeply for any stack.

    The error has the line with the deepest nesting.
    """
    sources = [(read or read_file)(path) for path in paths]
    waiting: list[tuple[int, Path, s.Position, Any]]
    waiting = [(0, one.file, s.Position(1, 1), one.declarations) for one in sources]
    deepest = waiting[0] if waiting else (0, None, s.Position(0, 0), None)
    while waiting:
        depth, file, at, node = waiting.pop()
        at = getattr(node, "at", at)
        if depth > deepest[0]:
            deepest = depth, file, at, node
        waiting += [(depth + 1, file, at, part) for part in [*parts(node)][::-1]]
    return InputError(
        "too many operators, brackets or calls inside each other",
        file=deepest[1],
        line=deepest[2].line,
        hint="assign parts of the expression to variables first",
    )


@uncollected()
def _analysed(
    paths: Sequence[Path], read: Read, visit: Visit | None = None, *, every: bool = False
) -> tuple[Project | None, list[InputError]]:
    errors: list[InputError] = []
    sources: list[s.Source] = []
    missing = False
    for path in dict.fromkeys(paths):
        try:
            source = read(path)
            _check_size(sources, source)
        except InputError as error:
            errors.append(error)
            missing = True
        else:
            sources.append(source)
            errors += source.errors
    found: list[InputError] = []
    whole = instantiated(separated(joined(sources)))
    errors += [error for one in whole for error in one.errors if error not in errors]
    rules = rules_of(dialect_of(paths))
    project = _resolve(whole, found, whole=not errors, dialect=rules, visit=visit)
    causes = _causes(found, sources)
    if every:
        caused = [_consequence(one) for one in found if one not in causes]
        return project, [*errors, *causes, *caused]
    # Declarations in an unreadable file are unknown to the other files.
    unread = {(one.file, one.line) for one in errors}
    errors += [
        one
        for one in causes
        if not ((missing or (one.file, one.line) in unread) and _UNKNOWN.match(one.message))
    ]
    errors = [one for one in errors if not isinstance(one, ConsequenceError)]
    ranks = {str(path): rank for rank, path in enumerate(paths)}
    errors.sort(key=lambda one: (ranks.get(one.file or "", -1), one.line or 0, one.column or 0))
    return project if not errors else None, list(dict.fromkeys(errors))


def _consequence(error: InputError) -> ConsequenceError:
    """Return an error, marked as the consequence of another error."""
    return ConsequenceError(
        error.message, file=error.file, line=error.line, column=error.column, hint=error.hint
    )


def _check_size(before: Sequence[s.Source], source: s.Source) -> None:
    """Raise InputError if a source makes the program too large to be compiled."""
    every = [*before, source]
    for size, most, what in (
        (sum(one.characters for one in every), MOST_CHARACTERS, "characters"),
        (sum(one.tokens for one in every), MOST_TOKENS, "words, numbers and signs"),
    ):
        if size > most:
            raise InputError(
                f"the sources up to this one have more than {most:,} {what}",
                file=source.file,
                hint="leave out what the program does not need",
            )


def first_errors(errors: list[InputError], most: int = MOST_MISTAKES) -> list[InputError]:
    """Return the first errors, up to a limit, and a note on the number of further errors.

    Errors with the same position and text count once.
    """
    errors = list({str(error): error for error in errors}.values())
    more = len(errors) - most
    if more <= 0:
        return errors
    last = errors[most - 1]
    text = f"there are more mistakes, which are not shown: {more:,}"
    return [*errors[:most], InputError(text, file=last.file, line=last.line)]


def _causes(errors: list[InputError], sources: list[s.Source]) -> list[InputError]:
    """Return the errors, except those that an error in a named interface has caused."""
    spoiled: dict[str, set[int]] = {}
    for error in (*errors, *(error for source in sources for error in source.errors)):
        spoiled.setdefault(error.file or "", set()).add(error.line or 0)
    names = {
        name
        for source in sources
        for lines in [spoiled.get(str(source.file), set())]
        for node in (source.declarations if lines else ())
        for name, first, behind in _interfaces(node)
        if any(first <= line < behind for line in lines)
    }

    extended = {
        node.name.key: base_name(node)
        for source in sources
        for node in source.declarations
        if isinstance(node, (s.Pou, s.TypeDecl)) and node.extends is not None
    }
    for key in extended:  # An error in a base also affects the declarations that extend the base.
        chain = [key]
        while chain[-1] in extended and extended[chain[-1]] not in chain:
            chain.append(extended[chain[-1]])
        if names & set(chain):
            names.add(key)

    def follows(error: InputError) -> bool:
        said = _OF.match(error.message)
        if said is None:
            return False
        name = said[1].upper()
        return name in names or name.partition(".")[0] in names

    return [error for error in errors if not follows(error)]


def _interfaces(node: s.Declaration) -> Iterator[tuple[str, int, int]]:
    """Yield name, first line and end line of the interface of a declaration and of its methods."""
    name, line = node.name.key, node.at.line
    if isinstance(node, s.TypeDecl):
        fields = node.spec.fields if isinstance(node.spec, s.StructSpec) else ()
        yield name, line, max((one.at.line + 1 for one in fields), default=line + 1)
    if isinstance(node, (s.Pou, s.Interface)):
        if isinstance(node, s.Pou):
            yield name, line, _behind(node.sections, line)
        for member in node.members:
            if isinstance(member, s.Method):
                first = member.at.line
                yield f"{name}.{member.name.key}", first, _behind(member.sections, first)


def _behind(sections: tuple[s.Section, ...], line: int) -> int:
    return max((one.at.line for part in sections for one in part.variables), default=line) + 1


#: Matches messages that may be a consequence of an error in the named declaration.
_OF = re.compile(
    r"(?:there is no (?:type|function|variable or namespace) )?"
    r"(\w+(?:\.\w+)?)(?: (?:takes|has no) .*)?$"
)
_UNKNOWN = re.compile(r"there is no |\S+ is not declared")


def _resolve(
    sources: list[s.Source],
    errors: list[InputError],
    *,
    whole: bool,
    dialect: Dialect,
    visit: Visit | None = None,
) -> Project | None:
    registry = Registry(sources, errors.append, dialect)
    ordered = registry.ordered()
    declarations = Declarations(registry, errors.append)
    for declared in (*_system_interfaces(registry), *ordered):
        if isinstance(declared.node, s.Interface):
            declarations.inheritance.add(declared.node, declared)
    for declared in ordered:
        if isinstance(declared.node, s.TypeDecl):
            declarations.add_type(declared.node, declared)
        elif isinstance(declared.node, s.Pou):
            declarations.add_pou(declared.node, declared)
    declarations.add_globals()
    declarations.inheritance.finish()
    for declared in ordered:
        if isinstance(declared.node, s.Pou):
            pou = declarations.pous[declared.node.name.key]
            scope = Scope(pou, declared, registry, declarations)
            check_body(scope, declared.node.body, errors.append)
            if visit is not None:
                visit(scope, declared.node.body)
            sections = (*declared.node.sections, *instance_sections(declared.node))
            check_start(scope, sections, errors.append)
    for method, syntax, where in declarations.inheritance.bodies():
        scope = Scope(method, where, registry, declarations)
        check_body(scope, syntax.body, errors.append)
        if visit is not None:
            visit(scope, syntax.body)
        check_start(scope, syntax.sections, errors.append)
    for scope, sections in declarations.starts_of_globals():
        check_start(scope, sections, errors.append)
    if errors or not whole:
        return None
    try:
        schedule = configure(registry, declarations)
        _check_extent(schedule, registry, declarations, ordered)
        places = located(schedule.instances, declarations)
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
            key: Variable(symbol.name, symbol.type, "VAR_GLOBAL", symbol.address, symbol.retain)
            for key, symbol in declarations.globals.items()
        },
        global_symbols=declarations.globals,
        lists=declarations.lists,
        located=places,
        tasks=schedule.tasks,
        tick_us=schedule.tick_us,
        schedule=schedule.runs,
        objects=declarations.objects,
        uses=tuple(dict.fromkeys(registry.uses)),
        views=declarations.views,
        dialect=dialect.name,
    )


def _system_interfaces(registry: Registry) -> Iterator[Declared]:
    """Yield the interface of `__SYSTEM`, if the sources use it and do not declare it."""
    mentioned = {
        last_name(name)
        for one in (*registry.interfaces.values(), *registry.pous.values())
        for name in _interfaces_of(one.node)
    }
    found = system_declaration(QUERY)
    if found is not None and QUERY in mentioned and QUERY not in registry.interfaces:
        registry.interfaces[QUERY] = found
        yield found


def _interfaces_of(node: s.Declaration) -> tuple[s.Name, ...]:
    if isinstance(node, s.Interface):
        return node.extends
    return node.implements if isinstance(node, s.Pou) else ()


def _check_extent(
    schedule: Schedule,
    registry: Registry,
    declarations: Declarations,
    ordered: Sequence[Declared],
) -> None:
    """Raise InputError if the running program has too many variables in all."""
    if not ordered:
        return
    bodies = [
        *declarations.pous.values(),
        *(one for one, _, _ in declarations.inheritance.bodies()),
    ]
    symbols = [symbol for pou in bodies if pou.block is None for symbol in pou.symbols.values()]
    where = registry.configuration or ordered[-1]
    blocks = schedule.instances.values()
    declarations.extents.check_all(blocks, [*declarations.globals.values(), *symbols], where)


def _unit(declared: Declared) -> Unit:
    node = declared.node
    kind = "TYPE" if isinstance(node, s.TypeDecl) else "CONFIGURATION"
    if isinstance(node, s.Interface):
        kind = "INTERFACE"
    if isinstance(node, s.Pou):
        kind = node.kind
    return Unit(kind, node.name.text, declared.file, node.at.line)


def _files(ordered: list[Declared]) -> tuple[Path, ...]:
    """Return the files, sorted by their last declaration in the order of dependencies."""
    last = {declared.file: rank for rank, declared in enumerate(ordered)}
    return tuple(sorted(last, key=lambda file: last[file]))
