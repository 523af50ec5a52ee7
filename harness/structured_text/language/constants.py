"""Literals and constant expressions of the source, as values of a given type.

An untyped literal has no type of its own. It is first read as LINT or LREAL, and `adapt` then gives
it the type that the context requires. A typed constant must widen to that type.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from structured_text.errors import InputError
from structured_text.language import syntax as s
from structured_text.language.arithmetic import ARITHMETIC, COMPARISONS, LOGIC, quotient, remainder
from structured_text.language.registry import Declared
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_CHARS,
    ANY_DURATION,
    ANY_REAL,
    ANY_STRING,
    BOOL,
    CORE,
    ELEMENTARY,
    INT_RANGE,
    LiteralError,
    Scalar,
    number,
    string_kind,
    string_length,
    string_literal,
    typed_literal,
    within_real,
)
from structured_text.language.tree import Constant
from structured_text.language.types import ElementaryType, EnumType, Type
from structured_text.language.values import describe
from structured_text.language.widening import converted, widening

__all__ = ["NotConstantError", "adapt", "constant", "evaluate", "literal", "member"]

#: Longest literal that is not a text [characters]. The longest LREAL and LWORD need far fewer.
_LONGEST = 200
_THIRD = "a type of the third edition"
_CONVERTED = "an implicit conversion"
#: Prefixes before a `#` that are not names of types.
_SHORT = ("T", "D", "LT", "LD")

#: A function that returns the constant which a name or path denotes; None for a variable.
Lookup = Callable[[s.Expression], Constant | None]


def literal(node: s.Literal, types: dict[str, Type], where: Declared) -> Constant:
    """Return the value of a literal; an untyped number is a LINT or LREAL.

    Raises:
        InputError: The literal is malformed or out of its type's range.
    """
    if node.kind != "STRING" and "'" not in node.text and len(node.text) > _LONGEST:
        raise where.error(
            f"the literal has {len(node.text)} characters: {node.text[:20]}...",
            node.at,
            "write a value that a type can hold",
        )
    try:
        if node.kind == "BOOLEAN":
            return Constant(node.text.upper() == "TRUE", BOOL, True)
        if node.kind == "STRING":
            text = string_literal(node.text)
            if node.text.startswith('"'):
                where.note(_THIRD, node.at, "WSTRING")
            name = "WSTRING" if node.text.startswith('"') else "STRING"
            return Constant(text, string_kind(name, len(text)), True)
        if node.kind == "TYPED":
            prefix, _, name = node.text.partition("#")
            kind = types.get(prefix.upper())
            if isinstance(kind, EnumType):
                return member(kind, s.Name(name.strip(), node.at), where)
            if prefix.upper() not in ELEMENTARY and prefix.upper() not in _SHORT:
                raise where.error(f"there is no type {prefix}", node.at)
            kind, value = typed_literal(node.text)
            if kind.name not in CORE:
                where.note(_THIRD, node.at, kind.name)
            if kind.name == "LTIME" and int(value) >= 1 << 63:
                where.note("an LTIME of more than 292 years", node.at)
            return Constant(value, kind, True)
        value = number(node.text)
        name = "LREAL" if isinstance(value, float) else "LINT"
        return Constant(value, ELEMENTARY[name])
    except LiteralError as error:
        raise where.error(str(error), node.at) from None


def member(kind: EnumType, name: s.Name, where: Declared) -> Constant:
    """Return a member of an enumeration by its name, or raise InputError."""
    try:
        return Constant(kind.value_of(name.key), kind, True)
    except ValueError:
        raise where.error(
            f"{kind.name} has no member {name.text}", name.at, f"use {', '.join(kind.members)}"
        ) from None


def adapt(found: Constant, kind: Type, at: s.Position, where: Declared) -> Constant:
    """Convert a constant to the type that the context requires, or raise InputError.

    An untyped integer fits every integer and bit string type that holds it (BOOL for 0 and 1). An
    untyped real fits REAL and LREAL. A typed constant must widen to the type. Integers where a REAL
    is expected, and constants of another type, are noted as not portable.
    """
    if found.typed or not isinstance(kind, ElementaryType):
        return _retyped(found, kind, at, where)
    value: Scalar = found.value
    if isinstance(value, float):
        real = value if kind.name == "LREAL" else within_real(value)
        if kind.name in ANY_REAL and real is not None:
            return Constant(real, kind)
    elif kind.name == "BOOL" and value in (0, 1):
        return Constant(bool(value), kind)
    elif kind.name in INT_RANGE:
        low, high = INT_RANGE[kind.name]
        if low <= int(value) <= high:
            return Constant(value, kind)
        raise where.error(f"{value} is outside {kind.name} ({low} to {high})", at)
    elif kind.name in ANY_REAL:
        where.note(_CONVERTED, at, f"{value} where a {kind.name} is expected: write {value}.0")
        return Constant(float(value), kind)
    raise where.error(
        f"a {describe(kind)} is expected here, not the number {value}", at, _hint(found, kind)
    )


def _retyped(found: Constant, kind: Type, at: s.Position, where: Declared) -> Constant:
    """Return a typed constant in the required type."""
    if found.type == kind:
        return found
    have = found.type
    if isinstance(have, EnumType) and isinstance(kind, ElementaryType):
        low, high = INT_RANGE.get(kind.name, (0, -1))
        if have.base == kind.name or widening(have.base, kind.name) or low <= found.value <= high:  # type: ignore[operator]
            where.note("an enumeration as a number", at)
            return Constant(converted(found.value, have.base, kind), kind, True)
    if isinstance(kind, EnumType) and have.name == kind.base and "strict" not in kind.attributes:
        where.note("a number as an enumeration", at)
        return Constant(found.value, kind, True)
    if isinstance(have, ElementaryType) and isinstance(kind, ElementaryType):
        texts = have.name in ANY_STRING and have.name == kind.name
        if texts and len(str(found.value)) <= string_length(kind):
            return Constant(found.value, kind, True)
        single = isinstance(found.value, str) and len(found.value) == 1
        if texts or widening(have.name, kind.name) or (single and _is_character(have, kind)):
            if not single:
                shown = f"a {describe(have)} literal where a {describe(kind)} is expected"
                where.note(_CONVERTED, at, shown)
            return Constant(converted(found.value, have.name, kind), kind, True)
    shown = describe(have) if found.typed else "number"
    raise where.error(
        f"a {describe(kind)} is expected here, not a {shown} literal", at, _hint(found, kind)
    )


def _is_character(have: ElementaryType, kind: ElementaryType) -> bool:
    """Return whether a STRING literal is used as a CHAR, or a WSTRING literal as a WCHAR."""
    return (have.name, kind.name) in (("STRING", "CHAR"), ("WSTRING", "WCHAR"))


def _hint(found: Constant, kind: Type) -> str:
    if not isinstance(kind, ElementaryType):
        return f"use a member of {kind.name}" if isinstance(kind, EnumType) else ""
    if kind.name in ANY_CHARS and isinstance(found.value, str):
        quote = '"' if kind.name.startswith("W") else "'"
        many = "text" if kind.name in ANY_STRING else "a"
        return f"write {quote}{many}{quote}"
    if kind.name in ANY_DURATION:
        return "write a duration such as T#500ms"
    if kind.name == "BOOL":
        return "write TRUE or FALSE"
    if kind.name in ANY_BIT and found.typed:
        return f"write {kind.name}#16#..."
    return ""


def constant(
    node: s.Init,
    kind: Type,
    types: dict[str, Type],
    where: Declared,
    lookup: Lookup,
    detail: str = "",
) -> Constant:
    """Return the value of an initial value or CASE label in the required type, or raise InputError.

    `lookup` finds named constants; `detail` is as for `evaluate`.
    """
    if isinstance(node, s.Name) and isinstance(kind, EnumType):
        if node.key in (one.upper() for one in kind.members):
            return member(kind, node, where)
        if lookup(node) is None:  # not constant: assigned at the start of the program
            return _member_or_variable(kind, node, where)
    found = evaluate(node, types, where, lookup, detail)
    if isinstance(kind, EnumType) and _is_number_of(found, kind):
        where.note("a number as an enumeration", node.at)
        return Constant(found.value, kind, True)
    if isinstance(node, s.Literal) or _is_negative(node):
        return adapt(found, kind, node.at, where)
    return _converted(found, kind, node.at, where)


def _is_number_of(found: Constant, kind: EnumType) -> bool:
    """Return whether an untyped number may be used as a value of an enumeration.

    A strict enumeration takes only the values of its members.
    """
    if found.typed or not isinstance(found.value, int):
        return False
    return "strict" not in kind.attributes or kind.member_of(found.value) is not None


def _is_negative(node: s.Init) -> bool:
    return isinstance(node, s.Unary) and isinstance(node.operand, s.Literal)


def _converted(found: Constant, kind: Type, at: s.Position, where: Declared) -> Constant:
    """Return a calculated or named constant in the required type.

    A number is accepted if its value is in the range of the type.
    """
    value = found.value
    if found.type == kind:
        return found
    whole = isinstance(value, int) and not isinstance(value, bool)
    other = isinstance(found.type, EnumType) and isinstance(kind, EnumType)
    if whole and isinstance(kind, EnumType) and not (other and "strict" in kind.attributes):
        return Constant(value, kind, True)
    if isinstance(kind, ElementaryType):
        if kind.name in INT_RANGE and whole:
            return adapt(Constant(value, ELEMENTARY["LINT"]), kind, at, where)
        if kind.name in ANY_REAL and (whole or isinstance(value, float)):
            real = Constant(float(value), ELEMENTARY["LREAL"])
            return adapt(real, kind, at, where)
    return adapt(found, kind, at, where)


_NAMED, _MEMBER = "a constant instead of a literal", "a member of an enumeration"


class NotConstantError(InputError):
    """The error for an expression that is not constant where a constant is required."""


def _member_or_variable(kind: EnumType, node: s.Name, where: Declared) -> Constant:
    """Return a member of an enumeration; raise NotConstantError for any other name."""
    try:
        return member(kind, node, where)
    except InputError as error:
        raise NotConstantError(
            error.message, file=error.file, line=error.line, column=error.column, hint=error.hint
        ) from None


_MOST_BITS = 256


def evaluate(
    node: s.Init, types: dict[str, Type], where: Declared, lookup: Lookup, detail: str = ""
) -> Constant:
    """Return the value of a constant expression: literals, named constants and operators.

    Args:
        node: The expression.
        types: Types of the project by upper-case name.
        where: The declaration that contains the expression, for messages.
        lookup: Finds named constants.
        detail: The role of a named constant here, for the note on portability.

    Raises:
        InputError: The expression is not constant.
    """
    if isinstance(node, s.Literal):
        return literal(node, types, where)
    if isinstance(node, (s.Name, s.Field, s.Call)):
        found = lookup(node)
        if found is not None:
            is_member = isinstance(found.type, EnumType)
            if is_member and isinstance(node, s.Field):
                where.note("a member with the name of its enumeration", node.at)
            else:
                where.note(_NAMED, node.at, _MEMBER if is_member else detail)
            return found
    elif isinstance(node, s.Unary):
        return _negated(node, evaluate(node.operand, types, where, lookup), where)
    elif isinstance(node, s.Binary):
        left = evaluate(node.left, types, where, lookup)
        right = evaluate(node.right, types, where, lookup)
        where.note("a constant expression", node.at)
        return _calculated(node, left, right, where)
    hint = "write a literal, or a member of an enumeration"
    error = where.error("a constant is expected here", node.at, hint)
    at = {"line": error.line, "column": error.column}
    raise NotConstantError(error.message, file=error.file, hint=hint, **at)


def _negated(node: s.Unary, found: Constant, where: Declared) -> Constant:
    value = found.value
    if node.op == "NOT" and isinstance(value, bool):
        return Constant(not value, found.type, True)
    if node.op == "NOT" and isinstance(value, int) and found.typed:
        low, high = INT_RANGE[found.type.name]
        return Constant(value ^ high if not low else ~value, found.type, True)
    literal_sign = isinstance(node.operand, s.Literal) and found.typed
    if node.op != "-" or isinstance(value, (bool, str)) or literal_sign:
        raise where.error("only a number can be negative here", node.at)
    return Constant(-value, found.type, found.typed)


def divided(node: s.Binary, a: float, b: float, where: Declared) -> int | float:
    """Return the constant result of / or MOD; raise InputError for a division by zero."""
    if b == 0:
        raise where.error("division by zero", node.at)
    if isinstance(a, int) and isinstance(b, int):
        return quotient(a, b) if node.op == "/" else remainder(a, b)
    return a / b if node.op == "/" else math.fmod(a, b)


def _calculated(node: s.Binary, left: Constant, right: Constant, where: Declared) -> Constant:
    a, b, op = left.value, right.value, node.op
    kind, typed = (left.type, True) if left.typed else (right.type, right.typed)
    if op in COMPARISONS:
        return Constant(COMPARISONS[op](a, b), BOOL, True)
    if isinstance(a, str) or isinstance(b, str):
        raise where.error(f"{op} is not defined for STRING", node.at)
    if op in LOGIC:
        return Constant(LOGIC[op](int(a), int(b)), kind, typed)
    if isinstance(a, float) != isinstance(b, float) and not typed:
        kind = ELEMENTARY["LREAL"]
    value: int | float
    if op not in ("/", "MOD"):
        if op == "**" and isinstance(a, int) and (b < 0 or a.bit_length() * b > _MOST_BITS):
            a = float(a)
        try:
            value = ARITHMETIC[op](a, b)
        except (ArithmeticError, ValueError):
            value = math.inf
    else:
        value = divided(node, a, b, where)
    if isinstance(value, complex) or not abs(value) < 1 << _MOST_BITS:
        raise where.error("the result of this constant expression is too large", node.at)
    return Constant(value, kind, typed)
