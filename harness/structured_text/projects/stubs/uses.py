"""The uses of missing elements in the bodies of a program, with the types around them."""

from __future__ import annotations

import re
from collections.abc import Iterable, MutableMapping, Sequence

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.declare import Scope
from structured_text.language.expression_checker import ExpressionChecker
from structured_text.language.standard import FUNCTIONS
from structured_text.language.types import (
    BlockType,
    ElementaryType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)
from structured_text.projects.missing import libraries_of
from structured_text.projects.stubs.model import (
    BLOCK,
    CONSTANT,
    ENUM,
    FUNCTION,
    INTERFACE,
    LIST,
    STRUCT,
    Pin,
    Stub,
    type_text,
)

__all__ = ["Uses"]

#: The bounds of an inferred array; uses of its elements do not show the real bounds.
_BOUNDS = "0..255"
_LITERALS = {"INTEGER": "", "REALNUM": "LREAL", "STRING": "STRING(255)", "BOOLEAN": "BOOL"}
_OPERATOR = re.compile(
    r"ADR|ADRINST|BITADR|SIZEOF|XSIZEOF|INDEXOF|REF|INI|NEW|DELETE|__\w+|(\w+_)?TO_\w+|TRUNC\w*"
)
_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")


class Uses:
    """Collects the uses of stubs in one body."""

    def __init__(self, scope: Scope, stubs: MutableMapping[str, Stub]) -> None:
        self._scope, self._stubs = scope, stubs
        self._checker = ExpressionChecker(scope)
        self._above = self._base()

    def note(self, body: Iterable[s.Statement]) -> None:
        """Note the uses of stubs in some statements."""
        for one in body:
            self._statement(one)

    # --- statements ---

    def _statement(self, node: s.Statement) -> None:
        if isinstance(node, (s.Assign, s.Latch)):
            self._assigned([node.target], node.value)
        elif isinstance(node, s.AssignChain):
            self._assigned(node.targets, node.value)
        elif isinstance(node, s.CallStatement):
            self._call(node.callee, node.arguments, None, used=False)
        elif isinstance(node, s.If):
            for condition, body in node.branches:
                self._read(condition, "BOOL")
                self.note(body)
            self.note(node.otherwise)
        elif isinstance(node, s.Case):
            self._read(node.selector, "")
            kind = self._text(node.selector)
            for branch in node.branches:
                for label in branch.labels:
                    if not isinstance(label, s.Range):
                        self._read(label, kind)
                self.note(branch.body)
            self.note(node.otherwise)
        elif isinstance(node, s.For):
            kind = self._text(node.counter)
            for one in (node.start, node.end, node.step):
                if one is not None:
                    self._read(one, kind)
            self.note(node.body)
        elif isinstance(node, (s.While, s.Repeat)):
            self._read(node.condition, "BOOL")
            self.note(node.body)

    def _assigned(self, targets: Sequence[s.Variable], value: s.Expression) -> None:
        for target in targets:
            self._read(value, self._text(target))
            self._written(target, self._text(value))

    def _written(self, target: s.Variable, kind: str) -> None:
        """Note that a value of this type is assigned to a variable."""
        if isinstance(target, s.Field):
            stub = self._owner(target.base, target.name.key)
            if stub is not None:
                written = stub.input if stub.kind in (BLOCK, INTERFACE) else stub.output
                written(target.name.text).note(kind, given=True)
            self._read(target.base, "")
        elif isinstance(target, (s.Index, s.Dereference)):
            self._inside(target, kind)
        elif isinstance(target, s.Part):
            self._read(target.base, "")
        elif isinstance(target, s.Name) and self._above is not None and not self._known(target):
            self._above.output(target.text).note(kind, given=True)

    # --- calls ---

    def _call(
        self,
        callee: s.Variable,
        arguments: Sequence[s.Argument],
        want: str | None,
        *,
        used: bool,
    ) -> None:
        stub = self._callee(callee)
        if stub is None:
            pins = self._pins(callee)
            for one in arguments:
                kind = pins.get(one.name.key, "") if one.name is not None else ""
                if one.output:
                    self._written_by_call(one.value)
                else:
                    self._read(one.value, kind)
        else:
            stub.used = stub.used or used
            if want:
                stub.result.note(want, given=False)
            mixed = any(one.name is None for one in arguments)
            for number, one in enumerate(arguments, 1):
                pin = self._argument(stub, one, number)
                if mixed and one.name is not None and not one.output and pin is not None:
                    pin.place = number
        if isinstance(callee, s.Field):
            self._read(callee.base, "")

    def _written_by_call(self, node: s.Expression) -> None:
        if isinstance(node, (s.Name, s.Field, s.Index, s.Dereference)):
            self._written(node, "")

    def _argument(self, stub: Stub, one: s.Argument, number: int) -> Pin | None:
        """Note an argument in a call of a stub; return the pin if the argument is an input."""
        name = one.name.text if one.name is not None else f"P{number}"
        if one.output:
            stub.output(name).note(self._text(one.value), given=False)
            self._written_by_call(one.value)
            return None
        kind = self._infer(one.value)
        if isinstance(kind, BlockType):
            stub.in_out(name).note(type_text(kind), given=True)
        else:
            stub.input(name).note(self._text(one.value), given=True)
        self._read(one.value, "")
        return stub.inputs.get(name.upper())

    def _callee(self, callee: s.Variable) -> Stub | None:
        """Return the stub of a block, method or function that is called."""
        if isinstance(callee, s.Name):
            found = self._stubs.get(callee.key)
            if found is not None and not self._known(callee):
                if self._above is None or found.kind != FUNCTION or libraries_of(callee.key):
                    return found
                # The name is more likely a method of the missing base block than a function.
                del self._stubs[callee.key]
                return self._above.method(callee.text)
            if self._known(callee):
                kind = self._infer(callee)
                return self._stub_of(kind) if isinstance(kind, BlockType) else None
            if self._above is not None and not self._is_callable(callee):
                return self._above.method(callee.text)
            return None
        if isinstance(callee, s.Field):
            owner = self._owner(callee.base, callee.name.key, BLOCK)
            if owner is not None and owner.kind in (BLOCK, INTERFACE):
                return owner.method(callee.name.text)
            if owner is None and isinstance(callee.base, s.Name):
                found = self._stubs.get(callee.name.key)
                if found is not None and not self._known(callee.base):
                    return found
        kind = self._infer(callee) if not isinstance(callee, s.This) else None
        return self._stub_of(kind) if isinstance(kind, BlockType) else None

    def _is_callable(self, callee: s.Name) -> bool:
        """Return whether the sources have a function or method of this name."""
        declarations = self._scope.declarations
        block = self._scope.block
        if callee.key in declarations.pous or callee.key in FUNCTIONS:
            return True
        if _OPERATOR.fullmatch(callee.key) or libraries_of(callee.key):
            return True
        return block is not None and self._has(block.block, callee.key)

    def _has(self, kind: Type | None, key: str) -> bool:
        """Return whether a block declares a variable, method or property of this name."""
        objects = self._scope.declarations.objects
        variables = kind.variables if isinstance(kind, BlockType) else ()
        return (
            any(one.name.upper() == key for one in variables)
            or objects.method(kind, key) is not None
            or objects.is_property(kind, key)
        )

    def _pins(self, callee: s.Variable) -> dict[str, str]:
        """Return the types of the pins of a known block or function."""
        kind = self._infer(callee)
        if isinstance(kind, BlockType):
            return {one.name.upper(): type_text(one.type) for one in kind.variables}
        pou = self._scope.declarations.pous.get(getattr(callee, "key", ""))
        symbols = pou.symbols.values() if pou is not None else ()
        return {one.name.upper(): type_text(one.type) for one in symbols}

    # --- expressions ---

    def _read(self, node: s.Expression, want: str) -> None:
        """Note the stubs in an expression that must have a value of the given type."""
        if isinstance(node, s.Field):
            stub = self._owner(node.base, node.name.key)
            if stub is not None:
                stub.output(node.name.text).note(want, given=False)
            self._read(node.base, "")
        elif isinstance(node, s.Call):
            if node.function.key == "ADR" or node.function.key == "SIZEOF":
                want = ""
            self._call(node.function, node.arguments, want, used=True)
        elif isinstance(node, s.Invoke):
            self._call(node.callee, node.arguments, want, used=True)
        elif isinstance(node, s.Unary):
            self._read(node.operand, want or ("BOOL" if node.op == "NOT" else ""))
        elif isinstance(node, s.Binary):
            self._operands(node, want)
        elif isinstance(node, (s.Index, s.Dereference)):
            self._inside(node, want)
        elif isinstance(node, s.Part):
            self._read(node.base, "")
        elif isinstance(node, s.Name) and node.key in self._stubs:
            if self._stubs[node.key].kind == CONSTANT:
                self._stubs[node.key].result.note(want, given=False)
        elif isinstance(node, s.Name) and self._is_inherited(node):
            assert self._above is not None
            self._above.output(node.text).note(want, given=False)

    def _inside(self, node: s.Index | s.Dereference, kind: str) -> None:
        """Note an array or pointer by the type of its element or target."""
        if isinstance(node, s.Dereference):
            self._read(node.base, f"POINTER TO {kind or 'BYTE'}")
            return
        for index in node.indices:
            self._read(index, "DINT")
        bounds = ", ".join([_BOUNDS] * len(node.indices))
        self._read(node.base, f"ARRAY [{bounds}] OF {kind or 'DINT'}")

    def _is_inherited(self, node: s.Name) -> bool:
        """Return whether an unknown name may be a variable of a stub that the block extends."""
        if self._above is None or self._known(node) or libraries_of(node.key):
            return False
        return not self._scope.registry.members.get(node.key)

    def _operands(self, node: s.Binary, want: str) -> None:
        if node.op in _COMPARISONS:
            self._read(node.left, self._text(node.right))
            self._read(node.right, self._text(node.left))
        else:
            boolean = node.op in ("AND", "OR", "XOR", "AND_THEN", "OR_ELSE")
            default = want or ("BOOL" if boolean else "")
            self._read(node.left, self._text(node.right) or default)
            self._read(node.right, self._text(node.left) or default)

    # --- types ---

    def _infer(self, node: s.Expression) -> Type | None:
        """Return the type of an expression, as far as it is known."""
        try:
            kind = self._checker.infer(node)
        except InputError:
            return None
        while isinstance(kind, ReferenceType) and kind.kind != "POINTER":
            kind = kind.target
        return kind

    def _text(self, node: s.Expression) -> str:
        if isinstance(node, s.Literal) and node.kind in _LITERALS:
            return _LITERALS[node.kind]
        return type_text(self._infer(node))

    def _stub_of(self, kind: Type | None) -> Stub | None:
        if isinstance(kind, (BlockType, StructType, InterfaceType)):
            return self._stubs.get(kind.name.upper())
        return None

    def _owner(self, base: s.Expression, member: str, nested: str = STRUCT) -> Stub | None:
        """Return the stub that declares a member of a variable; it may be a missing base block."""
        if isinstance(base, s.Name) and not self._known(base):
            found = self._stubs.get(base.key)
            if found is not None and found.kind in (ENUM, LIST):
                return found
            if self._above is not None and self._is_inherited(base):
                return self._nested(self._above, base, nested)
            return None
        if isinstance(base, s.This) and base.above:
            return self._above
        if isinstance(base, s.Field) and isinstance(base.base, s.Name):
            space, name = self._stubs.get(base.base.key), self._stubs.get(base.name.key)
            if space is not None and name is not None and not self._known(base.base):
                return name if name.kind in (ENUM, LIST) else None
        kind = self._infer(base)
        found = self._stub_of(kind)
        if isinstance(base, s.Field) and (kind is None or isinstance(kind, ElementaryType)):
            owner = self._owner(base.base, base.name.key)
            if owner is not None and owner.kind != ENUM:
                return self._nested(owner, base.name, nested)
        if found is None and isinstance(kind, BlockType) and not self._has(kind, member):
            found = self._extended(kind.name.upper())
        return found

    def _nested(self, owner: Stub, member: s.Name, kind: str) -> Stub | None:
        """Return the stub of the type of a stub's member, if this member has members itself."""
        pin = owner.output(member.text)
        if pin.given or pin.wanted:
            return self._stubs.get(pin.given[0].upper()) if pin.given else None
        name = f"{owner.name}_{member.text}"
        pin.note(name, given=True)
        return self._stubs.setdefault(name.upper(), Stub(name, kind))

    def _known(self, name: s.Name) -> bool:
        return self._checker.is_variable(name)

    def _base(self) -> Stub | None:
        """Return the stub that the block of this body extends, directly or indirectly, or None."""
        block = self._scope.block
        return self._extended(block.name.upper()) if block is not None else None

    def _extended(self, key: str) -> Stub | None:
        """Return the stub that a block extends, directly or indirectly, or None."""
        extended = self._scope.declarations.objects.extended
        seen = set()
        while key in extended and key not in seen:
            seen.add(key)
            key = extended[key]
            if key in self._stubs:
                return self._stubs[key]
        return None
