"""The uses of names in bodies and declarations.

The types of expressions come from the checker (`ExpressionChecker`), so that a use of a name is
resolved as the compiler resolves it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

from structured_text.editor.names import LIST, Definition, Names
from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Scope
from structured_text.language.expression_checker import ExpressionChecker
from structured_text.language.objects import INIT
from structured_text.language.registry import last_name
from structured_text.language.standard import pin_name
from structured_text.language.types import (
    ArrayType,
    BlockType,
    EnumType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)

__all__ = ["READ", "WRITE", "Note", "Resolver"]

READ, WRITE = "read", "write"
#: A function that is called for each use: the definition, the name as written, and READ or WRITE.
Note = Callable[[Definition, s.Name, str], None]


class Resolver:
    """Resolves the names in the body and the declarations of a POU or method."""

    def __init__(self, scope: Scope, names: Names, note: Note) -> None:
        self.scope, self._names, self._note = scope, names, note
        self._checker = ExpressionChecker(scope)

    # --- types ---

    def kind(self, node: Any) -> Type | None:
        """Return the type of an expression; None if it has none, or an error."""
        try:
            found = self._checker.infer(node)
        except InputError:
            return None
        if isinstance(found, ReferenceType) and found.kind == "REFERENCE":
            return found.target
        return found

    def member_of(self, kind: Type | None, name: str) -> Definition | None:
        """Return the member of a type by its upper-case name; None if there is none."""
        if isinstance(kind, BlockType):
            return self._names.member(kind.name.upper(), pin_name(kind, name))
        if isinstance(kind, (EnumType, InterfaceType, StructType)):
            return self._names.member(kind.name.upper(), name)
        return None

    def named(self, key: str) -> Definition | None:
        """Return the variable, property or result that a name in upper case denotes."""
        scope, names = self.scope, self._names
        symbol = scope.symbol(key)
        block = scope.block
        pou = scope.pou
        own = names.get(f"{pou.name.upper()}.{key}")
        if symbol is None:
            # A property, or a variable that has no symbol because its type is not known.
            found = None if block is None else names.member(block.name.upper(), key)
            found = own or found
            return found if found is not None and found.kind in ("variable", "property") else None
        if own is not None and own.kind == "variable":
            return self.global_of(own)
        if symbol is pou.result:
            return names.get(pou.name.upper().removesuffix(".GET").removesuffix(".SET"))
        if block is not None and symbol.section != "VAR_EXTERNAL":
            found = names.member(block.name.upper(), key)
            if found is not None:
                return found
        if symbol.section == "VAR_EXTERNAL":
            return self._global(symbol.source or key)
        return None

    def global_of(self, found: Definition) -> Definition:
        """Return the global variable behind a VAR_EXTERNAL; any other definition unchanged."""
        if found.section is None or found.section.kind != "VAR_EXTERNAL":
            return found
        return self._global(found.name.upper()) or found

    def _global(self, key: str) -> Definition | None:
        declarations = self.scope.declarations
        for list_key, variables in declarations.lists.items():
            for name, other in variables.items():
                if other == key:
                    return self._names.get(f"{LIST}{list_key}.{name}")
        configuration = self.scope.registry.configuration
        if configuration is not None:
            found = self._names.get(f"{LIST}{configuration.node.name.key}.{key}")
            if found is not None:
                return found
        return self._names.get(key) if key in declarations.programs else None

    def called(self, callee: s.Variable) -> Definition | None:
        """Return the method or function that a call executes; None for a block's instance."""
        method = self._method(callee)
        if method is not None:
            return self._names.get(method.name.upper())
        plain = self._bare(callee)
        if not isinstance(plain, s.Name):
            return None
        if plain is callee and self.scope.symbol(plain.key) is not None:
            return None
        found = self._names.get(last_name(plain))
        return found if found is not None and found.kind == "function" else None

    def _method(self, callee: s.Variable) -> t.Pou | None:
        try:
            found = self._checker.methods.called(callee)
        except InputError:
            return None
        return None if found is None else found[1]

    def _bare(self, node: Any) -> Any:
        return self._checker.methods.bare(node)

    # --- statements ---

    def body(self, statements: Iterable[s.Statement]) -> None:
        """Note the uses in some statements."""
        for one in statements:
            self._statement(one)

    def _statement(self, node: s.Statement) -> None:
        if isinstance(node, (s.Assign, s.Latch)):
            self.expression(node.target, role=WRITE)
            self.expression(node.value, self.kind(node.target))
        elif isinstance(node, s.AssignChain):
            for target in node.targets:
                self.expression(target, role=WRITE)
            self.expression(node.value, self.kind(node.targets[0]))
        elif isinstance(node, s.CallStatement):
            self._call(node.callee, node.arguments)
        elif isinstance(node, s.If):
            for condition, body in node.branches:
                self.expression(condition)
                self.body(body)
            self.body(node.otherwise)
        elif isinstance(node, s.Case):
            self._case(node)
        elif isinstance(node, s.For):
            kind = self.kind(node.counter)
            self.expression(node.counter, role=WRITE)
            for one in (node.start, node.end, node.step):
                self.expression(one, kind)
            self.body(node.body)
        elif isinstance(node, s.While):
            self.expression(node.condition)
            self.body(node.body)
        elif isinstance(node, s.Repeat):
            self.body(node.body)
            self.expression(node.condition)
        elif isinstance(node, s.Try):
            self.body(node.body)
            self.expression(node.code, role=WRITE)
            self.body(node.handler)
            self.body(node.last)

    def _case(self, node: s.Case) -> None:
        self.expression(node.selector)
        kind = self.kind(node.selector)
        for branch in node.branches:
            for label in branch.labels:
                ends = (label.low, label.high) if isinstance(label, s.Range) else (label,)
                for one in ends:
                    self.expression(one, kind)
            self.body(branch.body)
        self.body(node.otherwise)

    # --- expressions ---

    def expression(self, node: Any, want: Type | None = None, role: str = READ) -> None:
        """Note the uses in an expression; `want` is the type that its context requires."""
        if isinstance(node, s.Name):
            self._name(node, want, role)
        elif isinstance(node, s.Field):
            self._field(node, role)
        elif isinstance(node, s.Index):
            self.expression(node.base, role=role)
            for one in node.indices:
                self.expression(one)
        elif isinstance(node, s.Part):
            self.expression(node.base, role=role)
        elif isinstance(node, s.Dereference):
            self.expression(node.base)
        elif isinstance(node, s.Literal):
            self._literal(node)
        elif isinstance(node, s.Unary):
            self.expression(node.operand, want)
        elif isinstance(node, s.Binary):
            kinds = self.kind(node.left), self.kind(node.right)
            both = [one for one in kinds if isinstance(one, EnumType)]
            self.expression(node.left, both[0] if both else want)
            self.expression(node.right, both[0] if both else want)
        elif isinstance(node, s.Call):
            self._call(node.function, node.arguments)
        elif isinstance(node, s.Invoke):
            self._call(node.callee, node.arguments)
        elif isinstance(node, s.Assigned):
            self.expression(node.target, role=WRITE)
            self.expression(node.value, self.kind(node.target))
        elif isinstance(node, s.TypeName):
            self.spec(node.spec)

    def _name(self, node: s.Name, want: Type | None, role: str) -> None:
        found = self.named(node.key)
        if found is None:
            owners = self.scope.registry.members.get(node.key, [])
            wanted = want.name.upper() if isinstance(want, EnumType) else ""
            if owners:
                owner = wanted if wanted in owners else owners[0]
                found = self._names.get(f"{owner}.{node.key}")
            else:
                found = self._names.get(last_name(node))  # a type or POU as an argument
        if found is not None:
            self._note(found, node, role)

    def _field(self, node: s.Field, role: str) -> None:
        plain = self._bare(node)
        if plain is not node:
            self._name(plain, None, role)
            return
        base = self._bare(node.base)
        if isinstance(base, s.Name) and self._qualified(base, node.name, role):
            return
        self.expression(node.base)
        found = self.member_of(self.kind(node.base), node.name.key)
        if found is not None:
            self._note(found, node.name, role)

    def _qualified(self, base: s.Name, name: s.Name, role: str) -> bool:
        """Note a variable of a list, or a member of an enumeration; return False for others."""
        declarations = self.scope.declarations
        symbol = self.scope.symbol(base.key)
        if symbol is None and name.key in declarations.lists.get(base.key, {}):
            found = self._names.get(f"{LIST}{base.key}")
            if found is not None:
                self._note(found, base, READ)
            found = self._names.get(f"{LIST}{base.key}.{name.key}")
            if found is not None:
                self._note(found, name, role)
            return True
        if symbol is not None and isinstance(symbol.type, (BlockType, StructType)):
            return False
        kind = declarations.type_named(base.key)
        if not isinstance(kind, EnumType):
            return False
        self._member(kind, base, name)
        return True

    def _member(self, kind: EnumType, written: s.Name, name: s.Name) -> None:
        """Note a type and its member, as in `Colour#RED`."""
        owner = self._names.get(last_name(written))
        member = self.member_of(kind, name.key)
        if owner is not None:
            self._note(owner, written, READ)
        if member is not None:
            self._note(member, name, READ)

    def _literal(self, node: s.Literal) -> None:
        prefix, sign, rest = node.text.partition("#")
        if not sign or not prefix:
            return
        kind = self.scope.declarations.type_named(prefix.upper())
        name = rest.lstrip()
        line, column = node.at
        if isinstance(kind, EnumType):
            at = s.Position(line, column + len(node.text) - len(name))
            self._member(kind, s.Name(prefix, node.at), s.Name(name, at))

    def _call(self, callee: Any, arguments: Sequence[s.Argument]) -> None:
        found = self.called(callee)
        kind = None
        if found is None:
            self.expression(callee)
            kind = self.kind(callee)
            owner = kind.name.upper() if isinstance(kind, BlockType) else ""
        else:
            name = callee.name if isinstance(callee, s.Field) else callee
            self._note(found, name, READ)
            if isinstance(callee, s.Field) and self._bare(callee) is callee:
                self.expression(callee.base)
            owner = found.key
        self.arguments(owner, kind, arguments)

    def arguments(self, owner: str, kind: Type | None, given: Sequence[s.Argument]) -> None:
        """Note the uses in the arguments of a call; `owner` is the key of what is called."""
        types = self.pin_types(owner, kind)
        for place, one in enumerate(given):
            want = None
            if one.name is not None:
                key = pin_name(kind, one.name.key) if isinstance(kind, BlockType) else one.name.key
                found = self._names.member(owner, key) if owner else None
                want = types.get(key)
                if found is not None:
                    self._note(found, one.name, READ if one.output else WRITE)
            elif place < len(types):
                want = [*types.values()][place]
            self.expression(one.value, want, WRITE if one.output else READ)

    def pin_types(self, owner: str, kind: Type | None) -> dict[str, Type]:
        """Return the types of the inputs, in-outs and outputs of what is called."""
        if isinstance(kind, BlockType):
            pins = {one.name.upper(): (one.section, one.type) for one in kind.variables}
        else:
            pou = self.scope.declarations.pous.get(owner)
            symbols = pou.symbols if pou is not None else {}
            pins = {key: (one.section, one.type) for key, one in symbols.items()}
        order = ("VAR_INPUT", "VAR_IN_OUT", "VAR_OUTPUT")
        found = {key: of for key, (section, of) in pins.items() if section in order[:2]}
        return found | {key: of for key, (section, of) in pins.items() if section == order[2]}

    # --- declarations ---

    def declared(self, node: s.VarDecl) -> None:
        """Note the uses in the declaration of a variable or field."""
        self.spec(node.spec)
        if node.initial is not None:
            self.initial(node.initial, self._declared_type(node))

    def _declared_type(self, node: s.VarDecl) -> Type | None:
        symbol = self.scope.pou.symbols.get(node.names[0].key)
        if symbol is not None:
            return symbol.type
        try:
            return self.scope.declarations.resolve(node.spec, self.scope.where)[0]
        except InputError:
            return None

    def spec(self, spec: Any) -> None:
        """Note the uses in a type as it is written."""
        if isinstance(spec, s.NamedSpec):
            found = self._names.get(last_name(spec.name))
            if found is not None:
                self._note(found, spec.name, READ)
            self.expression(spec.length)
            for one in spec.generics:
                self.expression(one)
            starter = self._names.member(last_name(spec.name), INIT.upper())
            self.arguments(starter.key if starter is not None else "", None, spec.arguments)
        elif isinstance(spec, s.SubrangeSpec):
            self.spec(spec.base)
            self.expression(spec.low)
            self.expression(spec.high)
        elif isinstance(spec, s.ArraySpec):
            for bounds in spec.dimensions:
                self.expression(bounds.low)
                self.expression(bounds.high)
            self.spec(spec.element)
        elif isinstance(spec, s.PointerSpec):
            self.spec(spec.target)
        elif isinstance(spec, s.EnumSpec):
            self.spec(spec.base)
            for value in spec.values:
                self.expression(value)
        elif isinstance(spec, s.StructSpec):
            for field in spec.fields:
                self.declared(field)

    def initial(self, node: Any, kind: Type | None) -> None:
        """Note the uses in an initial value of a type."""
        if isinstance(node, (s.ArrayInit, s.Sequence)):
            element = kind.element if isinstance(kind, ArrayType) else kind
            for count, value in node.items:
                self.expression(count)
                self.initial(value, element)
        elif isinstance(node, s.StructInit):
            fields: dict[str, Type] = {}
            if isinstance(kind, StructType):
                fields = {name.upper(): of for name, of in kind.fields}
            elif isinstance(kind, BlockType):
                fields = {one.name.upper(): one.type for one in kind.variables}
            for name, value in node.fields:
                found = self.member_of(kind, name.key)
                if found is not None:
                    self._note(found, name, READ)
                self.initial(value, fields.get(name.key))
        else:
            self.expression(node, kind)
