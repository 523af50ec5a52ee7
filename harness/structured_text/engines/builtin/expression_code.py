"""Python code for checked expressions.

Integer arithmetic is not wrapped after each sum, difference or product. It is wrapped once, where
the exact value is needed. The range of each result is known, so a result that cannot overflow is
not wrapped. Untyped real literals keep double precision in REAL arithmetic, as in matiec's C, until
the result is stored or passed.
"""

from __future__ import annotations

from collections.abc import Iterable
from ctypes import c_float
from dataclasses import replace

from structured_text.engines.builtin.heap import kinds_of
from structured_text.engines.builtin.pointing import POINTING, Pointing, has_effect
from structured_text.engines.builtin.standard import JOINS, Value, of_type, settle, standard_call
from structured_text.engines.builtin.storage import (
    address_slot,
    in_cell,
    is_scalar,
    needs_globals,
    slot_name,
)
from structured_text.language import tree as t
from structured_text.language.dialects import rules_of
from structured_text.language.project import Project
from structured_text.language.scalars import (
    ANY_DURATION,
    ANY_REAL,
    ANY_STRING,
    INT_RANGE,
    string_length,
)
from structured_text.language.types import (
    ArrayType,
    BlockType,
    ElementaryType,
    Type,
    has_block,
    integer_name,
    type_name,
)

__all__ = ["ExpressionCode", "has_call"]

_COMPARISONS = {"=": "==", "<>": "!=", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
#: Python accepts 200 nested pairs of brackets; some versions accept fewer in deep expressions.
_BRACKETS = 60
_LOCAL = ("VAR_IN_OUT", "VAR_TEMP", "RESULT")


class ExpressionCode:
    """The writer of the expressions of one POU.

    All variables of a function are Python locals.
    """

    def __init__(self, project: Project, pou: t.Pou) -> None:
        self._project = project
        self._rules = rules_of(project.dialect)
        self._shared: dict[str, bool] = {}
        self._function, self._method = pou.kind == "FUNCTION", pou.kind == "METHOD"
        self._own = set(map(id, pou.symbols.values())) if pou.kind == "METHOD" else set()
        self.pointing = Pointing(self, views=project.views, made=kinds_of(project))
        self._views = project.views
        self._parts = 0
        self._results = 0
        self.parts: list[tuple[str, str]] = []
        """Name and code of each part of an expression that becomes a local function."""

    # --- variables ---

    def symbol(self, symbol: t.Symbol) -> str:
        """Return the Python code of a variable, to read or to assign."""
        name = slot_name(symbol.name)
        if symbol.section == "VAR_EXTERNAL":
            name = symbol.source or name
            symbol = self._project.global_symbols[name]
            return f"g.{address_slot(symbol.address)}" if symbol.address else f"g.{name}"
        if symbol.address is not None:
            return f"g.{address_slot(symbol.address)}"
        cell = "[0]" if in_cell(symbol) else ""
        if self.is_local(symbol):
            return f"{name}{cell}"
        return f"s.{name}{cell}" if symbol.shared else f"s.{name}"

    def is_local(self, symbol: t.Symbol) -> bool:
        """Return whether a variable lasts for one call only, as a Python local."""
        if symbol.section == "VAR_EXTERNAL" or symbol.address is not None:
            return False
        of_block = self._method and symbol.shared and id(symbol) not in self._own
        if self._function or (symbol.section in _LOCAL and not of_block):
            return True
        return id(symbol) in self._own and "." not in symbol.name

    def variable(self, node: t.Variable) -> str:
        """Return the Python code of a variable, member or element."""
        if isinstance(node, t.Use):
            return self.symbol(node.symbol)
        if isinstance(node, t.CallFunction):
            return self.exact(node)
        if isinstance(node, t.Member):
            return self._member(node)
        if isinstance(node, t.Index):
            return f"{self.elements(node)}[{self.position(node)}]"
        return self.pointing.variable(node)

    def _member(self, node: t.Member) -> str:
        """Return the Python code of a member of a structure or block.

        A located variable of a program is stored with the globals.
        """
        of, key = node.base.type, node.name.upper()
        if isinstance(of, BlockType) and of.name.upper() in self._project.pous:
            symbol = self._project.pous[of.name.upper()].symbols.get(key)
            if symbol is not None and symbol.address is not None:
                return self.symbol(symbol)
        return f"{self.variable(node.base)}.{slot_name(node.name)}"

    def is_shared(self, name: str) -> bool:
        """Return whether a function, or a function that it calls, uses globals or the time."""
        if name not in self._shared:
            pou = self._project.pous[name]
            self._shared[name] = self.uses_globals(pou, pou.symbols.values())
        return self._shared[name]

    def uses_globals(self, pou: t.Pou, made: Iterable[t.Symbol]) -> bool:
        """Return whether the code of a POU uses the globals `g`.

        `made` are the variables that the POU creates.
        """
        blocks = any(has_block(symbol.type) for symbol in made)
        return needs_globals(pou) or blocks or any(map(self.is_shared, pou.calls))

    @staticmethod
    def cut(code: str, kind: Type) -> str:
        """Return the Python code that cuts a text to the length of a STRING."""
        assert isinstance(kind, ElementaryType)
        return f"{code}[:{string_length(kind)}]"

    def adapted(self, code: str, kind: Type, to: Type) -> str:
        """Return the Python code that adapts an output to the type of its target.

        A text is cut to the length of the target, and a number is converted.
        """
        have, want = integer_name(kind), integer_name(to)
        if have != want:
            node = t.Standard(f"{have}_TO_{want}", (t.Constant(0, kind),), to)
            return settle(standard_call(node, [code], self._rules), to)
        return self.cut(code, to) if have in ANY_STRING else code

    def elements(self, node: t.Index) -> str:
        """Return the Python code of the list that contains an element of an array."""
        base = self.variable(node.base)
        kind = node.base.type
        return f"{base}.held" if isinstance(kind, ArrayType) and kind.open else base

    def given(self, variable: t.Variable, pin: Type) -> str:
        """Return the code that passes a variable to a VAR_IN_OUT.

        An array of open length also passes its bounds.
        """
        code, kind = self.variable(variable), variable.type
        if isinstance(pin, ArrayType) and pin.open and isinstance(kind, ArrayType):
            return code if kind.open else f"Open({code}, {kind.bounds!r})"
        return code

    def position(self, node: t.Index) -> str:
        """Return the code of the row-major position of an element, with the bounds checked."""
        kind = node.base.type
        assert isinstance(kind, ArrayType)
        if kind.open:
            indices = ", ".join(map(self.exact, node.indices))
            return f"{self.variable(node.base)}.position({indices})"
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
        # An index within the bounds needs no wrapping. Any other index is wrapped and checked
        # again.
        wrapped = settle(Value("i_", value.limits), index.type)
        low, high = max(low, least), min(high, most)
        return f"(i_ if {low} <= (i_ := {code}) <= {high} else inside({wrapped}, {low}, {high}))"

    # --- values ---

    def exact(self, node: t.Expression) -> str:
        """Return the Python code of an expression; its value is wrapped or rounded to its type."""
        if isinstance(node, t.Constant) and type_name(node.type) == "REAL":
            return repr(c_float(float(node.value)).value)
        return settle(self.value(node), node.type)

    def value(self, node: t.Expression) -> Value:
        """Return the code of an expression; its value may still need wrapping or rounding."""
        return self._short(self._value(node), node.type)

    def _short(self, value: Value, kind: Type) -> Value:
        """Return the value, or a call of a local function if its code has too many brackets.

        The local function is nested in the function of the POU. It sees the same variables and is
        evaluated at the same time as the whole expression.
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
            return of_type(self._read(self.variable(node), node.type), node.type)
        if isinstance(node, POINTING):
            return of_type(self._read(self.pointing.value(node), node.type), node.type)
        if isinstance(node, t.Unary):
            return self._unary(node)
        if isinstance(node, t.Binary):
            return self._binary(node)
        if isinstance(node, t.CallFunction):
            return self._call(node)
        if isinstance(node, t.Assigned):
            return self._assigned(node)
        return self._standard(node, [self.exact(item) for item in node.arguments])

    def _read(self, code: str, kind: Type) -> str:
        """Return the Python code that reads a variable.

        If pointers of the project can write into texts, a text ends at its first character 0.
        """
        return f"ended({code})" if self._views and type_name(kind) in ANY_STRING else code

    def _standard(self, node: t.Standard, arguments: list[str]) -> Value:
        if node.name in ("ADD", "MUL") and type_name(node.type) in ANY_REAL:
            # Each operation is rounded, from left to right, so each operation needs parentheses of
            # its own.
            while len(arguments) > 2:
                first = self._short(standard_call(node, arguments[:2], self._rules), node.type)
                arguments = [first.code, *arguments[2:]]
        return standard_call(node, arguments, self._rules)

    def _constant(self, node: t.Constant) -> Value:
        name = type_name(node.type)
        if name == "REAL" and node.typed:
            return Value(self.exact(node))
        if name in ANY_REAL:
            return Value(_real(float(node.value)), wide=name == "REAL")
        code = repr(node.value)
        if isinstance(node.value, int):  # a BOOL is an int as well; its limits are ignored
            return Value(f"({code})" if node.value < 0 else code, (node.value, node.value))
        return Value(code)

    def _call(self, node: t.CallFunction) -> Value:
        pou = self._project.pous[node.function]
        inputs = pou.section("VAR_INPUT")
        arguments = [
            repr(symbol.initial) if argument is None else self.exact(argument)
            for symbol, argument in zip(inputs, node.arguments, strict=True)
        ]
        types = {one.name: one.type for one in pou.section("VAR_IN_OUT")}
        arguments += [self.given(variable, types[name]) for name, variable in node.in_outs]
        if self.is_shared(node.function):
            arguments.insert(0, "g")
        call = f"f_{node.function}({', '.join(arguments)})"
        backs = [(name, kind) for name, kind in self._backs(pou)]
        if not backs:
            return of_type(call, node.type)
        self._results += 1
        result = f"r{self._results}"
        targets = dict((*node.in_outs, *node.outputs))
        stores = [
            self._stored(targets[name], kind, f"{result}[{place}]")
            for place, (name, kind) in enumerate(backs, start=1)
            if name in targets
        ]
        parts = ", ".join([f"{result} := {call}", *stores, f"{result}[0]"])
        return of_type(f"({parts})[-1]", node.type)

    def _assigned(self, node: t.Assigned) -> Value:
        """Return a Python expression that assigns a variable and has the assigned value."""
        value = self.exact(node.value)
        if not is_scalar(node.type):
            code = self.variable(node.target)
            return of_type(f"(filled({code}, {value}), {code})[-1]", node.type)
        self._results += 1
        result = f"r{self._results}"
        held = self.adapted(value, node.value.type, node.type)
        stored = self._stored(node.target, node.type, result)
        return of_type(f"({result} := {held}, {stored}, {result})[-1]", node.type)

    def _backs(self, pou: t.Pou) -> list[tuple[str, Type]]:
        """Return name and type of the variables that a function returns after its result.

        These are its scalar VAR_IN_OUT and then its outputs.
        """
        backs = [one for one in pou.section("VAR_IN_OUT") if is_scalar(one.type)]
        return [(one.name, one.type) for one in (*backs, *pou.section("VAR_OUTPUT"))]

    def _stored(self, target: t.Variable, kind: Type, value: str) -> str:
        """Return a Python expression that assigns a value to a variable."""
        code = self.variable(target)
        if not is_scalar(kind):
            return f"filled({code}, {value})"
        value = self.adapted(value, kind, target.type)
        if isinstance(target, t.Index):
            return f"{self.elements(target)}.__setitem__({self.position(target)}, {value})"
        if isinstance(target, t.Use) and code.endswith("[0]"):
            return f"{code[:-3]}.__setitem__(0, {value})"
        owner, _, slot = code.rpartition(".")
        return f"setattr({owner}, {slot!r}, {value})" if owner else f"{code} := {value}"

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
        if op in ("AND_THEN", "OR_ELSE"):
            word = "and" if op == "AND_THEN" else "or"
            return Value(f"({self.exact(node.left)} {word} {self.exact(node.right)})")
        if op in ("AND", "OR", "XOR"):
            symbols = JOINS
            needed = self._rules.operands == "needed"
            if name == "BOOL" and needed and not has_effect(node.right):
                symbols = {"AND": "and", "OR": "or", "XOR": "!="}
            left, right = self.exact(node.left), self.exact(node.right)
            return of_type(f"({left} {symbols[op]} {right})", node.type)
        if name in ANY_REAL:
            return self._real(node)
        if name in ANY_DURATION and op in ("*", "/"):
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
        if node.op == "/" and self._rules.real_by_zero == "infinite":
            code = f"(real_by({left.code}, {right.code}))"
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
        # The least value divided by -1 exceeds the range of the type by one.
        return Value(f"div({left}, {right})", (low, high + (0 if positive else 1)))


def has_call(node: t.Expression) -> bool:
    """Return whether an expression calls a function of the sources, or has another effect."""
    if isinstance(node, t.CallFunction) or has_effect(node):
        return True
    if isinstance(node, t.Binary):
        return has_call(node.left) or has_call(node.right)
    if isinstance(node, t.Unary):
        return has_call(node.operand)
    return isinstance(node, t.Standard) and any(map(has_call, node.arguments))


def _brackets(code: str) -> int:
    """Return the number of opening brackets, an upper limit of their nesting."""
    return code.count("(") + code.count("[")


def _real(value: float) -> str:
    return f"({value!r})" if value < 0 else repr(value)
