"""Python code for methods, THIS^, pointers and references in expressions.

A pointer is an object with the value `V` (see `references`): `Slot` for a scalar attribute, `Item`
for an element of a list, `Whole` for a structure, block or array. A Python function cannot assign
to a variable of its caller. Therefore a function returns its outputs and scalar VAR_IN_OUT in a
tuple, and the code of the call stores them in their targets.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from structured_text.engines.builtin.objects import attribute, handed_back
from structured_text.engines.builtin.storage import Storage, is_scalar, slot_name
from structured_text.language import tree as t
from structured_text.language.types import ArrayType, InterfaceType, ReferenceType, Type
from structured_text.language.walk import nodes

__all__ = ["POINTING", "Pointing", "has_effect"]

#: The types of expressions that this module translates.
POINTING = (
    t.This,
    t.CallMethod,
    t.Deref,
    t.Address,
    t.Offset,
    t.Recast,
    t.Null,
    t.Valid,
    t.Same,
    t.Generic,
    t.Query,
    t.New,
    t.Delete,
)


class _Code(Protocol):
    """The part of `ExpressionCode` that `Pointing` uses."""

    def is_local(self, symbol: t.Symbol) -> bool:
        """Return whether a variable lasts for one call only."""

    def variable(self, node: t.Variable) -> str:
        """Return the Python code of a variable, member or element."""

    def position(self, node: t.Index) -> str:
        """Return the Python code of the position of an element."""

    def elements(self, node: t.Index) -> str:
        """Return the Python code of the list that contains an element of an array."""

    def adapted(self, code: str, kind: Type, to: Type) -> str:
        """Return the Python code that adapts an output to the type of its target."""

    def given(self, variable: t.Variable, pin: Type) -> str:
        """Return the Python code of the argument for a VAR_IN_OUT."""

    def exact(self, node: t.Expression) -> str:
        """Return the Python code of an expression; its value is wrapped or rounded to its type."""


class Pointing:
    """The writer of method calls, pointers and references in one POU.

    `views` is true if pointers of the project access memory as another type. `made` lists the types
    of the variables that `__NEW` makes.

    Attributes:
        storage: Writer of copies of structures and arrays; set by the writer of statements.
    """

    def __init__(self, code: _Code, *, views: bool = False, made: Sequence[Type] = ()) -> None:
        self._code = code
        self._number = list(made).index
        self._views = views
        self._names = 0
        self.storage = Storage()

    def variable(self, node: t.Variable) -> str:
        """Return the Python code of a variable; the code of `pointer^` can also be assigned to."""
        if isinstance(node, t.This):
            return "s"
        if isinstance(node, t.Deref):
            return f"{self._pointer(node)}.V"
        assert isinstance(node, t.CallMethod)
        return self.call(node)

    def fixed(self, node: t.Variable, temporary: Callable[[str], str]) -> str:
        """Return the Python code of a variable and evaluate its pointer once, in a temporary.

        A VAR_IN_OUT is read before the call and written after it; both must use the same pointer.
        """
        if isinstance(node, t.Deref):
            return f"{temporary(self._pointer(node))}.V"
        return self.variable(node)

    def _pointer(self, node: t.Deref) -> str:
        base = self._code.exact(node.base)
        return base if node.offset is None else f"{base}.at({self._code.exact(node.offset)})"

    def value(self, node: t.Expression) -> str:
        """Return the Python code of a method call, pointer or reference."""
        if isinstance(node, (t.This, t.CallMethod, t.Deref)):
            return self.variable(node)
        if isinstance(node, t.Address):
            return self.address(node.variable)
        if isinstance(node, t.Null):
            return "no_block" if isinstance(node.type, InterfaceType) else "null"
        if isinstance(node, t.Valid):
            return self._valid(node.reference)
        if isinstance(node, t.Offset):
            sign = "-" if node.sign < 0 else ""
            moved = f"{sign}{self._code.exact(node.bytes)}, {node.size}"
            return f"{self._code.exact(node.base)}.moved({moved})"
        if isinstance(node, t.Recast):
            own, other = self._layout(node.base.type), self._layout(node.type)
            return f"recast({self._code.exact(node.base)}, {own}, {other})"
        if isinstance(node, t.Generic):
            values = (repr(node.number), self._code.exact(node.pointer), repr(node.size))
            return self.storage.made(node.type, values)
        if isinstance(node, t.Query):
            return self._query(node)
        if isinstance(node, t.New):
            created = self.storage.create(node.made, node.initial)
            if node.count is not None:
                count = self._code.exact(node.count)
                return f"heap_row(g, {self._number(node.made)}, {count}, lambda: {created})"
            in_list = is_scalar(node.made) or isinstance(node.made, ArrayType)
            held = f"[{created}]" if in_list else created
            return f"heap_new(g, {held}, {self._number(node.made)})"
        if isinstance(node, t.Delete):
            return self._delete(node.pointer)
        assert isinstance(node, t.Same)
        left, right = self._code.exact(node.left), self._code.exact(node.right)
        if isinstance(node.left.type, InterfaceType) or "null" in (left, right):
            return f"({left} {'is' if node.op == '=' else 'is not'} {right})"
        if self._views or node.op not in ("=", "<>"):
            given = f"{left}, {right}, {self._layout(node.left.type)}"
            if node.op in ("=", "<>"):
                return f"({'not ' if node.op == '=' else ''}unlike({given}))"
            return f"(order({given}) {node.op} 0)"
        return f"({'' if node.op == '=' else 'not '}same({left}, {right}))"

    def _valid(self, node: t.Expression) -> str:
        """Return code of `__ISVALIDREF`.

        A method may use a VAR_IN_OUT of its block before the first call of the block has passed a
        variable. In that case `__ISVALIDREF` is FALSE. A VAR_IN_OUT in any other place is always
        valid.
        """
        if isinstance(node.type, ReferenceType):
            return f"({self._code.exact(node)} is not null)"
        assert isinstance(node, t.Use)
        if self._code.is_local(node.symbol):
            return "True"
        return f"(s.{slot_name(node.symbol.name)} is not uncalled)"

    def _delete(self, pointer: t.Variable | t.Address) -> str:
        """Return the code of `__DELETE`, which frees a variable and sets the pointer to 0."""
        if isinstance(pointer, t.Address):
            return f"heap_delete(g, {self._code.exact(pointer)})"
        before: list[str] = []
        place = self._place(pointer, before)
        gone = f"heap_delete(g, {_read(place)})"
        return f"({', '.join([*before, gone, self._write(place, pointer, 'null')])})[-1]"

    def _query(self, node: t.Query) -> str:
        """Return code that queries another interface of a block and stores the result."""
        before: list[str] = []
        name, names = self._name(), frozenset(f"b_{block}" for block in node.blocks)
        target = self._place(node.target, before)
        found = f"asked({self._code.exact(node.source)}, {set(names) or '()'})"
        pointer = isinstance(node.target.type, ReferenceType)
        value = f"(null if {name} is no_block else Whole({name}))" if pointer else name
        stored = self._write(target, node.target, value)
        parts = [*before, f"({name} := {found})", stored, f"{name} is not no_block"]
        return f"({', '.join(parts)})[-1]"

    def _layout(self, kind: Type) -> str:
        """Return the name of the layout (`byte_views`) of a pointer's target."""
        assert isinstance(kind, ReferenceType)
        assert kind.target is not None
        return self.storage.layout(kind.target)

    def address(self, node: t.Variable) -> str:
        """Return the Python code of a pointer to a variable."""
        if isinstance(node, t.Deref):
            return self._pointer(node)
        if isinstance(node, t.Index):
            return f"Item({self._code.elements(node)}, {self._code.position(node)})"
        if not is_scalar(node.type):
            return f"Whole({self._code.variable(node)})"
        if isinstance(node, t.Use) and self._code.variable(node).endswith("[0]"):
            return f"Item({self._code.variable(node)[:-3]}, 0)"
        holder, _, slot = self._code.variable(node).rpartition(".")
        return f"Slot({holder}, {slot!r})"

    # --- calls ---

    def call(self, node: t.CallMethod) -> str:
        """Return the code of a method call; with outputs it is a tuple with the result last."""
        method = node.method
        instance = self._code.exact(node.instance)
        before: list[str] = []
        arguments = ["None" if one is None else self._code.exact(one) for one in node.arguments]
        targets = {name.upper(): variable for name, variable in (*node.outputs, *node.in_outs)}
        places: dict[str, tuple[str, str]] = {}
        for name, variable in node.in_outs:
            if is_scalar(variable.type):
                places[name.upper()] = place = self._place(variable, before)
                arguments.append(_read(place))
            else:
                arguments.append(self._code.given(variable, method.symbols[name.upper()].type))
        if node.final:
            owner = slot_name(method.name)
            call = f"f_{owner}({', '.join([instance, *arguments])})"
        else:
            key = method.name.partition(".")[2].upper()
            call = f"{instance}.{attribute(key)}({', '.join(arguments)})"
        more = handed_back(method)
        if not more:
            return call
        result = self._name()
        after: list[str] = []
        for number, symbol in enumerate(more, start=1):
            target = targets.get(symbol.name.upper())
            if target is not None:
                place = places.get(symbol.name.upper()) or self._place(target, after)
                value = self._code.adapted(f"{result}[{number}]", symbol.type, target.type)
                after.append(self._write(place, target, value))
        parts = [*before, f"({result} := {call})", *after, f"{result}[0]"]
        return f"({', '.join(parts)})[-1]"

    def _name(self) -> str:
        self._names += 1
        return f"m{self._names}"

    def _place(self, node: t.Variable, before: list[str]) -> tuple[str, str]:
        """Return code for the object or list of a variable, and for its name or position in it.

        Both are evaluated only once, by code that is appended to `before`. For a Python local the
        first code is empty.
        """
        code = self._code
        if isinstance(node, t.Index):
            return self._once(code.elements(node), before), self._once(code.position(node), before)
        if isinstance(node, t.Deref):
            return self._once(self._pointer(node), before), "'V'"
        if isinstance(node, t.Use) and code.variable(node).endswith("[0]"):
            return code.variable(node)[:-3], "0"
        if isinstance(node, t.Use) and code.is_local(node.symbol):
            return "", slot_name(node.symbol.name)
        holder, _, slot = code.variable(node).rpartition(".")
        return self._once(holder, before), repr(slot)

    def _once(self, code: str, before: list[str]) -> str:
        if code.isidentifier() or code.isdigit():
            return code
        name = self._name()
        before.append(f"({name} := {code})")
        return name

    def _write(self, place: tuple[str, str], variable: t.Variable, value: str) -> str:
        holder, key = place
        if not is_scalar(variable.type):
            return self.storage.copied(variable.type, self._code.variable(variable), value)
        if not holder:
            return f"({key} := {value})"
        if key.startswith("'"):
            return f"setattr({holder}, {key}, {value})"
        return f"{holder}.__setitem__({key}, {value})"


def _read(place: tuple[str, str]) -> str:
    holder, key = place
    if not holder:
        return key
    return f"{holder}.{key[1:-1]}" if key.startswith("'") else f"{holder}[{key}]"


#: Expressions that have an effect, or can stop the program when they are evaluated.
_EFFECTS = (t.CallMethod, t.Deref, t.Assigned, t.Query, t.New)


def has_effect(node: t.Expression) -> bool:
    """Return whether an operand must be evaluated: it has an effect, or it follows a pointer."""
    return any(isinstance(one, _EFFECTS) for one in nodes(node))
