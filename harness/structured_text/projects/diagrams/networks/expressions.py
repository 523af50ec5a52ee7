"""Expressions of a translation: they are made before it is known whether they need a variable.

A value of a block or contact is first a `Use`. When a statement is written, a `Use` becomes the
expression itself, or the variable that keeps its value.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

__all__ = ["FALSE", "TRUE", "Call", "Expression", "Infix", "Key", "Not", "Text", "Use"]
__all__ += ["alternatives", "inverted", "joined", "keys_in", "parts_of", "roots", "size", "written"]

#: An output of an element: the `id` of the element and the name of the pin.
Key = tuple[str, str]

#: How strongly operators bind, as in the standard.
_LEVELS = {
    "OR": 1,
    "XOR": 2,
    "AND": 3,
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
}
_UNARY, _ATOM, _LOOSE = 8, 9, 0
_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
_ASSOCIATIVE = ("AND", "OR", "XOR")
_INVERSES = {"TRUE": "FALSE", "FALSE": "TRUE"}

_SIMPLE = re.compile(
    r"\w+#[\w.:+-]+|\d[\d_.]*(?:[eE][+-]?\d+)?|'[^']*'|\"[^\"]*\""
    r"|[\w.%^]+(?:\[[^\[\]]*\][\w.%^]*)*"
)
_COMMENTS = re.compile(r"\(\*.*?\*\)|//[^\n]*|/\*.*?\*/", re.DOTALL)
_TEXTS = re.compile(r"'(?:\$.|[^$'\n])*'|\"(?:\$.|[^$\"\n])*\"")
_ROOT = re.compile(r"(?<![\w.#%])([^\W\d]\w*(?:\.[^\W\d]\w*)?)(?!\w*#)")
_WORDS = frozenset(("AND", "OR", "XOR", "NOT", "MOD", "TRUE", "FALSE"))


@dataclass(frozen=True)
class Text:
    """A variable, a literal, or an expression as it is written in the diagram."""

    text: str
    type: str = ""


@dataclass(frozen=True)
class Use:
    """The value of an output of an element."""

    key: Key
    type: str = ""


@dataclass(frozen=True)
class Not:
    """The inverse of an expression."""

    inner: Expression
    type: str = "BOOL"


@dataclass(frozen=True)
class Infix:
    """Two or more expressions with an operator between them."""

    op: str
    items: tuple[Expression, ...]
    type: str = "BOOL"


@dataclass(frozen=True)
class Call:
    """The call of a function. An argument has an empty name if it is given by its position.

    `outside` is whether the function may read variables outside of it.
    """

    name: str
    arguments: tuple[tuple[str, Expression], ...]
    type: str = ""
    outside: bool = False


Expression: TypeAlias = Text | Use | Not | Infix | Call

TRUE, FALSE = Text("TRUE", "BOOL"), Text("FALSE", "BOOL")


def inverted(expression: Expression) -> Expression:
    """Return the inverse of an expression."""
    if isinstance(expression, Not):
        return expression.inner
    if expression in (TRUE, FALSE):
        return FALSE if expression == TRUE else TRUE
    return Not(expression, expression.type or "BOOL")


def joined(items: Iterable[Expression]) -> Expression:
    """Return the series of some conditions."""
    flat: list[Expression] = []
    for item in items:
        flat += item.items if isinstance(item, Infix) and item.op == "AND" else [item]
    found = [item for item in flat if item != TRUE]
    if not found:
        return TRUE
    return found[0] if len(found) == 1 else Infix("AND", tuple(found))


def alternatives(items: Sequence[Expression]) -> Expression:
    """Return parallel conditions; what neighbours have in common is written once."""
    rows: list[tuple[Expression, ...]] = []
    for item in items:
        for one in item.items if isinstance(item, Infix) and item.op == "OR" else (item,):
            row = one.items if isinstance(one, Infix) and one.op == "AND" else (one,)
            rows.append(row if one != TRUE else ())
    return _alternatives(rows)


def _alternatives(rows: Sequence[tuple[Expression, ...]]) -> Expression:
    rows = list(dict.fromkeys(rows))
    if () in rows:
        return TRUE
    found: list[Expression] = []
    while rows:
        first = rows[0][0]
        same = [row for row in rows if row[0] == first]
        rows = [row for row in rows if row[0] != first]
        if len(same) == 1:
            found.append(joined(same[0]))
        else:
            found.append(joined((first, _alternatives([row[1:] for row in same]))))
    return found[0] if len(found) == 1 else Infix("OR", tuple(found))


def parts_of(expression: Expression) -> tuple[Expression, ...]:
    """Return the expressions directly inside an expression."""
    if isinstance(expression, Not):
        return (expression.inner,)
    if isinstance(expression, Infix):
        return expression.items
    if isinstance(expression, Call):
        return tuple(value for _, value in expression.arguments)
    return ()


def keys_in(expression: Expression) -> Iterator[Key]:
    """Yield the outputs that an expression uses directly."""
    if isinstance(expression, Use):
        yield expression.key
    for part in parts_of(expression):
        yield from keys_in(part)


def size(expression: Expression) -> int:
    """Return the number of variables and literals in an expression."""
    return sum(map(size, parts_of(expression))) or 1


def roots(text: str) -> frozenset[str]:
    """Return the variables in a text in upper case, each with its first field if it has one."""
    plain = _TEXTS.sub("''", _COMMENTS.sub(" ", text))
    return frozenset(word.upper() for word in _ROOT.findall(plain)) - _WORDS


def written(expression: Expression, bound: Callable[[Use], Expression]) -> str:
    """Return the text of an expression; `bound` returns the present form of a `Use`."""
    return _written(expression, bound)[0]


def _written(expression: Expression, bound: Callable[[Use], Expression]) -> tuple[str, int]:
    """Return the text of an expression and how strongly it binds."""
    if isinstance(expression, Use):
        return _written(bound(expression), bound)
    if isinstance(expression, Text):
        text = expression.text.strip()
        return text, _ATOM if _SIMPLE.fullmatch(text) else _LOOSE
    if isinstance(expression, Not):
        text, level = _written(expression.inner, bound)
        if text.startswith("NOT ") and level == _UNARY:
            return text[4:], _ATOM
        if text in _INVERSES:
            return _INVERSES[text], _ATOM
        return f"NOT {text}" if level >= _UNARY else f"NOT ({text})", _UNARY
    if isinstance(expression, Call):
        given = (
            f"{name} := {written(value, bound)}" if name else written(value, bound)
            for name, value in expression.arguments
        )
        return f"{expression.name}({', '.join(given)})", _ATOM
    return _with_operator(expression, bound)


def _with_operator(expression: Infix, bound: Callable[[Use], Expression]) -> tuple[str, int]:
    own, op = _LEVELS[expression.op], expression.op
    texts = []
    for number, item in enumerate(expression.items):
        text, level = _written(item, bound)
        if op in ("AND", "OR") and text in _INVERSES:
            if text == ("FALSE" if op == "AND" else "TRUE"):
                return text, _ATOM
            continue
        if level == own:
            within = number > 0 and op not in _ASSOCIATIVE
        elif op in _COMPARISONS:
            within = level in (4, 5) or level < own
        else:  # a reader need not know whether XOR or another operator comes first
            within = level < own or (op == "OR" and level == _LEVELS["XOR"])
            within |= op == "XOR" and level == _LEVELS["AND"]
        texts.append((f"({text})" if within else text, level))
    if not texts:
        return ("TRUE" if op == "AND" else "FALSE"), _ATOM
    if len(texts) == 1 and len(expression.items) > 1:
        return texts[0][0], _ATOM if texts[0][0].startswith("(") else texts[0][1]
    return f" {op} ".join(text for text, _ in texts), own
