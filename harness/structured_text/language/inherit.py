"""Inheritance of blocks and interfaces, and their methods and properties.

A block may stand before its base in the sources, so first the methods of all blocks are added. Then
`_inherit` handles every base before the blocks derived from it.
"""

from __future__ import annotations

from collections import ChainMap
from collections.abc import Callable, Iterator, MutableMapping
from dataclasses import dataclass
from typing import Any, Protocol

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.objects import INIT, Objects
from structured_text.language.parser import TWO_BASES
from structured_text.language.registry import Declared, Registry, base_name, last_name
from structured_text.language.tree import Pou, Symbol
from structured_text.language.types import ArrayType, BlockType, Type, has_block, inside
from structured_text.language.values import describe

__all__ = ["Inheritance"]


@dataclass(frozen=True)
class _Owner:
    """A block or interface and its declaration."""

    node: s.Pou | s.Interface
    where: Declared

    @property
    def key(self) -> str:
        """Return the upper-case name of the block or interface."""
        return self.node.name.key


class _Declarations(Protocol):
    """The part of `declare.Declarations` that this module uses."""

    pous: dict[str, Pou]
    broken: set[str]
    local: MutableMapping[str, Symbol]
    sections: list[tuple[s.Section, Declared]]
    registry: Registry

    def is_known(self, key: str) -> bool:
        """Return whether the sources declare this name."""

    def where(self, key: str) -> Declared:
        """Return the declaration of a POU."""

    def resolve(self, spec: s.TypeSpec, where: Declared) -> tuple[Type, Any]:
        """Return the type of a specification, and its initial value."""

    def link(self) -> None:
        """Resolve the targets of pointers and references."""

    def add_section(
        self, section: s.Section, kind: str, symbols: dict[str, Symbol], where: Declared
    ) -> None:
        """Add the variables of a section."""


class Inheritance:
    """Resolves methods and inheritance for `Declarations`, which resolves all other declarations.

    Attributes:
        objects: The resolved blocks, interfaces and methods.
    """

    def __init__(self, declarations: _Declarations, report: Callable[[InputError], None]) -> None:
        self.objects = Objects()
        self._declarations = declarations
        self._report = report
        self._owners: dict[str, _Owner] = {}
        self._bodies: list[tuple[Pou, s.Method, Declared]] = []

    # --- declarations ---

    def base_symbols(self, node: s.Pou, where: Declared) -> dict[str, Symbol]:
        """Return the variables that a block inherits, by upper-case name, or raise InputError."""
        if node.extends is None:
            return {}
        if TWO_BASES in node.words:
            raise where.error("a block extends one block only", node.at, "use interfaces")
        self._declarations.registry.check_reachable(node.extends, where)
        key = base_name(node)
        base = self._declarations.pous.get(key)
        if base is None or base.kind != "FUNCTION_BLOCK":
            hint = "name its file, too, or check the spelling"
            known = self._declarations.is_known(key)
            message = f"{node.extends.text} is not a function block of these sources"
            raise where.error(message, node.extends.at, "" if known else hint)
        if "FINAL" in base.words:
            raise where.error(f"{base.name} is FINAL", node.extends.at)
        return {key: item for key, item in base.symbols.items() if item.section != "VAR_TEMP"}

    def instance_symbols(self, node: s.Pou, where: Declared) -> Iterator[tuple[str, Symbol]]:
        """Yield the VAR_INST of a block's methods, stored in each instance."""
        for method in _methods_of(node):
            for section in method.sections:
                if section.kind != "VAR_INST":
                    continue
                found: dict[str, Symbol] = {}
                self._declarations.add_section(section, "METHOD", found, where)
                for symbol in found.values():
                    symbol.name = f"{method.name.text}.{symbol.name}"
                    symbol.section = "VAR"
                    yield symbol.name.upper(), symbol

    def add(self, node: s.Pou | s.Interface, where: Declared) -> None:
        """Register a block or interface; `finish` resolves its methods."""
        key, objects = node.name.key, self.objects
        self._owners[key] = _Owner(node, where)
        objects.bases[key], objects.own[key], objects.all[key] = [], {}, {}
        if isinstance(node, s.Pou):
            objects.blocks.append(key)
            if node.extends is not None:
                objects.extended[key] = base_name(node)

    def finish(self) -> None:
        """Resolve all methods and check the rules of inheritance; report errors."""
        for owner in self._owners.values():
            self._find_bases(owner)
        for key, owner in self._owners.items():
            self._add_methods(key, owner)
        self._declarations.link()
        done: set[str] = set()
        for key in self._owners:
            self._inherit(key, done)
        for owner in self._owners.values():
            if isinstance(owner.node, s.Pou):
                self._check_complete(owner)
        for pou in self._declarations.pous.values():
            self._check_instances(pou)

    def bodies(self) -> Iterator[tuple[Pou, s.Method, Declared]]:
        """Return every method of a block with its statements."""
        return iter(self._bodies)

    def _find_bases(self, owner: _Owner) -> None:
        node, where = owner.node, owner.where
        interfaces = node.implements if isinstance(node, s.Pou) else node.extends
        registry = self._declarations.registry
        if isinstance(node, s.Pou) and node.extends is not None:
            self.objects.bases[owner.key].append(base_name(node))
        for name in interfaces:
            try:
                registry.check_reachable(name, where)
            except InputError as error:
                self._report(error)
                continue
            base = self._owners.get(last_name(name))
            if base is None or not isinstance(base.node, s.Interface):
                hint = "name its file, too, or check the spelling"
                self._report(where.error(f"there is no interface {name.text}", name.at, hint))
            else:
                self.objects.bases[owner.key].append(last_name(name))

    def _add_methods(self, key: str, owner: _Owner) -> None:
        node, where = owner.node, owner.where
        pou = self._declarations.pous.get(key)
        for member in node.members:
            if isinstance(member, s.Method):
                self._add_method(owner, pou, member, member.name.text)
                continue
            getter, setter = member.getter, member.setter
            if isinstance(node, s.Interface) and getter is None and setter is None:
                plain = s.Method(member.name, member.words, member.result, (), (), member.at)
                getter = setter = plain
            if getter is None and setter is None:
                text = f"the property {member.name.text} has neither GET nor SET"
                self._report(where.error(text, member.at))
            for word, accessor in (("Get", getter), ("Set", setter)):
                if accessor is not None:
                    self._add_method(owner, pou, accessor, f"{member.name.text}.{word}")

    def _add_method(self, owner: _Owner, pou: Pou | None, node: s.Method, name: str) -> None:
        where, declarations = owner.where, self._declarations
        symbols: dict[str, Symbol] = {}
        # Bounds and initial values may use constants of the method and of its block. A constant of
        # the method hides a constant of the block with the same name.
        declarations.local = ChainMap(symbols, {} if pou is None else pou.symbols)
        declarations.sections = [(section, where) for section in node.sections]
        for section in node.sections:
            if section.kind != "VAR_INST":
                declarations.add_section(section, "METHOD", symbols, where)
            elif pou is not None:
                for variable in (name for one in section.variables for name in one.names):
                    found = pou.symbols.get(f"{node.name.key}.{variable.key}")
                    if found is not None:
                        symbols[variable.key] = found
        for symbol in symbols.values():
            is_open = isinstance(symbol.type, ArrayType) and symbol.type.open
            copied = not is_open and not has_block(symbol.type)
            if symbol.section == "VAR_IN_OUT" and symbol.constant and copied:
                symbol.section = "VAR_INPUT"  # SET takes a value and returns nothing.
        result = None
        key = f"{owner.key}.{name.upper()}"
        if node.result is not None:
            try:
                kind, initial = declarations.resolve(node.result, where)
            except InputError as error:
                self._report(error)
                declarations.broken.add(key)
            else:
                result = Symbol(node.name.text, kind, "RESULT", node.at, initial)
        declarations.local, declarations.sections = {}, []
        if result is not None and name.endswith(".Set"):
            result.section = "VAR_INPUT"
            symbols = {node.name.key: result, **symbols}
            result = None
        names = sum(len(one.names) for part in node.sections for one in part.variables)
        if len(symbols) < names:
            declarations.broken.add(key)
        method = Pou(
            "METHOD",
            f"{owner.node.name.text}.{name}",
            str(where.file),
            symbols,
            result=result,
            owner=pou,
            words=node.words,
            at=node.at,
        )
        key = name.upper()
        named = pou is not None and node.name.key in pou.symbols
        if named or key in self.objects.own[owner.key]:
            self._report(where.error(f"{node.name.text} is declared twice", node.name.at))
        self.objects.own[owner.key][key] = method
        if pou is not None:
            declarations.pous[method.name.upper()] = method
            self._bodies.append((method, node, where))
            if "ABSTRACT" in node.words and node.body:
                text = f"the method {node.name.text} is ABSTRACT and has statements"
                self._report(where.error(text, node.at, "leave them out"))

    def _inherit(self, key: str, done: set[str]) -> None:
        owner = self._owners.get(key)
        if owner is None or key in done:
            return
        done.add(key)
        for base in self.objects.bases[owner.key]:
            self._inherit(base, done)
        for base in reversed(self.objects.bases[owner.key]):
            if base in self._owners:
                self.objects.all[owner.key].update(self.objects.all[base])
        for name, method in self.objects.own[owner.key].items():
            inherited = self.objects.all[owner.key].get(name)
            if inherited is not None:
                self._check_override(owner, name, method, inherited)
            elif "OVERRIDE" in method.words:
                at = self._at(owner, name)
                text = f"{method.name} is OVERRIDE, but there is no such method to override"
                self._report(owner.where.error(text, at))
        self.objects.all[owner.key].update(self.objects.own[owner.key])

    def _at(self, owner: _Owner, key: str) -> s.Position:
        name = key.partition(".")[0]
        return next(item.at for item in owner.node.members if item.name.key == name)

    def _check_override(self, owner: _Owner, name: str, method: Pou, inherited: Pou) -> None:
        at = self._at(owner, name)
        # FINAL in an interface concerns the blocks that implement the interface.
        if "FINAL" in inherited.words and inherited.owner is not None:
            self._report(owner.where.error(f"{inherited.name} is FINAL", at))
        if name == INIT.upper():
            if not _extends(method, inherited):
                text = f"{method.name} must begin with the parameters of {inherited.name}"
                hint = "its own parameters come behind them"
                self._report(owner.where.error(text, at, hint))
        elif _signature(method) != _signature(inherited):
            text = f"{method.name} has other parameters than {inherited.name}"
            self._report(owner.where.error(text, at, "names, types and result must be the same"))

    def _check_complete(self, owner: _Owner) -> None:
        """Report a block that is not ABSTRACT and lacks the body of a method."""
        assert isinstance(owner.node, s.Pou)
        missing = [
            method
            for method in self.objects.all[owner.key].values()
            if method.owner is None or "ABSTRACT" in method.words
        ]
        if missing and "ABSTRACT" not in owner.node.words:
            names = ", ".join(method.name for method in missing[:5])
            text = f"a body is missing in {owner.node.name.text}: {names}"
            hint = "write the methods, or make the block ABSTRACT"
            self._report(owner.where.error(text, owner.node.name.at, hint))

    def _check_instances(self, pou: Pou) -> None:
        if pou.owner is not None and pou.kind == "METHOD":
            where = self._owners[pou.owner.name.upper()].where
        else:
            where = self._declarations.where(pou.name.upper())
        for symbol in pou.symbols.values():
            if symbol.section in ("VAR_IN_OUT", "VAR_EXTERNAL"):
                continue
            block = _held_block(symbol.type)
            made = self._declarations.pous.get(block.name.upper()) if block else None
            starter = self.objects.starter(block.name.upper()) if block is not None else None
            if starter is not None and not symbol.started and block is not None:
                names = [f"{one.name} := ..." for one in starter.section("VAR_INPUT")[2:]]
                text = f"{symbol.name} gives {INIT} of {block.name} no arguments"
                hint = f"write {block.name}({', '.join(names)})"
                self._report(where.error(text, symbol.at, hint))
            if made is not None and "ABSTRACT" in made.words:
                text = f"{made.name} is ABSTRACT and cannot have an instance"
                hint = f"declare a block that extends it, or REFERENCE TO {made.name}"
                self._report(where.error(text, symbol.at, hint))


def _methods_of(node: s.Pou) -> Iterator[s.Method]:
    for member in node.members:
        if isinstance(member, s.Method):
            yield member
        else:
            yield from (one for one in (member.getter, member.setter) if one is not None)


def _extends(method: Pou, inherited: Pou) -> bool:
    """Return whether the inputs of an `INIT` begin with the inputs of the base block's `INIT`.

    The base block's `INIT` gets its arguments by position, so only their types must be the same. An
    `INIT` may leave out its result and the names of the standard parameters.
    """
    own, base = (
        [describe(one.type).upper() for one in each.section("VAR_INPUT")]
        for each in (method, inherited)
    )
    return own[: len(base)] == base


def _signature(method: Pou) -> tuple[object, ...]:
    pins = [
        (symbol.section, symbol.name.upper(), describe(symbol.type).upper())
        for symbol in method.symbols.values()
        if symbol.section in ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT")
    ]
    result = describe(method.result.type).upper() if method.result is not None else ""
    return (*pins, result)


def _held_block(kind: Type) -> BlockType | None:
    """Return the type of the first block that a variable of this type contains, or None."""
    return next((one for one in inside(kind) if isinstance(one, BlockType)), None)
