"""The functions of TwinCAT's library Tc2_System that copy and compare memory, and raise exceptions.

Source: Beckhoff InfoSys, PLC library Tc2_System: MEMCPY, MEMMOVE, MEMSET, MEMCMP, F_RaiseException.
"""

from __future__ import annotations

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.calls import are_named
from structured_text.language.checking import Checking
from structured_text.language.scalars import ANY_BIT, ANY_INT, BOOL, ELEMENTARY
from structured_text.language.types import (
    ElementaryType,
    EnumType,
    ReferenceType,
    Type,
)
from structured_text.language.values import describe

__all__ = ["NAMES", "is_memory_function", "memory_call", "memory_result"]

_RAISE = "F_RAISEEXCEPTION"
#: The functions, with the names of their inputs. An input that begins with `*` is an address.
NAMES = {
    "MEMCPY": ("*DESTADDR", "*SRCADDR", "N"),
    "MEMMOVE": ("*DESTADDR", "*SRCADDR", "N"),
    "MEMSET": ("*DESTADDR", "FILLBYTE", "N"),
    "MEMCMP": ("*PBUF1", "*PBUF2", "N"),
    _RAISE: ("EXCEPTIONCODE",),
}
#: Dialects of tools that do not have these functions.
_WITHOUT = ("ax", "logix", "openplc", "tia")


def is_memory_function(key: str, expressions: Checking) -> bool:
    """Return whether an upper-case name is a memory function, and not declared by the program."""
    scope = expressions.scope
    known = key in NAMES and key not in scope.declarations.pous
    return known and scope.registry.dialect.name not in _WITHOUT


def memory_result(key: str) -> Type:
    """Return the type of a function's result; the empty type if the function has no result."""
    if key == _RAISE:
        return ElementaryType("")
    return ELEMENTARY["DINT" if key == "MEMCMP" else "UDINT"]


def memory_call(node: s.Call, expressions: Checking) -> t.Standard:
    """Check and type a call of a memory function, or raise InputError."""
    key = node.function.key
    scope = expressions.scope
    pins = NAMES[key]
    if len(node.arguments) != len(pins):
        text = f"{node.function.text} takes {len(pins)} arguments, not {len(node.arguments)}"
        raise scope.error(text, node.at)
    given = dict(zip(pins, node.arguments, strict=True))
    if are_named(node, scope):
        names = {pin.removeprefix("*"): pin for pin in pins}
        for argument in node.arguments:
            if argument.name is None:
                continue
            if argument.name.key not in names or argument.output:
                text = f"{node.function.text} has no input {argument.name.text}"
                raise scope.error(text, argument.at, f"use {', '.join(names)}")
            given[names[argument.name.key]] = argument
    scope.note("a function of memory", node.at, key)
    arguments = []
    for pin in pins:
        value = given[pin].value
        if pin.startswith("*"):
            scope.declarations.views = True
            pointer = ReferenceType("POINTER", ELEMENTARY["BYTE"])
            arguments.append(expressions.references.wanted(value, pointer))
        else:
            arguments.append(_number(value, expressions))
    return t.Standard(key, tuple(arguments), memory_result(key))


def _number(node: s.Expression, expressions: Checking) -> t.Expression:
    """Check and type an argument that is a number of bytes, a byte, or an exception code."""
    kind = expressions.infer(node) or ELEMENTARY["UDINT"]
    if isinstance(kind, EnumType):
        kind = ELEMENTARY[kind.base]
    if isinstance(kind, ElementaryType) and kind.name in ANY_BIT and kind != BOOL:
        kind = expressions.operators.number(kind)
    if not isinstance(kind, ElementaryType) or kind.name not in ANY_INT:
        error: InputError = expressions.scope.error(
            f"a number is expected here, not a {describe(kind)}", node.at
        )
        raise error
    return expressions.check(node, kind)
