"""Boolean expressions as the contacts of a rung: in series for AND, in parallel for OR.

NOT moves to the contacts (De Morgan). Only a variable can be a contact. Any other expression, such
as a comparison, is text that stands at the beginning of the contacts.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

from structured_text.language import syntax as s
from structured_text.language.printer import expression_text

__all__ = ["FALSE", "TRUE", "Leaf", "Parallel", "Power", "Series", "leaves", "negated", "parallel"]
__all__ += ["power_of", "series"]

_OPPOSITE = {"=": "<>", "<>": "="}
#: The precedence of the weakest operator that binds closer than AND.
_COMPARISON = 4
_VARIABLES = (s.Name, s.Field, s.Index, s.Part)


@dataclass(frozen=True)
class Leaf:
    """A contact, or an expression that is not a variable.

    Attributes:
        text: The variable or the expression.
        negated: Whether the contact is negated; an expression is never negated.
        opposite: The negated expression; empty for a contact.
    """

    text: str
    negated: bool = False
    opposite: str = ""

    @property
    def is_contact(self) -> bool:
        """Return whether this is a contact and not an expression."""
        return not self.opposite


@dataclass(frozen=True)
class Series:
    """Items that are joined by AND; without items it is TRUE."""

    items: tuple[Power, ...] = ()


@dataclass(frozen=True)
class Parallel:
    """Items that are joined by OR; without items it is FALSE."""

    items: tuple[Power, ...] = ()


Power: TypeAlias = Leaf | Series | Parallel

TRUE = Series()
FALSE = Parallel()


def series(*items: Power) -> Power:
    """Return the items joined by AND, in the simplest form."""
    found: list[Power] = []
    for item in items:
        if item == FALSE:
            return FALSE
        found += item.items if isinstance(item, Series) else [item]
    return found[0] if len(found) == 1 else Series(tuple(found))


def parallel(*items: Power) -> Power:
    """Return the items joined by OR, in the simplest form."""
    found: list[Power] = []
    for item in items:
        if item == TRUE:
            return TRUE
        found += item.items if isinstance(item, Parallel) else [item]
    return found[0] if len(found) == 1 else Parallel(tuple(found))


def negated(power: Power) -> Power:
    """Return the negation; NOT is moved to the contacts."""
    if isinstance(power, Series):
        return parallel(*map(negated, power.items))
    if isinstance(power, Parallel):
        return series(*map(negated, power.items))
    if power.is_contact:
        return Leaf(power.text, not power.negated)
    return Leaf(power.opposite, opposite=power.text)


def leaves(power: Power) -> Iterator[Leaf]:
    """Yield the contacts and expressions from left to right."""
    if isinstance(power, Leaf):
        yield power
    else:
        for item in power.items:
            yield from leaves(item)


def power_of(node: s.Expression) -> Power:
    """Return the contacts of a Boolean expression."""
    if isinstance(node, s.Unary) and node.op == "NOT":
        return negated(power_of(node.operand))
    if isinstance(node, s.Literal) and node.text.upper() in ("TRUE", "FALSE"):
        return TRUE if node.text.upper() == "TRUE" else FALSE
    if isinstance(node, s.Binary) and node.op in ("AND", "&", "OR", "XOR"):
        left, right = power_of(node.left), power_of(node.right)
        if node.op == "OR":
            return parallel(left, right)
        if node.op != "XOR":
            return series(left, right)
        if all(leaf.is_contact for side in (left, right) for leaf in leaves(side)):
            return parallel(series(left, negated(right)), series(negated(left), right))
    if isinstance(node, _VARIABLES):
        return Leaf(expression_text(node))
    # Tools write AND and NOT around the text without parentheses of their own.
    text = expression_text(node, _COMPARISON)
    if isinstance(node, s.Binary) and node.op in _OPPOSITE:
        other = s.Binary(_OPPOSITE[node.op], node.left, node.right, node.at)
        return Leaf(text, opposite=expression_text(other, _COMPARISON))
    return Leaf(text, opposite=expression_text(s.Unary("NOT", node, node.at)))
