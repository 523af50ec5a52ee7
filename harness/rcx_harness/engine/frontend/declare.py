"""Resolves types and the variables of POUs: names become types, initial values are complete."""

from __future__ import annotations

import re
from collections.abc import Callable
from ctypes import c_float
from dataclasses import dataclass
from typing import Any

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.constants import constant, integer
from rcx_harness.engine.frontend.registry import Declared, Registry
from rcx_harness.engine.frontend.scalars import ANY_REAL, ELEMENTARY, WIDTH
from rcx_harness.engine.frontend.standard import BLOCKS, UNSUPPORTED
from rcx_harness.engine.frontend.tree import Pou, Symbol
from rcx_harness.engine.frontend.values import array_length, describe
from rcx_harness.engine.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
    Variable,
)
from rcx_harness.errors import InputError

__all__ = ["Declarations", "Scope", "default_scalar"]

_SECTIONS = {
    "FUNCTION": ("VAR", "VAR_INPUT"),
    "FUNCTION_BLOCK": (
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL"),
    ),
    "PROGRAM": ("VAR", "VAR_TEMP", "VAR_EXTERNAL"),
    "CONFIGURATION": ("VAR_GLOBAL",),
}
_ADDRESS = re.compile(r"%([IQM])([XBWDL]?)(\d+(?:\.\d+)*)", re.IGNORECASE)
_ADDRESS_BITS = {"": 1, "X": 1, "B": 8, "W": 16, "D": 32, "L": 64}
_MAX_ELEMENTS = 1_000_000


class Declarations:
    """The resolved declarations of a project, filled in dependency order.

    Args:
        registry: All names.
        report: Takes each error; the declaration it is in is then incomplete.
    """

    def __init__(self, registry: Registry, report: Callable[[InputError], None]) -> None:
        self._registry = registry
        self._report = report
        self.types: dict[str, Type] = {}
        self.initial: dict[str, Any] = {}
        self.blocks: dict[str, BlockType] = {}
        self.pous: dict[str, Pou] = {}
        self.globals: dict[str, Symbol] = {}
        self._addresses: dict[str, Type] = {}

    # --- types ---

    def add_type(self, node: s.TypeDecl, where: Declared) -> None:
        """Resolve one type of a TYPE … END_TYPE."""
        try:
            kind, initial = self._named_type(node, where)
            if node.initial is not None:
                initial = self.initial_value(node.initial, kind, where, initial)
        except InputError as error:
            self._report(error)
            return
        self.types[node.name.key] = kind
        self.initial[node.name.key] = initial

    def _named_type(self, node: s.TypeDecl, where: Declared) -> tuple[Type, Any]:
        spec, name = node.spec, node.name.text
        if isinstance(spec, s.EnumSpec):
            return self._enumeration(name, spec, where)
        if isinstance(spec, s.StructSpec):
            return self._structure(name, spec, where)
        if isinstance(spec, s.ArraySpec):
            return self._array(name, spec, where)
        kind, initial = self.resolve(spec, where)
        if isinstance(kind, BlockType):
            raise where.error(f"{spec.name.text} is a block, not a data type", spec.at)
        return kind, initial

    def _enumeration(self, name: str, spec: s.EnumSpec, where: Declared) -> tuple[Type, Any]:
        if spec.explicit:
            raise where.error(
                "enumeration members with a value are not supported", spec.at, "remove the values"
            )
        seen: set[str] = set()
        for member in spec.members:
            if member.key in seen:
                raise where.error(f"{member.text} is a member twice", member.at)
            if self._registry.is_standard(member.key):
                raise where.error(f"{member.text} is the name of a standard element", member.at)
            if member.key in self._registry.types or member.key in self._registry.pous:
                raise where.error(f"{member.text} is also a type, function or block", member.at)
            seen.add(member.key)
        return EnumType(name, tuple(member.text for member in spec.members)), 0

    def _structure(self, name: str, spec: s.StructSpec, where: Declared) -> tuple[Type, Any]:
        fields: list[tuple[str, Type]] = []
        values: dict[str, Any] = {}
        for declaration in spec.fields:
            kind, initial = self._data_type(declaration.spec, where)
            if declaration.initial is not None:
                initial = self.initial_value(declaration.initial, kind, where, initial)
            for field in declaration.names:
                if field.key in (known.upper() for known, _ in fields):
                    raise where.error(f"{field.text} is a field twice", field.at)
                fields.append((field.text, kind))
                values[field.text] = initial
        return StructType(name, tuple(fields)), values

    def _array(self, name: str, spec: s.ArraySpec, where: Declared) -> tuple[Type, Any]:
        bounds = []
        for dimension in spec.dimensions:
            low, high = integer(dimension.low, where), integer(dimension.high, where)
            if low > high:
                raise where.error(f"the bounds {low}..{high} are empty", dimension.at)
            bounds.append((low, high))
        element, initial = self._data_type(spec.element, where)
        kind = ArrayType(name, tuple(bounds), element)
        if array_length(kind) > _MAX_ELEMENTS:
            raise where.error(f"more than {_MAX_ELEMENTS} elements are not supported", spec.at)
        return kind, [initial] * array_length(kind)

    def _data_type(self, spec: s.TypeSpec, where: Declared) -> tuple[Type, Any]:
        """A type that can be a field or element."""
        kind, initial = self.resolve(spec, where)
        if isinstance(kind, BlockType):
            raise where.error(
                "blocks in structures and arrays are not supported",
                spec.at,
                "declare each block as a variable of its own",
            )
        return kind, initial

    def resolve(self, spec: s.TypeSpec, where: Declared) -> tuple[Type, Any]:
        """The type that a specification names, and its initial value.

        Raises:
            InputError: no such type, or one that is not supported.
        """
        if isinstance(spec, s.ArraySpec):
            return self._array("", spec, where)
        if not isinstance(spec, s.NamedSpec):
            raise where.error(
                "a structure or enumeration without a name", spec.at, "declare it in a TYPE"
            )
        name, key = spec.name.text, spec.name.key
        if spec.extra:
            hint = f"write plain {name}"
            raise where.error(f"{name} with {spec.extra} is not supported", spec.at, hint)
        if key in ELEMENTARY:
            kind = ELEMENTARY[key]
            return kind, default_scalar(kind)
        if key in self.types:
            return self.types[key], self.initial[key]
        if key in BLOCKS:
            self.blocks.setdefault(key, BLOCKS[key])
            return BLOCKS[key], None
        if key in UNSUPPORTED:
            raise where.error(f"the block {name} is not supported", spec.at)
        declared = self._registry.pous.get(key)
        if declared is not None and isinstance(declared.node, s.Pou):
            if declared.node.kind != "FUNCTION_BLOCK":
                raise where.error(f"{name} is a {declared.node.kind}, not a type", spec.at)
            if key in self.blocks:
                return self.blocks[key], None
        if key in self._registry.types or declared is not None:
            raise where.error(f"the declaration of {name} has an error", spec.at)
        raise where.error(
            f"there is no type {name}", spec.at, "name its file too, or look at the spelling"
        )

    # --- initial values ---

    def initial_value(self, node: s.Init, kind: Type, where: Declared, default: Any) -> Any:
        """A complete initial value: a scalar, a flat list, or a dict by declared field name.

        Args:
            node: What the source says.
            kind: Type of the variable.
            where: Its declaration, for messages.
            default: The value where the source leaves something out.

        Raises:
            InputError: not constant, or not of the type.
        """
        if isinstance(kind, (ElementaryType, EnumType)):
            if isinstance(node, (s.ArrayInit, s.StructInit)):
                raise where.error(f"a {describe(kind)} needs a single value", node.at)
            value = constant(node, kind, self.types, where).value
            return c_float(float(value)).value if kind.name == "REAL" else value
        if isinstance(kind, ArrayType) and isinstance(node, s.ArrayInit):
            values = list(default)
            items = self._items(node, kind, where)
            if len(items) > len(values):
                raise where.error(f"{len(items)} values for {len(values)} elements", node.at)
            for position, item in enumerate(items):
                values[position] = self.initial_value(item, kind.element, where, values[position])
            return values
        if isinstance(kind, StructType) and isinstance(node, s.StructInit):
            known = {name.upper(): (name, field) for name, field in kind.fields}
            result = dict(default)
            for field, item in node.fields:
                if field.key not in known:
                    raise where.error(f"{kind.name} has no field {field.text}", field.at)
                name, field_type = known[field.key]
                result[name] = self.initial_value(item, field_type, where, result[name])
            return result
        raise where.error(f"this is no initial value for a {describe(kind)}", node.at)

    def _items(self, node: s.ArrayInit, kind: ArrayType, where: Declared) -> list[s.Init]:
        items: list[s.Init] = []
        for count, item in node.items:
            times = 1 if count is None else integer(count, where)
            if times > array_length(kind):
                raise where.error(f"{times} values are more than the array holds", node.at)
            items += [item] * times
        return items

    # --- variables ---

    def externals(self, block: BlockType) -> frozenset[str]:
        """Upper-case names of the global variables a block or the blocks inside it use."""
        names = set()
        for variable in block.variables:
            if variable.section == "VAR_EXTERNAL":
                names.add(variable.name.upper())
            elif isinstance(variable.type, BlockType):
                names |= self.externals(variable.type)
        return frozenset(names)

    def add_pou(self, node: s.Pou, where: Declared) -> None:
        """Resolve the interface and the variables of a POU; its body stays empty."""
        symbols: dict[str, Symbol] = {}
        for section in node.sections:
            self.add_section(section, node.kind, symbols, where)
        result = None
        if node.result is not None:
            try:
                kind, initial = self._data_type(node.result, where)
                result = Symbol(node.name.text, kind, "RESULT", node.result.at, initial)
            except InputError as error:
                self._report(error)
        if node.kind == "FUNCTION" and not any(
            symbol.section == "VAR_INPUT" for symbol in symbols.values()
        ):
            self._report(where.error(f"{node.name.text} has no VAR_INPUT", node.name.at))
        pou = Pou(node.kind, node.name.text, str(where.file), symbols, result=result)
        if node.kind != "FUNCTION":
            pou.block = BlockType(
                node.name.text,
                tuple(
                    Variable(symbol.name, symbol.type, symbol.section, symbol.address)
                    for symbol in symbols.values()
                    if symbol.section != "VAR_TEMP"
                ),
            )
            self.blocks[node.name.key] = pou.block
        self.pous[node.name.key] = pou

    def add_section(
        self, section: s.Section, kind: str, symbols: dict[str, Symbol], where: Declared
    ) -> None:
        """Add the variables of a section to `symbols`, reporting what is wrong with them."""
        if section.kind not in _SECTIONS[kind]:
            self._report(where.error(f"{section.kind} is not supported in a {kind}", section.at))
            return
        for declaration in section.variables:
            try:
                for symbol in self._variables(declaration, section, kind, where):
                    key = symbol.name.upper()
                    clash = self._registry.variable_clash(key)
                    if clash:
                        raise where.error(
                            f"{symbol.name} {clash}", symbol.at, "choose another name"
                        )
                    if key in symbols:
                        raise where.error(f"{symbol.name} is declared twice", symbol.at)
                    symbols[key] = symbol
            except InputError as error:
                self._report(error)

    def _variables(
        self, node: s.VarDecl, section: s.Section, pou: str, where: Declared
    ) -> list[Symbol]:
        kind, initial = self.resolve(node.spec, where)
        constant_section = section.qualifier == "CONSTANT"
        if isinstance(kind, BlockType) and (
            section.kind != "VAR" or pou == "FUNCTION" or constant_section
        ):
            raise where.error(
                f"a block cannot stand in {section.kind} of a {pou}",
                node.at,
                "declare it in VAR of a FUNCTION_BLOCK or PROGRAM",
            )
        if node.initial is not None:
            if isinstance(kind, BlockType) or section.kind in ("VAR_IN_OUT", "VAR_EXTERNAL"):
                raise where.error("an initial value is not possible here", node.at)
            initial = self.initial_value(node.initial, kind, where, initial)
        if section.kind == "VAR_EXTERNAL":
            self._check_external(node, kind, where)
        address = None
        if node.address is not None:
            address = self._address(node, kind, section, pou, where)
        return [
            Symbol(name.text, kind, section.kind, name.at, initial, constant_section, address)
            for name in node.names
        ]

    def _check_external(self, node: s.VarDecl, kind: Type, where: Declared) -> None:
        for name in node.names:
            found = self.globals.get(name.key)
            if found is None:
                raise where.error(f"there is no global variable {name.text}", name.at)
            if found.type != kind:
                raise where.error(f"the global {name.text} is a {describe(found.type)}", name.at)

    def _address(
        self, node: s.VarDecl, kind: Type, section: s.Section, pou: str, where: Declared
    ) -> str:
        assert node.address is not None
        text = node.address.text.upper()
        parts = _ADDRESS.fullmatch(text)
        if parts is None:
            raise where.error(
                f"{text} is no address", node.address.at, "write it as %IX0.0, %QW3 or %MD10"
            )
        if section.kind not in ("VAR", "VAR_GLOBAL") or pou in ("FUNCTION", "FUNCTION_BLOCK"):
            raise where.error(
                f"a located variable cannot stand in {section.kind} of a {pou}",
                node.address.at,
                "declare it in VAR of the PROGRAM or VAR_GLOBAL",
            )
        if len(node.names) > 1:
            raise where.error("one address for several variables", node.at)
        if not isinstance(kind, ElementaryType) or _bits(kind) != _ADDRESS_BITS[parts[2]]:
            raise where.error(
                f"a {describe(kind)} does not fit the address {text}",
                node.address.at,
                "X takes BOOL, B 8 bits, W 16, D 32, L 64; arrays cannot be located",
            )
        if self._addresses.setdefault(text, kind) != kind:
            raise where.error(
                f"{text} is also declared as {describe(self._addresses[text])}", node.address.at
            )
        return text


@dataclass(frozen=True)
class Scope:
    """What names mean inside one POU."""

    pou: Pou
    where: Declared
    registry: Registry
    declarations: Declarations

    def error(self, message: str, at: s.Position, hint: str = "") -> InputError:
        """An error in this POU's file."""
        return self.where.error(message, at, hint)

    def symbol(self, key: str) -> Symbol | None:
        """The variable of this upper-case name, a function's result included."""
        result = self.pou.result
        if result is not None and result.name.upper() == key:
            return result
        return self.pou.symbols.get(key)


def _bits(kind: ElementaryType) -> int:
    return {"BOOL": 1, "REAL": 32, "LREAL": 64, **WIDTH}.get(kind.name, 0)


def default_scalar(kind: ElementaryType) -> bool | int | float | str:
    """The initial value the standard gives a type: 0, FALSE or the empty string."""
    if kind.name == "BOOL":
        return False
    if kind.name == "STRING":
        return ""
    return 0.0 if kind.name in ANY_REAL else 0
