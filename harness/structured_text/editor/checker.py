"""A check of a program that is repeated after each change, as fast as an editor needs it.

The result is always that of `load.analyse`. While only bodies change, the resolved declarations of
the program are kept, and only the bodies of the changed files are checked again. If an interface
has changed, all declarations are resolved again, and all bodies are checked that mention a changed
name, directly or through other interfaces. The errors of all other bodies are kept.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from structured_text.editor.index import Index, outside_of
from structured_text.editor.shapes import Shape, Unit, shape_of, words_of
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.declare import Scope
from structured_text.language.dialects import Dialect
from structured_text.language.load import Read, analyse
from structured_text.language.registry import Declared
from structured_text.language.stages import Body, Interfaces, bodies, interfaces, project_of
from structured_text.language.starting import instance_sections
from structured_text.language.tree import Pou, Symbol

__all__ = ["Checker"]

#: A body: its file, the name of its POU or method, and its number among those of the same name.
_Key = tuple[str, str, int]


@dataclass
class _Checked:
    """The result of the check of a body.

    Attributes:
        programs: The programs that the body uses by their names, and those that it calls.
    """

    errors: list[InputError]
    programs: frozenset[str]
    called: frozenset[str]


@dataclass
class _State:
    """All that is kept from the last check.

    Attributes:
        sources: The sources by file, after the joining of phases and namespaces.
        own: The errors of the declarations.
        broken: The names of variables with an error in their declaration.
        globals: The global variables, without the programs that bodies use by their names.
    """

    dialect: Dialect
    sources: dict[str, s.Source]
    shapes: dict[str, Shape]
    found: Interfaces
    own: list[InputError]
    bodies: list[Body]
    broken: frozenset[str]
    globals: dict[str, Symbol]
    checked: dict[_Key, _Checked] = field(default_factory=dict)


class Checker:
    """Checks a program again and again; after small changes, this is fast.

    Attributes:
        checked_bodies: The number of bodies that the last check has looked at.
        errors: The errors that the last check has found.
    """

    def __init__(self) -> None:
        self.checked_bodies = 0
        self.errors: list[InputError] = []
        self._sources: list[s.Source] = []
        self._index: tuple[Index, Interfaces] | None = None
        self._state: _State | None = None
        self._words: dict[str, tuple[s.Source, frozenset[str]]] = {}

    def check(self, paths: Sequence[Path], read: Read) -> list[InputError]:
        """Return the errors of a program, in the order of the files and lines."""
        self._sources = []

        def reading(path: Path) -> s.Source:
            source = read(path)
            self._sources.append(source)
            return source

        self.errors = analyse(paths, reading, sys.maxsize, resolving=self._resolve)[1]
        return self.errors

    def index(self, text: Callable[[Path], str]) -> Index | None:
        """Return the index of names of the last check; None if there was no check.

        `text` returns the text of a file.
        """
        state = self._state
        if state is None:
            return None
        scopes: dict[str, Scope] = {}
        for body in state.bodies:
            if body.statements is not None:
                scopes.setdefault(body.scope.pou.name.upper(), body.scope)
        outside = outside_of(state.found.registry, state.found.declarations)
        before, interfaces = self._index or (None, None)
        same = interfaces is state.found
        index = Index(self._sources, scopes, outside, self.errors, text, before, same=same)
        self._index = index, state.found
        return index

    def _resolve(
        self,
        sources: Sequence[s.Source],
        errors: list[InputError],
        dialect: Dialect,
        *,
        whole: bool,
    ) -> None:
        """Check sources as `stages.resolve`, but return no project."""
        before = self._state
        self.checked_bodies = 0
        named = {str(source.file): source for source in sources}
        # A project file with several declarations is several sources; they are one source here.
        if len(named) < len(sources):
            named = {str(number): source for number, source in enumerate(sources)}
        state = None
        if before is not None:
            named = {key: _older(before.sources.get(key), one) for key, one in named.items()}
        if before is not None and before.dialect.name == dialect.name:
            state = self._bodies_only(before, named)
        if state is None:
            state = self._interfaces_again(before, named, dialect)
        self._state = None  # if the check fails, the next check begins anew
        self._check_bodies(state)
        self._state = state
        errors += state.own
        errors += [error for one in state.checked.values() for error in one.errors]
        if errors or not whole:
            return
        try:
            project_of(state.found)
        except InputError as error:
            errors.append(error)

    # --- what is kept ---

    def _bodies_only(self, before: _State, named: Mapping[str, s.Source]) -> _State | None:
        """Return the state if only bodies have changed since the last check, or None."""
        if list(named) != list(before.sources):
            return None
        changed = [key for key, one in named.items() if one is not before.sources[key]]
        known = before.found.registry
        shapes = dict(before.shapes)
        renewed: dict[int, s.Source] = {}
        for key in changed:
            shape, earlier = shape_of(named[key]), before.shapes[key]
            if not _alike(shape, earlier, {*known.types, *known.pous}):
                return None
            if shape.positions != earlier.positions and (
                before.own or _holds_positions(named[key], before)
            ):
                return None
            shapes[key] = shape
            renewed[id(before.sources[key])] = named[key]
        found = _renewed(before, renewed)
        if found is None:
            return None
        fresh = {str(named[key].file) for key in changed}
        checked = {key: one for key, one in before.checked.items() if key[0] not in fresh}
        return replace(before, sources=dict(named), shapes=shapes, bodies=found, checked=checked)

    def _interfaces_again(
        self, before: _State | None, named: Mapping[str, s.Source], dialect: Dialect
    ) -> _State:
        """Resolve all declarations, and keep the results of bodies that see no change."""
        own: list[InputError] = []
        shapes = {
            key: before.shapes[key]
            if before is not None and before.sources.get(key) is one
            else shape_of(one)
            for key, one in named.items()
        }
        found = interfaces(list(named.values()), own.append, dialect)
        broken = frozenset(found.declarations.broken)
        known = dict(found.declarations.globals)
        state = _State(dialect, dict(named), shapes, found, own, [], broken, known)
        if before is None or before.dialect.name != dialect.name:
            return state
        if [one.rest for one in shapes.values()] != [one.rest for one in before.shapes.values()]:
            return state
        if found.registry.cyclic or before.found.registry.cyclic:
            return state  # what is known then depends on where the search for cycles begins
        names = {
            *_changed_names(before.shapes, shapes),
            *(word for name in broken ^ before.broken for word in name.split(".")),
        }
        names = _reached(names, shapes.values())
        fresh = {
            str(source.file)
            for key, source in named.items()
            if source is not before.sources.get(key)
            or not self._mentioned(key, source).isdisjoint(names)
        }
        state.checked = {key: one for key, one in before.checked.items() if key[0] not in fresh}
        return state

    def _mentioned(self, key: str, source: s.Source) -> frozenset[str]:
        known = self._words.get(key)
        if known is None or known[0] is not source:
            known = self._words[key] = source, words_of(source)
        return known[1]

    # --- bodies ---

    def _check_bodies(self, state: _State) -> None:
        """Check the bodies without a kept result, and bring the declarations up to date."""
        declarations = state.found.declarations
        state.found.registry.uses.clear()
        kept, state.checked = state.checked, {}
        declarations.programs.clear()
        declarations.globals.clear()
        declarations.globals.update(state.globals)
        seen: list[Body] = []
        numbers: Counter[tuple[str, str]] = Counter()
        for body in state.bodies or bodies(state.found):
            seen.append(body)
            pou = body.scope.pou
            named = str(body.scope.where.file), pou.name
            key = (*named, numbers[named])
            numbers[named] += 1
            result = kept.get(key)
            if result is None:
                result = self._checked(body)
            state.checked[key] = result
            for program in sorted(result.programs):
                declarations.use_program(program)
        state.bodies = seen
        declarations.called.clear()
        for result in state.checked.values():
            declarations.called |= result.called

    def _checked(self, body: Body) -> _Checked:
        self.checked_bodies += 1
        pou, declarations = body.scope.pou, body.scope.declarations
        for key in [key for key in pou.symbols if key.startswith(" ")]:
            del pou.symbols[key]  # a global variable that the body used before
        declarations.called.clear()
        errors: list[InputError] = []
        body.check(errors.append)
        used = (key[1:] for key in pou.symbols if key.startswith(" "))
        programs = frozenset(key for key in used if key in declarations.programs)
        return _Checked(errors, programs, frozenset(declarations.called))


# --- comparisons ---


def _older(before: s.Source | None, now: s.Source) -> s.Source:
    """Return the earlier source if both say the same, so that sources are compared by identity."""
    same = before is now or (
        before is not None
        and str(before.file) == str(now.file)
        and before.declarations == now.declarations
        and before.namespaces == now.namespaces
        and before.entries == now.entries
    )
    return before if same and before is not None else now


def _alike(one: Shape, other: Shape, functions: set[str]) -> bool:
    """Return whether two interfaces of a source differ in positions only."""
    if one.rest != other.rest or len(one.units) != len(other.units):
        return False
    return all(
        mine.shape == before.shape
        and [name for name in mine.calls if name in functions]
        == [name for name in before.calls if name in functions]
        for mine, before in zip(one.units, other.units, strict=True)
    )


def _holds_positions(source: s.Source, before: _State) -> bool:
    """Return whether resolved declarations of a source keep positions that checks of bodies use."""
    if any(isinstance(one, (s.GlobalList, s.Configuration)) for one in source.declarations):
        return True
    return any(
        symbol.parts
        for body in before.bodies
        if body.scope.where.file == source.file
        for symbol in body.scope.pou.symbols.values()
    )


def _changed_names(before: Mapping[str, Shape], after: Mapping[str, Shape]) -> Iterator[str]:
    """Yield the names of declarations that differ, or that exist only before or after."""
    old, new = _units(before.values()), _units(after.values())
    for key in old.keys() | new.keys():
        mine, others = new.get(key, []), old.get(key, [])
        if [one.shape for one in mine] != [one.shape for one in others]:
            for one in (*mine, *others):
                yield from one.names


def _units(shapes: Iterable[Shape]) -> dict[frozenset[str], list[Unit]]:
    found: dict[frozenset[str], list[Unit]] = {}
    for shape in shapes:
        for unit in shape.units:
            found.setdefault(unit.names, []).append(unit)
    return found


def _reached(names: set[str], shapes: Iterable[Shape]) -> set[str]:
    """Return the names, and those of all declarations with an interface that mentions them."""
    names = set(names)
    waiting = [unit for shape in shapes for unit in shape.units]
    more = True
    while more:
        reached = [unit for unit in waiting if not unit.words.isdisjoint(names)]
        waiting = [unit for unit in waiting if unit.words.isdisjoint(names)]
        more = bool(reached)
        for unit in reached:
            names |= unit.names
    return names


def _renewed(before: _State, renewed: Mapping[int, s.Source]) -> list[Body] | None:
    """Return the bodies, those of changed sources with their new statements.

    The declarations of changed sources get their new positions. Return None if a body has no
    counterpart in the new source.
    """
    if not renewed:
        return before.bodies
    parts: dict[int, dict[str, _Part]] = {}
    for key, source in renewed.items():
        found = _parts(source)
        if found is None:
            return None
        parts[key] = found
    result: list[tuple[Body, _Part | None]] = []
    for body in before.bodies:
        own = parts.get(id(body.scope.where.source))
        part = own.get(body.scope.pou.name) if own is not None else None
        if own is not None and (part is None or body.statements is None):
            return None
        result.append((body, part))
    declared = _replaced(before.found, renewed)
    return [
        body if part is None else _with(body, part, declared[part.owner.name.key])
        for body, part in result
    ]


def _replaced(found: Interfaces, renewed: Mapping[int, s.Source]) -> dict[str, Declared]:
    """Replace the nodes of changed sources by those with the new positions, and return them."""
    declared: dict[str, Declared] = {}
    registry = found.registry
    for known in (registry.types, registry.pous, registry.interfaces):
        for name, one in known.items():
            source = renewed.get(id(one.source))
            if source is not None:
                node = next(node for node in source.declarations if node.name.key == name)
                known[name] = declared[name] = replace(one, node=node, source=source)
    return declared


def _with(body: Body, part: _Part, where: Declared) -> Body:
    _moved(body.scope.pou, part)
    return Body(replace(body.scope, where=where), part.statements, part.sections)


@dataclass(frozen=True)
class _Part:
    """A POU or method in a new source."""

    owner: s.Pou
    at: s.Position
    statements: tuple[s.Statement, ...]
    sections: tuple[s.Section, ...]


def _parts(source: s.Source) -> dict[str, _Part] | None:
    """Return the POUs and methods by name; None if a name occurs twice."""
    found: dict[str, _Part] = {}
    if len({node.name.key for node in source.declarations}) < len(source.declarations):
        return None
    for node in source.declarations:
        if not isinstance(node, s.Pou):
            continue
        name, sections = node.name.text, (*node.sections, *instance_sections(node))
        found[name] = _Part(node, node.at, node.body, sections)
        for member in node.members:
            accessors = {"": member} if isinstance(member, s.Method) else {}
            if isinstance(member, s.Property):
                both = {".Get": member.getter, ".Set": member.setter}
                accessors = {word: one for word, one in both.items() if one is not None}
            for word, one in accessors.items():
                title = f"{name}.{member.name.text}{word}"
                if title in found:
                    return None
                found[title] = _Part(node, one.at, one.body, one.sections)
    return found


def _moved(pou: Pou, part: _Part) -> None:
    """Give a resolved POU the positions of its variables in the new source."""
    pou.at = part.at
    places = {
        name.key: name.at
        for section in part.sections
        for variable in section.variables
        for name in variable.names
    }
    for key, symbol in pou.symbols.items():
        if key in places and symbol.at != places[key]:
            symbol.at = places[key]
