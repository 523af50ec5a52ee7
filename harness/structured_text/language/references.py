"""Pointers and references: ADR, REF, `^`, REF=, comparison and arithmetic."""

from __future__ import annotations

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.memory import (
    NAMES,
    is_memory_function,
    memory_call,
    memory_result,
)
from structured_text.language.registry import ConsequenceError
from structured_text.language.resolve import is_null
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_INT,
    ANY_STRING,
    BOOL,
    ELEMENTARY,
    string_length,
)
from structured_text.language.sizes import size_of
from structured_text.language.system import GROUPS, class_of
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.language.values import describe

__all__ = ["FUNCTIONS", "PLACES", "References", "place_of"]

#: Nodes that are written as a variable.
PLACES = (s.Name, s.Field, s.Index, s.Dereference, s.This)
#: The functions whose calls this module checks. The functions in `_REFUSED` are not supported.
FUNCTIONS = ("ADR", "REF", "__ISVALIDREF", "__QUERYINTERFACE", "__QUERYPOINTER")
_QUERY = "IQueryInterface"
_REFUSED = {
    "__NEW": "write it alone behind := of an assignment to a pointer",
    "__DELETE": "write it as a statement of its own",
    "__VARINFO": "write a STRING of your own",
    "BITADR": "name the bit of the variable",
    **dict.fromkeys(("MEMCPY", "MEMSET", "MEMMOVE", "MEMCMP"), "assign or compare the variables"),
}


class References:
    """Checks the pointers and references of one POU; `expression_checker` uses this class."""

    def __init__(self, expressions: Checking) -> None:
        self._all = expressions
        self._scope = expressions.scope

    def followed(self, found: t.Variable) -> t.Variable:
        """Return the target of a REFERENCE TO; return any other variable unchanged."""
        kind = found.type
        if isinstance(kind, ReferenceType) and kind.kind == "REFERENCE":
            return t.Deref(found, _target(kind))
        return found

    def deref(self, node: s.Dereference) -> t.Deref:
        """Check and type `pointer^`, or raise InputError."""
        base = self._all.base(node.base)
        kind = base.type
        if not isinstance(kind, ReferenceType):
            raise self._scope.error(
                f"^ needs a pointer, not a {describe(kind)}",
                node.at,
                "remove ^: a REFERENCE TO and a VAR_IN_OUT are used without it"
                if _is_plain(base)
                else "",
            )
        return t.Deref(base, _target(kind))

    def element(self, base: t.Variable, node: s.Index) -> t.Deref:
        """Check and type `pointer[i]`: the element `i` positions behind the pointer's target."""
        kind = base.type
        assert isinstance(kind, ReferenceType)
        if len(node.indices) != 1:
            raise self._scope.error("a pointer takes one index", node.at)
        index = self._all.infer(node.indices[0]) or ELEMENTARY["DINT"]
        if isinstance(index, EnumType):
            index = ELEMENTARY[index.base]
        if isinstance(index, ElementaryType) and index.name in ANY_BIT and index != BOOL:
            self._scope.note("arithmetic of bit strings", node.indices[0].at, "an index")
            index = self._all.operators.number(index)
        if index.name not in ANY_INT:
            text = f"an index must be an integer, not a {describe(index)}"
            raise self._scope.error(text, node.indices[0].at)
        return t.Deref(base, _target(kind), self._all.check(node.indices[0], index))

    # --- values for a pointer, reference or interface ---

    def wanted(self, node: s.Expression, want: ReferenceType | InterfaceType) -> t.Expression:
        """Check and type an expression where a pointer, reference or interface is required.

        Raise InputError if the expression has another type, or points to another type.
        """
        if is_null(node):
            return t.Null(want)
        if isinstance(node, s.This) and node.pointer and isinstance(want, ReferenceType):
            this = self._all.variable(node)
            return self._fitted(_to(this, "POINTER"), want, node)
        if isinstance(node, s.Binary) and isinstance(want, ReferenceType):
            if self._is_smaller(node.left, want):
                moved = self.moved(node.op, node.left, node.right, node.at)
                return self._fitted(moved, want, node)
            base = self.wanted(node.left, want)
            return self._moved(node.op, base, node.right, node.at)
        if isinstance(node, s.Call) and node.function.key in ("ADR", "REF"):
            self._scope.note("ADR or REF", node.at)
            found = self._address(node, want)
            if isinstance(want, ReferenceType):
                return self._fitted(found, want, node)
            text = f"a {want.name} is expected here, not a pointer"
            raise self._scope.error(text, node.at, "assign the block itself")
        if isinstance(want, ReferenceType) and want.kind == "REFERENCE":
            return self._fitted(self._bound(node), want, node)
        found = self._all.check(node, None)
        if isinstance(want, InterfaceType):
            if not self._scope.declarations.objects.is_a(found.type, want):
                block = isinstance(found.type, BlockType)
                if block and self._scope.registry.incomplete(found.type.name.upper()):
                    raise ConsequenceError(f"a base of {found.type.name} is missing")
                have = describe(found.type)
                text = f"a {want.name} is expected here, and {have} does not implement it"
                raise self._scope.error(text, node.at, f"let it IMPLEMENT {want.name}")
            return found
        return self._fitted(found, want, node)

    def _is_smaller(self, node: s.Expression, want: ReferenceType) -> bool:
        """Return whether the target of a pointer is smaller than the wanted target.

        If so, the offset counts elements of the smaller type, and the pointer is moved before its
        type is changed.
        """
        kind = self._all.infer(node)
        if not isinstance(kind, ReferenceType):
            return False
        have, need = size_of(_target(kind)), size_of(_target(want))
        return have is not None and need is not None and have < need

    def _bound(self, node: s.Expression) -> t.Expression:
        """Return a reference to a variable.

        If the variable is the target of a REFERENCE TO, return this reference itself.
        """
        found = self._all.check(node, None)
        place = place_of(found)
        if place is None:
            raise self._scope.error("a reference needs a variable to refer to", node.at)
        if isinstance(place, t.Deref) and place.offset is None:
            kind = place.base.type
            if isinstance(kind, ReferenceType):
                return place.base
        self._check_bit(place, node.at)
        return _to(place, "REFERENCE")

    def _check_bit(self, place: t.Variable, at: s.Position) -> None:
        """Raise InputError if a variable is a BIT, which shares its byte with others."""
        of = place.base.type if isinstance(place, t.Member) else None
        if isinstance(of, StructType) and place.name.upper() in of.bits:  # type: ignore[union-attr]
            raise self._scope.error("a BIT has no address", at, "make it a BOOL")

    def _fitted(self, found: t.Expression, want: ReferenceType, node: s.Expression) -> t.Expression:
        kind = found.type
        if not isinstance(kind, ReferenceType):
            text = f"a {describe(want)} is expected here, not a {describe(kind)}"
            raise self._scope.error(text, node.at, "write ADR(variable)")
        same = _target(kind) == _target(want)
        if not same and isinstance(kind.target, BlockType):
            same = self._scope.declarations.objects.is_a(kind.target, want.target)
        if want.kind == "REFERENCE" and self._scope.declarations.derives(
            _target(kind), _target(want)
        ):
            self._scope.note("a structure as its base", node.at)
            same = True
        if same:
            return found
        if isinstance(found, t.Address) and isinstance(kind.target, ArrayType):
            array = kind.target
            if array.element == want.target:
                lows = tuple(t.Constant(low, ELEMENTARY["DINT"]) for low, _ in array.bounds)
                return t.Address(t.Index(found.variable, lows, array.element), want)
        if "REFERENCE" not in (kind.kind, want.kind) and not self._are_strangers(kind, want):
            return self._recast(found, want, node.at)
        raise self._scope.error(
            f"a {describe(want)} cannot lead to a {describe(_target(kind))}",
            node.at,
            "use a pointer to data",
        )

    def _are_strangers(self, one: ReferenceType, other: ReferenceType) -> bool:
        """Return whether two pointers lead to unrelated blocks: neither block extends the other."""
        first, second = _target(one), _target(other)
        objects = self._scope.declarations.objects
        blocks = isinstance(first, BlockType) and isinstance(second, BlockType)
        return blocks and not (objects.is_a(first, second) or objects.is_a(second, first))

    def _recast(self, found: t.Expression, want: ReferenceType, at: s.Position) -> t.Recast:
        assert isinstance(found.type, ReferenceType)
        shown = f"a {describe(_target(found.type))} as a {describe(_target(want))}"
        self._scope.note("memory looked at as another type", at, shown)
        self._scope.declarations.views = True
        return t.Recast(found, want)

    def characters(self, base: t.Variable, at: s.Position) -> t.Variable:
        """Return the characters of a text as an array of BYTE or WORD, from index 0.

        In the dialects of Siemens the characters are CHAR or WCHAR, from index 1.

        Raise InputError if the text is not a variable but the result of a call.
        """
        kind = base.type
        assert isinstance(kind, ElementaryType)
        if place_of(base) is None:
            hint = "assign it to a variable first, or use MID"
            raise self._scope.error(
                "only characters of a variable can be accessed by their number", at, hint
            )
        self._scope.note("a character of a text by its number", at)
        element = ELEMENTARY["BYTE" if kind.name == "STRING" else "WORD"]
        row = ArrayType("", ((0, string_length(kind)),), element)
        if self._scope.registry.dialect.name in ("ax", "tia"):
            element = ELEMENTARY["CHAR" if kind.name == "STRING" else "WCHAR"]
            row = ArrayType("", ((1, string_length(kind)),), element)
        self._scope.declarations.views = True
        return t.Deref(t.Recast(_to(base, "POINTER"), ReferenceType("POINTER", row)), row)

    def generic(self, node: s.Expression, want: StructType) -> t.Expression:
        """Check and type the argument of an ANY input: pointer, size and class of a variable.

        Raise InputError for a value, a variable without known bytes, or a type of another group.
        """
        found = self._all.check(node, None)
        kind, group = found.type, GROUPS.get(want.name)
        if isinstance(kind, StructType) and kind.fields == want.fields:
            return found
        place = place_of(found)
        if place is None:
            hint = "assign it to a variable first"
            raise self._scope.error(
                f"{self._any(want)} takes a variable, not a value", node.at, hint
            )
        self._check_bit(place, node.at)
        size = size_of(kind)
        if size is None:
            raise self._scope.error(
                f"{self._any(want)} does not take a {describe(kind)}",
                node.at,
                "its size differs from tool to tool",
            )
        if group is not None and (not isinstance(kind, ElementaryType) or kind.name not in group):
            text = f"{self._any(want)} does not take a {describe(kind)}"
            raise self._scope.error(text, node.at, f"it takes {', '.join(group)}")
        pointer: t.Expression = _to(place, "POINTER")
        if kind != ELEMENTARY["BYTE"]:
            pointer = t.Recast(pointer, ReferenceType("POINTER", ELEMENTARY["BYTE"]))
        return t.Generic(pointer, class_of(kind), size, want)

    @staticmethod
    def _any(kind: StructType) -> str:
        return kind.name if kind.name in GROUPS else "ANY"

    def made(self, node: s.Call, want: Type) -> tuple[t.Expression, tuple[s.Argument, ...] | None]:
        """Check and type `__NEW(type)` or `__NEW(type, count)`, which is assigned to a pointer.

        Returns:
            The pointer, and the arguments for the `INIT` of a block, if the type has them.

        Raises:
            InputError: The result is not assigned to a pointer, the argument is not a type, or a
                count of blocks is given.
        """
        self._scope.note("__NEW or __DELETE", node.at)
        if not isinstance(want, ReferenceType):
            text = f"__NEW needs a pointer to assign to, not a {describe(want)}"
            raise self._scope.error(text, node.at)
        if len(node.arguments) not in (1, 2):
            text = f"__NEW takes a type, and a count, not {len(node.arguments)} arguments"
            raise self._scope.error(text, node.at)
        spec, given = self._new_spec(node.arguments[0].value)
        declarations = self._scope.declarations
        kind, initial = declarations.resolve(spec, self._scope.where)
        declarations.link()
        count: t.Expression | None = None
        if len(node.arguments) == 2:
            size = node.arguments[1].value
            if isinstance(kind, BlockType):
                raise self._scope.error("__NEW makes one block at a time", size.at)
            index = self._all.infer(size) or ELEMENTARY["DINT"]
            if isinstance(index, ElementaryType) and index.name in ANY_BIT and index != BOOL:
                index = self._all.operators.number(index)
            if not isinstance(index, ElementaryType) or index.name not in ANY_INT:
                text = f"a count must be an integer, not a {describe(index)}"
                raise self._scope.error(text, size.at)
            count = self._all.check(size, index)
        # The generated code needs the global data, because the new variables are registered in it.
        self._scope.pou.clock = True
        found = t.New(kind, initial, count, ReferenceType("POINTER", kind))
        pou = self._scope.declarations.pous.get(kind.name.upper())
        if isinstance(kind, BlockType) and pou is not None and "ABSTRACT" in pou.words:
            raise self._scope.error(f"{kind.name} is ABSTRACT and has no instances", node.at)
        return self._fitted(found, want, node), given

    def _new_spec(self, node: s.Expression) -> tuple[s.TypeSpec, tuple[s.Argument, ...] | None]:
        """Return the type that `__NEW` names, and the arguments behind it."""
        if isinstance(node, s.TypeName):
            return node.spec, None
        call = node if isinstance(node, (s.Call, s.Invoke)) else None
        callee = call.callee if isinstance(call, s.Invoke) else call.function if call else node
        plain = self._all.methods.bare(callee) if isinstance(callee, s.Field) else callee
        if not isinstance(plain, s.Name):
            raise self._scope.error("__NEW needs the name of a type", node.at)
        if call is None:
            return s.NamedSpec(plain, plain.at), None
        if plain.key in ANY_STRING and len(call.arguments) == 1:
            return s.NamedSpec(plain, plain.at, call.arguments[0].value), None
        return s.NamedSpec(plain, plain.at), call.arguments

    def deleted(self, node: s.CallStatement) -> t.Delete:
        """Check and type `__DELETE(pointer)`, or raise InputError."""
        self._scope.note("__NEW or __DELETE", node.at)
        value = node.arguments[0].value if len(node.arguments) == 1 else None
        self._scope.pou.clock = True
        if isinstance(value, s.This) and value.pointer and not value.above:
            return t.Delete(_to(self._all.variable(value), "POINTER"), ElementaryType(""))
        found = self._all.writable(value) if isinstance(value, PLACES) else None
        if found is None or not isinstance(found.type, ReferenceType):
            raise self._scope.error("__DELETE needs a variable that is a pointer", node.at)
        return t.Delete(found, ElementaryType(""))

    def query(self, node: s.Call) -> t.Query:
        """Check and type __QUERYINTERFACE and __QUERYPOINTER, or raise InputError."""
        name, objects = node.function.key, self._scope.declarations.objects
        if len(node.arguments) != 2:
            text = f"{name} takes 2 arguments, not {len(node.arguments)}"
            raise self._scope.error(text, node.at)
        first, second = (one.value for one in node.arguments)
        source = self._all.check(first, None)
        if not isinstance(source.type, (InterfaceType, BlockType)):
            text = f"{name} needs an interface or block, not a {describe(source.type)}"
            raise self._scope.error(text, first.at)
        if not isinstance(second, PLACES):
            raise self._scope.error(f"{name} needs a variable for its result", second.at)
        target = self._all.writable(second)
        kind = target.type
        asked: Type | None = kind
        if name == "__QUERYPOINTER":
            asked = kind.target if isinstance(kind, ReferenceType) else None
            if not isinstance(asked, BlockType):
                text = f"{name} needs a POINTER TO a function block, not a {describe(kind)}"
                raise self._scope.error(text, second.at)
        elif not isinstance(kind, InterfaceType):
            text = f"{name} needs a variable of an interface, not a {describe(kind)}"
            raise self._scope.error(text, second.at)
        every = self._scope.registry.dialect.name == "ax"  # SIMATIC AX can query every interface
        for one, at in ((source.type, first.at), (asked, second.at)):
            if every:
                break
            if isinstance(one, InterfaceType) and not objects.is_a(one, InterfaceType(_QUERY)):
                hint = f"let {one.name} EXTEND __SYSTEM.{_QUERY}"
                raise self._scope.error(f"{name} cannot query {one.name}", at, hint)
        assert asked is not None
        key = asked.name.upper()
        blocks = objects.derived(key) + [one for one in objects.blocks if one == key]
        return t.Query(source, target, tuple(blocks), BOOL)

    # --- functions ---

    def is_known(self, node: s.Call) -> bool:
        """Return whether the call is one of `FUNCTIONS`.

        Raise InputError if the function is not supported.
        """
        key = node.function.key
        if is_memory_function(key, self._all):
            return True
        if key in _REFUSED and key not in self._scope.declarations.pous:
            alone = key in ("__NEW", "__DELETE")
            text = "cannot stand here" if alone else "is not supported"
            raise self._scope.error(f"{node.function.text} {text}", node.at, _REFUSED[key])
        known = key in FUNCTIONS and key not in self._scope.declarations.pous
        if known and key.startswith("__QUERY"):
            self._scope.note("__QUERYINTERFACE or __QUERYPOINTER", node.at)
        elif known:
            self._scope.note("ADR or REF", node.at)
        return known

    def type_of(self, node: s.Call) -> Type | None:
        """Return the type of the result of ADR, REF, __ISVALIDREF and the functions of memory."""
        if node.function.key in NAMES:
            return memory_result(node.function.key)
        if node.function.key in ("ADR", "REF"):
            return self._address(node, None).type
        return BOOL

    def call(self, node: s.Call) -> t.Expression:
        """Check and type a call of ADR, REF, __ISVALIDREF or a function of memory."""
        if node.function.key in NAMES:
            return memory_call(node, self._all)
        if node.function.key in ("ADR", "REF"):
            return self._address(node, None)
        if node.function.key != "__ISVALIDREF":
            return self.query(node)
        argument = self._argument(node)
        found = self._all.place(argument) if isinstance(argument, PLACES) else None
        passed = isinstance(found, t.Use) and found.symbol.section == "VAR_IN_OUT"
        if isinstance(found, t.Use) and found.symbol.passed:
            # The caller has passed a variable or a value, so the VAR_IN_OUT is valid.
            return t.Constant(True, BOOL)
        if found is None or not (passed or isinstance(found.type, ReferenceType)):
            text = "__ISVALIDREF needs a variable of REFERENCE TO, or a VAR_IN_OUT"
            hint = "compare a pointer or an interface with 0"
            raise self._scope.error(text, node.at, hint)
        return t.Valid(found, BOOL)

    def _argument(self, node: s.Call) -> s.Expression:
        if len(node.arguments) != 1:
            text = f"{node.function.text} takes 1 argument, not {len(node.arguments)}"
            raise self._scope.error(text, node.at)
        return node.arguments[0].value

    def _address(self, node: s.Call, want: Type | None) -> t.Expression:
        argument = self._argument(node)
        found = self._all.check(argument, None)
        place = place_of(found)
        if isinstance(place, t.Use) and isinstance(place.type, ArrayType) and place.type.open:
            hint = "take the address of its first element"
            raise self._scope.error("an array of open length has no address", node.at, hint)
        if place is None or isinstance(place.type, InterfaceType):
            raise self._scope.error(f"{node.function.text} needs a variable", node.at)
        self._check_bit(place, argument.at)
        kind = "REF_TO" if node.function.key == "REF" else "POINTER"
        if isinstance(want, ReferenceType):
            kind = want.kind
        return _to(place, kind)

    # --- operators ---

    def compared(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression | None:
        """Check and type the comparison of pointers or interfaces; None for other operands.

        Pointers to data can be compared with = <> < > <= >=. All others can be compared with = and
        <> only.
        """
        sides = [side for side in (left, right) if not is_null(side)]
        kinds = [self._all.infer(side) for side in sides]
        kind = next((one for one in kinds if isinstance(one, (ReferenceType, InterfaceType))), None)
        if kind is None:
            return None
        if op not in ("=", "<>"):
            data = isinstance(kind, ReferenceType) and size_of(_target(kind)) is not None
            if not data or op not in ("<", ">", "<=", ">="):
                raise self._scope.error(f"{op} is not defined for {describe(kind)}", at)
            self._scope.note("pointers compared by < or >", at)
        first, second = self.wanted(left, kind), self.wanted(right, kind)
        return t.Same(op, first, second, BOOL)

    def moved(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        """Check and type pointer + bytes and pointer - bytes.

        Raises:
            InputError: The operator is not + or -, or the size of the target's type is unknown.
        """
        return self._moved(op, self._all.check(left, None), right, at)

    def _moved(
        self, op: str, base: t.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        kind = base.type
        assert isinstance(kind, ReferenceType)
        size = size_of(kind.target) if kind.target is not None else None
        if op not in ("+", "-") or size is None:
            raise self._scope.error(f"{op} is not defined for {describe(kind)}", at)
        number = self._all.infer(right) or ELEMENTARY["DINT"]
        if isinstance(number, ElementaryType) and number.name in ANY_BIT and number != BOOL:
            self._scope.note("arithmetic of bit strings", right.at)
            number = self._all.operators.number(number)
        if not isinstance(number, ElementaryType) or number.name not in ANY_INT:
            text = f"a pointer is moved by an integer, not by a {describe(number)}"
            raise self._scope.error(text, right.at)
        offset = self._all.check(right, number)
        if isinstance(offset, t.Constant) and int(offset.value) % size:
            text = (
                f"{offset.value} bytes are not a whole number of {kind.name.partition(' TO ')[2]}"
            )
            hint = f"write a multiple of SIZEOF, {size} here"
            raise self._scope.error(text, right.at, hint)
        return t.Offset(base, offset, size, 1 if op == "+" else -1, kind)


def _target(kind: ReferenceType) -> Type:
    """Return the type that a pointer leads to.

    Raise ConsequenceError if the declaration of this type has an error, which has been reported.
    """
    if kind.target is None:
        raise ConsequenceError("the type of a pointer's target has an error")
    return kind.target


def place_of(found: t.Expression) -> t.Variable | None:
    """Return the expression if it is a variable that a pointer can lead to; None for a value."""
    part = found
    while isinstance(part, (t.Member, t.Index)):
        part = part.base
    if isinstance(part, (t.Use, t.This, t.Deref)):
        assert isinstance(found, (t.Use, t.Member, t.Index, t.This, t.Deref))
        return found
    return None


def _to(place: t.Variable, kind: str) -> t.Address:
    if isinstance(place, t.Use):
        place.symbol.addressed = True
    return t.Address(place, ReferenceType(kind, place.type))


def _is_plain(found: t.Variable) -> bool:
    return isinstance(found, (t.Use, t.Deref))
