"""The index of a project: each declared name, its definition and its uses in all files.

The names and their types come from a check of the sources, which goes on behind mistakes. The uses
in a file are collected when a feature needs them, and are cached.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from operator import is_
from pathlib import Path
from typing import NamedTuple

from structured_text.editor.names import Definition, Names
from structured_text.editor.resolving import Resolver
from structured_text.editor.texts import Text, same_name
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.compiling import deeply, uncollected
from structured_text.language.declare import Declarations, Scope
from structured_text.language.generics import instantiated
from structured_text.language.load import Read, survey
from structured_text.language.namespaces import separated
from structured_text.language.phases import joined
from structured_text.language.registry import Declared, Registry, last_name
from structured_text.language.source import ELSEWHERE, source_text

__all__ = ["DECLARATION", "Index", "Occurrence", "build", "outside_of"]

DECLARATION = "declaration"
#: Path and name of a function that is added to the sources. Its scope has the globals only, and
#: exists even if the sources have no body. No source can have this name.
_PROBE, _EMPTY = Path("?"), "?"


@dataclass(frozen=True)
class Occurrence:
    """A name in a file, and what it means.

    Attributes:
        definition: The declared name.
        path: The file on disk.
        at: The position in the file.
        name: The name as written here.
        role: DECLARATION, `read` or `write`.
    """

    definition: Definition
    path: str
    at: s.Position
    name: str
    role: str

    def holds(self, at: s.Position) -> bool:
        """Return whether a position is in the name or directly behind it."""
        return at.line == self.at.line and 0 <= at.column - self.at.column <= len(self.name)


class _Use(NamedTuple):
    """A use of a name. It remains valid while the definition moves."""

    key: str
    at: s.Position
    name: str
    role: str


class Index:
    """The names of a project.

    `build` makes it with a check of the whole project. A server that keeps the declarations between
    two checks gives them itself. Making an index is fast, because uses are collected later.

    Attributes:
        names: The definitions.
        scopes: The names that are known in each POU and method, by upper-case name.
        outside: The names that are known outside of any POU.
        errors: All errors of the sources, in the order of the files.

    Args:
        sources: The parsed sources.
        read_text: Returns the text of a file on disk, as far as it is open in the editor.
        before: The index before a change. What it has of unchanged sources, which are the same
            objects, is used again.
        same: Whether all interfaces are as in `before`, so that only bodies have changed.
    """

    def __init__(
        self,
        sources: Sequence[s.Source],
        scopes: Mapping[str, Scope],
        outside: Scope,
        errors: list[InputError],
        read_text: Callable[[Path], str] | None = None,
        before: Index | None = None,
        *,
        same: bool = False,
    ) -> None:
        whole = instantiated(separated(joined(sources)))
        self.names: Names = Names(whole, before.names if before is not None else None)
        self.scopes, self.errors, self.outside = scopes, errors, outside
        self._read_text = read_text or source_text
        self._texts: dict[str, Text] = {}
        self._paths: dict[str, list[s.Source]] = {}
        for source in whole:
            self._paths.setdefault(str(source.file), []).append(source)
        if before is not None:
            self.scopes = {**_lost(before, scopes, whole), **scopes}
        self._uses: dict[str, list[_Use]] = {}
        self._found: dict[str, list[Occurrence]] = {}
        if before is not None:
            self._keep(before, same=same)

    def _keep(self, before: Index, *, same: bool) -> None:
        """Take over the texts and, if the interfaces are the same, the uses of unchanged files."""
        for key, sources in self._paths.items():
            known = before._paths.get(key, ())
            if len(known) == len(sources) and all(map(is_, known, sources)):
                if key in before._texts:
                    self._texts[key] = before._texts[key]
                if same and key in before._uses:
                    self._uses[key] = before._uses[key]

    @property
    def files(self) -> list[str]:
        """Return the files on disk, each once."""
        return list(self._paths)

    def text(self, path: Path | str) -> Text:
        """Return the text of a file as it was indexed; the empty text if it cannot be read."""
        key = str(path)
        if key not in self._texts:
            text = ""
            with suppress(InputError, OSError):
                text = self._read_text(Path(key))
            self._texts[key] = Text(text, key)
        return self._texts[key]

    def occurrences(self, path: Path | str) -> list[Occurrence]:
        """Return the declarations and uses of names in a file, in the order of the text."""
        key = str(path)
        if key not in self._found:
            if key not in self._uses:
                with uncollected():
                    self._uses[key] = deeply(partial(self._collected, key))
            self._found[key] = [
                Occurrence(found, key, one.at, one.name, one.role)
                for one in self._uses[key]
                if (found := self.names.get(one.key)) is not None
            ]
        return self._found[key]

    def at(self, path: Path | str, at: s.Position, text: Text) -> Occurrence | None:
        """Return the name at a position of a text that may be newer, or None."""
        return next((one for one in self.placed(path, text) if one.holds(at)), None)

    def placed(self, path: Path | str, text: Text) -> list[Occurrence]:
        """Return the names of a file at their places in a text that may be newer.

        Names in lines that have changed since the index was made are left out.
        """
        known = self.occurrences(path)
        old, new = self.text(path).lines, text.lines
        if not self.text(path).text or old == new:
            return [one for one in known if same_name(text.name_at(one.at), one.name)]
        same = min(len(old), len(new))
        above = next((k for k in range(same) if old[k] != new[k]), same)
        rest = same - above
        below = next((k for k in range(rest) if old[-1 - k] != new[-1 - k]), rest)
        moved = len(new) - len(old)
        found = []
        for one in known:
            line = one.at.line
            if above < line <= len(old) - below:
                continue
            at = one.at._replace(line=line + (moved if line > above else 0))
            in_code = text.plain[text.offset(at) : text.offset(at) + 1].strip()
            if in_code and same_name(text.name_at(at), one.name):
                found.append(replace(one, at=at))
        return found

    def uses(self, definitions: Iterable[Definition]) -> list[Occurrence]:
        """Return all declarations and uses of some definitions, by file and position."""
        wanted = set(definitions)
        words = {one.name.upper() for one in wanted}
        found = []
        for path in self._paths:
            text = self.text(path)
            if text.text and not any(word in text.words for word in words):
                continue
            found += [one for one in self.occurrences(path) if one.definition in wanted]
        return found

    def family(self, definition: Definition) -> list[Definition]:
        """Return a definition and those that must have its name.

        These are the methods that override each other, and the pins of such methods.
        """
        owner = self.names.get(definition.owner)
        if definition.kind == "variable" and owner is not None and owner.kind == "method":
            name = definition.name.upper()
            found = [self.names.get(f"{one.key}.{name}") for one in self.family(owner)]
            pins = [one for one in found if one is not None]
            return pins if all(map(_is_pin, pins)) else [definition]
        if definition.kind not in ("method", "property", "action"):
            return [definition]
        name = definition.key.rpartition(".")[2]
        kin = {definition.owner}
        lines = {
            one.key: set(self.names.lineage(one.key))
            for one in self.names.all()
            if "." not in one.key and self.names.get(f"{one.key}.{name}") is not None
        }
        while more := {
            key
            for key, line in lines.items()
            if key not in kin and (line & kin or any(key in lines[one] for one in kin))
        }:
            kin |= more
        every = [self.names.get(f"{key}.{name}") for key in sorted(kin)]
        return [one for one in every if one is not None]

    def scope(self, key: str) -> Scope:
        """Return the names that are known in a POU or method; those outside if it is unknown."""
        return self.scopes.get(key) or self.scopes.get(key.partition(".")[0]) or self.outside

    def resolver(self, scope: Scope, found: list[tuple[Definition, s.Name, str]]) -> Resolver:
        """Return a resolver for names in a scope, which appends the uses to a list."""
        return Resolver(scope, self.names, lambda *use: found.append(use))

    # --- uses ---

    def _collected(self, key: str) -> list[_Use]:
        found: dict[tuple[s.Position, str], _Use] = {}

        def add(definition: Definition, name: s.Name, role: str) -> None:
            written = name.text.rpartition(".")[2]  # the name without its namespace
            before = len(name.text) - len(written)
            at = s.Position(name.at.line, name.at.column + before)
            if name.at.line <= ELSEWHERE:
                found.setdefault((at, definition.key), _Use(definition.key, at, written, role))

        resolver = Resolver(self.outside, self.names, add)
        for definition in self.names.of_file(key):
            if definition.kind != "list":  # the name of a list is the name of its file
                meant = resolver.global_of(definition)
                add(meant, s.Name(definition.name, definition.at), DECLARATION)
        for source in self._paths.get(key, ()):
            _Walk(self, add).source(source)
        return sorted(found.values(), key=lambda one: one.at)


class _Walk:
    """Visits the declarations and bodies of a source."""

    def __init__(self, index: Index, add: Callable[[Definition, s.Name, str], None]) -> None:
        self._index, self._add = index, add

    def source(self, source: s.Source) -> None:
        """Note the uses of names in a source."""
        for node in source.declarations:
            outside = self._resolver("")
            if isinstance(node, s.TypeDecl):
                self._bases([node.extends])
                outside.spec(node.spec)
                if node.initial is not None:
                    outside.initial(node.initial, None)
            elif isinstance(node, s.GlobalList):
                self._sections(outside, [node.section])
            elif isinstance(node, s.Configuration):
                self._configuration(outside, node)
            else:
                self._pou(node)
        for entry in source.entries:
            resolver = self._resolver("")
            resolver.expression(entry.path)
            resolver.spec(entry.spec)

    def _resolver(self, key: str) -> Resolver:
        scope = self._index.scope(key) if key else self._index.outside
        return Resolver(scope, self._index.names, self._add)

    def _note(self, key: str, name: s.Name) -> None:
        found = self._index.names.get(key)
        if found is not None:
            self._add(found, name, "read")

    def _bases(self, names: Iterable[s.Name | None]) -> None:
        for name in names:
            if name is not None:
                self._note(last_name(name), name)

    def _sections(self, resolver: Resolver, sections: Iterable[s.Section]) -> None:
        for section in sections:
            for variable in section.variables:
                resolver.declared(variable)

    def _pou(self, node: s.Pou | s.Interface) -> None:
        key = node.name.key
        if isinstance(node, s.Pou):
            self._bases([node.extends, *node.implements])
            resolver = self._resolver(key)
            resolver.spec(node.result)
            self._sections(resolver, node.sections)
            resolver.body(node.body)
        else:
            self._bases(node.extends)
        for member in node.members:
            if isinstance(member, s.Method):
                self._method(f"{key}.{member.name.key}", member)
                continue
            self._resolver("").spec(member.result)
            for word, accessor in (("GET", member.getter), ("SET", member.setter)):
                if accessor is not None:
                    self._method(f"{key}.{member.name.key}.{word}", accessor)

    def _method(self, key: str, node: s.Method) -> None:
        resolver = self._resolver(key)
        resolver.spec(node.result)
        self._sections(resolver, node.sections)
        resolver.body(node.body)

    def _configuration(self, resolver: Resolver, node: s.Configuration) -> None:
        self._sections(resolver, node.globals)
        for task in node.tasks:
            for _, value in task.settings:
                resolver.expression(value)
        for program in node.programs:
            if program.task is not None:
                self._note(f"@{node.name.key}.{program.task.key}", program.task)
            self._note(program.program.key, program.program)


def _lost(
    before: Index, scopes: Mapping[str, Scope], sources: Iterable[s.Source]
) -> dict[str, Scope]:
    """Return the scopes before a change that are missing in a text with mistakes.

    While somebody is typing, a whole POU can be unreadable. Completion still needs its names.
    """
    broken = {str(one.file) for one in sources if one.errors}
    return {
        key: scope
        for key, scope in before.scopes.items()
        if key not in scopes and str(scope.where.file) in broken
    }


def _is_pin(definition: Definition) -> bool:
    section = definition.section.kind if definition.section is not None else ""
    return section in ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")


def outside_of(registry: Registry, declarations: Declarations) -> Scope:
    """Return the names that are known outside of any POU: the globals, types and POUs."""
    start = s.Position(1, 1)
    pou = s.Pou("FUNCTION", s.Name(_EMPTY, start), None, (), (), start)
    where = Declared(pou, s.Source(_PROBE, (pou,)))
    return Scope(t.Pou("FUNCTION", _EMPTY, str(_PROBE), {}), where, registry, declarations)


def build(paths: Sequence[Path], read: Read, text: Callable[[Path], str] | None = None) -> Index:
    """Return the index of a project.

    `read` parses a source, as for `load.analyse`. `text` returns the text of a file, as far as it
    is open in the editor; without it, the file is read. The errors of the check are in the index,
    so that no second check is necessary to show them.
    """
    sources: list[s.Source] = []
    scopes: dict[str, Scope] = {}

    def reading(path: Path) -> s.Source:
        if path == _PROBE:
            start = s.Position(1, 1)
            pou = s.Pou("FUNCTION", s.Name(_EMPTY, start), None, (), (), start)
            return s.Source(_PROBE, (pou,))
        source = read(path)
        sources.append(source)
        return source

    def visit(scope: Scope, body: tuple[s.Statement, ...]) -> None:
        del body
        scopes.setdefault(scope.pou.name.upper(), scope)

    errors = survey([*paths, _PROBE], visit, reading)
    probe = scopes.pop(_EMPTY)
    return Index(sources, scopes, outside_of(probe.registry, probe.declarations), errors, text)
