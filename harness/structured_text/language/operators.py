"""Operators: the type of their operands and of their result.

`operand_type` selects the type that both operands are converted to. If both have a type, it is
their common type (`widening.common`). If one operand is an untyped number, the number gets the type
of the other operand, or a wider type if it does not fit. If both are untyped, the context decides.
Bit strings are calculated with as unsigned integers, and bitwise operations convert integers to bit
strings.
"""

from __future__ import annotations

from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.checking import Checking
from structured_text.language.scalars import (
    ANY_BIT,
    ANY_DATE,
    ANY_DURATION,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    BOOL,
    ELEMENTARY,
    INT_RANGE,
    MOMENTS,
    SIGNED,
    UNSIGNED,
    WIDTH,
)
from structured_text.language.types import ElementaryType, EnumType, ReferenceType, Type, type_name
from structured_text.language.values import describe
from structured_text.language.widening import BITS_OF, common, fitting_integer, joined, number_of

__all__ = ["COMPARISONS", "LOGIC", "Operators"]

COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
LOGIC = ("AND", "OR", "XOR", "AND_THEN", "OR_ELSE")
ARITHMETIC = ("+", "-", "*", "/", "MOD")
DINT = ELEMENTARY["DINT"]


class Operators:
    """Checks the operators in the expressions of one POU; `expression_checker` uses this class."""

    def __init__(self, expressions: Checking) -> None:
        self._expressions = expressions
        self._scope = expressions.scope
        self._long: dict[int, t.Expression] = {}

    def number(self, kind: Type) -> Type:
        """Return the numeric type of a value: the unsigned integer for a bit string."""
        return ELEMENTARY[number_of(type_name(kind))] if type_name(kind) in ANY_BIT else kind

    def operand_type(
        self, op: str, left: s.Expression, right: s.Expression, want: Type | None
    ) -> Type | None:
        """Return the type that both operands get; None if neither operand has a type.

        An untyped number gets the type of the other operand, if that type holds it.
        """
        one, other = self._expressions.infer(left), self._expressions.infer(right)
        if op not in COMPARISONS:
            one, other = _number_of_member(one), _number_of_member(other)
        if one is None and other is None:
            return None
        if one is None or other is None:
            kind = one or other
            assert kind is not None
            return self._with_number(op, kind, right if other is None else left, want)
        if one == other:
            return one if op in LOGIC or op in COMPARISONS else self.number(one)
        self._check_common(one, other, right.at)
        return self.common(one, other, op)

    def _check_common(self, one: Type, other: Type, at: s.Position) -> None:
        """Refuse ULINT together with a signed type.

        These types have no common type, because neither holds all values of the other.
        """
        a, b = type_name(one), type_name(other)
        if a in INT_RANGE and b in INT_RANGE and not common(a, b):
            raise self._scope.error(
                f"no integer type has room for both a {a} and a {b}", at, "convert one of them"
            )

    def common(self, one: Type, other: Type, op: str = "") -> Type:
        """Return the common type of two types; the first type if there is none."""
        a, b = type_name(one), type_name(other)
        if one == other or not (a and b):
            return one
        if a == b and isinstance(one, ElementaryType) and isinstance(other, ElementaryType):
            return joined([one, other], longer=False)
        bits = a in ANY_BIT and b in ANY_BIT and op not in LOGIC and op not in COMPARISONS
        if bits and op:
            a, b = number_of(a), number_of(b)
        name = common(a, b)
        return ELEMENTARY[name] if name else one

    def _with_number(
        self, op: str, kind: Type, node: s.Expression, want: Type | None
    ) -> Type | None:
        """Return the operand type for a typed value and an untyped number."""
        name, folded = type_name(kind), self._expressions.fold(node)
        if op not in LOGIC and op not in COMPARISONS:
            name = number_of(name) if name in ANY_BIT else name
            kind = ELEMENTARY[name] if name else kind
        if folded is None or folded.typed or name not in INT_RANGE:
            return kind
        if isinstance(folded.value, float):
            return want if type_name(want) in ANY_REAL else ELEMENTARY["LREAL"]
        low, high = INT_RANGE[name]
        if low <= int(folded.value) <= high:
            return kind
        wider = common(name, fitting_integer(int(folded.value)) or name)
        return ELEMENTARY[wider] if wider else kind

    def moment_type(self, op: str, left: Type | None, right: Type | None) -> Type | None:
        """Return the result type of an operation with a duration or date."""
        a, b = type_name(left), type_name(right)
        if op == "*" and a not in MOMENTS:
            return right
        if op == "-" and a in ANY_DATE and a.removeprefix("L") == b.removeprefix("L"):
            return ELEMENTARY["LTIME" if "L" in (a[0], b[0]) else "TIME"]
        if a in ANY_DURATION and b in ANY_DURATION:
            return ELEMENTARY["LTIME" if "LTIME" in (a, b) else "TIME"]
        if a in ANY_DATE and b == "LTIME" and not a.startswith("L"):
            return ELEMENTARY[f"L{a}"]
        return left or right

    def unary(self, node: s.Unary, want: Type | None) -> t.Expression:
        """Check and type `-x` or `NOT x`, or raise InputError."""
        kind = (
            _number_of_member(self._expressions.infer(node.operand))
            or want
            or ELEMENTARY["BOOL" if node.op == "NOT" else "INT"]
        )
        if node.op == "NOT" and type_name(kind) in BITS_OF:
            self._note_bits("NOT", kind, node.at)
            bits = ELEMENTARY[BITS_OF[type_name(kind)]]
            inner = self._expressions.converted(self._expressions.check(node.operand, kind), bits)
            return self._expressions.converted(t.Unary("NOT", inner, bits), _elementary(kind))
        if node.op == "-" and type_name(kind) in ANY_BIT and type_name(kind) != "BOOL":
            kind = ELEMENTARY[number_of(type_name(kind))]
        if (
            node.op == "-"
            and type_name(kind) in UNSIGNED
            and not isinstance(node.operand, s.Literal)
        ):
            self._scope.note("the negative of an unsigned integer", node.at)
            operand = self._expressions.check(node.operand, kind)
            found = t.Binary("-", t.Constant(0, kind), operand, kind)
            return self._negative(found, node, want) if self.is_short(kind) else found
        allowed = ANY_BIT if node.op == "NOT" else (*SIGNED, *ANY_REAL)
        if type_name(kind) not in allowed:
            raise self._scope.error(f"{node.op} is not defined for {describe(kind)}", node.at)
        negative = t.Unary(node.op, self._expressions.check(node.operand, kind), kind)
        return self._negative(negative, node, want) if self.is_short(kind) else negative

    def _negative(self, short: t.Expression, node: s.Unary, want: Type | None) -> t.Expression:
        """Return the negative of a short integer, calculated as a DINT.

        `short` is the same operation in the integer's own type.
        """
        long = t.Unary("-", self.lengthened(node.operand), DINT)
        return self._shortened(long, short, want, node)

    def _note_bits(self, op: str, kind: Type, at: s.Position) -> None:
        self._scope.note("a bitwise operation of integers", at, f"{op} of a {describe(kind)}")

    def binary(
        self,
        op: str,
        left: s.Expression,
        right: s.Expression,
        want: Type | None,
        at: s.Position,
    ) -> t.Expression:
        """Check and type an operator with two operands; `at` is the position of the operator.

        Raises:
            InputError: The operands have different types, or a type that the operator is not
                defined for.
        """
        references = self._expressions.references
        if op in COMPARISONS:
            same = references.compared(op, left, right, at)
            if same is not None:
                return same
        left_type, right_type = self._expressions.infer(left), self._expressions.infer(right)
        if isinstance(left_type, ReferenceType):
            return references.moved(op, left, right, at)
        if op in COMPARISONS:
            return self._comparison(op, left, right, at)
        if op in LOGIC:
            return self._logic(op, left, right, want, at)
        if op == "**":
            return self._power(left, right, left_type, want, at)
        if type_name(left_type) in MOMENTS or (op == "*" and type_name(right_type) in ANY_DURATION):
            return self._moment(op, left, right, at)
        kind = self.operand_type(op, left, right, want)
        kind = kind or (want if type_name(want) in ANY_NUM else None)
        if kind is None:
            kind = self._expressions.check(left, None).type
        if {type_name(left_type), type_name(right_type)} & set(ANY_BIT) and type_name(
            kind
        ) not in ANY_BIT:
            shown = left_type if type_name(left_type) in ANY_BIT else right_type
            detail = f"{op} of a {describe(shown or kind)}"
            self._scope.note("arithmetic of bit strings", at, detail)
        self._allow(op, kind, ANY_INT if op == "MOD" else ANY_NUM, at)
        divisor = self._expressions.check(right, kind)
        if op in ("/", "MOD") and isinstance(divisor, t.Constant) and divisor.value == 0:
            raise self._scope.error("division by zero", at)
        found = t.Binary(op, self._expressions.check(left, kind), divisor, kind)
        if not self.is_short(kind):
            return found
        long = t.Binary(op, self.lengthened(left), self.lengthened(right), DINT)
        return self._shortened(long, found, want, s.Binary(op, left, right, at))

    def is_short(self, kind: Type) -> bool:
        """Return whether a type is shorter than DINT and the dialect calculates it as DINT."""
        name = type_name(kind)
        return (
            self._scope.registry.dialect.integers == "dint"
            and name in ANY_INT
            and WIDTH[name] < WIDTH["DINT"]
        )

    def lengthened(self, node: s.Expression) -> t.Expression:
        """Check and type an operand, and all calculations in it, as DINT."""
        if id(node) not in self._long:
            self._long[id(node)] = self._lengthened(node)
        return self._long[id(node)]

    def _lengthened(self, node: s.Expression) -> t.Expression:
        kind = self._expressions.infer(node)
        if kind is None or self._expressions.fold(node) is not None:
            return self._expressions.check(node, DINT)
        if isinstance(node, s.Binary) and node.op in ARITHMETIC:
            return t.Binary(node.op, self.lengthened(node.left), self.lengthened(node.right), DINT)
        if isinstance(node, s.Unary) and node.op == "-":
            return t.Unary("-", self.lengthened(node.operand), DINT)
        number = self.number(_number_of_member(kind) or kind)
        return self._expressions.converted(self._expressions.check(node, number), DINT)

    def _shortened(
        self, long: t.Expression, short: t.Expression, want: Type | None, node: s.Expression
    ) -> t.Expression:
        """Return a DINT in the type that the context requires.

        `short` is the same calculation in the type of its operands. The type of `short` decides
        whether the context accepts the result.
        """
        kind = short.type
        assert isinstance(kind, ElementaryType)
        if want is None or want == kind or not isinstance(want, ElementaryType):
            return self._expressions.converted(long, kind)
        if type_name(want) not in (*ANY_NUM, *ANY_BIT[1:]):
            return self._expressions.converted(long, kind)
        self._expressions.fitted(short, want, node)
        return self._expressions.converted(long, want)

    def _logic(
        self, op: str, left: s.Expression, right: s.Expression, want: Type | None, at: s.Position
    ) -> t.Expression:
        if "_" in op:
            return self._both(op, left, right, BOOL, BOOL)
        kind = self.operand_type(op, left, right, want)
        kind = kind or (want if type_name(want) in (*ANY_BIT, *ANY_INT) else None) or BOOL
        if type_name(kind) not in BITS_OF:
            self._allow(op, kind, ANY_BIT, at)
            return self._both(op, left, right, kind, kind)
        self._note_bits(op, kind, at)
        bits = ELEMENTARY[BITS_OF[type_name(kind)]]
        one, other = (
            self._expressions.converted(self._expressions.check(side, kind), bits)
            for side in (left, right)
        )
        return self._expressions.converted(t.Binary(op, one, other, bits), _elementary(kind))

    def _allow(self, op: str, kind: Type, allowed: tuple[str, ...], at: s.Position) -> None:
        if type_name(kind) not in allowed:
            hint = ""
            if type_name(kind) in ANY_BIT:
                hint = "convert bit strings to integers first" if op not in LOGIC else ""
            raise self._scope.error(f"{op} is not defined for {describe(kind)}", at, hint)

    def _comparison(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        kind = self.operand_type(op, left, right, None) or self._expressions.check(left, None).type
        if isinstance(kind, EnumType):
            kind = self._compared(op, kind, left, right)
        simple = isinstance(kind, ElementaryType)
        if not simple and not (isinstance(kind, EnumType) and op in ("=", "<>")):
            raise self._scope.error(f"{op} is not defined for {describe(kind)}", at)
        return self._both(op, left, right, kind, BOOL)

    def _both(
        self, op: str, left: s.Expression, right: s.Expression, kind: Type, result: Type
    ) -> t.Binary:
        """Check and type an operator whose two operands get the same type."""
        one, other = (self._expressions.check(side, kind) for side in (left, right))
        calculated = _calculates(left) or _calculates(right)
        if op in COMPARISONS and calculated and self.is_short(self.number(kind)):
            one, other = self.lengthened(left), self.lengthened(right)
        return t.Binary(op, one, other, result)

    def _compared(self, op: str, kind: EnumType, left: s.Expression, right: s.Expression) -> Type:
        """Return the operand type for a comparison with an enumeration.

        An enumeration and a number are compared as numbers.
        """
        for side in (left, right):
            found = self._expressions.infer(side)
            if type_name(found) in ANY_INT:
                assert found is not None
                return found
            if type_name(found) in (*ANY_BIT[1:], *ANY_REAL):
                return ELEMENTARY[common(kind.base, type_name(found)) or kind.base]
            if isinstance(found, EnumType) and found != kind:
                return ELEMENTARY[common(kind.base, found.base) or kind.base]
            if found is None and self._expressions.fold(side) is not None:
                return ELEMENTARY[kind.base]
        return kind if op in ("=", "<>") else ELEMENTARY[kind.base]

    def _power(
        self,
        left: s.Expression,
        right: s.Expression,
        left_type: Type | None,
        want: Type | None,
        at: s.Position,
    ) -> t.Expression:
        kind = left_type or (want if type_name(want) in ANY_REAL else None) or ELEMENTARY["LREAL"]
        if type_name(kind) in ANY_INT:
            kind = want if want is not None and type_name(want) in ANY_REAL else ELEMENTARY["LREAL"]
        self._allow("**", kind, ANY_REAL, at)
        exponent = self._expressions.check(right, self._expressions.infer(right))
        self._allow("**", exponent.type, ANY_NUM, right.at)
        return t.Binary("**", self._expressions.check(left, kind), exponent, kind)

    def _moment(
        self, op: str, left: s.Expression, right: s.Expression, at: s.Position
    ) -> t.Expression:
        """Check and type an operation with durations or dates.

        The standard defines + and - for them, and * and / of a duration by a number.
        """
        left_type, right_type = self._expressions.infer(left), self._expressions.infer(right)
        a, b = type_name(left_type), type_name(right_type)
        if a not in MOMENTS:
            self._scope.note("a number times a duration", at, f"write the {b} first")
            left, right, left_type, right_type, a = right, left, right_type, left_type, b
        if op in ("*", "/") and a in ANY_DURATION:
            number = self._expressions.check(right, right_type and self.number(right_type))
            self._allow(op, number.type, ANY_NUM, at)
            if op == "/" and isinstance(number, t.Constant) and number.value == 0:
                raise self._scope.error("division by zero", at)
            return t.Binary(op, self._expressions.check(left, left_type), number, ELEMENTARY[a])
        kind = self.moment_type(op, left_type, right_type)
        result = ELEMENTARY[type_name(kind) or a]
        if op == "-" and a.removeprefix("L") == b.removeprefix("L"):
            return self._both(op, left, right, ELEMENTARY[a if a.startswith("L") else b], result)
        if op in ("+", "-") and a not in ("DATE", "LDATE"):
            long = "LTIME" if result.name.startswith("L") else "TIME"
            duration = self._expressions.check(right, ELEMENTARY[long])
            return t.Binary(op, self._expressions.check(left, result), duration, result)
        raise self._scope.error(f"{op} is not defined for {a}", at)


def _number_of_member(kind: Type | None) -> Type | None:
    """Return the integer type of an enumeration; return any other type unchanged."""
    return ELEMENTARY[kind.base] if isinstance(kind, EnumType) else kind


def _calculates(node: s.Expression) -> bool:
    """Return whether an expression is a calculation with numbers."""
    if isinstance(node, s.Unary):
        return node.op == "-"
    return isinstance(node, s.Binary) and node.op in ARITHMETIC


def _elementary(kind: Type) -> ElementaryType:
    assert isinstance(kind, ElementaryType)
    return kind
