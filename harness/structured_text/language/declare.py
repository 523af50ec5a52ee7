"""The declarations of a project: variables of POUs and global variables.

`load` fills `Declarations`; the checker of a POU then looks up names in a `Scope`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import walk
from structured_text.language.constants import NotConstantError
from structured_text.language.inherit import Inheritance
from structured_text.language.later import Later, Part
from structured_text.language.objects import INIT, START
from structured_text.language.parser import CLASS
from structured_text.language.registry import Declared, Registry
from structured_text.language.resolve import Types
from structured_text.language.scalars import BOOL, WIDTH
from structured_text.language.sizes import size_of
from structured_text.language.tree import Pou, Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    Variable,
    has_block,
)
from structured_text.language.values import describe

__all__ = ["Declarations", "Scope"]

#: The portable sections of each kind of POU. `_ALSO` has accepted sections that are not portable.
_SECTIONS = {
    "FUNCTION": ("VAR", "VAR_INPUT"),
    "FUNCTION_BLOCK": (
        *("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL"),
    ),
    "PROGRAM": ("VAR", "VAR_TEMP", "VAR_EXTERNAL"),
    "METHOD": ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_INST"),
    "CONFIGURATION": ("VAR_GLOBAL",),
}
_ALSO = {
    "FUNCTION": ("VAR_OUTPUT", "VAR_IN_OUT", "VAR_TEMP", "VAR_EXTERNAL", "VAR_STAT"),
    "FUNCTION_BLOCK": ("VAR_STAT",),
    "PROGRAM": ("VAR_INPUT", "VAR_OUTPUT", "VAR_IN_OUT", "VAR_STAT"),
    "CONFIGURATION": (),
    "METHOD": ("VAR_STAT",),
}
_ADDRESS = re.compile(r"%([IQM])([XBWDL]?)(\d+(?:\.\d+)*)", re.IGNORECASE)
_ADDRESS_BITS = {"": 1, "X": 1, "B": 8, "W": 16, "D": 32, "L": 64}
#: Separator in the key of a global, between its list and its name. It is used if two lists have a
#: variable of the same name.
_JOINT = "__"


class Declarations(Types):
    """The resolved declarations of a project.

    A declaration with a reported error is incomplete.
    """

    def __init__(self, registry: Registry, report: Callable[[InputError], None]) -> None:
        super().__init__(registry, report)
        self.broken: set[str] = set()
        """Upper-case names of variables with an error in their declaration."""
        self.qualified: set[str] = set()
        """Keys of globals that a program must write with the name of the list of globals."""
        self.programs: set[str] = set()
        """Keys of the globals that hold the instances of programs that are used by their names."""
        self.called: set[str] = set()
        """Keys in `programs` whose program is called, and not only read."""
        self._addresses: dict[str, Type] = {}
        self._external: list[tuple[s.VarDecl, Type, Declared]] = []
        self.inheritance = Inheritance(self, report)
        self.objects = self.inheritance.objects

    def is_known(self, key: str) -> bool:
        """Return whether the sources declare a type, POU or interface of this name."""
        registry = self.registry
        return key in registry.types or key in registry.pous or key in registry.interfaces

    def where(self, key: str) -> Declared:
        """Return the declaration of a POU."""
        return self.registry.pous[key]

    def use_program(self, key: str) -> None:
        """Add the instance of a program that is used by its name; `key` is the upper-case name."""
        pou = self.pous[key]
        if key not in self.programs and pou.block is not None:
            self.programs.add(key)
            self.globals[key] = Symbol(pou.name, pou.block, "VAR_GLOBAL", self.where(key).node.at)

    # --- variables ---

    def externals(self, block: BlockType) -> frozenset[str]:
        """Return the upper-case names of the globals that a block and the blocks inside it use."""
        names = set()
        for variable in block.variables:
            if variable.section == "VAR_EXTERNAL":
                names.add(variable.name.upper())
            elif isinstance(variable.type, BlockType):
                names |= self.externals(variable.type)
        return frozenset(names)

    def add_pou(self, node: s.Pou, where: Declared) -> None:
        """Resolve the interface and the variables of a POU. Its body stays empty."""
        symbols: dict[str, Symbol] = {}
        self.local = symbols
        self.sections = [(section, where) for section in node.sections]
        try:
            symbols.update(self.inheritance.base_symbols(node, where))
        except InputError as error:
            self._report(error)
        for section in node.sections:
            self.add_section(section, node.kind, symbols, where)
        symbols.update(self.inheritance.instance_symbols(node, where))
        result = None
        if node.result is not None:
            try:
                kind, initial = self.resolve(node.result, where, "result")
                if has_block(kind):
                    raise where.error("a block cannot be a result", node.result.at)
                text = self.registry.written_names.get(node.name.key, node.name.text)
                result = Symbol(text, kind, "RESULT", node.result.at, initial)
            except InputError as error:
                self._report(error)
                self.broken.add(node.name.key)
        if node.kind == "FUNCTION" and node.members:
            text = "a FUNCTION has no methods, properties or actions"
            self._report(where.error(text, node.members[0].at, "use a FUNCTION_BLOCK"))
        if node.kind == "FUNCTION":
            self._note_function(symbols.values(), where)
        self.local, self.sections = {}, []
        file = str(where.file)
        pou = Pou(
            node.kind, node.name.text, file, symbols, result=result, words=node.words, at=node.at
        )
        if node.kind != "FUNCTION":
            pou.block = BlockType(
                node.name.text,
                tuple(
                    Variable(
                        symbol.name, symbol.type, symbol.section, symbol.address, symbol.retain
                    )
                    for symbol in symbols.values()
                    if symbol.section != "VAR_TEMP" and "." not in symbol.name
                ),
            )
            try:
                self.extents.check(pou.block, node.name.text, where, node.at)
            except InputError as error:
                self._report(error)
                pou.block = BlockType(node.name.text)
                self.extents.refuse(pou.block)
            self.blocks[node.name.key] = pou.block
            self.inheritance.add(node, where)
        self.pous[node.name.key] = pou

    def _note_function(self, symbols: Iterable[Symbol], where: Declared) -> None:
        sections = {symbol.section for symbol in symbols}
        if "VAR_INPUT" not in sections:
            where.note("a function without VAR_INPUT", where.node.name.at)
        if sections & {"VAR_OUTPUT", "VAR_IN_OUT"}:
            where.note("a function with VAR_OUTPUT or VAR_IN_OUT", where.node.name.at)
        if any(has_block(symbol.type) for symbol in symbols):
            where.note("a block in a function", where.node.name.at)

    def add_globals(self) -> None:
        """Declare the globals of the CONFIGURATION and of lists.

        Then resolve each VAR_EXTERNAL to its global.
        """
        configuration = self.registry.configuration
        if configuration is not None and isinstance(configuration.node, s.Configuration):
            for section in configuration.node.globals:
                self.add_section(section, "CONFIGURATION", self.globals, configuration)
        for declared in self.registry.lists:
            node = declared.node
            assert isinstance(node, s.GlobalList)
            found: dict[str, Symbol] = {}
            known = self.lists.setdefault(node.name.key, {})
            self.local = found
            self.add_section(node.section, "CONFIGURATION", found, declared)
            self.local, self.sections = {}, []
            for key, symbol in found.items():
                if key in known:
                    self._report(declared.error(f"{symbol.name} is declared twice", symbol.at))
                    continue
                known[key] = key if key not in self.globals else f"{node.name.key}{_JOINT}{key}"
                if node.qualified:
                    self.qualified.add(known[key])
                if known[key] != key:
                    symbol = replace(symbol, name=f"{node.name.text}{_JOINT}{symbol.name}")
                self.globals[known[key]] = symbol
        for variable, kind, where in self._external:
            try:
                self._check_external(variable, kind, where)
            except InputError as error:
                self._report(error)

    def starts_of_globals(self) -> Iterator[tuple[Scope, tuple[s.Section, ...]]]:
        """Yield a generated start function for each list of globals, with the list's sections."""
        found: list[tuple[Declared, tuple[s.Section, ...], dict[str, str]]] = []
        configuration = self.registry.configuration
        if configuration is not None and isinstance(configuration.node, s.Configuration):
            found.append((configuration, configuration.node.globals, {}))
        for declared in self.registry.lists:
            assert isinstance(declared.node, s.GlobalList)
            names = self.lists.get(declared.node.name.key, {})
            found.append((declared, (declared.node.section,), names))
        for number, (declared, sections, names) in enumerate(found, start=1):
            symbols: dict[str, Symbol] = {}
            for _, _, name in walk.declared(sections):
                symbol = self.global_symbol(names.get(name.key, name.key), name.text)
                if symbol is not None:
                    symbols[name.key] = symbol
            file, at = str(declared.file), declared.node.at
            title = f"{declared.node.name.text}.{START.lower()}{number}"
            pou = Pou("FUNCTION", title, file, symbols, words=(START,), at=at)
            yield Scope(pou, declared, self.registry, self), sections

    def global_symbol(self, key: str, local: str = "") -> Symbol | None:
        """Return the symbol of a global for a POU, as if the POU declared it in VAR_EXTERNAL."""
        found = self.globals.get(key)
        if found is None:
            return None
        return Symbol(
            local or found.name,
            found.type,
            "VAR_EXTERNAL",
            found.at,
            found.initial,
            found.constant,
            source=key,
        )

    def add_section(
        self, section: s.Section, kind: str, symbols: dict[str, Symbol], where: Declared
    ) -> None:
        """Add the variables of a section to `symbols`, and report errors in them."""
        if section.kind not in _SECTIONS[kind]:
            if section.kind not in _ALSO[kind]:
                message = f"{section.kind} is not supported in a {kind}"
                self._report(where.error(message, section.at))
                return
            where.note("a section in another place", section.at)
        for declaration in section.variables:
            try:
                for symbol in self._variables(declaration, section, kind, where):
                    key = symbol.name.upper()
                    if self.registry.variable_clash(key):
                        where.note("a variable called as something else", symbol.at)
                    if key in symbols:
                        raise where.error(f"{symbol.name} is declared twice", symbol.at)
                    symbols[key] = symbol
            except InputError as error:
                self._report(error)
                self.broken.update(name.key for name in declaration.names)

    def _variables(
        self, node: s.VarDecl, section: s.Section, pou: str, where: Declared
    ) -> list[Symbol]:
        owner = node.names[0].text
        open_array = self._open_array(node.spec, section, pou, where)
        if open_array is not None:
            return [
                Symbol(name.text, open_array, "VAR_IN_OUT", name.at, [], _is_input(section))
                for name in node.names
            ]
        kind: Type
        initial: Any
        own = ("VAR", "VAR_INPUT", "VAR_OUTPUT", "VAR_STAT")
        in_block = pou == "FUNCTION_BLOCK" and section.kind in own
        generic = None
        if section.kind == "VAR_INPUT" and pou in ("FUNCTION", "METHOD", "FUNCTION_BLOCK"):
            generic = self.any_type(node.spec, where)
        if in_block and self.is_bit(node.spec, where):
            kind, initial = BOOL, False
        elif generic is not None:
            kind, initial = generic
        else:
            kind, initial = self.resolve(node.spec, where, owner)
        constant_section, calculated = section.qualifier == "CONSTANT", False
        parts: tuple[Part, ...] = ()
        passed = False
        if constant_section and section.kind == "VAR_IN_OUT":
            # A VAR_IN_OUT CONSTANT cannot be written, so it is passed by value. Blocks are never
            # copied.
            where.note("VAR_IN_OUT CONSTANT", section.at)
            passed = True
            constant_section = False
            section = section if has_block(kind) else replace(section, kind="VAR_INPUT")
        if has_block(kind) and pou == "CONFIGURATION":
            constant_section = False  # CODESYS accepts CONSTANT; the block can be called
        if has_block(kind):
            self._check_block(node, section, pou, constant_section, where)
        held = isinstance(kind, (ReferenceType, InterfaceType))
        if node.initial is not None and not held:
            if section.kind in ("VAR_IN_OUT", "VAR_EXTERNAL"):
                raise where.error("an initial value is not possible here", node.at)
            block = pou in ("PROGRAM", "FUNCTION_BLOCK")
            places = ("VAR",) if block else ("VAR", "VAR_TEMP", "VAR_INST")
            possible = section.kind in places and not constant_section and pou != "CONFIGURATION"
            later = Later() if possible else None
            try:
                initial = self.initial_value(node.initial, kind, where, initial, later)
            except NotConstantError:
                calculated = isinstance(kind, (ArrayType, ElementaryType, EnumType, StructType))
                if not calculated or later is None:
                    raise
            parts = tuple(later.found) if later is not None else ()
            if calculated or parts:
                where.note("a calculated initial value", node.at)
        if node.bound and not (isinstance(kind, ReferenceType) and kind.kind == "REFERENCE"):
            text = f"REF= needs a variable of REFERENCE TO, not a {describe(kind)}"
            raise where.error(text, node.at)
        started = isinstance(node.spec, s.NamedSpec) and bool(node.spec.arguments)
        if started:
            where.note(f"arguments of {INIT}", node.spec.at)
        in_instance = section.kind in ("VAR", "VAR_INPUT", "VAR_OUTPUT")
        allowed = (
            (in_instance and pou in ("PROGRAM", "FUNCTION_BLOCK"))
            or (section.kind == "VAR" and pou == "METHOD")
            or (section.kind == "VAR_GLOBAL" and pou == "CONFIGURATION")
            or section.kind == "VAR_INST"
        )
        if started and not allowed:
            raise where.error(
                f"{INIT} takes no arguments in {section.kind} of a {pou}",
                node.spec.at,
                "declare the block in VAR, as a variable of its own",
            )
        if section.kind == "VAR_EXTERNAL":
            self._external.append((node, kind, where))
        address, area = None, ""
        if node.address is not None:
            address = self._address(node, kind, section, pou, where)
            area = "" if address else node.address.text[1:2].upper()
        found = [
            Symbol(
                name.text,
                kind,
                section.kind,
                name.at,
                initial,
                constant_section,
                address,
                started=started,
                calculated=calculated,
                parts=parts,
                retain=section.qualifier == "RETAIN",
                area=area,
                access=self._access(section, where),
                owner=where.node.name.key,
                passed=passed,
            )
            for name in node.names
        ]
        if section.kind == "VAR_STAT":
            return [self._static(symbol, where) for symbol in found]
        return found

    def _open_array(
        self, spec: s.TypeSpec, section: s.Section, pou: str, where: Declared
    ) -> Type | None:
        """Return the type of an ARRAY [*] parameter; None for other variables.

        A VAR_IN_OUT can have such a type, and a VAR_INPUT of a function or method. The VAR_INPUT is
        neither copied nor written.
        """
        places: tuple[str, ...] = ("VAR_IN_OUT",)
        if pou in ("FUNCTION", "METHOD"):
            places = ("VAR_IN_OUT", "VAR_INPUT")
        if pou == "FUNCTION" and self.registry.dialect.name == "ax":
            places = (*places, "VAR_OUTPUT")  # SIMATIC AX writes into the array of the caller
        if not isinstance(spec, s.ArraySpec) or section.kind not in places:
            return None
        stars = [isinstance(one.low, s.Name) and one.low.text == "*" for one in spec.dimensions]
        if not any(stars):
            return None
        if not all(stars):
            raise where.error("either all dimensions are of open length, or none", spec.at)
        where.note("an array of open length", spec.at)
        element, _ = self.resolve(spec.element, where)
        return ArrayType("", tuple((0, 0) for _ in stars), element, open=True)

    @staticmethod
    def _access(section: s.Section, where: Declared) -> str:
        """Return the access to the variables of a section: PRIVATE, PROTECTED, or empty for PUBLIC.

        A VAR of a CLASS is PROTECTED unless it says otherwise (IEC 61131-3, edition 3, 6.6.5).
        """
        node = where.node
        is_class = isinstance(node, s.Pou) and CLASS in node.words and section.kind == "VAR"
        word = section.access or ("PROTECTED" if is_class else "")
        return word if word in ("PRIVATE", "PROTECTED") else ""

    def _check_block(
        self, node: s.VarDecl, section: s.Section, pou: str, constant: bool, where: Declared
    ) -> None:
        if constant and section.kind != "VAR_IN_OUT":
            raise where.error(
                f"a block cannot stand in {section.kind} CONSTANT of a {pou}",
                node.at,
                "declare it without CONSTANT",
            )
        if section.kind not in ("VAR", "VAR_EXTERNAL"):
            where.note("a block in another section than VAR", node.at)

    def _static(self, symbol: Symbol, where: Declared) -> Symbol:
        """Return the symbol of a variable shared by all instances of its POU.

        Such a variable is stored as a global variable, and the POU's name stands before the
        variable's name.
        """
        key = f"{where.node.name.key}{_JOINT}{symbol.name.upper()}"
        name = f"{where.node.name.text}{_JOINT}{symbol.name}"
        self.globals[key] = replace(symbol, name=name, section="VAR_GLOBAL")
        found = self.global_symbol(key, symbol.name)
        assert found is not None
        return found

    def _check_external(self, node: s.VarDecl, kind: Type, where: Declared) -> None:
        for name in node.names:
            found = self.globals.get(name.key)
            if found is None:
                if name.key in self.broken:
                    continue
                raise where.error(f"there is no global variable {name.text}", name.at)
            if found.type != kind:
                raise where.error(f"the global {name.text} is a {describe(found.type)}", name.at)

    def configured_address(self, entry: s.ConfigEntry, kind: Type, where: Declared) -> str:
        """Return the address of an entry of VAR_CONFIG, or raise InputError."""
        assert entry.address is not None
        name = s.Name("", entry.at)
        node = s.VarDecl((name,), entry.spec, None, entry.address, entry.at)
        section = s.Section("VAR", "", (node,), entry.at)
        found = self._address(node, kind, section, "PROGRAM", where)
        if found is None:
            hint = "write it as %IX0.0, %QW3 or %MD10"
            raise where.error("VAR_CONFIG needs a complete address", entry.address.at, hint)
        return found

    def _address(
        self, node: s.VarDecl, kind: Type, section: s.Section, pou: str, where: Declared
    ) -> str | None:
        assert node.address is not None
        text = node.address.text.upper()
        if text.endswith("*"):
            where.note("an incomplete address", node.address.at)
            return None
        parts = _ADDRESS.fullmatch(text)
        if parts is None:
            raise where.error(
                f"{text} is not an address", node.address.at, "write it as %IX0.0, %QW3 or %MD10"
            )
        if section.kind not in ("VAR", "VAR_GLOBAL") or pou in ("FUNCTION", "FUNCTION_BLOCK"):
            raise where.error(
                f"a located variable cannot stand in {section.kind} of a {pou}",
                node.address.at,
                "declare it in VAR of the PROGRAM or VAR_GLOBAL",
            )
        if len(node.names) > 1:
            raise where.error("one address cannot belong to several variables", node.at)
        if _is_record(kind) and parts[2] != "X" and "." not in parts[3]:
            where.note("a located structure", node.address.at)
            return text
        one = kind.element if isinstance(kind, ArrayType) else kind
        bits = _bits(one) if isinstance(one, ElementaryType) else 0
        lies_there = one == kind or (bits > 1 and "." not in parts[3])
        if bits != _ADDRESS_BITS[parts[2]] or not lies_there:
            raise where.error(
                f"a {describe(kind)} does not fit the address {text}",
                node.address.at,
                "use X for BOOL, B for 8 bits, W 16, D 32, L 64; arrays of BOOL are not possible",
            )
        if one != kind:
            where.note("a located array", node.address.at)
        if self._addresses.setdefault(text, kind) != kind:
            raise where.error(
                f"{text} is also declared as {describe(self._addresses[text])}", node.address.at
            )
        return text


@dataclass(frozen=True)
class Scope:
    """Finds the meaning of a name inside one POU; the checker uses it."""

    pou: Pou
    where: Declared
    registry: Registry
    declarations: Declarations

    def error(self, message: str, at: s.Position, hint: str = "") -> InputError:
        """Return an error in this POU's file."""
        return self.where.error(message, at, hint)

    def note(self, construct: str, at: s.Position, detail: str = "") -> None:
        """Note a construct beyond the portable subset; `detail` describes the occurrence."""
        self.where.note(construct, at, detail)

    def symbol(self, key: str) -> Symbol | None:
        """Return the variable that an upper-case name denotes in this POU, or None.

        The variables of the POU come first, then a function's result, the variables of a method's
        block, globals, and programs.
        """
        found = self.pou.symbols.get(key)
        if found is not None:
            return found
        result = self.pou.result
        if result is not None and result.name.upper() == key:
            return result
        if self.pou.owner is not None:
            found = self.pou.owner.symbols.get(key)
            if found is not None and found.section != "VAR_TEMP":
                if found.section == "VAR_IN_OUT":
                    found.shared = found.addressed = True
                return found
        declarations = self.declarations
        plain = key in declarations.globals and key not in declarations.qualified
        if plain and key not in declarations.programs:
            return self._global(key, self.where.node.at)
        return self._program(key)

    def _program(self, key: str) -> Symbol | None:
        """Return the single instance of a PROGRAM that is called by the program's name."""
        found = self.declarations.pous.get(key)
        if found is None or found.kind != "PROGRAM" or found.block is None:
            return None
        if found is (self.pou.owner or self.pou):
            return None
        self.declarations.use_program(key)
        return self._global(key, self.where.node.at, "a PROGRAM called by its name")

    @property
    def block(self) -> Pou | None:
        """Return the block that a body or method belongs to; None in a function."""
        pou = self.pou.owner or self.pou
        return pou if pou.block is not None else None

    def listed(self, name: str, key: str, at: s.Position) -> Symbol | None:
        """Return a variable of a list of globals, by upper-case names."""
        found = self.declarations.lists.get(name, {}).get(key)
        return None if found is None else self._global(found, at)

    def _global(
        self, key: str, at: s.Position, construct: str = "a global without VAR_EXTERNAL"
    ) -> Symbol:
        self.note(construct, at)
        known = self.pou.symbols.get(f" {key}")
        if known is None:
            known = self.declarations.global_symbol(key)
            assert known is not None
            # The blank avoids a clash, because names in sources contain no blank.
            self.pou.symbols[f" {key}"] = known
        return known


def _is_input(section: s.Section) -> bool:
    """Return whether the called POU only reads a parameter."""
    return section.kind == "VAR_INPUT" or section.qualifier == "CONSTANT"


def _is_record(kind: Type) -> bool:
    """Return whether a type is a structure, or an array of structures, with a known layout."""
    inner = kind.element if isinstance(kind, ArrayType) else kind
    return isinstance(inner, StructType) and size_of(inner) is not None


def _bits(kind: ElementaryType) -> int:
    return {"BOOL": 1, "REAL": 32, "LREAL": 64, **WIDTH}.get(kind.name, 0)
