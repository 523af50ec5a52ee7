"""The registry of all names of a project, their declarations and their dependencies."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.constructs import CONSTRUCTS, Use
from structured_text.language.dialects import IEC, Dialect, rules_of
from structured_text.language.scalars import CORE
from structured_text.language.standard import BLOCKS, reserved
from structured_text.language.walk import nodes
from structured_text.output.limits import MOST_LEVELS

__all__ = ["ConsequenceError", "Declared", "Registry", "base_name", "last_name"]

#: Nodes that create no dependency between declarations. A pointer may lead back to the type that
#: contains it. A method may use a block that contains the method's own block.
_LATER = (s.PointerSpec, s.Method, s.Property)

#: Vendor libraries with standard elements. A program may write the library's name before such an
#: element.
_LIBRARIES = (
    "__SYSTEM",
    "STANDARD",
    "TC2_STANDARD",
    "TC2_SYSTEM",
    "TC2_UTILITIES",
    "UTIL",
    "STANDARD64",
)


class ConsequenceError(InputError):
    """An error that is only the consequence of another error, which has been reported."""


@dataclass(frozen=True)
class Declared:
    """A declaration and its source; `uses` collects constructs that are not portable."""

    node: s.Declaration
    source: s.Source
    uses: list[Use] = field(default_factory=list, compare=False, repr=False)

    @property
    def file(self) -> Path:
        """Return the file of the declaration."""
        return self.source.file

    @property
    def is_system(self) -> bool:
        """Return whether the declaration is built in, and not from a file of the user."""
        return str(self.file) == _LIBRARIES[0]

    def error(self, message: str, at: s.Position, hint: str = "") -> InputError:
        """Return an error in this declaration's file."""
        return InputError(message, file=self.file, line=at.line, column=at.column, hint=hint)

    def note(self, construct: str, at: s.Position, detail: str = "") -> None:
        """Note a construct beyond the portable subset; see `constructs.CONSTRUCTS`."""
        assert construct in CONSTRUCTS, construct
        self.uses.append(Use(construct, self.file, at, detail))


class Registry:
    """The types and POUs of all sources by upper-case name, and the rules for names.

    The registry continues after a reported error.

    Attributes:
        dialect: The rules where tools differ.
        cyclic: Whether `ordered` has found a declaration that uses itself.
    """

    def __init__(
        self,
        sources: Iterable[s.Source],
        report: Callable[[InputError], None],
        dialect: Dialect | None = None,
    ) -> None:
        self._report = report
        self.dialect = dialect or rules_of(IEC)
        self.cyclic = False
        self.types: dict[str, Declared] = {}
        self.pous: dict[str, Declared] = {}
        self.interfaces: dict[str, Declared] = {}
        self.overloads: dict[str, list[str]] = {}
        self.written_names: dict[str, str] = {}
        self.namespaces = set(_LIBRARIES)
        self.configuration: Declared | None = None
        self.members: dict[str, list[str]] = {}
        sources = list(sources)
        self.lists: list[Declared] = []
        self.uses: list[Use] = []
        self.entries: list[tuple[s.ConfigEntry, Declared]] = []
        for source in sources:
            self.uses += source.uses
            for entry in source.entries:
                self.entries.append((entry, Declared(_nameless(entry.at), source, self.uses)))
            for node in source.declarations:
                self._add(Declared(node, source, self.uses))
            for space in source.namespaces:
                if not space.used:
                    parts = space.name.key.split(".")
                    self.namespaces.update(".".join(parts[i:j]) for i, j in _spans(len(parts)))
        for source in sources:
            self._check_uses(source)
        for key, declared in self.types.items():
            spec = declared.node.spec if isinstance(declared.node, s.TypeDecl) else None
            if isinstance(spec, s.EnumSpec):
                for member in spec.members:
                    self.members.setdefault(member.key, []).append(key)

    def _add(self, declared: Declared) -> None:
        node = declared.node
        if isinstance(node, s.GlobalList):
            self.lists.append(declared)
            return
        if isinstance(node, s.Configuration):
            if self.configuration is not None:
                other = self.configuration
                self._report(
                    declared.error(
                        "there is a second CONFIGURATION",
                        node.name.at,
                        f"the first is in {other.file}, line {other.node.at.line}; give the files "
                        "of one program only",
                    )
                )
            self.configuration = declared
            return
        key = node.name.key
        earlier = self.types.get(key) or self.pous.get(key) or self.interfaces.get(key)
        if earlier is not None and self._overloads(declared, earlier):
            return
        if earlier is not None:
            place = f"{earlier.file.name}, line {earlier.node.name.at.line}"
            hint = f"remove this one or the one in {place}"
            self._report(declared.error(f"{node.name.text} is declared twice", node.name.at, hint))
        elif key in CORE:
            self._report(
                declared.error(f"{node.name.text} is the name of a standard element", node.name.at)
            )
        elif isinstance(node, s.Interface):
            self.interfaces[key] = declared
        elif isinstance(node, s.TypeDecl):
            self._note_standard(declared)
            self.types[key] = declared
        else:
            self._note_standard(declared)
            self.pous[key] = declared

    def _overloads(self, declared: Declared, earlier: Declared) -> bool:
        """Add a function with the name of another function; return False if that is illegal."""
        node, other = declared.node, earlier.node
        if self.dialect.name != "ax" or not isinstance(node, s.Pou) or not isinstance(other, s.Pou):
            return False
        key = node.name.key
        known = self.overloads.get(key, [key])
        inputs = [_inputs(self.pous[one].node) for one in known]
        if {node.kind, other.kind} != {"FUNCTION"} or _inputs(node) in inputs:
            return False
        name = f"{node.name.text}__{len(known) + 1}"
        self.overloads[key] = [*known, name.upper()]
        self.written_names[name.upper()] = node.name.text
        renamed = replace(node, name=s.Name(name, node.name.at))
        self.pous[name.upper()] = replace(declared, node=renamed)
        declared.note("functions of one name", node.name.at)
        return True

    def _note_standard(self, declared: Declared) -> None:
        if reserved(declared.node.name.key):
            construct = "a standard function with another meaning"
            declared.note(construct, declared.node.name.at)

    def _check_uses(self, source: s.Source) -> None:
        for space in source.namespaces:
            if space.used and space.name.key not in self.namespaces:
                self._report(
                    InputError(
                        f"there is no namespace {space.name.text}",
                        file=source.file,
                        line=space.at.line,
                        column=space.at.column,
                        hint="name its file, too, or check the spelling",
                    )
                )

    def incomplete(self, key: str) -> bool:
        """Return whether a base or interface of a block is not declared in these sources."""
        seen: set[str] = set()
        while key and key not in seen:
            seen.add(key)
            declared = self.pous.get(key)
            if declared is None or not isinstance(declared.node, s.Pou):
                return key not in BLOCKS
            node = declared.node
            if any(last_name(one) not in self.interfaces for one in node.implements):
                return True
            if node.extends is not None and not self.is_reachable(node.extends):
                return True
            key = "" if node.extends is None else base_name(node)
        return bool(key)

    def is_reachable(self, name: s.Name) -> bool:
        """Return whether a name has no namespace, or a namespace of the program or a library.

        A library may have its own libraries: `Library.Inner.Name`.
        """
        space = name.key.rpartition(".")[0]
        return not space or space in self.namespaces or space.rpartition(".")[2] in self.namespaces

    def check_reachable(self, name: s.Name, where: Declared) -> None:
        """Raise InputError if a name has an unknown namespace."""
        if not self.is_reachable(name):
            space = name.text[: name.text.rindex(".")]
            hint = "name its project, too, or check the spelling"
            raise where.error(f"there is no namespace {space}", name.at, hint)

    def variable_clash(self, key: str) -> str:
        """Return the reason why a variable should not have this name; empty if there is none."""
        if reserved(key) and key not in ("T", "D", "SEMA", "RTC", "PID", "RAMP"):
            return "is the name of a standard element"
        if key in self.types:
            return "is the name of a type"
        if key in self.interfaces:
            return "is the name of an INTERFACE"
        if key in self.pous:
            node = self.pous[key].node
            assert isinstance(node, s.Pou)
            return f"is the name of a {node.kind}"
        return "is a member of an enumeration" if key in self.members else ""

    def ordered(self) -> list[Declared]:
        """Return all declarations, each after those it uses.

        Types come first, then functions, blocks, programs and the configuration, as far as
        they do not use each other; otherwise in the order of the sources. A declaration that
        uses itself, directly or indirectly, is reported.
        """
        ranks = {"FUNCTION": 1, "FUNCTION_BLOCK": 2, "PROGRAM": 3}
        everything = {**self.types, **self.pous}
        first = sorted(
            everything.values(),
            key=lambda item: ranks[item.node.kind] if isinstance(item.node, s.Pou) else 0,
        )
        done: dict[str, bool] = {}
        levels: dict[str, int] = {}
        too_deep: list[Declared] = []
        result = [one for one in self.interfaces.values() if not one.is_system]

        # Depth-first search. `done` is False for a declaration while its dependencies are visited,
        # and True afterwards. A dependency that is still False uses itself. `levels` is the
        # length of the longest chain of dependencies, which the limit applies to, and the length
        # of `path` bounds the recursion.
        def visit(declared: Declared, path: tuple[str, ...]) -> None:
            key = declared.node.name.key
            if len(path) > MOST_LEVELS:
                too_deep.append(declared)
                return
            if key in done:
                if not done[key]:
                    self._report_cycle(declared, (*path[path.index(key) :], key))
                return
            done[key] = False
            used = [
                last_name(name)
                for name in _used(declared.node)
                if self.is_reachable(name) and last_name(name) in everything
            ]
            used = [one for name in used for one in self.overloads.get(name, [name])]
            # A call from one overload to another is not a cycle: the types of the arguments choose
            # the function.
            family = self.overloads.get(self.written_names.get(key, key).upper(), ())
            used = [one for one in used if one not in family]
            for name in used:
                visit(everything[name], (*path, key))
            done[key] = True
            levels[key] = 1 + max((levels.get(name, 0) for name in used), default=0)
            if levels[key] > MOST_LEVELS:
                too_deep.append(declared)
            result.append(declared)

        for declared in first:
            visit(declared, ())
        for declared in too_deep[:1]:
            message = f"more than {MOST_LEVELS} types, functions and blocks that use each other"
            self._report(declared.error(f"{message} in a row", declared.node.name.at))
        if self.configuration is not None:
            result.append(self.configuration)
        return result

    def _report_cycle(self, declared: Declared, cycle: tuple[str, ...]) -> None:
        self.cyclic = True
        kind = (
            "a type cannot contain itself"
            if declared.node.name.key in self.types
            else ("recursion is not supported")
        )
        names = " uses ".join(
            (self.types.get(key) or self.pous[key]).node.name.text for key in cycle
        )
        self._report(declared.error(f"{kind}: {names}", declared.node.name.at))


def _nameless(at: s.Position) -> s.GlobalList:
    """Return a declaration without a name, to which errors in VAR_CONFIG belong."""
    return s.GlobalList(s.Name("", at), s.Section("VAR_CONFIG", "", (), at), at)


def _inputs(node: s.Declaration) -> list[str]:
    """Return the types of the pins of a function, as written, in upper case."""
    assert isinstance(node, s.Pou)
    return [
        _written(variable.spec)
        for section in node.sections
        if section.kind in ("VAR_INPUT", "VAR_IN_OUT", "VAR_OUTPUT")
        for variable in section.variables
        for _ in variable.names
    ]


def _written(spec: object) -> str:
    if isinstance(spec, s.NamedSpec):
        return spec.name.key
    if isinstance(spec, s.ArraySpec):
        return f"ARRAY {len(spec.dimensions)} {_written(spec.element)}"
    return type(spec).__name__


def _used(node: Any) -> Iterator[s.Name]:
    """Yield names of types and functions that a piece of syntax uses, in order."""
    for one in nodes(node, _LATER):
        kind = type(one)
        if kind is s.NamedSpec:
            yield one.name
        elif kind in (s.Pou, s.TypeDecl) and one.extends is not None:
            space, _, name = one.extends.key.rpartition(".")
            # In `Drive EXTENDS Library.Drive`, the base is another block with the same name.
            if not space or name != one.name.key:
                yield one.extends
        elif kind is s.Call:
            yield one.function
    if isinstance(node, s.Pou):
        # The VAR_INST of a method are variables of each instance of its block.
        for part in nodes(node.members):
            if isinstance(part, s.Section) and part.kind == "VAR_INST":
                yield from _used(part)


def _spans(size: int) -> Iterator[tuple[int, int]]:
    """Yield the start and end index of every contiguous part of a sequence of this length."""
    return ((i, j) for i in range(size) for j in range(i + 1, size + 1))


def base_name(node: s.Pou | s.TypeDecl) -> str:
    """Return the upper-case name of the block or structure that a declaration extends.

    If the base has the name of the declaration itself, the result is a name that does not exist.
    """
    assert node.extends is not None
    key = last_name(node.extends)
    return node.extends.key if key == node.name.key and "." in node.extends.key else key


def last_name(name: s.Name) -> str:
    """Return the upper-case name without its namespaces."""
    return name.key.rpartition(".")[2]
