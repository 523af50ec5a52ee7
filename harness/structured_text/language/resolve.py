"""Resolution of types: names become types, initial values complete, constants have values.

Declarations may stand in any order, and constants and types depend on each other: an array bound
may be a constant, and the value of the constant may need a type. Each is therefore resolved on its
first use. `under_way` has the names whose resolution has begun; if such a name occurs again, there
is a cycle. A pointer may lead to a type that contains it, so the targets of pointers are resolved
last (`link`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, MutableMapping
from copy import deepcopy
from ctypes import c_float
from dataclasses import replace
from typing import Any

from structured_text.errors import InputError, did_you_mean, similar
from structured_text.language import syntax as s
from structured_text.language.constants import NotConstantError, constant, evaluate, member
from structured_text.language.extent import Extents
from structured_text.language.later import Later
from structured_text.language.registry import ConsequenceError, Declared, Registry, last_name
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_CHARS,
    ANY_INT,
    ANY_REAL,
    ANY_STRING,
    BOOL,
    CORE,
    ELEMENTARY,
    INT_RANGE,
    LONGEST_STRING,
    STRING_MAX,
)
from structured_text.language.sizes import size_of
from structured_text.language.standard import BLOCKS, UNSUPPORTED, conversion, reserved
from structured_text.language.system import ANY_TYPE, GROUPS, QUERY, system_declaration
from structured_text.language.tree import Constant, Pou, Symbol
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
    has_address,
    has_block,
)
from structured_text.language.values import array_length, describe
from structured_text.language.written_types import type_of
from structured_text.output.limits import MOST_LEVELS

__all__ = ["Types", "default_scalar", "fills", "is_null"]


#: A pointer whose target is not resolved yet, with the names that are known at its declaration.
_Unlinked = tuple[
    ReferenceType,
    s.TypeSpec,
    Declared,
    MutableMapping[str, Symbol],
    list[tuple[s.Section, Declared]],
]
#: Sizes of integers [bits], with the first letter of their types: SINT, INT, DINT, LINT.
_SIZES = ((8, "S"), (16, ""), (32, "D"), (64, "L"))
#: Names of types in other languages, with the type of IEC 61131-3 that is meant.
_OTHER_NAMES = {
    "BOOLEAN": "BOOL",
    "INTEGER": "INT",
    "SHORT": "INT",
    "LONG": "DINT",
    "UNSIGNED": "UINT",
    "FLOAT": "REAL",
    "DOUBLE": "LREAL",
    "TEXT": "STRING",
    "DURATION": "TIME",
    "DATETIME": "DT",
    **{f"{sign}INT{bits}": f"{sign}{size}INT" for sign in ("", "U") for bits, size in _SIZES},
}


class Types:
    """The types of a project, each resolved on its first use.

    A declaration with a reported error is incomplete.

    Attributes:
        types: Structures, arrays, enumerations and aliases by upper-case name.
        initial: The initial value of each type in `types`.
        blocks: Function blocks and programs by upper-case name.
        pous: Functions, blocks and programs by upper-case name.
        globals: Global variables by upper-case name.
        lists: Lists of globals: for each variable's upper-case name its key in `globals`.
        local: Variables of the POU that is being declared.
        sections: The sections of the POU that is being declared.
        views: Whether memory is read as another type; see `Project`.
        extents: The sizes of types, for the limits.
        extended: The structure that a structure extends, by upper-case name.
    """

    def __init__(self, registry: Registry, report: Callable[[InputError], None]) -> None:
        self.registry = registry
        self._report = report
        self.types: dict[str, Type] = {}
        self.initial: dict[str, Any] = {}
        self.blocks: dict[str, BlockType] = {}
        self.pous: dict[str, Pou] = {}
        self.globals: dict[str, Symbol] = {}
        self.lists: dict[str, dict[str, str]] = {}
        self.local: MutableMapping[str, Symbol] = {}
        self.sections: list[tuple[s.Section, Declared]] = []
        self.views = False
        self.extents = Extents()
        self.extended: dict[str, str] = {}
        self.under_way: set[str] = set()
        self._listed: dict[str, tuple[s.VarDecl, Declared]] | None = None
        self._pended: dict[str, Constant | InputError | None] = {}
        self._unlinked: list[_Unlinked] = []

    def link(self) -> None:
        """Resolve the targets of pointers and references, once all types and blocks are known."""
        while self._unlinked:
            reference, spec, where, local, sections = self._unlinked.pop()
            before = self.local, self.sections
            # The target may be an array whose bounds are constants of the block.
            self.local, self.sections = local, sections
            try:
                reference.target, _ = self.resolve(spec, where)
            except InputError as error:
                self._report(error)
            finally:
                self.local, self.sections = before

    # --- types ---

    def add_type(self, node: s.TypeDecl, where: Declared) -> None:
        """Resolve a type of a TYPE … END_TYPE, unless it has been resolved."""
        key = node.name.key
        if key in self.types or key in self.under_way:
            return
        self.under_way.add(key)
        try:
            kind, initial = self._named_type(node, where)
            self.types[key] = kind
            if node.initial is not None:
                initial = self.initial_value(node.initial, kind, where, initial)
            self.initial[key] = initial
        except InputError as error:
            self.types.pop(key, None)
            self._report(error)

    def type_named(self, key: str) -> Type | None:
        """Return the type of the sources with this upper-case name; None if there is none."""
        declared = self.registry.types.get(key)
        if declared is None and key not in self.registry.pous:
            declared = system_declaration(key) if key != QUERY else None
        if key not in self.types and declared is not None:
            assert isinstance(declared.node, s.TypeDecl)
            self.add_type(declared.node, declared)
        return self.types.get(key)

    def _named_type(self, node: s.TypeDecl, where: Declared) -> tuple[Type, Any]:
        spec, name = node.spec, node.name.text
        if isinstance(spec, s.EnumSpec):
            return self._enumeration(name, spec, where)
        if isinstance(spec, s.StructSpec):
            return self._structure(name, spec, where, node.extends)
        if node.extends is not None:
            raise where.error("only a structure or block can extend another", node.extends.at)
        if isinstance(spec, s.ArraySpec):
            return self._array(name, spec, where)
        kind, initial = self.resolve(spec, where)
        if isinstance(kind, BlockType):
            raise where.error(f"{describe(kind)} is a block, not a data type", spec.at)
        return kind, initial

    def _enumeration(self, name: str, spec: s.EnumSpec, where: Declared) -> tuple[Type, Any]:
        seen: set[str] = set()
        for one in spec.members:
            if one.key in seen:
                raise where.error(f"the member {one.text} is declared twice", one.at)
            if reserved(one.key) or one.key in (*self.registry.types, *self.registry.pous):
                where.note("a variable called as something else", one.at)
            seen.add(one.key)
        names = tuple(one.text for one in spec.members)
        if not spec.explicit and spec.base is None:
            return EnumType(name, names, attributes=spec.attributes), 0
        base = ELEMENTARY["INT"]
        if spec.base is not None:
            found, _ = self.resolve(spec.base, where)
            if not isinstance(found, ElementaryType) or found.name not in INT_RANGE:
                raise where.error(
                    f"a {describe(found)} cannot be the base of an enumeration", spec.base.at
                )
            base = found
        values: list[int] = []
        for value in spec.values:
            if value is None:
                values.append(values[-1] + 1 if values else 0)
                continue
            # The value of a member may use the members before it.
            earlier = EnumType(name, names[: len(values)], tuple(values), base.name)
            lookup = self._looking(where, earlier)
            found_value = constant(value, base, self.types, where, lookup).value
            values.append(int(found_value))
        low, high = INT_RANGE[base.name]
        if not all(low <= value <= high for value in values):
            raise where.error(f"a member is outside {base.name} ({low} to {high})", spec.at)
        return EnumType(name, names, tuple(values), base.name, spec.attributes), values[0]

    def _structure(
        self, name: str, spec: s.StructSpec, where: Declared, base: s.Name | None = None
    ) -> tuple[Type, Any]:
        fields: list[tuple[str, Type]] = []
        seen: set[str] = set()
        bits: set[str] = set()
        values: dict[str, Any] = {}
        if base is not None:
            self.registry.check_reachable(base, where)
            known = self.type_named(last_name(base))
            if known is None and last_name(base) in self.registry.types:
                raise ConsequenceError(f"the declaration of {base.text} has an error")
            if not isinstance(known, StructType):
                raise where.error(f"{base.text} is not a structure of these sources", base.at)
            self.extended[name.upper()] = last_name(base)
            fields += known.fields
            bits |= known.bits
            seen.update(field.upper() for field, _ in fields)
            values.update(self.initial[last_name(base)])
        for declaration in spec.fields:
            owner = f"{name}_{declaration.names[0].text}"
            bit = self.is_bit(declaration.spec, where)
            kind, initial = (BOOL, False) if bit else self.resolve(declaration.spec, where, owner)
            bits |= {field.key for field in declaration.names if bit}
            if has_block(kind):
                where.note("a block in a structure", declaration.at)
            if declaration.initial is not None:
                initial = self.initial_value(declaration.initial, kind, where, initial)
            for field in declaration.names:
                if field.key in seen:
                    raise where.error(f"the field {field.text} is declared twice", field.at)
                seen.add(field.key)
                fields.append((field.text, kind))
                if spec.union:
                    self._check_overlaid(kind, declaration, where)
                if not spec.union or declaration.initial is not None:
                    values[field.text] = initial
        if spec.union and len(values) > 1:
            raise where.error("more than one field of a UNION has an initial value", spec.at)
        self.views = self.views or spec.union
        kind = StructType(name, tuple(fields), spec.union, frozenset(bits))
        self.extents.check(kind, name, where, spec.at)
        return kind, values

    def any_type(self, spec: s.TypeSpec, where: Declared) -> tuple[Type, Any] | None:
        """Return type and initial value of an ANY or ANY_INT input; None for other types."""
        key = spec.name.key if isinstance(spec, s.NamedSpec) else ""
        if key not in GROUPS or key in self.registry.types:
            return None
        where.note("ANY", spec.at, key)
        kind = self.type_named(ANY_TYPE)
        assert isinstance(kind, StructType)
        named = kind if key == "ANY" else replace(kind, name=key)
        self.types[key], self.initial[key] = named, self.initial[ANY_TYPE]
        self.views = True
        return named, self.initial[ANY_TYPE]

    def is_bit(self, spec: s.TypeSpec, where: Declared) -> bool:
        """Return whether a field or a block's variable has the type BIT, and note the construct."""
        found = isinstance(spec, s.NamedSpec) and spec.name.key == "BIT"
        if not found or "BIT" in self.registry.types:
            return False
        where.note("the type BIT", spec.at)
        return True

    @staticmethod
    def _check_overlaid(kind: Type, node: s.VarDecl, where: Declared) -> None:
        if has_address(kind):
            text = f"a field of a UNION cannot be a {describe(kind)}"
            raise where.error(text, node.at, "use a STRUCT for it")

    def derives(self, have: Type, want: Type) -> bool:
        """Return whether a structure extends another one, directly or indirectly."""
        if not isinstance(have, StructType) or not isinstance(want, StructType):
            return False
        key = have.name.upper()
        while key in self.extended:
            key = self.extended[key]
            if key == want.name.upper():
                return True
        return False

    def _array(self, name: str, spec: s.ArraySpec, where: Declared) -> tuple[Type, Any]:
        bounds = []
        for dimension in spec.dimensions:
            if isinstance(dimension.low, s.Name) and dimension.low.text == "*":
                hint = "write the bounds"
                raise where.error(
                    "an array of open length can only be a VAR_IN_OUT,"
                    " or a VAR_INPUT of a function or method",
                    dimension.at,
                    hint,
                )
            low, high = self.integer(dimension.low, where), self.integer(dimension.high, where)
            # TwinCAT and CODESYS accept an array without elements: ARRAY [0..-1].
            none = self.registry.dialect.name in ("codesys", "twincat")
            if low > high + none:
                raise where.error(f"the bounds {low}..{high} are empty", dimension.at)
            bounds.append((low, high))
        element, initial = self.resolve(spec.element, where, f"{name}_element")
        if isinstance(element, BlockType):
            where.note("an array of blocks", spec.at)
        kind = ArrayType(name, tuple(bounds), element)
        self.extents.check(kind, name or "this array", where, spec.at)
        self.extents.make(array_length(kind), where, spec.at)
        return kind, [initial] * array_length(kind)

    def resolve(self, spec: s.TypeSpec, where: Declared, owner: str = "") -> tuple[Type, Any]:
        """Return the type of a specification, and its initial value, or raise InputError.

        A type without a name is named after `owner`, the variable.
        """
        if isinstance(spec, s.ArraySpec):
            return self._array("", spec, where)
        if isinstance(spec, s.SubrangeSpec):
            return self._subrange(spec, where)
        if isinstance(spec, s.PointerSpec):
            reference = ReferenceType(spec.kind)
            self._unlinked.append((reference, spec.target, where, self.local, self.sections))
            return reference, None
        if not isinstance(spec, s.NamedSpec):
            return self._nameless(spec, where, owner)
        if spec.empty:
            kind, initial = self.resolve(replace(spec, empty=False), where, owner)
            if not isinstance(kind, BlockType):
                text = f"a {describe(kind)} takes no arguments in ( )"
                raise where.error(text, spec.at, "remove the ( )")
            return kind, initial
        if spec.generics:
            text = f"{spec.name.text} has no VAR_GENERIC"
            raise where.error(text, spec.at, "remove the < > and its values")
        self.registry.check_reachable(spec.name, where)
        key = last_name(spec.name)
        name = spec.name.text[-len(key) :]
        if key in self.registry.interfaces:
            return InterfaceType(self.registry.interfaces[key].node.name.text), None
        if key == QUERY and key not in self.registry.types and key not in self.registry.pous:
            return InterfaceType("IQueryInterface"), None
        if spec.length is not None:
            return self._sized(spec, where)
        found = self.type_named(key)
        if found is not None and key in self.initial:
            return found, self.initial[key]
        if key in ELEMENTARY and key not in self.registry.types:
            kind = ELEMENTARY[key]
            if key not in CORE:
                where.note("a type of the third edition", spec.at, kind.name)
            if key in ANY_STRING and self.registry.dialect.text != STRING_MAX:
                kind = ElementaryType(key, self.registry.dialect.text)
            return kind, default_scalar(kind)
        if key in BLOCKS and key not in self.registry.pous:
            self.blocks.setdefault(key, BLOCKS[key])
            if not reserved(key):
                where.note("a standard block of the third edition", spec.at, key)
            return BLOCKS[key], None
        declared = self.registry.pous.get(key)
        if declared is not None and isinstance(declared.node, s.Pou):
            if declared.node.kind != "FUNCTION_BLOCK":
                raise where.error(f"{name} is a {declared.node.kind}, not a type", spec.at)
            if key in self.blocks:
                return self.blocks[key], None
        if key in self.registry.types or declared is not None:
            raise ConsequenceError(f"the declaration of {name} has an error")
        if key in GROUPS:
            text = f"{key} is for inputs of functions, methods and function blocks only"
            raise where.error(text, spec.at, "write the type")
        if key == "BIT":
            text = "BIT is for fields of a structure and variables of a function block only"
            raise where.error(text, spec.at, "use BOOL")
        if key in UNSUPPORTED:
            raise where.error(f"the block {name} is not supported", spec.at)
        own = [*self.registry.types.values(), *self.registry.pous.values()]
        names = [*(one.node.name.text for one in own), *ELEMENTARY, *BLOCKS]
        meant = [_OTHER_NAMES[key]] if key in _OTHER_NAMES else similar(name, names)
        hint = did_you_mean(meant) or "name its file, too, or check the spelling"
        raise where.error(f"there is no type {name}", spec.at, hint)

    def _nameless(
        self, spec: s.EnumSpec | s.StructSpec, where: Declared, owner: str
    ) -> tuple[Type, Any]:
        """Return an enumeration or structure without a name, named after its variable."""
        name = f"{where.node.name.text}_{owner}"
        if isinstance(spec, s.StructSpec):
            where.note("a structure without a name", spec.at)
            kind, initial = self._structure(name, spec, where)
        else:
            where.note("an enumeration without a name", spec.at)
            kind, initial = self._enumeration(name, spec, where)
            for one in spec.members:
                self.registry.members.setdefault(one.key, []).append(name.upper())
        self.types[name.upper()], self.initial[name.upper()] = kind, initial
        return kind, initial

    def _sized(self, spec: s.NamedSpec, where: Declared) -> tuple[Type, Any]:
        assert spec.length is not None
        if spec.name.key not in ANY_STRING:
            raise where.error(f"a {spec.name.text} has no length", spec.at, "remove it")
        length = self.integer(spec.length, where)
        # TwinCAT and CODESYS accept a text without characters: STRING(0).
        least = 0 if self.registry.dialect.name in ("codesys", "twincat") else 1
        if not least <= length <= LONGEST_STRING:
            raise where.error(f"a STRING holds 1 to {LONGEST_STRING} characters", spec.at)
        if spec.name.key == "WSTRING":
            where.note("a type of the third edition", spec.at, "WSTRING")
        return ElementaryType(spec.name.key, length), ""

    def _subrange(self, spec: s.SubrangeSpec, where: Declared) -> tuple[Type, Any]:
        kind, _ = self.resolve(spec.base, where)
        if not isinstance(kind, ElementaryType) or kind.name not in (
            *ANY_INT,
            *ANY_REAL,
            *ANY_BIT[1:],
        ):
            raise where.error(f"a {describe(kind)} has no subrange", spec.at)
        low = constant(spec.low, kind, self.types, where, self.lookup).value
        high = constant(spec.high, kind, self.types, where, self.lookup).value
        if low > high:  # type: ignore[operator]
            raise where.error(f"the range {low}..{high} is empty", spec.at)
        return kind, low if not low <= 0 <= high else default_scalar(kind)  # type: ignore[operator]

    # --- constants ---

    def _without_space(self, node: s.Expression) -> s.Expression:
        """Return a path without the namespace at its beginning."""
        if not isinstance(node, s.Field):
            return node
        if isinstance(node.base, s.Name):
            key = node.base.key
            known = key in self.lists or self.type_named(key) is not None
            return node.name if key in self.registry.namespaces and not known else node
        base = self._without_space(node.base)
        if base is node.base or not isinstance(base, s.Name):
            return node
        return s.Field(base, node.name, node.at)

    def lookup(self, node: s.Expression) -> Constant | None:
        """Return the constant of a name, path or call; None if it is not a constant."""
        node = self._without_space(node)
        if isinstance(node, s.Field) and isinstance(node.base, s.Name):
            kind = self.type_named(node.base.key)
            if isinstance(kind, EnumType):
                found = node.name.key in (one.upper() for one in kind.members)
                return Constant(kind.value_of(node.name.key), kind, True) if found else None
            key = self.lists.get(node.base.key, {}).get(node.name.key)
            if key:
                return self._global_constant(key)
            return self._of_block(node) or self._pending(node.name.key)
        if isinstance(node, s.Field) and isinstance(node.base, s.Field):
            return self.lookup(replace(node, base=node.base.name))  # drop the leading namespace
        if isinstance(node, s.Call):
            return self._called(node)
        if not isinstance(node, s.Name):
            return None
        symbol = self.local.get(node.key)
        if symbol is not None:
            return _constant_of(symbol)
        later = self._declared_constant(node.key)
        if later is not None:
            return later
        for owner in self.registry.members.get(node.key, ()):
            kind = self.type_named(owner)
            if isinstance(kind, EnumType):
                return Constant(kind.value_of(node.key), kind, True)
        if node.key in self.globals:
            return self._global_constant(node.key)
        return self._pending(node.key)

    def _of_block(self, node: s.Field) -> Constant | None:
        """Return the constant of a block's instance or of a POU, such as `Drive.MOST`."""
        assert isinstance(node.base, s.Name)
        symbol = self.local.get(node.base.key)
        block = symbol.type if symbol is not None else self.blocks.get(node.base.key)
        pou = self.pous.get(block.name.upper()) if isinstance(block, BlockType) else None
        found = pou.symbols.get(node.name.key) if pou is not None else None
        return None if found is None else _constant_of(found)

    def _called(self, node: s.Call) -> Constant | None:
        """Return the value of a call that is constant.

        Such a call is SIZEOF of a type or variable, a bound of an array, or the conversion of a
        constant to an integer type.
        """
        key = node.function.key
        if key in ("LOWER_BOUND", "UPPER_BOUND") and len(node.arguments) == 2:
            kind, which = type_of(self, node.arguments[0].value), node.arguments[1].value
            number = which.text if isinstance(which, s.Literal) else ""
            if not isinstance(kind, ArrayType) or kind.open or not number.isdecimal():
                return None
            if not 1 <= int(number) <= len(kind.bounds):
                return None
            ends = kind.bounds[int(number) - 1]
            return Constant(ends[key == "UPPER_BOUND"], ELEMENTARY["LINT"])
        if len(node.arguments) != 1:
            return None
        argument = node.arguments[0].value
        if key in ("SIZEOF", "XSIZEOF"):
            kind = type_of(self, argument)
            name = argument.key if isinstance(argument, s.Name) else ""
            if kind is None and name in self.registry.types:
                raise ConsequenceError(f"the declaration of {name} has an error")
            size = None if kind is None else size_of(kind)
            return None if size is None else Constant(size, ELEMENTARY["LINT"])
        pair = conversion(node.function.key)
        found = self.lookup(argument)
        if pair is None or pair[1] not in INT_RANGE or found is None:
            return None
        low, high = INT_RANGE[pair[1]]
        fits = isinstance(found.value, int) and low <= found.value <= high
        return Constant(found.value, ELEMENTARY[pair[1]], True) if fits else None

    def _looking(self, where: Declared, earlier: EnumType) -> Callable[..., Constant | None]:
        """Return a lookup that also finds members of the enumeration being resolved."""

        def lookup(node: s.Expression) -> Constant | None:
            names = [one.upper() for one in earlier.members]
            if isinstance(node, s.Name) and node.key in names:
                value = member(earlier, node, where).value
                return Constant(value, ELEMENTARY[earlier.base], True)
            return self.lookup(node)

        return lookup

    def _global_constant(self, key: str) -> Constant | None:
        symbol = self.globals.get(key)
        return None if symbol is None else _constant_of(symbol)

    def _pending(self, key: str) -> Constant | None:
        """Return a global constant that a type needs before the globals are declared."""
        found = self._constants_of_lists().get(key)
        if found is None:
            return None
        if key not in self._pended:
            try:
                self._pended[key] = self._value_of(key, *found)
            except InputError as error:
                self._pended[key] = error
        known = self._pended[key]
        if isinstance(known, InputError):
            raise known
        return known

    def _constants_of_lists(self) -> dict[str, tuple[s.VarDecl, Declared]]:
        """Return the constants of all lists of global variables, by upper-case name."""
        if self._listed is None:
            self._listed = {}
            for declared in self.registry.lists:
                assert isinstance(declared.node, s.GlobalList)
                for name, variable in _constants(declared.node.section):
                    self._listed.setdefault(name, (variable, declared))
        return self._listed

    def _declared_constant(self, key: str) -> Constant | None:
        """Return the value of a constant in sections whose variables are not declared yet."""
        for section, declared in self.sections:
            for name, variable in _constants(section):
                if name == key:
                    return self._value_of(key, variable, declared)
        return None

    def _value_of(self, key: str, variable: s.VarDecl, declared: Declared) -> Constant | None:
        """Return the value of a constant before its declaration is resolved."""
        if key in self.under_way:
            raise declared.error(f"the constant {key} uses itself", variable.at)
        if len(self.under_way) > MOST_LEVELS:
            text = f"more than {MOST_LEVELS} constants and types that use each other in a row"
            raise declared.error(text, variable.at)
        assert variable.initial is not None
        self.under_way.add(key)
        try:
            kind, _ = self.resolve(variable.spec, declared)
            if not isinstance(kind, (ElementaryType, EnumType)):
                return None
            found = constant(variable.initial, kind, self.types, declared, self.lookup)
            return Constant(found.value, kind, True)
        finally:
            self.under_way.discard(key)

    def constant(self, node: s.Init, kind: Type, where: Declared, detail: str = "") -> Constant:
        """Return the value of a constant expression in the required type, or raise InputError."""
        return constant(node, kind, self.types, where, self.lookup, detail)

    def integer(self, node: s.Expression, where: Declared) -> int:
        """Return the value of a whole number, for bounds and lengths, or raise InputError."""
        if isinstance(node, s.Literal) or (
            isinstance(node, s.Unary) and isinstance(node.operand, s.Literal)
        ):
            return int(self.constant(node, ELEMENTARY["DINT"], where).value)
        value = evaluate(node, self.types, where, self.lookup).value
        if isinstance(value, bool) or not isinstance(value, int):
            raise where.error("a whole number is expected here", node.at)
        return value

    # --- initial values ---

    def initial_value(
        self, node: s.Init, kind: Type, where: Declared, default: Any, later: Later | None = None
    ) -> Any:
        """Return a complete initial value.

        The value is a scalar for a scalar, a flat list for an array, and a dict by declared field
        name for a structure. For a block, it is a dict of the given variables, or None.

        Args:
            node: The initial value as written.
            kind: Type of the variable.
            where: The declaration of the variable, for messages.
            default: The value of parts that are not given.
            later: Receives the parts that are not constant. If `later` is None, such parts are
                errors.

        Raises:
            InputError: The value is not constant, or does not have the type.
        """
        if isinstance(kind, (ElementaryType, EnumType)):
            if isinstance(node, (s.ArrayInit, s.StructInit, s.Sequence)):
                raise where.error(f"a {describe(kind)} needs a single value", node.at)
            try:
                value = constant(node, kind, self.types, where, self.lookup).value
            except NotConstantError:
                if later is None or not later.takes(node, kind):
                    raise
                return default
            return c_float(float(value)).value if kind.name == "REAL" else value
        if isinstance(kind, (ReferenceType, InterfaceType)):
            if is_null(node) or (later is not None and later.takes(node, kind)):
                return None
            text = f"a {describe(kind)} inside another variable has no initial value but 0"
            raise where.error(text, node.at, "assign it in the code")
        if isinstance(kind, ArrayType) and isinstance(node, s.ArrayInit):
            self.extents.make(len(default), where, node.at)
            values = list(default)
            items = self._items(node.items, kind, where)
            if len(items) > len(values):
                raise where.error(
                    f"{len(items)} values are given for {len(values)} elements", node.at
                )
            for position, item in enumerate(items):
                if item is not None:
                    inner = later and later.element(kind, position)
                    values[position] = self.initial_value(
                        item, kind.element, where, values[position], inner
                    )
            return values
        if isinstance(kind, StructType) and isinstance(node, s.StructInit):
            known = {name.upper(): (name, field) for name, field in kind.fields}
            result = dict(default)
            for field, item in node.fields:
                if field.key not in known:
                    raise where.error(f"{kind.name} has no field {field.text}", field.at)
                name, field_type = known[field.key]
                if kind.union and len(node.fields) > 1:
                    text = f"{kind.name} is a UNION and takes one initial value"
                    raise where.error(text, field.at)
                before = self._plain_value(field_type) if kind.union else result[name]
                inner = later and later.member(field)
                value = self.initial_value(item, field_type, where, before, inner)
                result = {name: value} if kind.union else {**result, name: value}
            return result
        if isinstance(kind, BlockType) and isinstance(node, s.StructInit):
            return self._block_value(node, kind, where, default, later)
        if isinstance(kind, (ArrayType, StructType)) and isinstance(node, (s.Name, s.Field)):
            found = self._whole_constant(node, kind)
            if found is not None:
                where.note("a constant instead of a literal", node.at)
                return found
        if later is not None and not isinstance(kind, BlockType) and later.takes(node, kind):
            return default
        error = where.error(f"this is not an initial value for a {describe(kind)}", node.at)
        data = isinstance(kind, (ArrayType, StructType)) and later is not None
        if data and isinstance(node, (s.Name, s.Field, s.Index, s.Dereference, s.Call, s.Invoke)):
            raise NotConstantError(
                error.message, file=error.file, line=error.line, column=error.column
            )
        raise error

    def _whole_constant(self, node: s.Name | s.Field, kind: Type) -> Any:
        """Return the value of a constant array or structure; None for another variable."""
        key = node.key if isinstance(node, s.Name) else node.name.key
        symbol = self.local.get(key) if isinstance(node, s.Name) else None
        if symbol is not None:
            return deepcopy(symbol.initial) if symbol.constant and symbol.type == kind else None
        if isinstance(node, s.Field) and not isinstance(node.base, s.Name):
            return None
        variable, declared = self._constants_of_lists().get(key, (None, None))
        if variable is None or declared is None or variable.initial is None:
            return None
        found, default = self.resolve(variable.spec, declared)
        if found != kind:
            return None
        return self.initial_value(variable.initial, kind, declared, default)

    def _plain_value(self, kind: Type) -> Any:
        """Return the initial value of a variable of this type that is declared without a value."""
        if isinstance(kind, ElementaryType):
            return default_scalar(kind)
        if isinstance(kind, ArrayType):
            return [self._plain_value(kind.element)] * array_length(kind)
        return self.initial[kind.name.upper()]

    def _block_value(
        self,
        node: s.StructInit,
        kind: BlockType,
        where: Declared,
        default: Any,
        later: Later | None = None,
    ) -> dict[str, Any]:
        where.note("an initial value of a block", node.at)
        pou = self.pous.get(kind.name.upper())
        known = {pin.name.upper(): pin for pin in kind.variables}
        result = dict(default or {})
        for field, item in node.fields:
            pin = known.get(field.key)
            if pin is None or pin.section not in ("VAR", "VAR_INPUT", "VAR_OUTPUT"):
                raise where.error(f"{kind.name} has no input {field.text}", field.at)
            start = pou.symbols[field.key].initial if pou is not None else None
            inner = later and later.member(field)
            result[pin.name] = self.initial_value(item, pin.type, where, start, inner)
        return result

    def _items(
        self,
        items: tuple[tuple[s.Expression | None, s.Init], ...],
        kind: ArrayType,
        where: Declared,
    ) -> list[s.Init | None]:
        """Return the values of all elements; None for an element that has its default value."""
        result: list[s.Init | None] = []
        for count, item in items:
            times = 1 if count is None else self.integer(count, where)
            if count is None and isinstance(item, s.Call) and self.lookup(item.function):
                # `N(0)`, the value 0 repeated N times, is parsed as a call.
                times = self.integer(item.function, where)
                given = tuple((None, one.value) for one in item.arguments)
                item = s.Sequence(given, item.at)
            inner: list[s.Init | None] = [item]
            if isinstance(item, s.Sequence):
                inner = self._items(item.items, kind, where) if item.items else [None]
            elif isinstance(item, s.ArrayInit) and not isinstance(kind.element, ArrayType):
                inner = self._items(item.items, kind, where)  # a nested list is one row
            if times * len(inner) > array_length(kind):
                text = f"{times * len(inner)} values are more than the array holds"
                raise where.error(text, item.at)
            result += inner * times
        return result


def _constants(section: s.Section) -> Iterator[tuple[str, s.VarDecl]]:
    """Yield the constants of a section that have an initial value, by upper-case name."""
    for one in section.variables if section.qualifier == "CONSTANT" else ():
        if one.initial is not None:
            yield from ((name.key, one) for name in one.names)


def _constant_of(symbol: Symbol) -> Constant | None:
    scalar = isinstance(symbol.type, (ElementaryType, EnumType))
    return Constant(symbol.initial, symbol.type, True) if symbol.constant and scalar else None


def is_null(node: Any) -> bool:
    """Return whether an expression is 0 or NULL."""
    if isinstance(node, s.Literal):
        return node.kind == "INTEGER" and node.text.strip("_0") in ("", "16#", "2#", "8#", "10#")
    return isinstance(node, s.Name) and node.key == "NULL"


def fills(have: Type, want: Type) -> bool:
    """Return whether an array can be passed to a parameter that is an array of open length."""
    return (
        isinstance(have, ArrayType)
        and isinstance(want, ArrayType)
        and want.open
        and len(have.bounds) == len(want.bounds)
        and have.element == want.element
    )


def default_scalar(kind: ElementaryType) -> bool | int | float | str:
    """Return the standard's initial value of a type: 0, FALSE or the empty string."""
    if kind.name == "BOOL":
        return False
    if kind.name in ANY_CHARS:
        return "" if kind.name in ANY_STRING else "\0"
    return 0.0 if kind.name in ANY_REAL else 0
