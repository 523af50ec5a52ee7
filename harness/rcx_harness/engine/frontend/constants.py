"""Literals and constant expressions of the source, as values of a given type."""

from __future__ import annotations

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend.registry import Declared
from rcx_harness.engine.frontend.scalars import (
    ANY_BIT,
    ANY_REAL,
    BOOL,
    ELEMENTARY,
    INT_RANGE,
    REAL_MAX,
    STRING,
    LiteralError,
    Scalar,
    number,
    string_literal,
    typed_literal,
)
from rcx_harness.engine.frontend.tree import Constant
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import ElementaryType, EnumType, Type

__all__ = ["adapt", "constant", "integer", "literal", "member"]

#: Characters of a literal that is no text; the longest LREAL and LWORD need far fewer.
_LONGEST = 200


def literal(node: s.Literal, types: dict[str, Type], where: Declared) -> Constant:
    """Value of one literal; untyped numbers are given as LINT or LREAL and not `typed`.

    Args:
        node: The literal.
        types: Types of the project by upper-case name, for `COLOUR#RED`.
        where: Its declaration, for messages.

    Raises:
        InputError: malformed or out of its type's range.
    """
    if node.kind != "STRING" and len(node.text) > _LONGEST:
        raise where.error(
            f"a literal of {len(node.text)} characters: {node.text[:20]}...",
            node.at,
            "no type holds such a value",
        )
    try:
        if node.kind == "BOOLEAN":
            return Constant(node.text.upper() == "TRUE", BOOL, True)
        if node.kind == "STRING":
            return Constant(string_literal(node.text), STRING, True)
        if node.kind == "TYPED":
            prefix, _, name = node.text.partition("#")
            kind = types.get(prefix.upper())
            if isinstance(kind, EnumType):
                return member(kind, s.Name(name, node.at), where)
            if prefix.upper() not in ELEMENTARY and prefix.upper() not in ("T", "D"):
                raise where.error(f"there is no type {prefix}", node.at)
            kind, value = typed_literal(node.text)
            return Constant(value, kind, True)
        value = number(node.text)
        name = "LREAL" if isinstance(value, float) else "LINT"
        return Constant(value, ELEMENTARY[name])
    except LiteralError as error:
        raise where.error(str(error), node.at) from None


def member(kind: EnumType, name: s.Name, where: Declared) -> Constant:
    """A member of an enumeration by its name.

    Raises:
        InputError: it has no such member.
    """
    names = [item.upper() for item in kind.members]
    if name.key not in names:
        raise where.error(
            f"{kind.name} has no member {name.text}", name.at, f"it has {', '.join(kind.members)}"
        )
    return Constant(names.index(name.key), kind, True)


def adapt(found: Constant, kind: Type, at: s.Position, where: Declared) -> Constant:
    """Bring a constant to the type that its place asks for.

    An untyped integer fits every integer and bit string type that holds it (BOOL for 0 and 1),
    an untyped real fits REAL and LREAL; everything else must have the type already.

    Raises:
        InputError: another type, or out of its range.
    """
    if found.typed or not isinstance(kind, ElementaryType):
        if found.type != kind:
            shown = describe(found.type) if found.typed else "number"
            raise where.error(
                f"a {describe(kind)} is expected here, not a {shown} literal",
                at,
                _hint(found, kind),
            )
        return found
    value: Scalar = found.value
    if isinstance(value, float):
        if kind.name in ANY_REAL and (kind.name == "LREAL" or abs(value) <= REAL_MAX):
            return Constant(value, kind)
    elif kind.name == "BOOL" and value in (0, 1):
        return Constant(bool(value), kind)
    elif kind.name in INT_RANGE:
        low, high = INT_RANGE[kind.name]
        if low <= int(value) <= high:
            return Constant(value, kind)
        raise where.error(f"{value} is outside {kind.name} ({low} to {high})", at)
    raise where.error(
        f"a {describe(kind)} is expected here, not the number {value}", at, _hint(found, kind)
    )


def _hint(found: Constant, kind: Type) -> str:
    if not isinstance(kind, ElementaryType):
        return f"use a member of {kind.name}" if isinstance(kind, EnumType) else ""
    if kind.name in ANY_REAL and isinstance(found.value, int) and not found.typed:
        return f"write {found.value}.0"
    if kind.name == "TIME":
        return "write a duration such as T#500ms"
    if kind.name == "BOOL":
        return "write TRUE or FALSE"
    if kind.name in ANY_BIT and found.typed:
        return f"write {kind.name}#16#..."
    return ""


def constant(node: s.Init, kind: Type, types: dict[str, Type], where: Declared) -> Constant:
    """Value of an initial value or CASE label: a literal or a member of an enumeration.

    Raises:
        InputError: not constant, or not of the type.
    """
    if isinstance(node, s.Unary) and node.op == "-" and isinstance(node.operand, s.Literal):
        found = literal(node.operand, types, where)
        if found.typed or isinstance(found.value, (bool, str)):
            raise where.error("only a number can be negative here", node.at)
        return adapt(Constant(-found.value, found.type), kind, node.at, where)
    if isinstance(node, s.Literal):
        return adapt(literal(node, types, where), kind, node.at, where)
    if isinstance(node, s.Name) and isinstance(kind, EnumType):
        return member(kind, node, where)
    raise where.error(
        "a constant is expected here", node.at, "write a literal, or a member of an enumeration"
    )


def integer(node: s.Expression, where: Declared) -> int:
    """Value of a literal whole number, as array bounds need it.

    Raises:
        InputError: anything else.
    """
    value = constant(node, ELEMENTARY["DINT"], {}, where).value
    return int(value)
