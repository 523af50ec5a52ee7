"""The standard functions of a diagram: their form in a statement, and the type of their result."""

from __future__ import annotations

from collections.abc import Sequence

from structured_text.language.scalars import ANY_INT, ANY_REAL, ELEMENTARY
from structured_text.language.standard import (
    FUNCTIONS,
    MOMENT_OPERATORS,
    Signature,
    bcd,
    conversion,
    overload,
    truncation,
)
from structured_text.projects.diagrams.networks.expressions import (
    Call,
    Expression,
    Infix,
    Not,
)
from structured_text.projects.diagrams.networks.types import ANY_INTEGER, ANY_NUMBER, Types

__all__ = [
    "applied",
    "common",
    "inputs_count",
    "is_standard",
    "needs_context",
    "result_type",
    "standard_name",
]

#: Operators of the language that a function of the standard stands for.
_OPERATORS = {
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "AND": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "GT": ">",
    "GE": ">=",
    "EQ": "=",
    "LE": "<=",
    "LT": "<",
    "NE": "<>",
}
_COMPARISONS = ("GT", "GE", "EQ", "LE", "LT", "NE")
#: Signs that tools write in place of the names.
_SIGNS = {"&": "AND", ">=1": "OR", "=1": "XOR", "+": "ADD", "-": "SUB", "*": "MUL", "/": "DIV"}
_SIGNS |= {sign: name for name, sign in _OPERATORS.items() if name in _COMPARISONS}

_RANKS: tuple[tuple[str, ...], ...] = (
    ("SINT", "INT", "DINT", "LINT"),
    ("USINT", "UINT", "UDINT", "ULINT"),
    ("BOOL", "BYTE", "WORD", "DWORD", "LWORD"),
    ANY_REAL,
    ("TIME", "LTIME"),
)


def standard_name(name: str) -> str:
    """Return the standard function that a block's type means, in upper case; else empty."""
    key = _SIGNS.get(name, name.upper())
    return key if is_standard(key) else ""


def is_standard(name: str) -> bool:
    """Return whether the language has a function of a name in upper case."""
    return (
        name == "NOT"
        or name in FUNCTIONS
        or name in MOMENT_OPERATORS
        or bool(conversion(name) or overload(name) or truncation(name) or bcd(name))
    )


def inputs_count(name: str) -> tuple[int, bool]:
    """Return the number of inputs of a standard function, and whether it may have more."""
    if name in FUNCTIONS:
        signature = FUNCTIONS[name]
        return len(signature.pins), signature.extensible
    return (2 if name in MOMENT_OPERATORS else 1), False


def applied(
    name: str, arguments: Sequence[tuple[str, Expression]], types: Types, expected: str
) -> Expression:
    """Return the expression for a standard function and its connected inputs with their names.

    If all inputs of the function are connected, it becomes an operator where there is one, or gets
    its arguments by their position. `expected` is the type that the context gives to a result of
    literals.
    """
    values = tuple(value for _, value in arguments)
    kind = result_type(name, [value.type for value in values], types, expected)
    count, extensible = inputs_count(name)
    if name == "MOVE" and len(values) == 1:
        return values[0]
    if name == "NOT" and len(values) == 1:
        inner = values[0]
        return inner.inner if isinstance(inner, Not) else Not(inner, kind or "BOOL")
    enough = len(values) == count or (extensible and len(values) > count)
    if name in _OPERATORS and enough and (len(values) == 2 or name not in _COMPARISONS):
        return Infix(_OPERATORS[name], values, kind)
    if name in MOMENT_OPERATORS and enough:
        return Infix(MOMENT_OPERATORS[name][0], values, kind)
    given = tuple(("" if enough else pin, value) for pin, value in arguments)
    return Call(name, given, kind)


def common(kinds: Sequence[str], types: Types) -> str:
    """Return the type that contains some types; that of a literal only if there is no other."""
    found = ""
    for kind in kinds:
        base = types.base(kind)
        if not kind or base == types.base(found):
            continue
        if not found or _rank(types.base(found)) < _rank(base):
            found = kind
    return found


def _rank(kind: str) -> int:
    """Return a number that is higher for a type that contains another one."""
    if kind in (ANY_INTEGER, ANY_NUMBER):
        return -2 if kind == ANY_INTEGER else -1
    place = next((row.index(kind) for row in _RANKS if kind in row), 0)
    return place + 10 * (kind in ANY_REAL)


def needs_context(name: str, kinds: Sequence[str], types: Types) -> bool:
    """Return whether the inputs of a standard function do not determine the type of its result."""
    if name == "NOT":
        return not common(kinds, types)
    signature = FUNCTIONS.get(name)
    if signature is None:
        return False
    if signature.result != "T":
        return signature.result not in ELEMENTARY
    return common(_shared(name, signature, kinds), types) in ("", ANY_INTEGER, ANY_NUMBER)


def result_type(name: str, kinds: Sequence[str], types: Types, expected: str) -> str:
    """Return the type of a standard function's result; empty if it is unknown.

    `kinds` are the types of its connected inputs, `expected` is the type that the context gives to
    a result of literals.
    """
    pair = conversion(name)
    if pair is not None:
        return pair[1]
    target = overload(name)
    cut, digits = truncation(name), bcd(name)
    if target or cut or digits:
        return target or (cut[1] if cut else digits[2] if digits else "")
    if name in MOMENT_OPERATORS:
        return MOMENT_OPERATORS[name][3]
    if name == "NOT":
        return common(kinds, types) or expected or "BOOL"
    signature = FUNCTIONS[name]
    if signature.result != "T":
        if signature.result in ELEMENTARY:
            return signature.result
        return expected if types.base(expected) in ANY_INT else "INT"
    found = common(_shared(name, signature, kinds), types)
    if found not in ("", ANY_INTEGER, ANY_NUMBER):
        return found
    if expected and not expected.startswith("ANY"):
        return expected
    return {ANY_INTEGER: "INT", ANY_NUMBER: "REAL"}.get(found, "")


def _shared(name: str, signature: Signature, kinds: Sequence[str]) -> Sequence[str]:
    """Return the types of the inputs that have the type of the result."""
    if name in ("ADD", "SUB", "MUL", "DIV") and "TIME" in kinds:
        return ("TIME",)
    pins = [*signature.pins, *([signature.pins[-1]] * (len(kinds) - len(signature.pins)))]
    return [kind for kind, (_, pin) in zip(kinds, pins, strict=False) if pin == "T"]
