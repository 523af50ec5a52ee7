"""All names of a project: what declares them, and in which order they depend on each other."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, fields, is_dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.scalars import ELEMENTARY
from rcx_harness.engine.frontend.standard import BLOCKS, FUNCTIONS, UNSUPPORTED, conversion
from rcx_harness.errors import InputError

__all__ = ["Declared", "Registry", "parts_of"]

#: Types and POUs that may use each other in a row.
_MOST_LEVELS = 100

#: Types of those fields of syntax in which nothing is used.
_PLAIN = ("Name", "Name | None", "Position", "str", "bool", "int", "tuple[Name, ...]")

Declaration = s.TypeDecl | s.Pou | s.Configuration


@dataclass(frozen=True)
class Declared:
    """A declaration and where it comes from."""

    node: Declaration
    source: s.Source

    @property
    def file(self) -> Path:
        """The file it is in."""
        return self.source.file

    def error(self, message: str, at: s.Position, hint: str = "") -> InputError:
        """An error in this declaration's file."""
        return InputError(message, file=self.file, line=at.line, column=at.column, hint=hint)


class Registry:
    """The types and POUs of all sources by upper-case name, and the rules for names.

    Args:
        sources: The parsed files.
        report: Takes each error; the registry goes on after it.
    """

    def __init__(self, sources: Iterable[s.Source], report: Callable[[InputError], None]) -> None:
        self._report = report
        self.types: dict[str, Declared] = {}
        self.pous: dict[str, Declared] = {}
        self.configuration: Declared | None = None
        self.members: dict[str, list[str]] = {}
        for source in sources:
            for node in source.declarations:
                self._add(Declared(node, source))
        for key, declared in self.types.items():
            spec = declared.node.spec if isinstance(declared.node, s.TypeDecl) else None
            if isinstance(spec, s.EnumSpec):
                for member in spec.members:
                    self.members.setdefault(member.key, []).append(key)

    def _add(self, declared: Declared) -> None:
        node = declared.node
        if isinstance(node, s.Configuration):
            if self.configuration is not None:
                other = self.configuration
                self._report(
                    declared.error(
                        "a second CONFIGURATION",
                        node.name.at,
                        f"the first is in {other.file.name}, line {other.node.at.line}",
                    )
                )
            self.configuration = declared
            return
        key = node.name.key
        earlier = self.types.get(key) or self.pous.get(key)
        if earlier is not None:
            hint = f"it is also declared in {earlier.file.name}, line {earlier.node.name.at.line}"
            self._report(declared.error(f"{node.name.text} is declared twice", node.name.at, hint))
        elif self.is_standard(key):
            self._report(
                declared.error(f"{node.name.text} is the name of a standard element", node.name.at)
            )
        elif isinstance(node, s.TypeDecl):
            self.types[key] = declared
        else:
            self.pous[key] = declared

    def is_standard(self, key: str) -> bool:
        """Whether the standard defines a type, function or block of this name."""
        return (
            key in ELEMENTARY
            or key in BLOCKS
            or key in FUNCTIONS
            or key in UNSUPPORTED
            or conversion(key) is not None
            or key in ("T", "D")
        )

    def variable_clash(self, key: str) -> str:
        """Why a variable cannot have this name; empty if it can."""
        if self.is_standard(key) and key not in ("T", "D", "SEMA", "RTC", "PID", "RAMP"):
            return "is the name of a standard element"
        if key in self.types:
            return "is the name of a type"
        if key in self.pous:
            node = self.pous[key].node
            assert isinstance(node, s.Pou)
            return f"is the name of a {node.kind}"
        if key in self.members:
            return "is a member of an enumeration"
        return ""

    def ordered(self) -> list[Declared]:
        """All declarations, each after those it uses.

        Types come first, then functions, blocks, programs and the configuration, as far as
        they do not use each other; otherwise in the order of the sources. A declaration that
        uses itself, directly or not, is reported.
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
        result: list[Declared] = []

        def visit(declared: Declared, path: tuple[str, ...]) -> None:
            key = declared.node.name.key
            if len(path) > _MOST_LEVELS:
                too_deep.append(declared)
                return
            if key in done:
                if not done[key]:
                    self._report_cycle(declared, (*path[path.index(key) :], key))
                return
            done[key] = False
            used = [name for name in _used(declared.node) if name in everything]
            for name in used:
                visit(everything[name], (*path, key))
            done[key] = True
            levels[key] = 1 + max((levels.get(name, 0) for name in used), default=0)
            if levels[key] > _MOST_LEVELS:
                too_deep.append(declared)
            result.append(declared)

        for declared in first:
            visit(declared, ())
        for declared in too_deep[:1]:
            message = f"more than {_MOST_LEVELS} types, functions and blocks that use each other"
            self._report(declared.error(f"{message} in a row", declared.node.name.at))
        if self.configuration is not None:
            result.append(self.configuration)
        return result

    def _report_cycle(self, declared: Declared, cycle: tuple[str, ...]) -> None:
        kind = (
            "a type cannot contain itself"
            if declared.node.name.key in self.types
            else ("recursion is not supported")
        )
        names = " uses ".join(
            (self.types.get(key) or self.pous[key]).node.name.text for key in cycle
        )
        self._report(declared.error(f"{kind}: {names}", declared.node.name.at))


def _used(node: Any) -> Iterator[str]:
    """Names of types and functions that a piece of syntax uses, in order."""
    waiting = [node]
    while waiting:
        one = waiting.pop()
        kind: Any = type(one)
        if kind is tuple:
            waiting += one[::-1]
            continue
        if kind is s.NamedSpec:
            yield one.name.key
        elif kind is s.Call:
            yield one.function.key
        waiting += [getattr(one, name) for name in parts_of(one)]


def parts_of(node: Any) -> tuple[str, ...]:
    """The fields of a piece of syntax that are syntax too, the last one first."""
    kind: Any = type(node)
    return _parts(kind)


@lru_cache(maxsize=256)
def _parts(kind: Any) -> tuple[str, ...]:
    if not is_dataclass(kind):
        return ()
    return tuple(field.name for field in reversed(fields(kind)) if field.type not in _PLAIN)
