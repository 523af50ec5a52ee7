"""Overloaded methods: a block declares a method for each type, and a call chooses between them.

A block that declares the methods `M__INT`, `M__BOOL` and so on can be called with `M(…)`: the types
of the arguments choose. If the values have different types, `M__TYPES`, if it exists, is called
with the names of the types. With such methods a unit-test framework in Structured Text offers an
assert with inputs of the type ANY.
"""

from __future__ import annotations

from dataclasses import replace

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.objects import Objects
from structured_text.language.types import ElementaryType, EnumType, Type, type_name
from structured_text.language.values import describe

__all__ = ["overload", "overloads"]

#: Separator between the name of a method and the type.
_JOINT = "__"
_TYPES = "TYPES"
#: Types that decide the overload for an untyped number, without and with decimals.
_WHOLE, _REAL = "DINT", "LREAL"

_Node = s.Call | s.Invoke | s.CallStatement


def overloads(objects: Objects, kind: Type | None, key: str) -> dict[str, t.Pou]:
    """Return the overloads of a method of a block by their types, in upper case."""
    start = f"{key}{_JOINT}"
    every = objects.all.get(getattr(kind, "name", "").upper(), {})
    return {name[len(start) :]: pou for name, pou in every.items() if name.startswith(start)}


def overload(node: _Node, methods: dict[str, t.Pou], expressions: Checking) -> tuple[_Node, t.Pou]:
    """Return the overload for the arguments of a call, and the call with its arguments.

    Raises:
        InputError: There is no overload for the types of the arguments.
    """
    first, sample = next(iter(methods.items()))
    inputs = list(sample.section("VAR_INPUT"))
    generic = [one.name.upper() for one in inputs if type_name(one.type) == first]
    order = [one.name.upper() for one in inputs]
    found: dict[int, str] = {}
    for number, argument in enumerate(node.arguments):
        key = argument.name.key if argument.name is not None else ""
        if not key and number < len(order):
            key = order[number]
        if key in generic:
            found[number] = _name_of(argument.value, expressions)
    names = {name for name in found.values() if name}
    if not names:
        values = [node.arguments[number].value for number in found]
        names = {_REAL if any(map(expressions.is_real, values)) else _WHOLE}
    if len(names) > 1 and _TYPES in methods:
        arguments = list(node.arguments)
        for number, name in found.items():
            at = arguments[number].at
            text = s.Literal("STRING", f"'(Type class = {name or min(names)})'", at)
            arguments[number] = replace(arguments[number], value=text)
        return replace(node, arguments=tuple(arguments)), methods[_TYPES]
    name = min(names)
    if name not in methods:
        base = sample.name.rpartition(_JOINT)[0].rpartition(".")[2]
        raise expressions.scope.error(f"{base} takes no value of {name}", node.at)
    return node, methods[name]


def _name_of(value: s.Expression, expressions: Checking) -> str:
    """Return the name of a value's type.

    An enumeration has the name of its base type. An untyped number has an empty name.
    """
    kind = expressions.infer(value)
    if kind is None:
        return ""
    if isinstance(kind, EnumType):
        return kind.base
    return kind.name if isinstance(kind, ElementaryType) else describe(kind)
