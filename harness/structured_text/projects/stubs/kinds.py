"""Classification of missing names: block, structure, enumeration, function or list."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from structured_text.language import syntax as s
from structured_text.language.objects import INIT
from structured_text.language.walk import nodes
from structured_text.projects.missing import simple_type
from structured_text.projects.stubs.model import (
    ALIAS,
    BLOCK,
    ENUM,
    FUNCTION,
    INTERFACE,
    LIST,
    NAMESPACE,
    STRUCT,
    Stub,
)

__all__ = ["Mentions"]

_BLOCK_NAME = re.compile("FB" + "_", re.IGNORECASE)
_INTERFACE_NAME = re.compile(r"I_[A-Z]\w*|I[A-Z][a-z]\w*|IT[A-Z]\w*")
_ENUM_NAME = re.compile(r"E_\w+|E[A-Z][a-z]\w*")
_STRUCT_NAME = re.compile(r"ST_|T_|S[A-Z][a-z]")
_TYPE_OF_LITERAL = {
    "INTEGER": "DINT",
    "REALNUM": "LREAL",
    "STRING": "STRING(255)",
    "BOOLEAN": "BOOL",
}


class Mentions:
    """The uses of missing names.

    Names are compared as text, because the types are not known yet.
    """

    def __init__(self, sources: Iterable[s.Source]) -> None:
        self._types: dict[str, set[str]] = {}
        self._spelled: dict[str, str] = {}
        self._bases: dict[str, str] = {}
        self._fields: dict[str, list[tuple[s.Name, s.Init]]] = {}
        self._called: set[str] = set()
        self._functions: set[str] = set()
        self._asked: set[str] = set()
        self._members: dict[str, dict[str, str]] = {}
        self._initial: dict[str, str] = {}
        self._started: dict[str, list[tuple[s.Argument, ...]]] = {}
        self._values: dict[str, list[tuple[s.Name, str]]] = {}
        self._interfaces: set[str] = set()
        for source in sources:
            for node in nodes(source.declarations, names=True):
                self._note(node)

    def _note(self, node: object) -> None:
        if isinstance(node, s.VarDecl):
            if isinstance(node.initial, s.Field):
                wanted = next((one.text for one in _named(node.spec)), "")
                values = self._values.setdefault(_last(node.initial.base), [])
                values.append((node.initial.name, wanted))
            for kind in _named(node.spec):
                key = kind.key.rpartition(".")[2]
                self._types.setdefault(key, set()).update(one.key for one in node.names)
                for value in _structures(node.initial):
                    self._fields.setdefault(key, []).extend(value.fields)
                if isinstance(node.initial, s.Literal):
                    self._initial.setdefault(key, _TYPE_OF_LITERAL.get(node.initial.kind, ""))
        elif isinstance(node, s.NamedSpec) and node.arguments:
            key = node.name.key.rpartition(".")[2]
            self._started.setdefault(key, []).append(node.arguments)
        elif isinstance(node, (s.Pou, s.TypeDecl)) and node.extends is not None:
            base = BLOCK if isinstance(node, s.Pou) else STRUCT
            self._bases.setdefault(node.extends.key.rpartition(".")[2], base)
        elif isinstance(node, s.Interface):
            self._interfaces.update(one.key.rpartition(".")[2] for one in node.extends)
        elif isinstance(node, s.CallStatement):
            self._called.add(_last(node.callee))
            self._functions.add(_last(node.callee))
            self._ask(node.callee)
        elif isinstance(node, s.Invoke):
            self._ask(node.callee)
            self._functions.add(_last(node.callee))
        elif isinstance(node, s.Call):
            self._functions.add(node.function.key)
        elif isinstance(node, s.Field):
            found = self._members.setdefault(_last(node.base), {})
            found.setdefault(node.name.key, node.name.text)
        if isinstance(node, s.Pou):
            self._interfaces.update(one.key.rpartition(".")[2] for one in node.implements)

    def _ask(self, callee: s.Variable) -> None:
        if isinstance(callee, s.Field):
            self._asked.add(_last(callee.base))

    def type_stub(self, name: str) -> Stub:
        """Return the stub of a missing type, with the members that the program initialises."""
        stub = self._type_stub(name)
        for field, value in self._fields.get(name.upper(), ()):
            if stub.kind == ALIAS:
                stub.kind = STRUCT
            pin = stub.input(field.text) if stub.kind == BLOCK else stub.output(field.text)
            if isinstance(value, s.Literal):
                pin.note(_TYPE_OF_LITERAL.get(value.kind, ""), given=True)
        if stub.kind == ENUM:
            for member in self._members.get(name.upper(), {}).values():
                stub.output(member)
        if stub.kind == BLOCK:
            self._start(stub)
        return stub

    def _start(self, stub: Stub) -> None:
        """Add an `INIT` method if declarations of the block pass arguments."""
        for arguments in self._started.get(stub.name.upper(), ()):
            method = stub.method(INIT)
            method.used = True
            method.result.note("BOOL", given=True)
            for name in ("bInitRetains", "bInCopyCode"):
                method.input(name).note("BOOL", given=True)
            for number, one in enumerate(arguments, 1):
                pin = method.input(one.name.text if one.name is not None else f"Argument{number}")
                if isinstance(one.value, s.Literal):
                    pin.note(_TYPE_OF_LITERAL.get(one.value.kind, ""), given=True)

    def _type_stub(self, name: str) -> Stub:
        key = name.upper()
        variables = self._types.get(key, set())
        alias = simple_type(name)
        if alias:
            return Stub(name, ALIAS, base=alias)
        if key in self._interfaces:
            return Stub(name, INTERFACE)
        if key in self._started:
            return Stub(name, BLOCK)
        if key in self._bases:
            return Stub(name, self._bases[key])
        if _BLOCK_NAME.match(name) or variables & self._called:
            return Stub(name, BLOCK)
        if _INTERFACE_NAME.fullmatch(name):
            return Stub(name, INTERFACE)
        if variables & self._asked:
            return Stub(name, BLOCK)
        if _ENUM_NAME.fullmatch(name) or key in self._members:
            return Stub(name, ENUM)
        if any(self._members.get(one) for one in variables):
            return Stub(name, STRUCT)
        if self._initial.get(key):
            return Stub(name, ALIAS, base=self._initial[key])
        return Stub(name, STRUCT if _STRUCT_NAME.match(name) else ALIAS)

    def name_stub(self, name: str) -> Stub:
        """Return the stub of an undeclared name before a dot: an enumeration or a global list."""
        stub = Stub(name, ENUM if name.upper() in self._types else LIST)
        for member, kind in self._values.get(name.upper(), ()):
            stub.output(member.text).note(kind if stub.kind == LIST else "", given=False)
        return stub

    def is_base(self, name: str) -> bool:
        """Return whether the program uses a member of this name, as in `Name.Member`."""
        return bool(self._members.get(name.upper()))

    def is_called(self, name: str) -> bool:
        """Return whether the program calls this name as a function."""
        return name.upper() in self._functions

    def function_stub(self, name: str) -> Stub:
        """Return the stub of a missing function."""
        return Stub(name, FUNCTION)

    def space_stub(self, name: str) -> Stub:
        """Return the stub of a namespace."""
        return Stub(name, NAMESPACE)


def _structures(value: object) -> Iterator[s.StructInit]:
    """Yield the initial values of a structure, or of the structures in an array."""
    if isinstance(value, s.StructInit):
        yield value
    elif isinstance(value, s.ArrayInit):
        for _, item in value.items:
            yield from _structures(item)


def _named(spec: s.TypeSpec) -> Iterator[s.Name]:
    """Yield the names of the types inside a specification."""
    if isinstance(spec, s.NamedSpec):
        yield spec.name
    elif isinstance(spec, s.ArraySpec):
        yield from _named(spec.element)
    elif isinstance(spec, s.PointerSpec):
        yield from _named(spec.target)


def _last(node: object) -> str:
    """Return the last name in a variable with members: `c` for `a.b[1].c^`."""
    while isinstance(node, (s.Index, s.Dereference, s.Part)):
        node = node.base
    if isinstance(node, s.Field):
        return node.name.key
    return node.key if isinstance(node, s.Name) else ""
