"""The checker of expressions: it gives every expression its type.

Untyped numbers make this a problem of two directions. `X + 1` gets its type from X, but in `R := 1
/ 3` only the target has a type. So `infer` first goes upwards and finds the type that the operands
give; untyped numbers give none. Then `check` goes downwards with the type that the context
requires, and gives this type to the untyped numbers. An implicit conversion (`widening`) becomes an
explicit call in the tree and is noted as not portable.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.arithmetic import ARITHMETIC
from structured_text.language.calls import pin_of
from structured_text.language.compiling import MOST_OPERATORS
from structured_text.language.constants import adapt, divided, literal, member
from structured_text.language.declare import Scope
from structured_text.language.fitting import Fitting
from structured_text.language.functions import Functions
from structured_text.language.methods import Methods
from structured_text.language.operators import COMPARISONS, Operators
from structured_text.language.references import PLACES, References
from structured_text.language.registry import ConsequenceError
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_INT,
    ANY_REAL,
    ANY_STRING,
    BOOL,
    ELEMENTARY,
    LREAL,
    MOMENTS,
    WIDTH,
)
from structured_text.language.standard import pin_name
from structured_text.language.system import GROUPS
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
    integer_name,
    type_name,
)
from structured_text.language.values import describe
from structured_text.language.walk import declared as declared_in
from structured_text.language.widening import BITS_OF

__all__ = ["ExpressionChecker"]

#: The types of the parts of a bit string.
_PARTS = {"X": "BOOL", "B": "BYTE", "W": "WORD", "D": "DWORD", "L": "LWORD"}
#: Limit for intermediate values of constant expressions. It is far beyond the range of any type.
_LARGEST = 1 << 128


class ExpressionChecker:
    """Checks the expressions of one POU.

    `infer` returns the type that an expression has by itself, or None if it consists only of
    untyped numbers. `check` then returns the typed expression. Untyped numbers get the required
    type.
    """

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        # Results by `id` of a node. Without them, each operator of a long expression would repeat
        # the work for all its operands, and the time would grow with the square of the length.
        self._inferred: dict[int, Type | None] = {}
        self._folded: dict[int, t.Constant | None] = {}
        self._checked: dict[tuple[int, str], t.Expression] = {}
        self._depth = 0
        self.functions = Functions(self)
        self.references = References(self)
        self.methods = Methods(self)
        self.operators = Operators(self)
        self.fitting = Fitting(self)

    # --- variables ---

    def variable(self, node: s.Variable) -> t.Variable:
        """Check and type a variable, member or element; a reference becomes its target.

        Raises:
            InputError: The variable is not declared, the member does not exist, or an index is
                wrong.
        """
        return self.references.followed(self.place(node))

    def place(self, node: s.Variable) -> t.Variable:
        """Check and type a variable, member or element; a reference remains a reference."""
        if isinstance(node, s.Name):
            symbol = self.scope.symbol(node.key)
            if symbol is not None:
                self._check_access(symbol, node.at)
                return t.Use(symbol, symbol.type)
            if self.methods.is_own_property(node.key):
                return self.methods.own_property(node)
            raise self._undeclared(node)
        if isinstance(node, s.This):
            return self.methods.this(node.at, above=node.above)
        if isinstance(node, s.Dereference):
            return self.references.deref(node)
        if isinstance(node, s.Field):
            plain = self.methods.bare(node)
            if isinstance(plain, s.Name):
                return self.place(plain)
            listed = self._listed(node) or self.methods.symbol_of_this(node)
            if listed is not None:
                return listed
        if isinstance(node, s.Part):
            raise self.scope.error(
                "a bit or part of a variable cannot stand here",
                node.at,
                "copy it to a variable first",
            )
        if isinstance(node, (s.Call, s.Invoke)):
            hint = "call it in a statement before"
            raise self.scope.error("a call cannot stand here", node.at, hint)
        if isinstance(node, s.Field) and self._is_broken_global(node):
            raise ConsequenceError(f"{node.name.text} is not declared")
        base = self.base(node.base)
        if isinstance(node, s.Field):
            return self._member(base, node)
        if isinstance(base.type, ReferenceType):
            return self.references.element(base, node)
        return self._element(base, node)

    def _is_broken_global(self, node: s.Field) -> bool:
        """Return whether a name is a variable of a list of globals, declared with an error."""
        if not isinstance(node.base, s.Name) or self.is_variable(node.base):
            return False
        if node.name.key not in self.scope.declarations.broken:
            return False
        return any(one.node.name.key == node.base.key for one in self.scope.registry.lists)

    def base(self, node: s.Variable | s.Call | s.Invoke) -> t.Variable:
        """Check and type the base of a member, element or method: a variable or a call's result."""
        if isinstance(node, s.Call):
            self.scope.note("a member of a call's result", node.at)
            return self.check(node, None)  # type: ignore[return-value]
        if isinstance(node, s.Invoke):
            self.scope.note("a member of a call's result", node.at)
            plain = self.methods.plain_call(node)
            return self.invoked(node) if plain is None else self.base(plain)
        return self.variable(node)

    def invoked(self, node: s.Invoke) -> t.Variable:
        """Check and type a call of a method, or raise InputError."""
        call = self.methods.call(node)
        if call is None:
            hint = "call a block in a statement before"
            raise self.scope.error("this is not a method, and has no value", node.at, hint)
        return self.references.followed(call)

    def is_variable(self, node: s.Name) -> bool:
        """Return whether a name without a path is a variable or a property."""
        known = self.scope.symbol(node.key) is not None
        return known or self.methods.is_own_property(node.key)

    def writable(self, node: s.Variable) -> t.Variable:
        """Check and type a variable that is written.

        Raises:
            InputError: The variable cannot be written here, because it is a constant, an output of
                a block or a result.
        """
        known = not isinstance(node, s.Name) or self.scope.symbol(node.key) is not None
        if isinstance(node, s.Name) and not known and node.key in self.scope.registry.members:
            raise self.scope.error(f"{node.text} is a member of an enumeration", node.at)
        found = self.variable(node)
        part: t.Variable = found
        while isinstance(part, (t.Member, t.Index)):
            if isinstance(part, t.Member) and isinstance(part.base.type, BlockType):
                pin = pin_of(part.base.type, part.name)
                if pin is not None and pin.section == "VAR":
                    self.scope.note("a variable of a block that is not a pin", node.at)
                elif pin is None or pin.section != "VAR_INPUT":
                    what = f"is an output of {part.base.type.name}"
                    if pin is None and part.name.endswith(f".{t.AFTER_CALL}"):
                        what = f"is a VAR_IN_OUT of {part.base.type.name}: give it in the call"
                    name = part.name.removesuffix(f".{t.AFTER_CALL}")
                    raise self.scope.error(f"{name} {what}", node.at)
            part = part.base
        if isinstance(part, (t.CallFunction, t.CallMethod)):
            raise self.scope.error(
                "the result of a call or property cannot be written",
                node.at,
                "copy it to a variable, change that, and write it back",
            )
        if not isinstance(part, t.Use):
            return found
        symbol = part.symbol
        if symbol.section == "VAR_INPUT":
            self.scope.note("a written VAR_INPUT", node.at)
            self.scope.pou.copied.add(symbol.name.upper())
        external = symbol.section == "VAR_EXTERNAL"
        key = symbol.source or symbol.name.upper()
        source = self.scope.declarations.globals.get(key) if external else None
        if symbol.constant or (source is not None and source.constant):
            raise self.scope.error(f"{symbol.name} is CONSTANT", node.at)
        return found

    def _listed(self, node: s.Field) -> t.Use | None:
        """Return a global variable that is written with its list; None otherwise."""
        base = self.methods.bare(node.base)
        if not isinstance(base, s.Name) or self.scope.symbol(base.key) is not None:
            return None
        symbol = self.scope.listed(base.key, node.name.key, node.at)
        return None if symbol is None else t.Use(symbol, symbol.type)

    def member_of(self, node: s.Expression) -> t.Constant | None:
        """Return the enumeration member that `Colour.RED` denotes; None for any other expression.

        Raise InputError if the enumeration has no such member.
        """
        if not isinstance(node, s.Field) or not isinstance(node.base, (s.Name, s.Field)):
            return None
        base = self.methods.bare(node.base)
        if not isinstance(base, s.Name):
            return None
        kind = self.scope.declarations.type_named(base.key)
        if not isinstance(kind, EnumType):
            return None
        symbol = self.scope.symbol(base.key)
        if symbol is not None and isinstance(symbol.type, (StructType, BlockType)):
            return None
        self.scope.note("a member with the name of its enumeration", node.at)
        return member(kind, node.name, self.scope.where)

    def is_member(self, node: s.Variable) -> bool:
        """Return whether a name or path in the source denotes a member of an enumeration."""
        if isinstance(node, s.Name) and not self.is_variable(node):
            return node.key in self.scope.registry.members
        return self.member_of(node) is not None

    def part(self, node: s.Part) -> tuple[t.Variable, t.Expression, int, ElementaryType]:
        """Resolve an access to a bit or part of a variable, such as `Status.3`.

        Raise InputError if the variable has no bits, or too few bits.

        Returns:
            The variable, the variable as a bit string, the first bit, and the type of the part.
        """
        base = self.variable(node.base)
        name = integer_name(base.type)
        if name not in WIDTH:
            raise self.scope.error(f"a {describe(base.type)} has no bits", node.at)
        if isinstance(base.type, EnumType):
            self.scope.note("an enumeration as a number", node.at)
        kind = ELEMENTARY[_PARTS[node.size]]
        size = WIDTH.get(kind.name, 1)
        if (node.number + 1) * size > WIDTH[name]:
            raise self.scope.error(f"a {name} has no {kind.name} {node.number}", node.at)
        return base, self.bits(self.fitting.based(base)), node.number * size, kind

    @staticmethod
    def bits(value: t.Expression) -> t.Expression:
        """Convert an integer to a bit string of its width."""
        name = type_name(value.type)
        if name in ANY_BIT:
            return value
        kind = ELEMENTARY[BITS_OF[name]]
        return t.Standard(f"{name}_TO_{kind.name}", (value,), kind)

    def _part(self, node: s.Part) -> t.Expression:
        _, bits, first, kind = self.part(node)
        whole = bits.type
        if kind == BOOL:
            bit = t.Binary("AND", bits, t.Constant(1 << first, whole, True), whole)
            return t.Binary("<>", bit, t.Constant(0, whole, True), BOOL)
        if first:
            count = t.Constant(first, ELEMENTARY["INT"])
            bits = t.Standard("SHR", (bits, count), whole)
        if whole == kind:
            return bits
        return t.Standard(f"{type_name(whole)}_TO_{kind.name}", (bits,), kind)

    def _undeclared(self, node: s.Name) -> InputError:
        here = self.scope.block
        lacks = here is not None and self.scope.registry.incomplete(here.name.upper())
        if lacks or node.key in self.scope.declarations.broken:
            return ConsequenceError(f"{node.text} is not declared")
        if "_INIT_DONE" in (self.scope.block or self.scope.pou).symbols:
            hint = "name its .var file, too, or the folder of the task"
            return self.scope.error(f"{node.text} is not declared", node.at, hint)
        pou = self.scope.pou
        if pou.name.upper().rpartition(".")[2] == node.key and pou.kind in ("FUNCTION", "METHOD"):
            if pou.name.upper() in self.scope.declarations.broken:
                return ConsequenceError(f"the type of {pou.name} has an error")
            text = f"the {pou.kind} {node.text} has no result"
            return self.scope.error(text, node.at, f"write {pou.kind} {node.text} : and its type")
        symbols = [symbol.name for symbol in pou.symbols.values()]
        return self.scope.error(f"{node.text} is not declared", node.at, _near(node.key, symbols))

    def _after_call(self, block: t.Pou, pin: Variable, node: s.Field) -> str | None:
        """Return the variable that holds a block's VAR_IN_OUT after the last call of the block.

        matiec passes a VAR_IN_OUT by value and back, so a block keeps its last value. The result is
        None in all other dialects, where the access is refused, and for arrays and structures.
        """
        scalar = isinstance(pin.type, (ElementaryType, EnumType))
        if not scalar or self.scope.registry.dialect.name not in ("iec", "openplc"):
            return None
        symbol = block.symbols.get(pin.name.upper())
        if symbol is None or block.owner is not None:
            return None
        self.scope.note("a VAR_IN_OUT read outside of its block", node.name.at)
        name = f"{symbol.name}.{t.AFTER_CALL}"
        hidden = t.Symbol(name, symbol.type, "VAR", symbol.at, symbol.initial)
        block.symbols.setdefault(name.upper(), hidden)
        return name

    def _member(self, base: t.Variable, node: s.Field) -> t.Variable:
        kind, key = base.type, node.name.key
        final = isinstance(node.base, s.This) and node.base.above
        value = self.methods.property(base, node.name, final=final)
        if value is not None:
            return value
        if isinstance(kind, StructType):
            for name, field in kind.fields:
                if name.upper() == key:
                    return t.Member(base, name, field)
            near = _near(key, [name for name, _ in kind.fields])
        elif isinstance(kind, BlockType):
            if pin_name(kind, key) != key:
                key = pin_name(kind, key)
                self.scope.note("another name of a pin", node.name.at, f"{node.name.key} is {key}")
            declared = self.scope.declarations.pous.get(kind.name.upper())
            for pin in kind.variables:
                if pin.name.upper() == key:
                    if declared is not None and key in declared.symbols:
                        self._check_access(declared.symbols[key], node.name.at)
                    if pin.section == "VAR_IN_OUT" and declared is not None:
                        after = self._after_call(declared, pin, node)
                        if after is not None:
                            return t.Member(base, after, pin.type)
                    if pin.section in ("VAR_IN_OUT", "VAR_EXTERNAL", "VAR_TEMP"):
                        raise self.scope.error(
                            f"{pin.name} is internal to {kind.name}", node.name.at
                        )
                    if pin.section == "VAR":
                        self.scope.note("a variable of a block that is not a pin", node.name.at)
                    return t.Member(base, pin.name, pin.type)
            written = self.scope.registry.pous.get(kind.name.upper())
            sections = written.node.sections if written is not None else ()  # type: ignore[union-attr]
            if any(name.key == key for _, _, name in declared_in(sections)):
                raise ConsequenceError(f"{kind.name}.{node.name.text} has an error")
            near = self.methods.method_hint(kind, key)
            near = near or _near(key, [pin.name for pin in kind.variables])
        elif isinstance(kind, InterfaceType):
            near = self.methods.method_hint(kind, key)
        else:
            raise self.scope.error(f"a {describe(kind)} has no members", node.name.at)
        raise self.scope.error(f"{kind.name} has no member {node.name.text}", node.name.at, near)

    def _check_access(self, symbol: t.Symbol, at: s.Position) -> None:
        """Raise InputError if a PRIVATE or PROTECTED variable is used outside of its block."""
        here = self.scope.block
        if not symbol.access or (here is not None and here.name.upper() == symbol.owner):
            return
        owner = self.scope.declarations.pous.get(symbol.owner)
        inside = here is not None and owner is not None and owner.block is not None
        if inside and symbol.access == "PROTECTED":
            assert here is not None
            assert owner is not None
            if self.scope.declarations.objects.is_a(here.block, owner.block):
                return
        name = owner.name if owner is not None else symbol.owner
        raise self.scope.error(f"{name}.{symbol.name} is {symbol.access}", at)

    def _element(self, base: t.Variable, node: s.Index) -> t.Index:
        if type_name(base.type) in ANY_STRING:
            base = self.references.characters(base, node.at)
        kind = base.type
        if not isinstance(kind, ArrayType):
            raise self.scope.error(f"a {describe(kind)} has no elements", node.at)
        if len(node.indices) != len(kind.bounds):
            raise self.scope.error(
                f"{describe(kind)} has {len(kind.bounds)} dimensions, not {len(node.indices)}",
                node.at,
            )
        indices = []
        for index, (low, high) in zip(node.indices, kind.bounds, strict=True):
            index_type = self.infer(index) or ELEMENTARY["DINT"]
            if isinstance(index_type, EnumType):
                index_type = ELEMENTARY[index_type.base]
            if type_name(index_type) in ANY_BIT and type_name(index_type) != "BOOL":
                self.scope.note("arithmetic of bit strings", index.at, "an index")
                index_type = self.operators.number(index_type)
            if type_name(index_type) not in ANY_INT:
                raise self.scope.error(
                    f"an index must be an integer, not a {describe(index_type)}", index.at
                )
            found = self.check(index, index_type)
            if self.operators.is_short(index_type) and isinstance(index, (s.Binary, s.Unary)):
                found = self.operators.lengthened(index)
            if (
                isinstance(found, t.Constant)
                and not kind.open
                and not low <= int(found.value) <= high
            ):
                raise self.scope.error(f"index {found.value} is outside {low}..{high}", index.at)
            indices.append(found)
        return t.Index(base, tuple(indices), kind.element)

    # --- types ---

    def infer(self, node: s.Expression) -> Type | None:
        """Return the type that an expression has without its context; None for untyped numbers."""
        if id(node) not in self._inferred:
            self._inferred[id(node)] = self._infer(node)
        return self._inferred[id(node)]

    def _infer(self, node: s.Expression) -> Type | None:
        if isinstance(node, s.Literal):
            found = literal(node, self.scope.declarations.types, self.scope.where)
            return found.type if found.typed else None
        if isinstance(node, s.Name) and not self.is_variable(node):
            return self._enumeration(node)
        if isinstance(node, s.Part):
            return ELEMENTARY[_PARTS[node.size]]
        if isinstance(node, s.Field):
            found_member = self.member_of(node)
            if found_member is not None:
                return found_member.type
        if isinstance(node, s.Invoke):
            plain = self.methods.plain_call(node)
            return self.infer(plain) if plain is not None else self.invoked(node).type
        if isinstance(node, PLACES):
            return self.variable(node).type
        if isinstance(node, s.TypeName):
            raise self.scope.error("a type cannot stand here", node.at, "name a variable")
        if isinstance(node, s.Assigned):
            return self._place_of(node).type
        if isinstance(node, s.Unary):
            inner = self.infer(node.operand)
            return inner if node.op == "NOT" or inner is None else self.operators.number(inner)
        if isinstance(node, s.Call):
            return self._called_type(node)
        if node.op in COMPARISONS:
            return BOOL
        left = self.infer(node.left)
        if isinstance(left, ReferenceType):
            return left
        if node.op == "**":
            return left if left is None or type_name(left) in ANY_REAL else ELEMENTARY["LREAL"]
        right = self.infer(node.right)
        if left is None and right is None:
            return None
        if type_name(left) in MOMENTS or type_name(right) in MOMENTS:
            return self.operators.moment_type(node.op, left, right)
        return self.operators.operand_type(node.op, node.left, node.right, None)

    def _place_of(self, node: s.Assigned) -> t.Variable:
        """Return the target of an assignment that is inside an expression, or raise InputError."""
        hint = "assign it in a statement of its own"
        if isinstance(node.target, s.Part):
            raise self.scope.error("a bit is not assigned inside an expression", node.at, hint)
        if isinstance(node.target, PLACES) and self.methods.setter(node.target) is not None:
            raise self.scope.error("a property is not assigned inside an expression", node.at, hint)
        return self.writable(node.target)

    def _enumeration(self, node: s.Name) -> Type | None:
        owners = self.scope.registry.members.get(node.key, [])
        if not owners:
            raise self._undeclared(node)
        return self.scope.declarations.types[owners[0]] if len(owners) == 1 else None

    def check(self, node: s.Expression, want: Type | None) -> t.Expression:
        """Check and type an expression, or raise InputError.

        `want` is the type that the context requires; None allows any type.
        """
        if isinstance(want, (ReferenceType, InterfaceType)):
            return self.references.wanted(node, want)
        if isinstance(want, StructType) and (want.name in GROUPS or want.name == "AnyType"):
            return self.references.generic(node, want)
        key = id(node), type_name(want)
        known = self._checked.get(key)
        if known is not None and (want is None or key[1]):
            return known
        self._depth += 1
        try:
            found = self._checked[key] = self._fitting(node, want)
        finally:
            self._depth -= 1
        return found

    def _fitting(self, node: s.Expression, want: Type | None) -> t.Expression:
        if self._depth > MOST_OPERATORS:
            raise self.scope.error(
                f"an expression of more than {MOST_OPERATORS:,} operators inside each other",
                node.at,
                "assign parts of it to variables first",
            )
        found = self.fitting.numbered(self._typed(node, want), want, node.at)
        if isinstance(found.type, BlockType) and want is not None and found.type is not want:
            raise self.scope.error(f"a block of type {found.type.name} is not a value", node.at)
        if want is None or found.type == want:
            return found
        return self.fitting.fitted(found, want, node)

    def converted(self, found: t.Expression, want: ElementaryType) -> t.Expression:
        """Return the call of a conversion, or the converted constant."""
        return self.fitting.converted(found, want)

    def fitted(self, found: t.Expression, want: Type, node: s.Expression) -> t.Expression:
        """Return an expression in the required type, or raise InputError; see `Fitting`."""
        return self.fitting.fitted(found, want, node)

    def _typed(self, node: s.Expression, want: Type | None) -> t.Expression:
        if isinstance(node, s.Name) and not self.is_variable(node):
            return self._member_of_enumeration(node, want)
        if isinstance(node, s.Part):
            return self._part(node)
        if isinstance(node, s.Field):
            found = self.member_of(node)
            if found is not None:
                return found
        if isinstance(node, s.Call):
            return self._call(node, want)
        if isinstance(node, s.Invoke):
            plain = self.methods.plain_call(node)
            return self._call(plain, want) if plain is not None else self.invoked(node)
        if isinstance(node, PLACES):
            return self.variable(node)
        if isinstance(node, s.TypeName):
            raise self.scope.error("a type cannot stand here", node.at, "name a variable")
        if isinstance(node, s.Assigned):
            target = self._place_of(node)
            return t.Assigned(target, self.check(node.value, target.type), target.type)
        folded = self.fold(node)
        if folded is not None:
            if folded.typed:
                return folded
            if isinstance(want, EnumType) and isinstance(folded.value, int):
                self.scope.note("a number as an enumeration", node.at)
                return t.Constant(folded.value, want, True)
            return adapt(folded, want or _default(folded), node.at, self.scope.where)
        if isinstance(node, s.Unary):
            return self.operators.unary(node, want)
        assert isinstance(node, s.Binary)
        return self.operators.binary(node.op, node.left, node.right, want, node.at)

    def _member_of_enumeration(self, node: s.Name, want: Type | None) -> t.Constant:
        kind = self._enumeration(node)
        if isinstance(want, EnumType):
            owners = self.scope.registry.members[node.key]
            if want.name.upper() in owners:
                return member(want, node, self.scope.where)
        if not isinstance(kind, EnumType):
            owners = self.scope.registry.members[node.key]
            raise self.scope.error(
                f"{node.text} is a member of {' and '.join(owners)}",
                node.at,
                f"write {owners[0]}#{node.text}",
            )
        return member(kind, node, self.scope.where)

    def fold(self, node: s.Expression) -> t.Constant | None:
        """Return the value of a literal, or of arithmetic on untyped numbers, else None."""
        if id(node) not in self._folded:
            self._folded[id(node)] = self._value(node)
        return self._folded[id(node)]

    def _value(self, node: s.Expression) -> t.Constant | None:
        if isinstance(node, s.Literal):
            return literal(node, self.scope.declarations.types, self.scope.where)
        if isinstance(node, s.Unary) and node.op == "-":
            found = self.fold(node.operand)
            if found is None or found.typed:
                return None
            return t.Constant(-found.value, found.type)  # type: ignore[operator]
        if not isinstance(node, s.Binary) or node.op not in ("+", "-", "*", "/", "MOD"):
            return None
        left, right = self.fold(node.left), self.fold(node.right)
        if left is None or right is None or left.typed or right.typed:
            return None
        if left.type != right.type:
            self.scope.note("an implicit conversion", node.at, "a whole number: write .0 behind it")
            left, right = (t.Constant(float(one.value), LREAL) for one in (left, right))
        a, b, op = left.value, right.value, node.op
        if op in ("/", "MOD"):
            value = divided(node, a, b, self.scope.where)  # type: ignore[arg-type]
        else:
            value = ARITHMETIC[op](a, b)
        if not abs(value) < (_LARGEST if isinstance(value, int) else math.inf):
            raise self.scope.error("the result of this constant expression is too large", node.at)
        return t.Constant(value, left.type)

    def is_real(self, node: s.Expression) -> bool:
        """Return whether an expression consists of untyped numbers, at least one with decimals."""
        found = self.fold(node)
        return found is not None and not found.typed and isinstance(found.value, float)

    def _called_type(self, node: s.Call) -> Type | None:
        """Return the type of a call's result; None if the context determines it."""
        method = self.methods.called(node.function)
        if method is not None:
            result = method[1].result
            return result.type if result is not None else None
        if self.references.is_known(node):
            return self.references.type_of(node)
        return self.functions.result(node)

    def _call(self, node: s.Call, want: Type | None) -> t.Expression:
        method = self.methods.call(node)
        if method is not None:
            return self.references.followed(method)
        if self.references.is_known(node):
            return self.references.call(node)
        return self.functions.call(node, want)


def _near(key: str, names: Iterable[str]) -> str:
    """Return a hint with names similar to an upper-case name; empty if there are none."""
    known = {name.upper(): name for name in names}
    close = difflib.get_close_matches(key, known, n=2)
    return f"did you mean {' or '.join(known[name] for name in close)}?" if close else ""


def _default(found: t.Constant) -> Type:
    """Return the type that an untyped number gets if the context does not require a type."""
    return ELEMENTARY["LREAL" if isinstance(found.value, float) else "LINT"]
