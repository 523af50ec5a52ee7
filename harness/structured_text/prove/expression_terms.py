"""Translation of checked expressions into terms of the solver."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from functools import reduce
from itertools import pairwise
from typing import Any, Protocol

import z3

from structured_text.engines.builtin.storage import is_scalar
from structured_text.language import tree as t
from structured_text.language.dialects import rules_of
from structured_text.language.project import Project
from structured_text.language.scalars import (
    ANY_CHARS,
    ANY_DURATION,
    ANY_INT,
    ANY_REAL,
    ELEMENTARY,
    INT_RANGE,
    MOMENTS,
    SIGNED,
    STRING_MAX,
    WIDTH,
    string_length,
)
from structured_text.language.types import ArrayType, ElementaryType, Type, type_name
from structured_text.language.values import array_length
from structured_text.prove import known_calls, overflow, reals, texts, values
from structured_text.prove.logic import Bool, UnsupportedError, both, is_known, logical, negated
from structured_text.prove.overflow import Span, resized
from structured_text.prove.symbolic_memory import Alternatives, Leaf
from structured_text.prove.values import TIME_BITS, Value

__all__ = ["ExpressionTerms"]

_COMPARISONS = ("=", "<>", "<", ">", "<=", ">=")
_CHAINS = {"GT": ">", "GE": ">=", "EQ": "=", "LE": "<=", "LT": "<", "NE": "<>"}
_JOINS = {"ADD": "+", "MUL": "*", "SUB": "-", "DIV": "/", "MOD": "MOD"}
_BITS = ("BYTE", "WORD", "DWORD", "LWORD")


class _Machine(Protocol):
    """The interface of `machine.Machine` that `ExpressionTerms` uses."""

    project: Project

    @property
    def summaries(self) -> Mapping[str, Callable[[Any, list[Value]], Value]]: ...

    def leaves(self, kind: Type) -> tuple[Leaf, ...]: ...

    def load(self, places: Alternatives, kind: Type) -> Value: ...

    def store(self, places: Alternatives, kind: Type, value: Value) -> None: ...

    def element(self, array: Alternatives, kind: ArrayType, index: Value) -> Value: ...

    def set_element(
        self, array: Alternatives, kind: ArrayType, index: Value, value: Value
    ) -> None: ...

    def oblige(self, kind: str, bad: Bool) -> None: ...

    def computes(self, node: t.Expression, leaves: Callable[[Span], Bool]) -> None: ...

    def under(self, condition: Bool) -> AbstractContextManager[None]: ...

    def root(self, symbol: t.Symbol) -> Alternatives: ...

    def call_function(self, name: str, arguments: list[Value | Alternatives | None]) -> Any: ...


class ExpressionTerms:
    """Evaluates expressions in the memory of a machine."""

    def __init__(self, machine: _Machine) -> None:
        self._machine = machine
        self._rules = rules_of(machine.project.dialect)

    # --- variables ---

    def places(self, node: t.Expression) -> Alternatives:
        """Return the memory paths of a variable, or of a returned structure or array.

        A constant index adds one step to the path. An index that is not constant gives one
        alternative per element, with the condition that the index selects it.

        Raises:
            UnsupportedError: The expression is not a variable and not a result of a function.
        """
        if isinstance(node, t.Use):
            return self._machine.root(node.symbol)
        if isinstance(node, t.Member):
            return [(c, (*path, node.name.upper())) for c, path in self.places(node.base)]
        if isinstance(node, t.Index):
            base = self.places(node.base)
            index = self._position(node)
            if is_known(index):
                return [(c, (*path, index)) for c, path in base]
            assert isinstance(node.base.type, ArrayType)
            return [
                (both(c, values.compare("=", index, place, _DINT)), (*path, place))
                for c, path in base
                for place in range(array_length(node.base.type))
            ]
        if isinstance(node, t.CallFunction):
            result: Alternatives = self._call(node)
            return result
        raise UnsupportedError(f"{type(node).__name__} of a structure or an array is not supported")

    def _position(self, node: t.Index) -> Value:
        """Return the row-major position of an element as DINT, from 0 on.

        Record the obligation that each index is inside its bounds. A constant index is clamped, so
        that the evaluation can continue after the obligation.
        """
        kind = node.base.type
        assert isinstance(kind, ArrayType)
        position: Value = 0
        for expression, (low, high) in zip(node.indices, kind.bounds, strict=True):
            index = self.exact(expression)
            if is_known(index):
                self._machine.oblige("index", not low <= index <= high)
                index = min(max(index, low), high)
            else:
                wide = resized(index, expression.type, TIME_BITS)
                inside = both(
                    values.compare(">=", wide, low, _TIME), values.compare("<=", wide, high, _TIME)
                )
                self._machine.oblige("index", negated(inside))
                index = resized(index, expression.type, 32)
            index = values.combine("-", index, low, _DINT)
            position = values.combine("*", position, high - low + 1, _DINT)
            position = values.combine("+", position, index, _DINT)
        return position

    def long_element(self, node: t.Expression) -> tuple[Alternatives, ArrayType, Value] | None:
        """Return array, type and position of an element of a long array, else None."""
        if not isinstance(node, t.Index):
            return None
        (leaf, *_) = self._machine.leaves(node.base.type)
        if leaf.suffix or not leaf.long:
            return None
        kind = node.base.type
        assert isinstance(kind, ArrayType)
        return self.places(node.base), kind, self._position(node)

    def assign(self, target: t.Variable, value: Value) -> None:
        """Assign a value to a scalar variable."""
        found = self.long_element(target)
        if found is not None:
            self._machine.set_element(*found, value)
        else:
            self._machine.store(self.places(target), target.type, value)

    # --- values ---

    def exact(self, node: t.Expression) -> Value:
        """Return the value of an expression in its own type; a REAL has single precision."""
        if isinstance(node, t.Constant):
            return values.constant(node.type, node.value)
        value = self.value(node)
        return (
            reals.settled(value, type_name(node.type)) if isinstance(value, reals.Real) else value
        )

    def value(self, node: t.Expression) -> Value:
        """Return the value of an expression; a REAL may still have double precision.

        As in the engines, an untyped literal keeps double precision in REAL arithmetic until the
        result is stored or passed.
        """
        if isinstance(node, t.Constant):
            if type_name(node.type) == "REAL" and not node.typed:
                return reals.constant(float(node.value), "REAL", wide=True)
            return values.constant(node.type, node.value)
        if isinstance(node, (t.Use, t.Member, t.Index)):
            found = self.long_element(node)
            if found is not None:
                return self._machine.element(*found)
            return self._machine.load(self.places(node), node.type)
        if isinstance(node, t.Unary):
            return self._unary(node)
        if isinstance(node, t.Binary):
            return self._binary(node)
        if isinstance(node, t.CallFunction):
            return self._call(node)
        assert isinstance(node, t.Standard)
        return self._standard(node)

    def _call(self, node: t.CallFunction) -> Any:
        inputs = self._machine.project.pous[node.function].section("VAR_INPUT")
        arguments = [
            None
            if argument is None
            else (self.exact(argument) if is_scalar(symbol.type) else self.places(argument))
            for symbol, argument in zip(inputs, node.arguments, strict=True)
        ]
        return self._machine.call_function(node.function, arguments)

    def _unary(self, node: t.Unary) -> Value:
        if type_name(node.type) in ANY_REAL:
            return reals.negative(self.value(node.operand))
        value = self.exact(node.operand)
        if node.op == "-":
            self._machine.computes(node, lambda time: overflow.negation(value, node.type, time))
            return values.negate(value, node.type)
        if type_name(node.type) == "BOOL":
            return negated(value)
        return values.combine("XOR", value, (1 << values.bits(node.type)) - 1, node.type)

    def _binary(self, node: t.Binary) -> Value:
        op, name = node.op, type_name(node.type)
        if op in _COMPARISONS:
            real = type_name(node.left.type) in ANY_REAL
            left, right = (
                self.value(s) if real else self.exact(s) for s in (node.left, node.right)
            )
            return values.compare(op, left, right, node.left.type)
        if name == "BOOL":
            # As in the engines, the right operand is not evaluated if the left one decides the
            # result, except in dialects that evaluate both.
            left = self.exact(node.left)
            looked_at = {"AND": left, "OR": negated(left), "XOR": True}[op]
            if self._rules.operands == "both":
                looked_at = True
            with self._machine.under(looked_at):
                right = self.exact(node.right)
            return logical(op, left, right)
        if name in ANY_REAL:
            return self._real(op, self.value(node.left), self.value(node.right), name)
        left, right = self.exact(node.left), self.exact(node.right)
        if name in ANY_DURATION and op in ("*", "/"):
            if type_name(node.right.type) in ANY_REAL:
                return self._scaled(node, left, right)
            right = resized(right, node.right.type, TIME_BITS)
        return self._combined(op, left, right, node)

    def _real(self, op: str, left: reals.Real, right: reals.Real, name: str) -> reals.Real:
        if op == "/" and self._rules.real_by_zero == "stop":
            zero = reals.compare("=", right, reals.constant(0.0, "LREAL"))
            self._machine.oblige("division", zero)
        return reals.arithmetic(op, left, right, name)

    def _scaled(self, node: t.Binary, time: Value, factor: reals.Real) -> Value:
        """Return a TIME multiplied or divided by a REAL, truncated towards zero."""
        number = reals.from_integer(time, "LREAL", signed=True)
        exact = self._real(node.op, number, reals.widened(factor), "LREAL")
        result = self._cut(exact, TIME_BITS, _TIME)
        self._machine.computes(node, lambda time: overflow.outside(result, _TIME, time))
        return result

    def _cut(self, number: reals.Real, width: int, kind: Type) -> Value:
        """Return a number truncated towards zero; record the obligation that it fits its type."""
        signed = type_name(kind) in MOMENTS or type_name(kind) in SIGNED
        self._machine.oblige("conversion", negated(reals.fits(number, width, signed=signed)))
        return reals.cut(number, width, signed=signed)

    def _combined(self, op: str, left: Value, right: Value, node: t.Expression) -> Value:
        kind = _TIME if isinstance(node, t.Standard) and "_TO_" in node.name else node.type
        if op not in ("AND", "OR", "XOR"):
            self._machine.computes(
                node, lambda time: overflow.arithmetic(op, left, right, kind, time)
            )
        if op == "/":
            self._machine.oblige("division", values.compare("=", right, 0, kind))
        result = values.combine(op, left, right, kind)
        if values.bits(kind) == TIME_BITS and not is_known(result) and op in "+-*":
            self._machine.oblige("time", overflow.beyond_bits(op, left, right, kind))
        return result

    def _standard(self, node: t.Standard) -> Value:
        name, kind = node.name, node.type
        arguments = [self.exact(item) for item in node.arguments]
        types = [item.type for item in node.arguments]
        # The engine does not report a REAL that does not fit the target type, so these conversions
        # are always translated, with an obligation.
        cut = name == "TRUNC" or (
            "_TO_" in name and type_name(types[0]) in ANY_REAL and type_name(kind) != "STRING"
        )
        if not cut and name not in _OWN and all(values.concrete(value) for value in arguments):
            self._known(node, arguments)
            result, refused = known_calls.result(node, arguments, self._rules)
            if refused:
                self._machine.oblige(refused, True)
            return result
        if "_TO_" in name:
            return self._conversion(node, arguments[0])
        if name in _CHAINS:
            pairs = pairwise(arguments)
            return both(*(values.compare(_CHAINS[name], a, b, types[0]) for a, b in pairs))
        if name in ("AND", "OR", "XOR"):
            return self._folded(name, arguments, node)
        if name in _JOINS:
            return self._folded(_JOINS[name], arguments, node)
        if name in ("SHL", "SHR", "ROL", "ROR"):
            return self._shift(node, *arguments)
        if name == "MOVE":
            return arguments[0]
        if name == "SEL":
            return values.choose(arguments[0], arguments[2], arguments[1], kind)
        if name in ("CONCAT_DATE_TOD", "CONCAT_DATE_LTOD"):
            return self._combined("+", arguments[0], arguments[1], node)
        if name in ("MAX", "MIN", "LIMIT"):
            return self._bounded(name, arguments, kind)
        if name == "ABS":
            return self._absolute(arguments[0], node)
        if name == "MUX":
            return self._mux(arguments, types[0], kind)
        if name in ("LEN", "LEFT", "MID", "CONCAT", "FIND"):
            if isinstance(kind, ElementaryType) and (kind.length or 0) > STRING_MAX:
                raise UnsupportedError(
                    f"{name} of texts longer than {STRING_MAX} characters is not supported"
                )
            return self._text(name, arguments, types, kind)
        if name == "TRUNC":
            return self._cut(arguments[0], values.bits(kind), kind)
        if name == "SQRT":
            if self._rules.root != "stop":
                raise UnsupportedError(f"SQRT in the dialect {self._rules.name}")
            below = reals.compare("<", arguments[0], reals.constant(0.0, "LREAL"))
            self._machine.oblige("argument", below)
            return reals.root(arguments[0], type_name(kind))
        if name in self._machine.summaries:
            return self._machine.summaries[name](self._machine, arguments)
        raise UnsupportedError(f"the standard function {name} is not supported")

    def _known(self, node: t.Standard, arguments: list[Value]) -> None:
        """Record an operation with known operands, so that a result outside its type is noticed."""
        source, kind = node.arguments[0].type, node.type
        if not is_known(arguments[0]):
            return
        if node.name in _JOINS:
            op, left, right = _JOINS[node.name], *arguments
            self._machine.computes(
                node, lambda time: overflow.arithmetic(op, left, right, kind, time)
            )
        elif node.name == "ABS" and type_name(kind) in SIGNED:
            self._machine.computes(node, lambda time: overflow.negation(arguments[0], kind, time))
        elif "_TO_" in node.name:
            number = arguments[0]
            if type_name(source) in MOMENTS:
                number = values.combine("/", number, self._rules.unit_ns(type_name(source)), _TIME)
            self._machine.computes(node, lambda _: overflow.conversion(number, source, kind))

    def _folded(self, op: str, arguments: list[Value], node: t.Standard) -> Value:
        result, kind = arguments[0], node.type
        for argument in arguments[1:]:
            if type_name(kind) == "BOOL":
                result = logical(op, result, argument)
            elif isinstance(result, reals.Real):
                name = type_name(kind)
                result = reals.settled(self._real(op, result, argument, name), name)
            else:
                result = self._combined(op, result, argument, node)
        return result

    def _bounded(self, name: str, arguments: list[Value], kind: Type) -> Value:
        def bound(op: str, one: Value, other: Value) -> Value:
            """Return `one` if the comparison `one op other` is TRUE, else `other`."""
            return values.choose(values.compare(op, one, other, kind), one, other, kind)

        if name == "LIMIT":
            low, value, high = arguments
            return bound("<", bound(">", value, low), high)
        op = ">" if name == "MAX" else "<"
        return reduce(lambda result, argument: bound(op, argument, result), arguments)

    def _absolute(self, value: Value, node: t.Standard) -> Value:
        kind = node.type
        if isinstance(value, reals.Real):
            return reals.absolute(value)
        if type_name(kind) not in SIGNED:
            return value
        self._machine.computes(node, lambda time: overflow.negation(value, kind, time))
        if is_known(value):
            return values.wrapped(kind, abs(value))
        return z3.If(value < 0, -value, value)

    def _mux(self, arguments: list[Value], selector: Type, kind: Type) -> Value:
        index, *inputs = arguments
        inside = both(
            values.compare(">=", index, 0, selector),
            values.compare("<", index, len(inputs), selector),
        )
        self._machine.oblige("index", negated(inside))
        result = inputs[-1]
        for place in reversed(range(len(inputs) - 1)):
            here = values.compare("=", index, place, selector)
            result = values.choose(here, inputs[place], result, kind)
        return result

    def _shift(self, node: t.Standard, value: Value, count: Value) -> Value:
        kind, name = node.type, node.name
        width = values.bits(kind)
        if type_name(kind) == "BOOL":
            none = values.compare("=", count, 0, node.arguments[1].type)
            return value if name in ("ROL", "ROR") else both(value, none)
        if name in ("ROL", "ROR") and not is_known(count):
            # The width is a power of two, so the remainder of the count is in its lowest bits.
            low = z3.Extract(min(count.size(), width.bit_length() - 1) - 1, 0, count)
            amount = z3.ZeroExt(width - low.size(), low)
            amount = amount if name == "ROL" else -amount & width - 1
            return z3.RotateLeft(values.scalar(kind, value), amount)
        if not is_known(count):
            self._machine.oblige("shift", values.compare("<", count, 0, node.arguments[1].type))
            wide = max(width, values.bits(node.arguments[1].type))
            amount = resized(count, node.arguments[1].type, wide)
            term = (
                z3.ZeroExt(wide - width, values.scalar(kind, value))
                if wide > width
                else (values.scalar(kind, value))
            )
            shifted = term << amount if name == "SHL" else z3.LShR(term, amount)
            return z3.Extract(width - 1, 0, shifted)
        if name in ("ROL", "ROR"):
            count = (count if name == "ROL" else -count) % width
            if is_known(value):
                return (value << count | value >> width - count) & (1 << width) - 1
            return z3.RotateLeft(value, count)
        if count < 0:
            self._machine.oblige("shift", True)
            return 0
        if is_known(value):
            return value << count & (1 << width) - 1 if name == "SHL" else value >> count
        if count >= width:
            return 0
        return value << count if name == "SHL" else z3.LShR(value, count)

    def _text(self, name: str, arguments: list[Value], types: list[Type], kind: Type) -> Value:
        machine = self._machine
        if name == "LEN":
            return texts.length(arguments[0], values.bits(kind))
        if name == "CONCAT":
            result = arguments[0]
            for argument in arguments[1:]:
                result = texts.concat(result, argument)
            return result
        if name == "FIND":
            place = texts.find(*arguments)
            return resized(place, ElementaryType("UINT"), values.bits(kind))
        for count, counted in zip(arguments[1:], types[1:], strict=True):
            machine.oblige("text", values.compare("<", count, 0, counted))
        if name == "LEFT":
            return texts.left(*arguments)
        machine.oblige("text", values.compare("<", arguments[2], 1, types[2]))
        return texts.mid(*arguments)

    def _conversion(self, node: t.Standard, value: Value) -> Value:
        source, target = node.name.split("_TO_")
        from_, to = node.arguments[0].type, node.type
        if source in ANY_CHARS and target in ANY_CHARS and "W" not in (source[0], target[0]):
            return self._text_cut(value, to)
        if source in ANY_CHARS or target in ANY_CHARS:
            raise UnsupportedError(f"the conversion {node.name} needs a constant")
        if target == "BOOL":
            if isinstance(value, reals.Real):
                return reals.compare("<>", value, reals.constant(0.0, source))
            return values.compare("<>", value, 0, from_)
        if target in MOMENTS:
            return self._to_moment(source, target, value, node)
        if source in MOMENTS:
            return self._from_moment(value, source, node)
        if source == "BOOL":
            if target in ANY_REAL:
                one, zero = reals.constant(1.0, target), reals.constant(0.0, target)
                return values.choose(value, one, zero, to)
            return values.choose(value, 1, 0, to)
        if target in ANY_REAL:
            if source in ANY_REAL:
                if source == "REAL":
                    return reals.widened(value)
                return reals.settled(value, "REAL")
            return reals.from_integer(value, target, signed=source in SIGNED)
        if source in ANY_REAL:
            low, high = INT_RANGE[target]
            least = low if target in SIGNED else -(1 << 62)
            self._machine.oblige("conversion", negated(reals.in_range(value, least, high)))
            return reals.to_integer(value, WIDTH[target], signed=target in SIGNED)
        if source in ANY_INT or source in _BITS:
            self._machine.computes(node, lambda _: overflow.conversion(value, from_, to))
            if is_known(value):
                return values.wrapped(to, value)
            return resized(value, from_, values.bits(to))
        raise UnsupportedError(f"the conversion {node.name} is not supported")

    def _text_cut(self, value: texts.Text, to: Type) -> Value:
        """Return a text or character converted to another STRING or a CHAR.

        Raise UnsupportedError if a STRING that may not have length 1 is converted to CHAR.
        """
        assert isinstance(to, ElementaryType)
        if to.name == "STRING":
            most = string_length(to)
            return texts.left(value, most) if value.most > most else value
        if value.most > 1 or not is_known(value.size) or value.size != 1:
            raise UnsupportedError("the conversion STRING_TO_CHAR needs a constant")
        return value

    def _to_moment(self, source: str, target: str, value: Value, node: t.Standard) -> Value:
        """Return a number, duration or date converted to a TIME or date type.

        The dialect decides in which unit a number counts (`Dialect.unit_ns`). Raise
        UnsupportedError if a date and time is converted to its date or its time of day.
        """
        unit = self._rules.unit_ns(target)
        if source in MOMENTS:
            same = source.removeprefix("L") == target.removeprefix("L")
            if same or target in ("DT", "LDT", *ANY_DURATION):
                return value
            raise UnsupportedError(f"the conversion {source}_TO_{target} needs a constant")
        if source == "BOOL":
            return values.choose(value, unit, 0, _TIME)
        if source in ANY_REAL:
            second = reals.constant(float(unit), "LREAL")
            whole = reals.arithmetic("*", reals.widened(value), second, "LREAL")
            return self._cut(whole, TIME_BITS, _TIME)
        if is_known(value):
            return value * unit
        wide = resized(value, node.arguments[0].type, TIME_BITS)
        return self._combined("*", wide, unit, node)

    def _from_moment(self, value: Value, source: str, node: t.Standard) -> Value:
        to, unit = node.type, self._rules.unit_ns(source)
        if type_name(to) not in ANY_REAL:
            whole = values.combine("/", value, unit, _TIME)
            self._machine.computes(node, lambda _: overflow.conversion(whole, _TIME, to))
            return resized(whole, _TIME, values.bits(to))
        # Up to 2^53 a double holds every nanosecond exactly, so the result is rounded only once.
        exact = 1 << 53
        inside = both(
            values.compare(">=", value, -exact, _TIME), values.compare("<=", value, exact, _TIME)
        )
        self._machine.oblige("time", negated(inside))
        second = reals.constant(float(unit), "LREAL")
        number = reals.from_integer(value, "LREAL", signed=True)
        return reals.settled(reals.arithmetic("/", number, second, "LREAL"), type_name(to))


_DINT, _TIME = ELEMENTARY["DINT"], ELEMENTARY["TIME"]

#: Functions that this module computes itself for known arguments. For all other functions the
#: engine's code computes the result.
_OWN = ("AND", "OR", "XOR", "ADD", "MUL", "MOVE", "SEL", "MUX", "LEN", "CONCAT")
