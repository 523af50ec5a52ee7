"""The declared names of a project: what declares them, where, and inside of what."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from structured_text.language import syntax as s
from structured_text.language.parser import ACTION
from structured_text.language.registry import base_name, last_name

__all__ = ["LIST", "Definition", "Names", "Part", "spec_name"]

#: First character of the keys of lists of globals, of configurations, and of what they contain.
#: A list may have the name of a POU.
LIST = "@"


@dataclass(frozen=True, eq=False)
class Definition:
    """A declared name.

    Attributes:
        key: Its path in upper case: `BLOCK.METHOD.PIN`.
        name: The name as declared.
        kind: `variable`, `field`, `member` (of an enumeration), `method`, `action`, `property`,
            `list`, `task`, `instance`, `configuration`, `interface`, `structure`, `enumeration`,
            `type`, `function`, `function_block` or `program`.
        path: The source of the declaration.
        at: The position of the name.
        node: The syntax of the declaration.
        section: The section of a variable.
        number: The place of a member in its enumeration.
    """

    key: str
    name: str
    kind: str
    path: Path
    at: s.Position
    node: Any = field(repr=False)
    section: s.Section | None = field(default=None, repr=False)
    number: int = 0

    @property
    def owner(self) -> str:
        """Return the key of the declaration around it; empty for a declaration of a file."""
        return self.key.rpartition(".")[0]

    @property
    def file(self) -> str:
        """Return the path of the file on disk."""
        return str(self.path)


class Names:
    """The declared names of some sources.

    The definitions of a source that `before` has as well are taken from it.

    Attributes:
        parts: The definitions of each source, by the `id` of the source.
    """

    def __init__(self, sources: Iterable[s.Source], before: Names | None = None) -> None:
        self._by_key: dict[str, Definition] = {}
        self._in_file: dict[str, list[Definition]] = {}
        self._inside: dict[str, list[Definition]] = {}
        self._bases: dict[str, list[str]] = {}
        self.parts: dict[int, Part] = {}
        known = before.parts if before is not None else {}
        for source in sources:
            part = known.get(id(source))
            if part is None or part.source is not source:
                part = Part(source)
            self.parts[id(source)] = part
            self._bases |= part.bases
            self._in_file.setdefault(str(source.file), []).extend(part.every)
            for key, found in part.keys:
                if key not in self._by_key:  # what is declared twice has an error
                    self._by_key[key] = found
                    self._inside.setdefault(key.rpartition(".")[0], []).append(found)

    def get(self, key: str) -> Definition | None:
        """Return the definition with this key; None if there is none."""
        return self._by_key.get(key)

    def member(self, owner: str, name: str) -> Definition | None:
        """Return a member of a block, structure or interface, or of its bases, by its key."""
        for key in self.lineage(owner):
            found = self._by_key.get(f"{key}.{name}")
            if found is not None:
                return found
        return None

    def lineage(self, owner: str) -> list[str]:
        """Return the keys of a declaration and of its direct and indirect bases."""
        found = [owner]
        for key in found:
            found += [base for base in self._bases.get(key, ()) if base not in found]
        return found

    def inside(self, owner: str) -> Sequence[Definition]:
        """Return what a declaration itself declares."""
        return self._inside.get(owner, ())

    def of_file(self, path: Path | str) -> Sequence[Definition]:
        """Return the definitions in a file."""
        return self._in_file.get(str(path), ())

    def all(self) -> Iterator[Definition]:
        """Return all definitions."""
        return (one for found in self._in_file.values() for one in found)


class Part:
    """The definitions of one source.

    Attributes:
        every: The definitions. A generic block has many keys, but one definition.
        keys: The definitions with their keys.
        bases: The keys of what each declaration extends and implements.
    """

    def __init__(self, source: s.Source) -> None:
        self.source = source
        self.keys: list[tuple[str, Definition]] = []
        self.bases: dict[str, list[str]] = {}
        self._places: dict[s.Position, Definition] = {}
        for node in source.declarations:
            self._declaration(node)
        self.every = list(self._places.values())

    def _add(
        self,
        key: str,
        name: s.Name,
        kind: str,
        node: Any,
        section: s.Section | None = None,
        number: int = 0,
    ) -> None:
        found = self._places.get(name.at)
        if found is None:
            path = self.source.file
            found = Definition(key, name.text, kind, path, name.at, node, section, number)
            self._places[name.at] = found
        self.keys.append((key, found))

    def _declaration(self, node: s.Declaration) -> None:
        key = node.name.key
        if isinstance(node, s.GlobalList):
            self._add(f"{LIST}{key}", node.name, "list", node)
            self._section(f"{LIST}{key}", node.section)
        elif isinstance(node, s.Configuration):
            self._configuration(f"{LIST}{key}", node)
        elif isinstance(node, s.TypeDecl):
            if node.extends is not None:
                self.bases[key] = [base_name(node)]
            kinds = {s.StructSpec: "structure", s.EnumSpec: "enumeration"}
            self._add(key, node.name, kinds.get(type(node.spec), "type"), node)
            self._spec(key, node.spec)
        elif isinstance(node, s.Interface):
            self.bases[key] = [last_name(one) for one in node.extends]
            self._add(key, node.name, "interface", node)
            self._members(key, node.members)
        else:
            self.bases[key] = [] if node.extends is None else [base_name(node)]
            self.bases[key] += [last_name(one) for one in node.implements]
            self._add(key, node.name, node.kind.lower(), node)
            for section in node.sections:
                self._section(key, section)
            self._members(key, node.members)

    def _configuration(self, key: str, node: s.Configuration) -> None:
        self._add(key, node.name, "configuration", node)
        for section in node.globals:
            self._section(key, section)
        for task in node.tasks:
            self._add(f"{key}.{task.name.key}", task.name, "task", task)
        for instance in node.programs:
            self._add(f"{key}.{instance.name.key}", instance.name, "instance", instance)

    def _members(self, owner: str, members: Sequence[s.Method | s.Property]) -> None:
        for node in members:
            key = f"{owner}.{node.name.key}"
            if isinstance(node, s.Method):
                self._add(key, node.name, "action" if ACTION in node.words else "method", node)
                for section in node.sections:
                    self._section(key, section)
                continue
            self._add(key, node.name, "property", node)
            for word, accessor in (("GET", node.getter), ("SET", node.setter)):
                for section in accessor.sections if accessor is not None else ():
                    self._section(f"{key}.{word}", section)

    def _section(self, owner: str, section: s.Section) -> None:
        for variable in section.variables:
            for name in variable.names:
                self._add(f"{owner}.{name.key}", name, "variable", variable, section)
            self._spec(f"{owner}.{variable.names[0].key}", variable.spec)

    def _spec(self, owner: str, spec: s.TypeSpec) -> None:
        if isinstance(spec, s.EnumSpec):
            for number, name in enumerate(spec.members):
                self._add(f"{owner}.{name.key}", name, "member", spec, None, number)
        elif isinstance(spec, s.StructSpec):
            for variable in spec.fields:
                for name in variable.names:
                    self._add(f"{owner}.{name.key}", name, "field", variable)
                nested = f"{owner}_{variable.names[0].key}"
                self._spec(nested, variable.spec)
        elif isinstance(spec, s.ArraySpec):
            self._spec(f"{owner}_ELEMENT", spec.element)


def spec_name(spec: Any) -> str:
    """Return the upper-case name of the named type inside of a specification; else empty."""
    while isinstance(spec, (s.ArraySpec, s.PointerSpec)):
        spec = spec.element if isinstance(spec, s.ArraySpec) else spec.target
    if isinstance(spec, s.SubrangeSpec):
        spec = spec.base
    return last_name(spec.name) if isinstance(spec, s.NamedSpec) else ""
