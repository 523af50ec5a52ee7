"""Initial values that are assigned when a program or call starts, for example pointers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.declare import Scope
from structured_text.language.methods import NOTHING
from structured_text.language.objects import INIT
from structured_text.language.registry import ConsequenceError
from structured_text.language.types import BlockType, InterfaceType, ReferenceType, Type
from structured_text.language.walk import declared as declared_in

__all__ = ["Start", "instance_sections", "start_calls", "start_of", "starting"]

_NO_EXPRESSION = (s.ArrayInit, s.StructInit, s.Sequence)


@dataclass(frozen=True)
class Start:
    """A block whose declaration has arguments for its `INIT`."""

    name: s.Name
    arguments: tuple[s.Argument, ...]
    at: s.Position


def starting(sections: Iterable[s.Section], scope: Scope) -> Iterator[s.Assign | s.Latch | Start]:
    """Yield assignments of those initial values of a POU that are not constant."""
    for section in sections:
        # A VAR_INST gets its value at the start of its block: see `instance_sections`.
        if section.kind in ("VAR_IN_OUT", "VAR_EXTERNAL", "VAR_INST"):
            continue
        for variable in section.variables:
            for name in variable.names:
                symbol = scope.symbol(name.key)
                if symbol is not None:
                    yield from _one(variable, name, symbol, section)


def _one(
    variable: s.VarDecl, name: s.Name, symbol: t.Symbol, section: s.Section
) -> Iterator[s.Assign | s.Latch | Start]:
    kind, initial = symbol.type, variable.initial
    yield from (part.assignment(name) for part in symbol.parts)
    if isinstance(kind, (ReferenceType, InterfaceType)):
        if initial is None or isinstance(initial, _NO_EXPRESSION):
            return
        if isinstance(kind, ReferenceType) and kind.kind == "REFERENCE":
            yield s.Latch(name, "REF", initial, name.at)
        elif section.kind != "VAR_INPUT":
            yield s.Assign(name, initial, name.at)
    elif symbol.calculated:
        # A second declaration of the name, which has been reported, has another initial value.
        if initial is not None and not isinstance(initial, _NO_EXPRESSION):
            yield s.Assign(name, initial, name.at)
    elif _has_arguments(variable):
        assert isinstance(variable.spec, s.NamedSpec)
        yield Start(name, variable.spec.arguments, variable.spec.at)


def _has_arguments(variable: s.VarDecl) -> bool:
    return isinstance(variable.spec, s.NamedSpec) and bool(variable.spec.arguments)


def instance_sections(node: s.Pou) -> Iterator[s.Section]:
    """Yield the VAR_INST of methods that have an initial value, as variables of the block.

    Such a variable is part of each instance of the block, and starts with the instance.
    """
    for member in node.members:
        accessors = (member.getter, member.setter) if isinstance(member, s.Property) else (member,)
        for method in (one for one in accessors if one is not None):
            for section in method.sections:
                if section.kind != "VAR_INST":
                    continue
                variables = tuple(
                    replace(one, names=tuple(_qualified(method.name, name) for name in one.names))
                    for one in section.variables
                    if _has_arguments(one) or one.initial is not None
                )
                yield replace(section, kind="VAR", variables=variables)


def _qualified(method: s.Name, name: s.Name) -> s.Name:
    return s.Name(f"{method.text}.{name.text}", name.at)


def start_calls(node: Start, expressions: Checking) -> list[t.Evaluate]:
    """Check and type the calls of `INIT` for a declaration with arguments.

    The block and each of its bases has an `INIT`. The `INIT` of a base is called first, with the
    first arguments of the declaration.

    Raise InputError if the block has no `INIT` with parameters, or the arguments do not fit.
    """
    instance = expressions.variable(node.name)
    return start_of(instance.type, instance, node.arguments, node.at, expressions, node.name.text)


def _has_broken_input(method: t.Pou, scope: Scope) -> bool:
    """Return whether an input of the `INIT` of a block is declared with an error."""
    owner = method.name.partition(".")[0].upper()
    declared = scope.registry.pous.get(owner)
    members = declared.node.members if declared is not None else ()  # type: ignore[union-attr]
    return any(
        section.kind == "VAR_INPUT" and name.key not in method.symbols
        for member in members
        if isinstance(member, s.Method) and member.name.key == INIT.upper()
        for section, _, name in declared_in(member.sections)
    )


def start_of(
    kind: Type,
    instance: t.Expression,
    given_arguments: tuple[s.Argument, ...],
    at: s.Position,
    expressions: Checking,
    shown: str = "",
) -> list[t.Evaluate]:
    """Check and type the calls of the `INIT` methods of an instance, of the base block first.

    `shown` is the name of the variable, for messages. Raise InputError in the same cases as
    `start_calls`.
    """
    scope = expressions.scope
    if not isinstance(kind, BlockType):
        text = f"{shown or kind.name} has no {INIT} that takes arguments"
        raise scope.error(text, at, "write := (pin := value) for initial values")
    key, objects = kind.name.upper(), scope.declarations.objects
    declared = objects.all.get(key, {}).get(INIT.upper())
    if scope.registry.incomplete(key) or (declared and _has_broken_input(declared, scope)):
        raise ConsequenceError(f"a part of {kind.name}.{INIT} is missing")
    method = objects.starter(key)
    if method is None:
        text = f"{shown or kind.name} has no {INIT} that takes arguments"
        raise scope.error(text, at, "write := (pin := value) for initial values")
    inputs = method.section("VAR_INPUT")[2:]
    given: dict[str, s.Argument] = {}
    for symbol, argument in zip(inputs, given_arguments, strict=False):
        given[argument.name.key if argument.name is not None else symbol.name.upper()] = argument
    arguments: list[t.Expression | None] = [None, None]
    for symbol in inputs:
        found = given.pop(symbol.name.upper(), None)
        if found is None:
            text = f"the argument {symbol.name} of {method.name} is missing"
            raise scope.error(text, at, f"write {kind.name}({symbol.name} := ...)")
        arguments.append(expressions.check(found.value, symbol.type))
    for argument in given.values():
        name = argument.name.text if argument.name is not None else ""
        raise scope.error(f"{method.name} has no input {name}", argument.at)
    calls = []
    for each in scope.declarations.objects.starters(kind.name.upper()):
        count = len(each.section("VAR_INPUT"))
        given_here = tuple(arguments[:count])
        call = t.CallMethod(instance, each, True, given_here, (), (), NOTHING)
        calls.append(t.Evaluate(call, at))
    return calls
