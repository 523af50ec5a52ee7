"""Protocols of the expression checker, for the modules that check parts of expressions.

The protocols avoid import cycles: the checker contains `functions`, `methods`, `operators` and
`references`, and these modules use the checker.
"""

from __future__ import annotations

from typing import Protocol

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.declare import Scope
from structured_text.language.types import (
    ElementaryType,
    InterfaceType,
    ReferenceType,
    StructType,
    Type,
)

__all__ = ["Checking"]


class Operating(Protocol):
    """The part of `operators.Operators` that other modules use."""

    def number(self, kind: Type) -> Type:
        """Return the numeric type with which a value of this type is calculated."""

    def common(self, one: Type, other: Type, op: str = "") -> Type:
        """Return the type that both operands are converted to."""

    def binary(
        self, op: str, left: s.Expression, right: s.Expression, want: Type | None, at: s.Position
    ) -> t.Expression:
        """Check and type an operator with two operands.

        `want` is the required type, `at` the position of the operator.
        """


class Referring(Protocol):
    """The interface of `references.References` for other modules."""

    def followed(self, found: t.Variable) -> t.Variable:
        """Return the target of a reference; return any other variable unchanged."""

    def wanted(self, node: s.Expression, want: ReferenceType | InterfaceType) -> t.Expression:
        """Check and type an expression where a pointer, reference or interface is required."""

    def generic(self, node: s.Expression, want: StructType) -> t.Expression:
        """Check and type the argument of an input that is ANY."""

    def compared(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression | None:
        """Check and type a comparison of pointers or interfaces; None for other operands."""

    def moved(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        """Check and type a pointer that is moved by some bytes."""


class Naming(Protocol):
    """The part of `methods.Methods` that other modules use."""

    def bare(self, node: s.Variable) -> s.Variable:
        """Return `Library.Name` as `Name`; without a namespace the node itself."""


class Checking(Protocol):
    """The interface of `ExpressionChecker` for the modules that check parts of expressions.

    Attributes:
        scope: The names of the POU.
    """

    scope: Scope

    @property
    def operators(self) -> Operating:
        """Return the checker of operators."""

    @property
    def references(self) -> Referring:
        """Return the checker of pointers and references."""

    @property
    def methods(self) -> Naming:
        """Return the checker of method calls and of names with a namespace."""

    def variable(self, node: s.Variable) -> t.Variable:
        """Check and type a variable, member or element. A reference is replaced by its target."""

    def place(self, node: s.Variable) -> t.Variable:
        """Check and type a variable, member or element. A reference remains a reference."""

    def base(self, node: s.Variable | s.Call | s.Invoke) -> t.Variable:
        """Check and type the base of a member, element or method."""

    def is_variable(self, node: s.Name) -> bool:
        """Return whether a name without a path is a variable or a property."""

    def writable(self, node: s.Variable) -> t.Variable:
        """Check and type a variable that is written."""

    def infer(self, node: s.Expression) -> Type | None:
        """Return the type that an expression has without its context; None for untyped numbers."""

    def check(self, node: s.Expression, want: Type | None) -> t.Expression:
        """Check and type an expression in the required type."""

    def converted(self, found: t.Expression, want: ElementaryType) -> t.Expression:
        """Return the expression converted to another type."""

    def fitted(self, found: t.Expression, want: Type, node: s.Expression) -> t.Expression:
        """Return an expression in the required type, if its type widens to it."""

    def is_real(self, node: s.Expression) -> bool:
        """Return whether an expression is an untyped number with decimals."""

    def fold(self, node: s.Expression) -> t.Constant | None:
        """Return the value of an expression if it is constant, else None."""
