"""The stages of checking: the interfaces of all declarations, then the bodies, then the schedule.

`load` runs them one after the other. A language server keeps the interfaces of a program while only
bodies change, and checks again only the changed bodies.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.bodies import check_body, check_start
from structured_text.language.declare import Declarations, Scope
from structured_text.language.dialects import Dialect
from structured_text.language.located import located
from structured_text.language.project import Project, Unit
from structured_text.language.registry import Declared, Registry, last_name
from structured_text.language.schedule import Schedule, configure
from structured_text.language.starting import instance_sections
from structured_text.language.system import QUERY, system_declaration
from structured_text.language.types import Variable

__all__ = ["Body", "Interfaces", "Visit", "bodies", "interfaces", "project_of", "resolve"]

#: A function that receives an error.
Report = Callable[[InputError], None]
#: A function that is called for each body, with the names known in the body and its statements.
Visit = Callable[[Scope, tuple[s.Statement, ...]], None]


@dataclass(frozen=True)
class Interfaces:
    """The declarations of a program, without the bodies.

    Attributes:
        ordered: The declarations, each after those that it uses.
    """

    registry: Registry
    declarations: Declarations
    ordered: Sequence[Declared]


@dataclass(frozen=True)
class Body:
    """The body of a POU or method, with the names that are known in it.

    Attributes:
        statements: The statements; None for the initial values of a list of global variables.
        sections: The sections with initial values that are known only at run time.
    """

    scope: Scope
    statements: tuple[s.Statement, ...] | None
    sections: tuple[s.Section, ...]

    def check(self, report: Report) -> None:
        """Check the body, and store it in its POU."""
        if self.statements is not None:
            check_body(self.scope, self.statements, report)
        check_start(self.scope, self.sections, report)


def interfaces(sources: Sequence[s.Source], report: Report, dialect: Dialect) -> Interfaces:
    """Resolve all declarations; report errors and continue."""
    registry = Registry(sources, report, dialect)
    ordered = registry.ordered()
    declarations = Declarations(registry, report)
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
    return Interfaces(registry, declarations, ordered)


def bodies(found: Interfaces) -> Iterator[Body]:
    """Yield all bodies. Each body must be checked before the next is taken."""
    registry, declarations = found.registry, found.declarations
    for declared in found.ordered:
        if isinstance(declared.node, s.Pou):
            pou = declarations.pous[declared.node.name.key]
            scope = Scope(pou, declared, registry, declarations)
            sections = (*declared.node.sections, *instance_sections(declared.node))
            yield Body(scope, declared.node.body, sections)
    for method, syntax, where in declarations.inheritance.bodies():
        scope = Scope(method, where, registry, declarations)
        yield Body(scope, syntax.body, syntax.sections)
    for scope, sections in declarations.starts_of_globals():
        yield Body(scope, None, sections)


def resolve(
    sources: Sequence[s.Source],
    errors: list[InputError],
    dialect: Dialect,
    *,
    whole: bool,
    visit: Visit | None = None,
) -> Project | None:
    """Check sources, and return the project; with errors, return None.

    `whole` tells whether the sources have been read without errors. `visit` is called for each
    body.
    """
    found = interfaces(sources, errors.append, dialect)
    for body in bodies(found):
        body.check(errors.append)
        if visit is not None and body.statements is not None:
            visit(body.scope, body.statements)
    if errors or not whole:
        return None
    try:
        return project_of(found)
    except InputError as error:
        errors.append(error)
        return None


def project_of(found: Interfaces) -> Project:
    """Return the project, or raise InputError for a mistake in its configuration.

    All bodies must have been checked without errors.
    """
    registry, declarations, ordered = found.registry, found.declarations, found.ordered
    schedule = configure(registry, declarations)
    _check_extent(schedule, registry, declarations, ordered)
    places = located(schedule.instances, declarations)
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
        dialect=registry.dialect.name,
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


def _files(ordered: Sequence[Declared]) -> tuple[Path, ...]:
    """Return the files, sorted by their last declaration in the order of dependencies."""
    last = {declared.file: rank for rank, declared in enumerate(ordered)}
    return tuple(sorted(last, key=lambda file: last[file]))
