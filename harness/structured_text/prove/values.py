"""Values of a program as terms of the solver, with the same machine arithmetic as the engines.

A known value is a Python number; any other value is a term of z3. BOOL is `bool` or a Boolean
term. Integers, bit strings and enumerations are `int` or bit-vectors of their width. TIME and
dates are `int` or bit-vectors of `TIME_BITS` in nanoseconds. REAL and LREAL are `reals.Real`,
STRING is `texts.Text`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import z3

from structured_text.language.arithmetic import ARITHMETIC, COMPARISONS, LOGIC, quotient, remainder
from structured_text.language.scalars import (
    ANY_DATE,
    ANY_DURATION,
    ANY_REAL,
    INT_RANGE,
    MOMENTS,
    SIGNED,
    WIDTH,
    Scalar,
    string_length,
)
from structured_text.language.types import ElementaryType, EnumType, Type, type_name
from structured_text.prove import reals, texts
from structured_text.prove.logic import (
    Bool,
    UnsupportedError,
    both,
    either,
    equal,
    is_known,
    negated,
    truth,
)

__all__ = [
    "ENUM_BITS",
    "TIME_BITS",
    "Value",
    "anything",
    "bits",
    "choose",
    "combine",
    "compare",
    "concrete",
    "constant",
    "is_duration",
    "is_signed",
    "legal",
    "negate",
    "scalar",
    "wrapped",
]

Value = Any

#: Width of a TIME in bits. A literal has 64 bits; 8 more bits hold the sums of one scan.
TIME_BITS = 72
ENUM_BITS = 16


def bits(kind: Type) -> int:
    """Return the width of the bit-vector of a numeric type; 0 for any other type."""
    if isinstance(kind, EnumType):
        return ENUM_BITS
    name = type_name(kind)
    return TIME_BITS if name in MOMENTS else WIDTH.get(name, 0)


def is_number(kind: Type) -> bool:
    """Return whether a type is numeric or BOOL, so that its values are single terms."""
    return bits(kind) > 0 or type_name(kind) == "BOOL"


def is_duration(kind: Type) -> bool:
    """Return whether the type is TIME or LTIME."""
    return type_name(kind) in ANY_DURATION


def is_signed(kind: Type) -> bool:
    """Return whether a type is signed."""
    name = type_name(kind)
    return name in SIGNED or name in MOMENTS


def _is_text(kind: Type) -> bool:
    """Return whether the type is STRING or CHAR.

    Raise UnsupportedError if it is a WSTRING or WCHAR.
    """
    name = type_name(kind)
    if name in ("WSTRING", "WCHAR"):
        raise UnsupportedError(f"a {name}")
    return name in ("STRING", "CHAR")


def constant(kind: Type, value: Scalar) -> Value:
    """Return the value of a literal or an initial value."""
    if type_name(kind) in ANY_REAL:
        return reals.constant(float(value), type_name(kind))
    if _is_text(kind):
        return texts.constant(str(value))
    return bool(value) if type_name(kind) == "BOOL" else int(value)


def anything(kind: Type, name: str) -> Value:
    """Return an arbitrary value of a scalar type, as a new variable of the solver."""
    if type_name(kind) == "BOOL":
        return z3.Bool(name)
    if type_name(kind) in ANY_REAL:
        return reals.anything(name, type_name(kind))
    if _is_text(kind):
        assert isinstance(kind, ElementaryType)
        return texts.anything(name, string_length(kind), exact=kind.name == "CHAR")
    return z3.BitVec(name, bits(kind))


def legal(kind: Type, value: Value) -> Bool:
    """Return the condition that holds for every legal value of the type.

    An enumeration has only its members; a duration has 64 bits, a date is not negative.
    """
    if is_known(value):
        return True
    if isinstance(kind, EnumType):
        return truth(z3.ULT(value, len(kind.members)))
    if bits(kind) == TIME_BITS:
        low = 0 if type_name(kind) in ANY_DATE else -(1 << 63)
        return truth(z3.And(value >= low, value < 1 << 63))
    return texts.legal(value) if _is_text(kind) else True


def scalar(kind: Type, value: Value) -> z3.ExprRef:
    """Return the value as a term, even if it is known.

    Raise TypeError if the value is a REAL or STRING, which is more than one term.
    """
    if isinstance(value, (reals.Real, texts.Text)):
        raise TypeError("a REAL or STRING is not a single term")
    if not is_known(value):
        return value
    if type_name(kind) == "BOOL":
        return z3.BoolVal(bool(value))
    return z3.BitVecVal(int(value), bits(kind))


def wrapped(kind: Type, value: int) -> int:
    """Return a number wrapped into the range of an integer type, as the PLC's registers do."""
    name = type_name(kind)
    if name not in INT_RANGE:
        return value
    low, _ = INT_RANGE[name]
    return (value - low) % (1 << WIDTH[name]) + low


def choose(condition: Bool, yes: Value, no: Value, kind: Type) -> Value:
    """Return `yes` if the condition holds, else `no`."""
    if condition is True or yes is no:
        return yes
    if condition is False:
        return no
    if isinstance(yes, reals.Real):
        return reals.choose(condition, yes, no)
    if isinstance(yes, texts.Text):
        return texts.choose(condition, yes, no)
    if is_known(yes) and is_known(no) and yes == no:
        return yes
    if type_name(kind) == "BOOL":
        return _choose_bool(condition, yes, no)
    left, right = scalar(kind, yes), scalar(kind, no)
    return left if left.eq(right) else z3.If(condition, left, right)


def _choose_bool(condition: Any, yes: Bool, no: Bool) -> Bool:
    if yes is True:
        return condition if no is False else z3.Or(condition, no)
    if yes is False:
        return z3.Not(condition) if no is True else z3.And(z3.Not(condition), no)
    if no is True:
        return z3.Or(z3.Not(condition), yes)
    if no is False:
        return z3.And(condition, yes)
    return yes if yes.eq(no) else z3.If(condition, yes, no)


_PYTHON = ARITHMETIC | LOGIC | COMPARISONS
_UNSIGNED: dict[str, Callable[[Any, Any], Any]] = {
    "<": z3.ULT,
    ">": z3.UGT,
    "<=": z3.ULE,
    ">=": z3.UGE,
}


def compare(op: str, left: Value, right: Value, kind: Type) -> Bool:
    """Return the result of a comparison (= <> < > <= >=) of two values of the same type."""
    if isinstance(left, reals.Real):
        return reals.compare(op, left, right)
    if isinstance(left, texts.Text):
        return texts.compare(op, left, right)
    if is_known(left) and is_known(right):
        return bool(_PYTHON[op](left, right))
    if type_name(kind) == "BOOL" and op not in ("=", "<>"):
        less, more = (left, right) if op in ("<", "<=") else (right, left)
        return both(negated(less), more) if op in ("<", ">") else either(negated(less), more)
    if op in ("=", "<>"):
        same = equal(scalar(kind, left), scalar(kind, right))
        return same if op == "=" else negated(same)
    call = _PYTHON[op] if is_signed(kind) else _UNSIGNED[op]
    return truth(call(scalar(kind, left), scalar(kind, right)))


def combine(op: str, left: Value, right: Value, kind: Type) -> Value:
    """Return the result of an arithmetic or bitwise operation on integers.

    The operations are sum, difference, product, quotient, remainder, AND, OR and XOR. A division by
    0 has the result that z3 defines; the caller must exclude it.
    """
    if is_known(left) and is_known(right):
        return _known(op, left, right, kind)
    if op in ("AND", "OR", "XOR") and type_name(kind) != "BOOL":
        for one, other in ((left, right), (right, left)):
            if is_known(one) and op in ("OR", "XOR") and one == 0:
                return other
            if is_known(one) and op == "AND" and one in (0, (1 << bits(kind)) - 1):
                return one if one == 0 else other
    elif op in ("+", "-") and is_known(right) and right == 0:
        return left
    a, b = scalar(kind, left), scalar(kind, right)
    if op in ("/", "MOD"):
        if op == "/":
            return a / b if is_signed(kind) else z3.UDiv(a, b)
        rest = z3.SRem(a, b) if is_signed(kind) else z3.URem(a, b)
        return z3.If(b == 0, z3.BitVecVal(0, bits(kind)), rest)
    return _PYTHON[op](a, b)


def _known(op: str, left: int, right: int, kind: Type) -> int:
    if op == "MOD":
        return remainder(left, right)
    if op == "/":
        return wrapped(kind, quotient(left, right)) if right else 0
    return wrapped(kind, _PYTHON[op](left, right))


def negate(value: Value, kind: Type) -> Value:
    """Return -value of an integer or TIME."""
    return wrapped(kind, -value) if is_known(value) else -value


def concrete(value: Value) -> bool:
    """Return whether the value is known without the solver."""
    if isinstance(value, reals.Real):
        return value.known
    return texts.known(value) if isinstance(value, texts.Text) else is_known(value)
