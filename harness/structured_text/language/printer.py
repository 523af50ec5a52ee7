"""The printer: turns expressions, types and initial values back into Structured Text."""

from __future__ import annotations

from datetime import timedelta
from typing import Any

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.displayed import literal
from structured_text.language.scalars import ANY_CHARS, ANY_DURATION, DIGITS
from structured_text.language.types import (
    ElementaryType,
    EnumType,
    InterfaceType,
    ReferenceType,
)

__all__ = ["bounds_text", "expression_text", "init_text", "label_text", "spec_text"]

_STRENGTH = {
    **dict.fromkeys(("OR", "OR_ELSE"), 1),
    "XOR": 2,
    **dict.fromkeys(("AND", "AND_THEN", "&"), 3),
    **dict.fromkeys(("=", "<>"), 4),
    **dict.fromkeys(("<", ">", "<=", ">="), 5),
    **dict.fromkeys(("+", "-"), 6),
    **dict.fromkeys(("*", "/", "MOD"), 7),
    "**": 8,
}
_UNARY = 9


def expression_text(node: s.Expression | t.Expression, within: int = 0) -> str:
    """Return a parsed or checked expression as Structured Text.

    `within` is the precedence of the operator around the expression. If it is higher, the text gets
    parentheses.
    """
    if isinstance(node, (s.Binary, t.Binary)):
        strength = _STRENGTH[node.op]
        left, right = (
            expression_text(node.left, strength),
            expression_text(node.right, strength + 1),
        )
        text = f"{left} {node.op} {right}"
        return f"({text})" if strength < within else text
    if isinstance(node, (s.Unary, t.Unary)):
        word = "NOT " if node.op == "NOT" else node.op
        return f"{word}{expression_text(node.operand, _UNARY)}"
    if isinstance(node, (s.Index, t.Index)):
        return f"{expression_text(node.base)}[{_list(node.indices)}]"
    if isinstance(node, (s.Literal, s.Name)):
        return node.text
    if isinstance(node, s.Field):
        return f"{expression_text(node.base)}.{node.name.text}"
    if isinstance(node, s.Call):
        return f"{node.function.text}({', '.join(map(_argument, node.arguments))})"
    if isinstance(node, s.TypeName):
        return spec_text(node.spec)
    if isinstance(node, (s.Assigned, t.Assigned)):
        return f"({expression_text(node.target)} := {expression_text(node.value)})"
    return _checked(node)


def _list(nodes: tuple[Any, ...]) -> str:
    return ", ".join(expression_text(one) for one in nodes if one is not None)


def _checked(node: Any) -> str:
    """Return the text of a node of a kind that occurs only in the checked tree."""
    if isinstance(node, t.Constant):
        return _constant(node)
    if isinstance(node, t.Use):
        return node.symbol.name
    if isinstance(node, t.Member):
        return f"{expression_text(node.base)}.{node.name}"
    if isinstance(node, t.CallFunction):
        return f"{node.function}({_list(node.arguments)})"
    if isinstance(node, t.Standard):
        return f"{node.name}({_list(node.arguments)})"
    if isinstance(node, t.This):
        return "THIS^"
    if isinstance(node, t.Null):
        return "0"
    if isinstance(node, t.Same):
        return f"{expression_text(node.left)} {node.op} {expression_text(node.right)}"
    if isinstance(node, t.Valid):
        return f"__ISVALIDREF({expression_text(node.reference)})"
    if isinstance(node, t.Recast):
        return expression_text(node.base)
    if isinstance(node, t.Address):
        return f"ADR({expression_text(node.variable)})"
    if isinstance(node, t.Offset):
        sign = "+" if node.sign > 0 else "-"
        return f"{expression_text(node.base)} {sign} {expression_text(node.bytes)}"
    if isinstance(node, t.Deref):
        base, kind = expression_text(node.base), node.base.type
        if node.offset is not None:
            return f"{base}[{expression_text(node.offset)}]"
        return base if isinstance(kind, ReferenceType) and kind.kind == "REFERENCE" else f"{base}^"
    if isinstance(node, t.Generic):
        return expression_text(node.pointer)
    if isinstance(node, t.New):
        count = "" if node.count is None else f", {expression_text(node.count)}"
        return f"__NEW({node.made.name}{count})"
    if isinstance(node, t.Delete):
        return f"__DELETE({expression_text(node.pointer)})"
    if isinstance(node, t.Query):
        word = "INTERFACE" if isinstance(node.target.type, InterfaceType) else "POINTER"
        given = f"{expression_text(node.source)}, {expression_text(node.target)}"
        return f"__QUERY{word}({given})"
    assert isinstance(node, t.CallMethod), node  # the callers pass no other kind of node
    _, name, *accessor = node.method.name.split(".")
    called = f"{'SUPER^' if node.final else expression_text(node.instance)}.{name}"
    return called if accessor else f"{called}({_list(node.arguments)})"


def _constant(node: t.Constant) -> str:
    kind, value = node.type, node.value
    if isinstance(kind, EnumType):
        return label_text(kind, int(value))
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name in DIGITS:
        return f"{name}#16#{int(value):0{DIGITS[name]}X}"
    if name == "BOOL":
        return "TRUE" if value else "FALSE"
    if name in ANY_DURATION:
        whole = literal(timedelta(microseconds=int(value) / 1000))
        return whole if name == "TIME" else f"L{whole}"
    return f"'{value}'" if name in ANY_CHARS else str(value)


def label_text(kind: Any, value: int) -> str:
    """Return the text of a CASE label; the type decides between a member and a number."""
    return (kind.member_of(value) if isinstance(kind, EnumType) else None) or str(value)


def spec_text(spec: s.TypeSpec) -> str:
    """Return a type as written after the colon; enumerations and structures on one line."""
    if isinstance(spec, s.NamedSpec):
        return spec.name.text
    if isinstance(spec, s.ArraySpec):
        return f"ARRAY [{bounds_text(spec)}] OF {spec_text(spec.element)}"
    if isinstance(spec, s.PointerSpec):
        word = spec.kind if spec.kind == "REF_TO" else f"{spec.kind} TO"
        return f"{word} {spec_text(spec.target)}"
    if isinstance(spec, s.EnumSpec):
        return f"({', '.join(member.text for member in spec.members)})"
    assert isinstance(spec, s.StructSpec)
    fields = " ".join(_field(one) for one in spec.fields)
    return f"STRUCT {fields} END_STRUCT"


def bounds_text(spec: s.ArraySpec) -> str:
    """Return the bounds of an array as written in brackets."""
    ends = ((expression_text(one.low), expression_text(one.high)) for one in spec.dimensions)
    return ", ".join(f"{low}..{high}" for low, high in ends)


def init_text(init: s.Init) -> str:
    """Return an initial value as written after `:=`."""
    if isinstance(init, s.ArrayInit):
        items = (
            init_text(value) if count is None else f"{expression_text(count)}({init_text(value)})"
            for count, value in init.items
        )
        return f"[{', '.join(items)}]"
    if isinstance(init, s.StructInit):
        return f"({', '.join(f'{name.text} := {init_text(value)}' for name, value in init.fields)})"
    assert not isinstance(init, s.Sequence)
    return expression_text(init)


def _argument(one: s.Argument) -> str:
    value = expression_text(one.value)
    if one.name is None:
        return value
    return f"{one.name.text} {'=>' if one.output else ':='} {value}"


def _field(one: s.VarDecl) -> str:
    names = ", ".join(name.text for name in one.names)
    initial = "" if one.initial is None else f" := {init_text(one.initial)}"
    return f"{names} : {spec_text(one.spec)}{initial};"
