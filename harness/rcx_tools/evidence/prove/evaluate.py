"""Compiler from terms of the solver to straight-line Python, much faster than `z3.substitute`.

Truth values are `bool`, bit vectors unsigned `int`, floating-point numbers `float`. Arrays are
`dict`; the key `REST` holds the value of all elements without a key. The caller supplies the
functions that the solver does not interpret. For a conversion out of range the solver allows any
result. The compiled code then returns an arbitrary number.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from ctypes import c_float
from dataclasses import dataclass
from typing import Any

import z3

from structured_text.prove.logic import UnsupportedError

__all__ = ["REST", "Program", "program"]

#: The key of an array under which the value of all other elements is stored.
REST = "rest"
#: A term that is used once is written inline if its code has at most this number of characters.
_INLINE = 300


@dataclass(frozen=True)
class Program:
    """A compiled term or list of terms, returned by `program`.

    Attributes:
        inputs: Names of the variables, in the order in which `run` takes their values.
        run: Function that takes the values of the inputs and returns the values of the terms.
    """

    inputs: tuple[str, ...]
    run: Callable[[Sequence[Any]], tuple[Any, ...]]


def program(
    terms: Sequence[Any], functions: Mapping[str, Callable[..., Any]] | None = None
) -> Program:
    """Compile these terms to Python.

    Args:
        terms: Terms of the solver. Any other object is a constant.
        functions: Python functions for the uninterpreted functions, by name.
    """
    order, uses = _ordered(terms)
    writer = _Writer(uses, functions or {})
    for term in order:
        writer.add(term)
    results = [writer.code[term.get_id()] if z3.is_expr(term) else repr(term) for term in terms]
    inputs = writer.inputs
    text = "\n".join(
        [
            "def run(given):",
            f"    {''.join(f'{name}, ' for name in inputs.values())}= given" if inputs else "    0",
            *writer.lines,
            f"    return ({''.join(f'{code}, ' for code in results)})",
        ]
    )
    names = dict(writer.names)
    exec(compile(text, "<terms>", "exec"), names)
    return Program(tuple(inputs), names["run"])


def _ordered(terms: Iterable[Any]) -> tuple[list[Any], dict[int, int]]:
    """Return all terms, each after its arguments, and the number of uses of each term."""
    order: list[Any] = []
    uses: dict[int, int] = {}
    todo: list[tuple[Any, list[Any] | None]] = [(term, None) for term in terms if z3.is_expr(term)]
    done: set[int] = set()
    for term, _ in todo:
        uses[term.get_id()] = uses.get(term.get_id(), 0) + 2
    while todo:
        term, children = todo.pop()
        name = term.get_id()
        if children is not None:
            order.append(term)
            continue
        if name in done:
            continue
        done.add(name)
        children = term.children()
        todo.append((term, children))
        for child in children:
            uses[child.get_id()] = uses.get(child.get_id(), 0) + 1
            todo.append((child, None))
    return order, uses


class _Writer:
    def __init__(self, uses: Mapping[int, int], functions: Mapping[str, Any]) -> None:
        self._uses = uses
        self._functions = functions
        self.code: dict[int, str] = {}
        self.lines: list[str] = []
        self.inputs: dict[str, str] = {}
        self.names: dict[str, Any] = dict(_NAMES)

    def add(self, term: Any) -> None:
        """Write code for a term. Code for its arguments must have been written before."""
        arguments = [self.code[child.get_id()] for child in term.children()]
        code = self._code(term, arguments)
        name = term.get_id()
        if arguments and (self._uses[name] > 1 or len(code) > _INLINE):
            self.lines.append(f"    v{name} = {code}")
            code = f"v{name}"
        self.code[name] = code

    def _code(self, term: Any, a: list[str]) -> str:
        kind = term.decl().kind()
        if kind == z3.Z3_OP_UNINTERPRETED:
            return self._variable(term, a)
        if kind == z3.Z3_OP_BNUM:
            return str(term.as_long())
        if kind in _PLAIN:
            return _PLAIN[kind].format(*a)
        if kind in _JOINED:
            return f"({f' {_JOINED[kind]} '.join(a)})"
        if kind in _VECTOR:
            return _VECTOR[kind](term, a)
        if kind in _FLOAT:
            return _FLOAT[kind](term, a)
        raise UnsupportedError(f"the term {term.decl()} of the solver ({kind})")

    def _variable(self, term: Any, a: list[str]) -> str:
        name = term.decl().name()
        if not a:
            return self.inputs.setdefault(name, f"i{len(self.inputs)}")
        own = f"f{sum(key.startswith('f') and key[1:].isdigit() for key in self.names)}"
        own = next((key for key, it in self.names.items() if it is self._functions[name]), own)
        self.names[own] = self._functions[name]
        return f"{own}({', '.join(a)})"


def _mask(term: Any) -> int:
    return int((1 << term.size()) - 1)


def _half(term: Any) -> int:
    return int(1 << term.size() - 1)


def _signed(term: Any, code: str) -> str:
    half = _half(term)
    return f"(({code} ^ {half}) - {half})"


def _wrapping(symbol: str) -> Callable[[Any, list[str]], str]:
    return lambda term, a: f"(({f' {symbol} '.join(a)}) & {_mask(term)})"


def _ordering(symbol: str) -> Callable[[Any, list[str]], str]:
    """Return a function that writes the code of a signed comparison."""

    def code(term: Any, a: list[str]) -> str:
        half = _half(term.arg(0))
        return f"(({a[0]} ^ {half}) {symbol} ({a[1]} ^ {half}))"

    return code


def _signed_call(name: str) -> Callable[[Any, list[str]], str]:
    return lambda term, a: f"({name}({_signed(term, a[0])}, {_signed(term, a[1])}) & {_mask(term)})"


def _concat(term: Any, a: list[str]) -> str:
    code, children = a[0], term.children()
    for more, child in zip(a[1:], children[1:], strict=True):
        code = f"({code} << {child.size()} | {more})"
    return code


def _extract(term: Any, a: list[str]) -> str:
    _, low = term.params()
    return f"({a[0]} >> {low} & {_mask(term)})" if low else f"({a[0]} & {_mask(term)})"


def _extend_sign(term: Any, a: list[str]) -> str:
    return f"({_signed(term.arg(0), a[0])} & {_mask(term)})"


def _shift(name: str) -> Callable[[Any, list[str]], str]:
    return lambda term, a: f"{name}({a[0]}, {a[1]}, {term.size()})"


def _rotate(name: str) -> Callable[[Any, list[str]], str]:
    return lambda term, a: f"{name}({a[0]}, {term.params()[0]}, {term.size()})"


def _fits(symbol: str, high: bool) -> Callable[[Any, list[str]], str]:
    """Return a function that writes a check of the upper (or lower) limit of a signed result."""

    def code(term: Any, a: list[str]) -> str:
        one = term.arg(0)
        half = _half(one)
        result = f"{_signed(one, a[0])} {symbol} {_signed(one, a[1])}"
        return f"({result} < {half})" if high else f"({result} >= {-half})"

    return code


#: Templates of operators that use the code of their operands unchanged.
_PLAIN: dict[int, str] = {
    z3.Z3_OP_TRUE: "True",
    z3.Z3_OP_FALSE: "False",
    z3.Z3_OP_NOT: "(not {0})",
    z3.Z3_OP_IMPLIES: "(not {0} or {1})",
    z3.Z3_OP_ITE: "({1} if {0} else {2})",
    z3.Z3_OP_ULEQ: "({0} <= {1})",
    z3.Z3_OP_ULT: "({0} < {1})",
    z3.Z3_OP_UGEQ: "({0} >= {1})",
    z3.Z3_OP_UGT: "({0} > {1})",
    z3.Z3_OP_ZERO_EXT: "{0}",
    z3.Z3_OP_SELECT: "select({0}, {1})",
    z3.Z3_OP_STORE: "store({0}, {1}, {2})",
    z3.Z3_OP_CONST_ARRAY: "{{REST: {0}}}",
    z3.Z3_OP_FPA_RM_NEAREST_TIES_TO_EVEN: "round",
    z3.Z3_OP_FPA_RM_TOWARD_ZERO: "trunc",
    z3.Z3_OP_FPA_ROUND_TO_INTEGRAL: "integral({0}, {1})",
    z3.Z3_OP_FPA_NEG: "(-{0})",
    z3.Z3_OP_FPA_ABS: "abs({0})",
    z3.Z3_OP_FPA_EQ: "({0} == {1})",
    z3.Z3_OP_FPA_LT: "({0} < {1})",
    z3.Z3_OP_FPA_GT: "({0} > {1})",
    z3.Z3_OP_FPA_LE: "({0} <= {1})",
    z3.Z3_OP_FPA_GE: "({0} >= {1})",
    z3.Z3_OP_FPA_IS_NAN: "({0} != {0})",
    z3.Z3_OP_FPA_IS_INF: "isinf({0})",
}
_JOINED = {z3.Z3_OP_AND: "and", z3.Z3_OP_OR: "or", z3.Z3_OP_XOR: "!=", z3.Z3_OP_IFF: "=="}
_VECTOR: dict[int, Callable[[Any, list[str]], str]] = {
    z3.Z3_OP_BADD: _wrapping("+"),
    z3.Z3_OP_BSUB: _wrapping("-"),
    z3.Z3_OP_BMUL: _wrapping("*"),
    z3.Z3_OP_BNEG: lambda term, a: f"(-{a[0]} & {_mask(term)})",
    z3.Z3_OP_BNOT: lambda term, a: f"({a[0]} ^ {_mask(term)})",
    z3.Z3_OP_BAND: lambda _, a: f"({' & '.join(a)})",
    z3.Z3_OP_BOR: lambda _, a: f"({' | '.join(a)})",
    z3.Z3_OP_BXOR: lambda _, a: f"({' ^ '.join(a)})",
    z3.Z3_OP_BUDIV: lambda term, a: f"(quotient({a[0]}, {a[1]}) & {_mask(term)})",
    z3.Z3_OP_BUREM: lambda _, a: f"remainder({a[0]}, {a[1]})",
    z3.Z3_OP_BSDIV: _signed_call("quotient"),
    z3.Z3_OP_BSREM: _signed_call("remainder"),
    z3.Z3_OP_BSMOD: _signed_call("modulo"),
    z3.Z3_OP_SLEQ: _ordering("<="),
    z3.Z3_OP_SLT: _ordering("<"),
    z3.Z3_OP_SGEQ: _ordering(">="),
    z3.Z3_OP_SGT: _ordering(">"),
    z3.Z3_OP_CONCAT: _concat,
    z3.Z3_OP_EXTRACT: _extract,
    z3.Z3_OP_SIGN_EXT: _extend_sign,
    z3.Z3_OP_BSHL: _shift("left"),
    z3.Z3_OP_BLSHR: lambda _, a: f"right({a[0]}, {a[1]})",
    z3.Z3_OP_ROTATE_LEFT: _rotate("rotated"),
    z3.Z3_OP_EXT_ROTATE_LEFT: _shift("rotated"),
    z3.Z3_OP_BSMUL_NO_OVFL: _fits("*", high=True),
    z3.Z3_OP_BSMUL_NO_UDFL: _fits("*", high=False),
}


def _is_single(term: Any) -> bool:
    return bool(z3.is_fp(term) and term.sort() == z3.Float32())


def _rounded(symbol: str) -> Callable[[Any, list[str]], str]:
    """Return a function that writes an operation that rounds to the nearest number.

    A result of single precision is computed in double precision and then rounded.
    """

    def code(term: Any, a: list[str]) -> str:
        result = (
            f"divided({a[1]}, {a[2]})"
            if symbol == "/"
            else f"root({a[1]})"
            if symbol == "sqrt"
            else f"({a[1]} {symbol} {a[2]})"
        )
        return f"single({result})" if _is_single(term) else result

    return code


def _to_float(term: Any, a: list[str]) -> str:
    """Write a conversion from a pattern (one argument), another precision, or a signed number."""
    source = term.arg(len(a) - 1)
    if len(a) == 1:
        return f"{'single' if _is_single(term) else 'double'}_of({a[0]})"
    if z3.is_fp(source):
        return f"single({a[1]})" if _is_single(term) else a[1]
    return f"{'nearest_single' if _is_single(term) else 'float'}({_signed(source, a[1])})"


def _numeral(term: Any, _: list[str]) -> str:
    pattern = z3.simplify(z3.fpToIEEEBV(term)).as_long()
    code = "<f" if _is_single(term) else "<d"
    raw = pattern.to_bytes(4 if _is_single(term) else 8, "little")
    return f"float({str(struct.unpack(code, raw)[0])!r})"


def _pattern(term: Any, a: list[str]) -> str:
    return f"{'single' if term.size() == 32 else 'double'}_pattern({a[0]})"


_FLOAT: dict[int, Callable[[Any, list[str]], str]] = {
    z3.Z3_OP_FPA_NUM: _numeral,
    z3.Z3_OP_FPA_NAN: lambda *_: "nan",
    z3.Z3_OP_FPA_PLUS_INF: lambda *_: "inf",
    z3.Z3_OP_FPA_MINUS_INF: lambda *_: "(-inf)",
    z3.Z3_OP_FPA_PLUS_ZERO: lambda *_: "0.0",
    z3.Z3_OP_FPA_MINUS_ZERO: lambda *_: "(-0.0)",
    z3.Z3_OP_FPA_ADD: _rounded("+"),
    z3.Z3_OP_FPA_SUB: _rounded("-"),
    z3.Z3_OP_FPA_MUL: _rounded("*"),
    z3.Z3_OP_FPA_DIV: _rounded("/"),
    z3.Z3_OP_FPA_SQRT: _rounded("sqrt"),
    z3.Z3_OP_FPA_TO_FP: _to_float,
    z3.Z3_OP_FPA_TO_FP_UNSIGNED: lambda term, a: (
        f"{'nearest_single' if _is_single(term) else 'float'}({a[1]})"
    ),
    z3.Z3_OP_FPA_TO_SBV: lambda term, a: f"whole({a[0]}, {a[1]}, {_mask(term)})",
    z3.Z3_OP_FPA_TO_UBV: lambda term, a: f"whole({a[0]}, {a[1]}, {_mask(term)})",
    z3.Z3_OP_FPA_TO_IEEE_BV: _pattern,
    # Both operands have the same sort. For floats, NaN equals NaN and 0.0 differs from -0.0.
    z3.Z3_OP_EQ: lambda term, a: (
        f"alike({a[0]}, {a[1]})" if z3.is_fp(term.arg(0)) else f"({a[0]} == {a[1]})"
    ),
}


def _quotient(a: int, b: int) -> int:
    """Return the quotient truncated towards zero.

    A division by 0 gives the same result as in the solver.
    """
    if b == 0:
        return 1 if a < 0 else -1
    quotient = abs(a) // abs(b)
    return quotient if (a < 0) == (b < 0) else -quotient


def _remainder(a: int, b: int) -> int:
    rest = abs(a) % abs(b) if b else abs(a)
    return -rest if a < 0 else rest


def _divided(a: float, b: float) -> float:
    if b != 0:
        return a / b
    if a == 0 or math.isnan(a) or math.isnan(b):
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def _root(a: float) -> float:
    return math.nan if a < 0 else math.sqrt(a)


def _whole(rounds: Callable[[float], int], value: float, mask: int) -> int:
    return rounds(value) & mask if math.isfinite(value) else 0


def _integral(rounds: Callable[[float], int], value: float) -> float:
    return math.copysign(float(rounds(value)), value) if math.isfinite(value) else value


def _single_of(pattern: int) -> float:
    return float(struct.unpack("<f", pattern.to_bytes(4, "little"))[0])


def _double_of(pattern: int) -> float:
    return float(struct.unpack("<d", pattern.to_bytes(8, "little"))[0])


def _single_pattern(value: float) -> int:
    if value != value:
        return 0x7FC0_0000
    return int.from_bytes(struct.pack("<f", value), "little")


def _double_pattern(value: float) -> int:
    if value != value:
        return 0x7FF8_0000_0000_0000
    return int.from_bytes(struct.pack("<d", value), "little")


def _nearest_single(value: int) -> float:
    """Return the nearest REAL, rounded only once.

    Bits that do not fit into a double are combined into an odd last bit. A second rounding then has
    no effect.
    """
    cut = max(abs(value).bit_length() - 53, 0)
    kept = abs(value) >> cut << cut
    sticky = 1 << cut if kept != abs(value) and not kept >> cut & 1 else 0
    return c_float(float((kept | sticky) * (-1 if value < 0 else 1))).value


def _left(value: int, count: int, width: int) -> int:
    return value << count & (1 << width) - 1 if count < width else 0


def _right(value: int, count: int) -> int:
    return value >> count


def _rotated(value: int, count: int, width: int) -> int:
    count %= width
    return (value << count | value >> width - count) & (1 << width) - 1


def _select(array: dict[Any, Any], index: int) -> Any:
    return array[index] if index in array else array[REST]


def _store(array: dict[Any, Any], index: int, value: Any) -> dict[Any, Any]:
    return {**array, index: value}


def _alike(a: float, b: float) -> bool:
    return struct.pack("<d", a) == struct.pack("<d", b) or (a != a and b != b)


_NAMES: dict[str, Any] = {
    "REST": REST,
    "select": _select,
    "store": _store,
    "quotient": _quotient,
    "remainder": _remainder,
    "modulo": lambda a, b: a % b if b else a,
    "left": _left,
    "right": _right,
    "rotated": _rotated,
    "divided": _divided,
    "root": _root,
    "whole": _whole,
    "integral": _integral,
    "single": lambda value: c_float(value).value,
    "single_of": _single_of,
    "double_of": _double_of,
    "single_pattern": _single_pattern,
    "double_pattern": _double_pattern,
    "nearest_single": _nearest_single,
    "alike": _alike,
    "trunc": math.trunc,
    "isinf": math.isinf,
    "nan": math.nan,
    "inf": math.inf,
}
