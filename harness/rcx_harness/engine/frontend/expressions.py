"""Checks expressions and gives each its type; nothing is ever converted silently."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable

from rcx_harness.engine.compiling import MOST_OPERATORS
from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.calls import function_arguments, standard_arguments
from rcx_harness.engine.frontend.constants import adapt, literal, member
from rcx_harness.engine.frontend.declare import Scope
from rcx_harness.engine.frontend.scalars import (
    ANY_BIT,
    ANY_DATE,
    ANY_INT,
    ANY_NUM,
    ANY_REAL,
    BOOL,
    ELEMENTARY,
    SIGNED,
    TIME,
)
from rcx_harness.engine.frontend.standard import BLOCKS, FUNCTIONS, Signature, conversion
from rcx_harness.engine.frontend.values import describe
from rcx_harness.engine.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    EnumType,
    StructType,
    Type,
)
from rcx_harness.errors import InputError

__all__ = ["Expressions", "group"]

_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
_LOGIC = ("AND", "OR", "XOR")
#: Standard functions that are operators, and the time functions written as such.
_OPERATORS = {
    "ADD": "+",
    "SUB": "-",
    "MUL": "*",
    "DIV": "/",
    "MOD": "MOD",
    "EXPT": "**",
    "AND": "AND",
    "OR": "OR",
    "XOR": "XOR",
    "GT": ">",
    "GE": ">=",
    "EQ": "=",
    "LE": "<=",
    "LT": "<",
    "NE": "<>",
    "ADD_TIME": "+",
    "SUB_TIME": "-",
    "MULTIME": "*",
    "DIVTIME": "/",
}
#: No type holds so much, nor half of it on the way to a smaller result.
_LARGEST = 1 << 128


def group(kind: Type | None) -> str:
    """Name of an elementary type; empty for every other type."""
    return kind.name if isinstance(kind, ElementaryType) else ""


class Expressions:
    """The expressions of one POU.

    `infer` finds the type an expression has by itself, None where it is made of untyped numbers
    only; `check` then gives it a type, which for untyped numbers is the one asked for.
    """

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        # By `id` of a piece of syntax: long expressions are asked the same at each operator.
        self._inferred: dict[int, Type | None] = {}
        self._folded: dict[int, t.Constant | None] = {}
        self._checked: dict[tuple[int, str], t.Expression] = {}
        self._depth = 0

    # --- variables ---

    def variable(self, node: s.Variable) -> t.Variable:
        """Resolve a variable, member or element.

        Raises:
            InputError: undeclared, no such member, or a wrong index.
        """
        if isinstance(node, s.Name):
            symbol = self.scope.symbol(node.key)
            if symbol is None:
                raise self._undeclared(node)
            return t.Use(symbol, symbol.type)
        base = self.variable(node.base)
        if isinstance(node, s.Field):
            return self._member(base, node)
        return self._element(base, node)

    def _undeclared(self, node: s.Name) -> InputError:
        symbols = [symbol.name for symbol in self.scope.pou.symbols.values()]
        return self.scope.error(f"{node.text} is not declared", node.at, _near(node.key, symbols))

    def _member(self, base: t.Variable, node: s.Field) -> t.Member:
        kind, key = base.type, node.name.key
        if isinstance(kind, StructType):
            for name, field in kind.fields:
                if name.upper() == key:
                    return t.Member(base, name, field)
            near = _near(key, [name for name, _ in kind.fields])
        elif isinstance(kind, BlockType):
            for pin in kind.variables:
                if pin.name.upper() == key:
                    if pin.section not in ("VAR_INPUT", "VAR_OUTPUT"):
                        raise self.scope.error(
                            f"{pin.name} is internal to {kind.name}", node.name.at
                        )
                    return t.Member(base, pin.name, pin.type)
            near = _near(key, [pin.name for pin in kind.variables])
        else:
            raise self.scope.error(f"a {describe(kind)} has no members", node.name.at)
        raise self.scope.error(f"{kind.name} has no member {node.name.text}", node.name.at, near)

    def _element(self, base: t.Variable, node: s.Index) -> t.Index:
        kind = base.type
        if not isinstance(kind, ArrayType):
            raise self.scope.error(f"a {describe(kind)} has no elements", node.at)
        if len(node.indices) != len(kind.bounds):
            raise self.scope.error(
                f"{describe(kind)} has {len(kind.bounds)} dimensions, not {len(node.indices)}",
                node.at,
            )
        indices = []
        for index, (low, high) in zip(node.indices, kind.bounds, strict=True):
            index_type = self.infer(index) or ELEMENTARY["DINT"]
            if group(index_type) not in ANY_INT:
                raise self.scope.error(
                    f"an index must be an integer, not a {describe(index_type)}", index.at
                )
            found = self.check(index, index_type)
            if isinstance(found, t.Constant) and not low <= int(found.value) <= high:
                raise self.scope.error(f"index {found.value} is outside {low}..{high}", index.at)
            indices.append(found)
        return t.Index(base, tuple(indices), kind.element)

    # --- types ---

    def infer(self, node: s.Expression) -> Type | None:
        """The type an expression has by itself; None for untyped numbers."""
        if id(node) not in self._inferred:
            self._inferred[id(node)] = self._infer(node)
        return self._inferred[id(node)]

    def _infer(self, node: s.Expression) -> Type | None:
        if isinstance(node, s.Literal):
            found = literal(node, self.scope.declarations.types, self.scope.where)
            return found.type if found.typed else None
        if isinstance(node, s.Name) and self.scope.symbol(node.key) is None:
            return self._enumeration(node)
        if isinstance(node, (s.Name, s.Field, s.Index)):
            return self.variable(node).type
        if isinstance(node, s.Unary):
            return self.infer(node.operand)
        if isinstance(node, s.Call):
            return self._result_of(node)
        if node.op in _COMPARISONS:
            return BOOL
        left = self.infer(node.left)
        if node.op == "**":
            return left
        right = self.infer(node.right)
        if node.op == "-" and left == right and group(left) in ANY_DATE:
            return TIME
        return left or right

    def _enumeration(self, node: s.Name) -> Type | None:
        owners = self.scope.registry.members.get(node.key, [])
        if not owners:
            raise self._undeclared(node)
        return self.scope.declarations.types[owners[0]] if len(owners) == 1 else None

    def check(self, node: s.Expression, want: Type | None) -> t.Expression:
        """Type an expression.

        Args:
            node: The expression.
            want: The type its place asks for; None where any will do.

        Raises:
            InputError: a type that does not fit, an undeclared name and the like.
        """
        key = id(node), group(want)
        known = self._checked.get(key)
        if known is not None and (want is None or key[1]):
            return known
        self._depth += 1
        try:
            found = self._checked[key] = self._fitting(node, want)
        finally:
            self._depth -= 1
        return found

    def _fitting(self, node: s.Expression, want: Type | None) -> t.Expression:
        if self._depth > MOST_OPERATORS:
            raise self.scope.error(
                f"an expression of more than {MOST_OPERATORS:,} operators inside each other",
                node.at,
                "assign parts of it to variables first",
            )
        found = self._typed(node, want)
        if isinstance(found.type, BlockType):
            raise self.scope.error(f"a block of type {found.type.name} is no value", node.at)
        if want is not None and found.type != want:
            hint = ""
            if isinstance(want, ElementaryType) and isinstance(found.type, ElementaryType):
                name = f"{found.type.name}_TO_{want.name}"
                hint = f"convert it with {name}" if conversion(name) else ""
            raise self.scope.error(
                f"a {describe(want)} is expected here, not a {describe(found.type)}", node.at, hint
            )
        return found

    def _typed(self, node: s.Expression, want: Type | None) -> t.Expression:
        if isinstance(node, s.Name) and self.scope.symbol(node.key) is None:
            return self._member_of_enumeration(node, want)
        if isinstance(node, (s.Name, s.Field, s.Index)):
            return self.variable(node)
        if isinstance(node, s.Call):
            return self._call(node, want)
        folded = self._fold(node)
        if folded is not None:
            if folded.typed:
                return folded
            return adapt(folded, want or _default(folded), node.at, self.scope.where)
        if isinstance(node, s.Unary):
            return self._unary(node, want)
        assert isinstance(node, s.Binary)
        return self.binary(node.op, node.left, node.right, want, node.at)

    def _member_of_enumeration(self, node: s.Name, want: Type | None) -> t.Constant:
        kind = self._enumeration(node)
        if isinstance(want, EnumType):
            owners = self.scope.registry.members[node.key]
            if want.name.upper() in owners:
                return member(want, node, self.scope.where)
        if not isinstance(kind, EnumType):
            owners = self.scope.registry.members[node.key]
            raise self.scope.error(
                f"{node.text} is a member of {' and '.join(owners)}",
                node.at,
                f"write {owners[0]}#{node.text}",
            )
        return member(kind, node, self.scope.where)

    def _fold(self, node: s.Expression) -> t.Constant | None:
        """Value of a literal, or of arithmetic on untyped numbers; None for anything else."""
        if id(node) not in self._folded:
            self._folded[id(node)] = self._value(node)
        return self._folded[id(node)]

    def _value(self, node: s.Expression) -> t.Constant | None:
        if isinstance(node, s.Literal):
            return literal(node, self.scope.declarations.types, self.scope.where)
        if isinstance(node, s.Unary) and node.op == "-":
            found = self._fold(node.operand)
            if found is None or found.typed:
                return None
            return t.Constant(-found.value, found.type)  # type: ignore[operator]
        if not isinstance(node, s.Binary) or node.op not in ("+", "-", "*", "/", "MOD"):
            return None
        left, right = self._fold(node.left), self._fold(node.right)
        if left is None or right is None or left.typed or right.typed or left.type != right.type:
            return None
        value = self._calculate(node, left.value, right.value)  # type: ignore[arg-type]
        if not abs(value) < (_LARGEST if isinstance(value, int) else math.inf):
            raise self.scope.error("the result of this constant expression is too large", node.at)
        return t.Constant(value, left.type)

    def _calculate(self, node: s.Binary, left: float, right: float) -> int | float:
        if node.op == "+":
            return left + right
        if node.op == "-":
            return left - right
        if node.op == "*":
            return left * right
        if right == 0:
            raise self.scope.error("division by zero", node.at)
        if isinstance(left, int) and isinstance(right, int):
            quotient = abs(left) // abs(right) * (1 if (left < 0) == (right < 0) else -1)
            return quotient if node.op == "/" else left - quotient * right
        return left / right if node.op == "/" else math.fmod(left, right)

    # --- operators ---

    def _unary(self, node: s.Unary, want: Type | None) -> t.Expression:
        kind = self.infer(node.operand) or want or ELEMENTARY["BOOL" if node.op == "NOT" else "INT"]
        allowed = ANY_BIT if node.op == "NOT" else (*SIGNED, *ANY_REAL)
        if group(kind) not in allowed:
            raise self.scope.error(f"{node.op} is not defined for {describe(kind)}", node.at)
        return t.Unary(node.op, self.check(node.operand, kind), kind)

    def binary(
        self,
        op: str,
        left: s.Expression,
        right: s.Expression,
        want: Type | None,
        at: s.Position,
    ) -> t.Expression:
        """Type an operator with two operands; `at` is where the operator stands.

        Raises:
            InputError: operands of different types, or of a type it is not defined for.
        """
        left_type, right_type = self.infer(left), self.infer(right)
        if op in _COMPARISONS:
            return self._comparison(op, left, right, left_type or right_type, at)
        if op in _LOGIC:
            logic = left_type or right_type or want or BOOL
            self._allow(op, logic, ANY_BIT, at)
            return t.Binary(op, self.check(left, logic), self.check(right, logic), logic)
        if op == "**":
            return self._power(left, right, left_type, want, at)
        if group(left_type) in ("TIME", *ANY_DATE):
            return self._moment(op, left, right, left_type, right_type, at)
        kind = left_type or right_type or (want if group(want) in ANY_NUM else None)
        if kind is None:
            kind = self.check(left, None).type
        self._allow(op, kind, ANY_INT if op == "MOD" else ANY_NUM, at)
        divisor = self.check(right, kind)
        if op in ("/", "MOD") and isinstance(divisor, t.Constant) and divisor.value == 0:
            raise self.scope.error("division by zero", at)
        return t.Binary(op, self.check(left, kind), divisor, kind)

    def _allow(self, op: str, kind: Type, allowed: tuple[str, ...], at: s.Position) -> None:
        if group(kind) not in allowed:
            hint = ""
            if group(kind) in ANY_BIT:
                hint = "convert bit strings to integers first" if op not in _LOGIC else ""
            raise self.scope.error(f"{op} is not defined for {describe(kind)}", at, hint)

    def _comparison(
        self,
        op: str,
        left: s.Expression,
        right: s.Expression,
        kind: Type | None,
        at: s.Position,
    ) -> t.Expression:
        kind = kind or self.check(left, None).type
        simple = isinstance(kind, ElementaryType)
        if not simple and not (isinstance(kind, EnumType) and op in ("=", "<>")):
            raise self.scope.error(f"{op} is not defined for {describe(kind)}", at)
        return t.Binary(op, self.check(left, kind), self.check(right, kind), BOOL)

    def _power(
        self,
        left: s.Expression,
        right: s.Expression,
        left_type: Type | None,
        want: Type | None,
        at: s.Position,
    ) -> t.Expression:
        kind = left_type or (want if group(want) in ANY_REAL else None) or ELEMENTARY["LREAL"]
        self._allow("**", kind, ANY_REAL, at)
        exponent = self.check(right, self.infer(right))
        self._allow("**", exponent.type, ANY_NUM, right.at)
        return t.Binary("**", self.check(left, kind), exponent, kind)

    def _moment(
        self,
        op: str,
        left: s.Expression,
        right: s.Expression,
        left_type: Type | None,
        right_type: Type | None,
        at: s.Position,
    ) -> t.Expression:
        """TIME and dates: + and - among them as the standard allows, TIME * and / a number."""
        name = group(left_type)
        if op in ("*", "/") and name == "TIME":
            number = self.check(right, right_type)
            self._allow(op, number.type, ANY_NUM, at)
            if op == "/" and isinstance(number, t.Constant) and number.value == 0:
                raise self.scope.error("division by zero", at)
            return t.Binary(op, self.check(left, TIME), number, TIME)
        if op == "-" and left_type == right_type:
            return t.Binary(op, self.check(left, left_type), self.check(right, left_type), TIME)
        if op in ("+", "-") and name in ("TIME", "TOD", "DT"):
            kind = ELEMENTARY[name]
            return t.Binary(op, self.check(left, kind), self.check(right, TIME), kind)
        raise self.scope.error(f"{op} is not defined for {name}", at)

    # --- calls of functions ---

    def _result_of(self, node: s.Call) -> Type | None:
        """Type of the result; None where it is what the context asks for."""
        key = node.function.key
        declared = self.scope.declarations.pous.get(key)
        if declared is not None and declared.result is not None:
            return declared.result.type
        pair = conversion(key)
        if pair is not None:
            return ELEMENTARY[pair[1]]
        signature = FUNCTIONS.get(key)
        if signature is None or signature.result == "ANY_INT":
            return None
        if signature.result != "T":
            return ELEMENTARY[signature.result]
        return self._common_type(node, signature)

    def _common_type(self, node: s.Call, signature: Signature) -> Type | None:
        for argument, (_, kind) in standard_arguments(node, signature, self.scope):
            found = self.infer(argument.value) if kind == "T" else None
            if found is not None:
                return found
        return None

    def _call(self, node: s.Call, want: Type | None) -> t.Expression:
        key, name, at = node.function.key, node.function.text, node.at
        pou = self.scope.declarations.pous.get(key)
        if pou is not None and pou.kind == "FUNCTION" and pou.result is not None:
            return self._user(node, pou)
        if pou is not None or key in BLOCKS:
            raise self.scope.error(
                f"{name} is a block, not a function", at, "declare an instance and call that"
            )
        if conversion(key) is not None:
            return self._conversion(node)
        if key not in FUNCTIONS:
            symbol = self.scope.symbol(key)
            if symbol is not None:
                raise self.scope.error(f"{name} is a {describe(symbol.type)}, not a function", at)
            raise self.scope.error(
                f"there is no function {name}", at, "name its file too, or look at the spelling"
            )
        if key in _OPERATORS and len(node.arguments) <= 2:
            pairs = standard_arguments(node, FUNCTIONS[key], self.scope)
            left, right = (argument.value for argument, _ in pairs)
            if key in ("ADD_TIME", "SUB_TIME", "MULTIME", "DIVTIME"):
                self.check(left, ELEMENTARY["TIME"])
            return self.binary(_OPERATORS[key], left, right, want, at)
        return self._standard(node, FUNCTIONS[key], want)

    def _user(self, node: s.Call, pou: t.Pou) -> t.Expression:
        given = function_arguments(node, pou, self.scope)
        arguments = tuple(
            self.check(given[symbol.name.upper()].value, symbol.type)
            if symbol.name.upper() in given
            else None
            for symbol in pou.section("VAR_INPUT")
        )
        assert pou.result is not None
        return t.CallFunction(pou.name.upper(), arguments, pou.result.type)

    def _conversion(self, node: s.Call) -> t.Expression:
        pair = conversion(node.function.key)
        assert pair is not None
        signature = Signature((("IN", pair[0]),), (), pair[1])
        ((argument, _),) = standard_arguments(node, signature, self.scope)
        value = self.check(argument.value, ELEMENTARY[pair[0]])
        return t.Standard(f"{pair[0]}_TO_{pair[1]}", (value,), ELEMENTARY[pair[1]])

    def _standard(self, node: s.Call, signature: Signature, want: Type | None) -> t.Expression:
        name = node.function.key
        pairs = standard_arguments(node, signature, self.scope)
        common = self._common_type(node, signature)
        if common is None and any(kind == "T" for _, (_, kind) in pairs):
            wanted = (
                want if isinstance(want, ElementaryType) and want.name in signature.group else None
            )
            first = next(argument.value for argument, (_, kind) in pairs if kind == "T")
            common = (wanted if signature.result == "T" else None) or self.check(first, None).type
        if common is not None and (
            not isinstance(common, ElementaryType) or common.name not in signature.group
        ):
            raise self.scope.error(f"{name} is not defined for {describe(common)}", node.at)
        arguments = []
        for argument, (_, kind) in pairs:
            expected: Type | None
            if kind == "T":
                expected = common
            elif kind in ("ANY_INT", "ANY_NUM"):
                expected = self._number(argument, ANY_INT if kind == "ANY_INT" else ANY_NUM)
            else:
                expected = ELEMENTARY[kind]
            arguments.append(self.check(argument.value, expected))
        return t.Standard(name, tuple(arguments), self._result(signature, common, want))

    def _number(self, argument: s.Argument, allowed: tuple[str, ...]) -> Type:
        found = self.infer(argument.value)
        if found is None:
            return self.check(argument.value, None).type
        if not isinstance(found, ElementaryType) or found.name not in allowed:
            raise self.scope.error(
                f"a number is expected here, not a {describe(found)}", argument.at
            )
        return found

    def _result(self, signature: Signature, common: Type | None, want: Type | None) -> Type:
        if signature.result == "T":
            return common or BOOL
        if signature.result != "ANY_INT":
            return ELEMENTARY[signature.result]
        if isinstance(want, ElementaryType) and want.name in ANY_INT:
            return want
        return ELEMENTARY["INT"]


def _near(key: str, names: Iterable[str]) -> str:
    """A hint on the names that are near an upper-case one."""
    known = {name.upper(): name for name in names}
    close = difflib.get_close_matches(key, known, n=2)
    return f"did you mean {' or '.join(known[name] for name in close)}?" if close else ""


def _default(found: t.Constant) -> Type:
    """The type of an untyped number where nothing asks for one."""
    return ELEMENTARY["LREAL" if isinstance(found.value, float) else "LINT"]
