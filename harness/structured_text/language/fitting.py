"""Implicit conversions, which the checker makes explicit where another type is required."""

from __future__ import annotations

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.constants import adapt
from structured_text.language.operators import LOGIC
from structured_text.language.scalars import (
    ANY_INT,
    BOOL,
    ELEMENTARY,
    INT_RANGE,
    string_length,
)
from structured_text.language.standard import convertible
from structured_text.language.types import (
    ElementaryType,
    EnumType,
    Type,
    integer_name,
    type_name,
)
from structured_text.language.values import describe
from structured_text.language.widening import converted, widening

__all__ = ["Fitting"]


class Fitting:
    """Inserts the implicit conversions in the expressions of one POU."""

    def __init__(self, expressions: Checking) -> None:
        self._all = expressions
        self._scope = expressions.scope

    def fitted(self, found: t.Expression, want: Type, node: s.Expression) -> t.Expression:
        """Return an expression in the required type, converted if its type widens to it.

        Raise InputError if the type does not widen to the required type.
        """
        have = found.type
        hint = ""
        if self._scope.declarations.derives(have, want):
            # Every field of the base is also a field of the value, with the same name and type.
            shown = f"a {describe(have)} where a {describe(want)} is expected"
            self._scope.note("a structure as its base", node.at, shown)
            return found
        if isinstance(want, ElementaryType) and isinstance(have, ElementaryType):
            if isinstance(found, t.Constant) and isinstance(found.value, str):
                return adapt(found, want, node.at, self._scope.where)
            if have.name == want.name:
                return self._cut(found, have, want)
            if widening(have.name, want.name) or self._leaves_fit(node, want.name):
                shown = f"a {describe(have)} where a {describe(want)} is expected"
                written = f"write {have.name}_TO_{want.name}"
                self._scope.note("an implicit conversion", node.at, f"{shown}: {written}")
                return self.converted(found, want)
            name = f"{have.name}_TO_{want.name}"
            hint = f"convert it with {name}" if convertible(have.name, want.name) else ""
        if (
            isinstance(node, s.Assigned)
            and isinstance(want, ElementaryType)
            and want.name == "BOOL"
        ):
            raise self._scope.error(":= assigns, and does not compare", node.at, "write =")
        raise self._scope.error(
            f"a {describe(want)} is expected here, not a {describe(have)}", node.at, hint
        )

    def converted(self, found: t.Expression, want: ElementaryType) -> t.Expression:
        """Return the call of a conversion, or the converted constant."""
        have = found.type
        assert isinstance(have, ElementaryType)
        if have == want:
            return found
        if isinstance(found, t.Constant) and widening(have.name, want.name):
            return t.Constant(converted(found.value, have.name, want), want, True)
        return t.Standard(f"{have.name}_TO_{want.name}", (found,), want)

    def _cut(self, found: t.Expression, have: ElementaryType, want: ElementaryType) -> t.Expression:
        """Return a text for a variable of another length; surplus characters are cut off."""
        if string_length(have) <= string_length(want):
            return found
        return t.Standard(f"{have.name}_TO_{want.name}", (found,), want)

    def _leaves_fit(self, node: s.Expression, want: str) -> bool:
        """Return whether every operand of a calculation fits a type.

        The common type of the operands may be wider. Example: in `I := I + U` with INT and UINT,
        the sum is a DINT. Its lower half, which the INT gets, is the same as in a calculation with
        16 bits.
        """
        if isinstance(node, s.Unary) and node.op == "-":
            return self._leaves_fit(node.operand, want)
        if isinstance(node, s.Binary) and node.op in (*LOGIC, "+", "-", "*", "/", "MOD"):
            return self._leaf_fits(node.left, want) and self._leaf_fits(node.right, want)
        return False

    def _leaf_fits(self, node: s.Expression, want: str) -> bool:
        kind = self._all.infer(node)
        if kind is None or type_name(kind) == want or widening(type_name(kind), want):
            return True
        return self._leaves_fit(node, want)

    def numbered(self, found: t.Expression, want: Type | None, at: s.Position) -> t.Expression:
        """Convert an enumeration to a number, or a number to an enumeration, as `want` requires."""
        if want is None or found.type == want:
            return found
        have = found.type
        if isinstance(want, EnumType) and integer_name(have) in INT_RANGE and have != BOOL:
            if isinstance(have, EnumType) and "strict" in want.attributes:
                return found
            self._scope.note("a number as an enumeration", at)
            number = self.based(found) if isinstance(have, EnumType) else found
            if not isinstance(have, ElementaryType) or have.name not in ANY_INT:
                number = self._as(number, ELEMENTARY[want.base])
            return t.Standard("MOVE", (number,), want)
        if isinstance(have, EnumType) and isinstance(want, ElementaryType):
            known = want.name == have.base or want.name in ANY_INT
            if known or widening(have.base, want.name):
                self._scope.note("an enumeration as a number", at)
                return self._as(self.based(found), want)
        return found

    @staticmethod
    def based(found: t.Expression) -> t.Expression:
        """Return an enumeration as a number of its base type; return any other value unchanged."""
        if not isinstance(found.type, EnumType):
            return found
        base = ELEMENTARY[found.type.base]
        if isinstance(found, t.Constant):
            return t.Constant(found.value, base, True)
        return t.Standard("MOVE", (found,), base)

    @staticmethod
    def _as(found: t.Expression, want: ElementaryType) -> t.Expression:
        """Return a number converted to another type, without a check that the type widens."""
        have = type_name(found.type)
        if have == want.name:
            return found
        if isinstance(found, t.Constant):
            return t.Constant(converted(found.value, have, want), want, True)
        return t.Standard(f"{have}_TO_{want.name}", (found,), want)
