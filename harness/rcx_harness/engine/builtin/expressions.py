"""Python code for checked expressions.

Integer arithmetic is left unwrapped as long as only sums, differences and products follow, and
wrapped once where the exact value matters; the range of each result is known, so that what
cannot overflow is not wrapped. Untyped real literals keep double precision in REAL arithmetic,
as in matiec's C, until the result is stored or passed.
"""

from __future__ import annotations

from ctypes import c_float
from dataclasses import replace

from rcx_harness.engine.builtin.standard import standard_call
from rcx_harness.engine.builtin.storage import address_slot
from rcx_harness.engine.builtin.value import Value, of_type, settle, type_name
from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.project import Project
from rcx_harness.engine.frontend.scalars import ANY_REAL, INT_RANGE
from rcx_harness.engine.types import ArrayType, Type

__all__ = ["Expressions"]

_COMPARISONS = {"=": "==", "<>": "!=", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
#: Python takes 200 pairs of brackets inside each other, some versions fewer in deep expressions.
_BRACKETS = 60
_LOCAL = ("VAR_IN_OUT", "VAR_TEMP", "RESULT")


class Expressions:
    """Writes the expressions of one POU.

    Args:
        project: For the functions and global variables it uses.
        pou: The POU; a function keeps all its variables in Python locals.
    """

    def __init__(self, project: Project, pou: t.Pou) -> None:
        self._project = project
        self._function = pou.kind == "FUNCTION"
        self._parts = 0
        self.parts: list[tuple[str, str]] = []
        """Name and code of each part that is to be a function of its own."""

    # --- variables ---

    def symbol(self, symbol: t.Symbol) -> str:
        """Code that reads a variable, and to which it can be assigned."""
        name = symbol.name.upper()
        if symbol.section == "VAR_EXTERNAL":
            symbol = self._project.global_symbols[name]
            return f"g.{address_slot(symbol.address)}" if symbol.address else f"g.{name}"
        if symbol.address is not None:
            return f"g.{address_slot(symbol.address)}"
        if self._function or symbol.section in _LOCAL:
            return name
        return f"s.{name}"

    def variable(self, node: t.Variable) -> str:
        """Code of a variable, member or element."""
        if isinstance(node, t.Use):
            return self.symbol(node.symbol)
        if isinstance(node, t.Member):
            return f"{self.variable(node.base)}.{node.name.upper()}"
        return f"{self.variable(node.base)}[{self.position(node)}]"

    def position(self, node: t.Index) -> str:
        """Code of the row-major position of an element, with the bounds checked."""
        kind = node.base.type
        assert isinstance(kind, ArrayType)
        offset, parts = 0, []
        stride = 1
        for index, (low, high) in reversed(list(zip(node.indices, kind.bounds, strict=True))):
            if isinstance(index, t.Constant):
                offset += (int(index.value) - low) * stride
            else:
                parts.append(
                    self._checked(index, low, high) + (f" * {stride}" if stride > 1 else "")
                )
                offset -= low * stride
            stride *= high - low + 1
        if not parts:
            return str(offset)
        sign = f" {'-' if offset < 0 else '+'} {abs(offset)}" if offset else ""
        return " + ".join(parts) + sign

    def _checked(self, index: t.Expression, low: int, high: int) -> str:
        value = self.value(index)
        least, most = INT_RANGE[type_name(index.type)]
        if low <= least and most <= high:
            return settle(value, index.type)
        code = value.code
        if isinstance(index, t.Use):
            return f"({code} if {low} <= {code} <= {high} else inside({code}, {low}, {high}))"
        # What lies within the bounds needs no wrapping; the rest is wrapped, and looked at anew.
        wrapped = settle(Value("i_", value.limits), index.type)
        low, high = max(low, least), min(high, most)
        return f"(i_ if {low} <= (i_ := {code}) <= {high} else inside({wrapped}, {low}, {high}))"

    # --- values ---

    def exact(self, node: t.Expression) -> str:
        """Code of an expression with a value of its type."""
        if isinstance(node, t.Constant) and type_name(node.type) == "REAL":
            return repr(c_float(float(node.value)).value)
        return settle(self.value(node), node.type)

    def value(self, node: t.Expression) -> Value:
        """Code of an expression, possibly not wrapped or rounded yet."""
        return self._short(self._value(node), node.type)

    def _short(self, value: Value, kind: Type) -> Value:
        """The value itself; where its code has more brackets than Python takes, a call of it.

        It is a function inside that of the POU, so that it sees the same variables and is
        evaluated when the whole is.
        """
        if len(value.code) < _BRACKETS or _brackets(value.code) < _BRACKETS:
            return value
        self._parts += 1
        name = f"e{self._parts}"
        self.parts.append((name, value.code if value.wide else settle(value, kind)))
        part = of_type(f"{name}()", kind)
        return replace(part, wide=value.wide)

    def _value(self, node: t.Expression) -> Value:
        if isinstance(node, t.Constant):
            return self._constant(node)
        if isinstance(node, (t.Use, t.Member, t.Index)):
            return of_type(self.variable(node), node.type)
        if isinstance(node, t.Unary):
            return self._unary(node)
        if isinstance(node, t.Binary):
            return self._binary(node)
        if isinstance(node, t.CallFunction):
            return self._call(node)
        return self._standard(node, [self.exact(item) for item in node.arguments])

    def _standard(self, node: t.Standard, arguments: list[str]) -> Value:
        if node.name in ("ADD", "MUL") and type_name(node.type) in ANY_REAL:
            # Rounded after each operation, from the left, so that each has brackets of its own.
            while len(arguments) > 2:
                first = self._short(standard_call(node, arguments[:2]), node.type)
                arguments = [first.code, *arguments[2:]]
        return standard_call(node, arguments)

    def _constant(self, node: t.Constant) -> Value:
        name = type_name(node.type)
        if name == "REAL" and node.typed:
            return Value(self.exact(node))
        if name in ANY_REAL:
            return Value(_real(float(node.value)), wide=name == "REAL")
        code = repr(node.value)
        if isinstance(node.value, int) and not isinstance(node.value, bool):
            return Value(f"({code})" if node.value < 0 else code, (node.value, node.value))
        return Value(code)

    def _call(self, node: t.CallFunction) -> Value:
        inputs = self._project.pous[node.function].section("VAR_INPUT")
        arguments = [
            repr(symbol.initial) if argument is None else self.exact(argument)
            for symbol, argument in zip(inputs, node.arguments, strict=True)
        ]
        return of_type(f"f_{node.function}({', '.join(arguments)})", node.type)

    def _unary(self, node: t.Unary) -> Value:
        name = type_name(node.type)
        if name == "BOOL":
            return Value(f"(not {self.exact(node.operand)})")
        if node.op == "NOT":
            mask = INT_RANGE[name][1]
            return of_type(f"({self.exact(node.operand)} ^ {mask})", node.type)
        value = self.value(node.operand)
        low, high = value.limits
        return Value(f"(-{value.code})", (-high, -low), wide=value.wide)

    def _binary(self, node: t.Binary) -> Value:
        op, name = node.op, type_name(node.type)
        if op in _COMPARISONS:
            return self._comparison(node)
        if op in ("AND", "OR", "XOR"):
            symbols = {"AND": "and", "OR": "or", "XOR": "!="}
            if name != "BOOL":
                symbols = {"AND": "&", "OR": "|", "XOR": "^"}
            left, right = self.exact(node.left), self.exact(node.right)
            return of_type(f"({left} {symbols[op]} {right})", node.type)
        if name in ANY_REAL:
            return self._real(node)
        if name == "TIME" and op in ("*", "/"):
            return self._time(node)
        if name not in INT_RANGE:
            return Value(f"({self.exact(node.left)} {op} {self.exact(node.right)})")
        return self._integer(node)

    def _comparison(self, node: t.Binary) -> Value:
        sides = [self.value(side) for side in (node.left, node.right)]
        left, right = (
            side.code if side.wide else settle(side, kind)
            for side, kind in zip(sides, (node.left.type, node.right.type), strict=True)
        )
        return Value(f"({left} {_COMPARISONS[node.op]} {right})")

    def _real(self, node: t.Binary) -> Value:
        if node.op == "**":
            base, power = self.value(node.left).code, self.value(node.right).code
            code = f"math.pow({base}, {power})"
            return Value(code, wide=type_name(node.type) == "REAL")
        left, right = self.value(node.left), self.value(node.right)
        code = f"({left.code} {node.op} {right.code})"
        if type_name(node.type) == "LREAL":
            return Value(code)
        wide = left.wide or right.wide
        return Value(code, wide=True) if wide else Value(f"c_float{code}.value")

    def _time(self, node: t.Binary) -> Value:
        time, factor = self.exact(node.left), self.exact(node.right)
        if type_name(node.right.type) in ANY_REAL:
            name = "time_times" if node.op == "*" else "time_by"
            return Value(f"{name}({time}, {factor})")
        return Value(f"({time} * {factor})" if node.op == "*" else f"div({time}, {factor})")

    def _integer(self, node: t.Binary) -> Value:
        if node.op in ("/", "MOD"):
            return self._division(node)
        left, right = self.value(node.left), self.value(node.right)
        code = f"({left.code} {node.op} {right.code})"
        (a, b), (c, d) = left.limits, right.limits
        if node.op == "+":
            return Value(code, (a + c, b + d))
        if node.op == "-":
            return Value(code, (a - d, b - c))
        corners = (a * c, a * d, b * c, b * d)
        return Value(code, (min(corners), max(corners)))

    def _division(self, node: t.Binary) -> Value:
        left, right = self.exact(node.left), self.exact(node.right)
        low, high = INT_RANGE[type_name(node.type)]
        positive = isinstance(node.right, t.Constant) and int(node.right.value) > 0
        if node.op == "MOD":
            code = f"({left} % {right})" if low == 0 and positive else f"mod({left}, {right})"
            return Value(code, (low, high))
        if low == 0:
            return Value(f"({left} // {right})", (low, high))
        # The least value divided by -1 is one more than the type holds.
        return Value(f"div({left}, {right})", (low, high + (0 if positive else 1)))


def _brackets(code: str) -> int:
    """How many there are; no more than that are inside each other."""
    return code.count("(") + code.count("[")


def _real(value: float) -> str:
    return f"({value!r})" if value < 0 else repr(value)
