"""Parsed expressions, types and initial values as Structured Text again."""

from __future__ import annotations

from structured_text.language import syntax as s

__all__ = ["expression_text", "init_text", "spec_text"]

_STRENGTH = {
    "OR": 1,
    "XOR": 2,
    "AND": 3,
    "&": 3,
    "=": 4,
    "<>": 4,
    "<": 5,
    ">": 5,
    "<=": 5,
    ">=": 5,
    "+": 6,
    "-": 6,
    "*": 7,
    "/": 7,
    "MOD": 7,
    "**": 8,
}
_UNARY = 9


def expression_text(node: s.Expression, within: int = 0) -> str:
    """An expression, in parentheses if its place binds more strongly than `within`."""
    if isinstance(node, s.Literal):
        return node.text
    if isinstance(node, s.Name):
        return node.text
    if isinstance(node, s.Field):
        return f"{expression_text(node.base)}.{node.name.text}"
    if isinstance(node, s.Index):
        return f"{expression_text(node.base)}[{', '.join(map(expression_text, node.indices))}]"
    if isinstance(node, s.Unary):
        word = "NOT " if node.op == "NOT" else node.op
        return f"{word}{expression_text(node.operand, _UNARY)}"
    if isinstance(node, s.Binary):
        strength = _STRENGTH[node.op]
        left = expression_text(node.left, strength)
        text = f"{left} {node.op} {expression_text(node.right, strength + 1)}"
        return f"({text})" if strength < within else text
    assert isinstance(node, s.Call)
    return f"{node.function.text}({', '.join(map(_argument, node.arguments))})"


def spec_text(spec: s.TypeSpec) -> str:
    """A type as it is written after the colon; enumerations and structures on one line."""
    if isinstance(spec, s.NamedSpec):
        return spec.name.text
    if isinstance(spec, s.ArraySpec):
        bounds = (
            f"{expression_text(one.low)}..{expression_text(one.high)}" for one in spec.dimensions
        )
        return f"ARRAY [{', '.join(bounds)}] OF {spec_text(spec.element)}"
    if isinstance(spec, s.EnumSpec):
        return f"({', '.join(member.text for member in spec.members)})"
    assert isinstance(spec, s.StructSpec)
    fields = " ".join(_field(one) for one in spec.fields)
    return f"STRUCT {fields} END_STRUCT"


def init_text(init: s.Init) -> str:
    """An initial value as it is written after `:=`."""
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
