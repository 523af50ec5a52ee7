"""Checked expressions as Structured Text."""

from __future__ import annotations

from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.types import ElementaryType, EnumType

__all__ = ["text_of"]

_STRENGTH = {
    "OR": 1,
    "XOR": 2,
    "AND": 3,
    **dict.fromkeys(("=", "<>", "<", ">", "<=", ">="), 4),
    **dict.fromkeys(("+", "-"), 5),
    **dict.fromkeys(("*", "/", "MOD"), 6),
    "**": 8,
}
_UNARY = 7
_BITS = {"BYTE": 2, "WORD": 4, "DWORD": 8, "LWORD": 16}


def text_of(node: t.Expression, within: int = 0) -> str:
    """An expression as one would write it, in parentheses if its place binds more strongly.

    Args:
        node: The expression.
        within: How strongly the operator binds whose operand it is.
    """
    if isinstance(node, t.Constant):
        return _constant(node)
    if isinstance(node, t.Use):
        return node.symbol.name
    if isinstance(node, t.Member):
        return f"{text_of(node.base)}.{node.name}"
    if isinstance(node, t.Index):
        return f"{text_of(node.base)}[{', '.join(map(text_of, node.indices))}]"
    if isinstance(node, t.Unary):
        word = "NOT " if node.op == "NOT" else node.op
        return f"{word}{text_of(node.operand, _UNARY)}"
    if isinstance(node, t.Binary):
        strength = _STRENGTH[node.op]
        left, right = text_of(node.left, strength), text_of(node.right, strength + 1)
        text = f"{left} {node.op} {right}"
        return f"({text})" if strength < within else text
    name = node.function if isinstance(node, t.CallFunction) else node.name
    given = [text_of(item) for item in node.arguments if item is not None]
    return f"{name}({', '.join(given)})"


def _constant(node: t.Constant) -> str:
    kind, value = node.type, node.value
    if isinstance(kind, EnumType):
        return kind.members[int(value)]
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name in _BITS:
        return f"{name}#16#{int(value):0{_BITS[name]}X}"
    if name == "BOOL":
        return "TRUE" if value else "FALSE"
    if name == "TIME":
        return f"T#{int(value) // 1_000_000}ms"
    return f"'{value}'" if name == "STRING" else str(value)
