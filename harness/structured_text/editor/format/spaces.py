"""The spaces between two items on one line."""

from __future__ import annotations

from structured_text.editor.format.items import HASH, Item
from structured_text.editor.format.structure import Colon, Part

__all__ = ["binary", "space_between"]

_NEVER_BEFORE = frozenset(("COMMA", "SEMICOLON", "RPAR", "RSQB", "DOT", "CARET", "DOTDOT"))
_NEVER_BEHIND = frozenset(("LPAR", "LSQB", "DOT", "DOTDOT", HASH))
#: Tokens that end an operand. A sign behind them is an operator between two operands.
_OPERAND_ENDS = frozenset(
    (
        *("IDENT", "LABEL", "INTEGER", "REALNUM", "STRING", "TYPED", "DIRECT", "PART", "TRUE"),
        *("FALSE", "RPAR", "RSQB", "CARET", "THIS", "SUPER"),
    )
)
_SIGNS = frozenset(("PLUS", "MINUS"))
#: Words that are called like functions: `AND(a, b)`.
_FUNCTIONS = frozenset(("AND", "OR", "XOR", "MOD", "NOT"))


def binary(before: Part | None) -> bool:
    """Return whether an operator behind this part stands between two operands."""
    return before is not None and before.item.kind in _OPERAND_ENDS


def space_between(earlier: Part | None, before: Part, part: Part) -> int:
    """Return the number of spaces before a part, which stands on the line of the part before it.

    `earlier` is the part before these two.
    """
    first, second = before.item, part.item
    if not (first.is_token and second.is_token):
        return _beside_others(first, second)
    one, other = first.kind, second.kind
    if other in _NEVER_BEFORE or one in _NEVER_BEHIND or part.colon == Colon.LABEL:
        return 0
    if one in _SIGNS and not binary(earlier):
        return 0
    if other == "LPAR":
        return _before_parenthesis(earlier, before)
    if other == "LSQB":
        return 0 if one in _OPERAND_ENDS else 1
    if part.declares and before.declares and (other in ("LT", "GT") or one == "LT"):
        return 0  # in the type of a declaration, < and > surround values of generic constants
    return 1


def _beside_others(first: Item, second: Item) -> int:
    """Return the number of spaces beside a comment or pragma: as in the source, at most one."""
    if first.kind == HASH:
        return 0
    if second.kind in ("COMMA", "SEMICOLON", "RPAR", "RSQB") or first.kind in ("LPAR", "LSQB"):
        return min(second.gap, 1) if second.breaks == 0 else 0
    if second.kind == HASH:
        return 0 if first.kind in _NEVER_BEHIND else 1
    return 1


def _before_parenthesis(earlier: Part | None, before: Part) -> int:
    kind = before.item.kind
    if kind in _FUNCTIONS:
        return 1 if binary(earlier) or kind == "NOT" else 0
    if kind in ("RETURN", "CATCH"):
        return 0
    return 0 if kind in _OPERAND_ENDS else 1
