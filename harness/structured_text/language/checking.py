"""What the parts of the checker of expressions ask of the whole."""

from __future__ import annotations

from typing import Protocol

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Scope
from structured_text.language.types import ElementaryType, Type

__all__ = ["Checking"]


class Operating(Protocol):
    """What others than the operators ask of `operators.Operators`."""

    def number(self, kind: Type) -> Type:
        """The type in which a value is calculated with."""

    def common(self, one: Type, other: Type, op: str = "") -> Type:
        """The type that two operands are brought to."""

    def binary(
        self, op: str, left: s.Expression, right: s.Expression, want: Type | None, at: s.Position
    ) -> t.Expression:
        """An operator with two operands."""


class Referring(Protocol):
    """What others than the references ask of `references.References`."""

    def followed(self, found: t.Variable) -> t.Variable:
        """What a reference refers to; any other variable as it is."""

    def compared(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression | None:
        """The comparison of two places; None where they are none."""

    def moved(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        """A pointer so many bytes further on."""


class Checking(Protocol):
    """`expressions.Expressions`, as `functions`, `methods`, `operators` and `references` see it.

    Attributes:
        scope: The names of the POU.
    """

    scope: Scope

    @property
    def operators(self) -> Operating:
        """The operators."""

    @property
    def references(self) -> Referring:
        """The references."""

    def variable(self, node: s.Variable) -> t.Variable:
        """A variable, member or element; of a reference what it refers to."""

    def place(self, node: s.Variable) -> t.Variable:
        """The same; of a reference the reference itself."""

    def base(self, node: s.Variable | s.Call | s.Invoke) -> t.Variable:
        """What a member, element or method is of."""

    def is_variable(self, node: s.Name) -> bool:
        """Is it declared as one?"""

    def writable(self, node: s.Variable) -> t.Variable:
        """A variable that may be written."""

    def infer(self, node: s.Expression) -> Type | None:
        """The type by itself; None of untyped numbers."""

    def check(self, node: s.Expression, want: Type | None) -> t.Expression:
        """The expression in the type that is asked for."""

    def converted(self, found: t.Expression, want: ElementaryType) -> t.Expression:
        """The expression in another type, by the function that converts it."""

    def is_real(self, node: s.Expression) -> bool:
        """Is it a number with a point?"""

    def fold(self, node: s.Expression) -> t.Constant | None:
        """Its value, where it is constant."""
