"""Comparisons of durations whose result on matiec differs from exact arithmetic.

matiec stores a duration as seconds and nanoseconds, with two faults. A sum may keep 1000 ms beside
its seconds, and compares as less than the next whole second. About half of the literals are a
nanosecond short, because they are calculated in floating point (C type `long double`, here that of
x86) and cut off. Both matter only if the two sides of a comparison are equal in exact arithmetic.

The analysis follows durations through assignments, pins, fields and results of functions, without
regard to the order of statements. A value that is measured by a timer is exact.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

from structured_text.engines.matiec.hits import Hit, expressions
from structured_text.language import tree as t
from structured_text.language.types import BlockType, StructType, type_name
from structured_text.language.walk import nodes

__all__ = ["is_exact", "wrong_comparisons"]

_SECOND = 1_000_000_000
#: Bits of the mantissa of `long double` on x86.
_MANTISSA = 64

#: A variable: its POU, structure or block, and its name, in upper case.
_Key = tuple[str, str]


@dataclass(frozen=True)
class _Value:
    """The possible errors of a duration.

    Attributes:
        sum: Whether the duration may keep 1000 ms beside its seconds.
        low: Whether the duration may be less than its exact value by nanoseconds.
        high: Whether the duration may be greater than its exact value by nanoseconds.
    """

    sum: bool = False
    low: bool = False
    high: bool = False

    def __or__(self, other: _Value) -> _Value:
        return _Value(self.sum or other.sum, self.low or other.low, self.high or other.high)


_EXACT = _Value()


def wrong_comparisons(pous: Sequence[t.Pou], *, sums: bool) -> Iterator[Hit]:
    """Yield the comparisons and conversions of durations that may give a wrong result on matiec.

    With `sums`, yield those with a sum that keeps 1000 ms beside its seconds. Without `sums`, yield
    comparisons with a value that is wrong by nanoseconds.
    """
    if not any(_is_time(symbol.type) for pou in pous for symbol in pou.symbols.values()) and (
        not any(
            isinstance(node, t.Binary) and _is_time(node.left.type)
            for pou in pous
            for _, node in expressions(pou)
        )
    ):
        return
    values = _Values(pous)
    for pou in pous:
        for at, node in expressions(pou):
            if isinstance(node, t.Binary) and node.op in _LESS and _is_time(node.left.type):
                text = values.wrong(pou, node, sums=sums)
                if text is not None:
                    yield Hit(pou.file, at, text)
            elif sums and isinstance(node, t.Standard) and values.converts_sum(pou, node):
                yield Hit(pou.file, at, f"{node.name} of a sum")


def _is_time(kind: object) -> bool:
    return type_name(kind) == "TIME"  # type: ignore[arg-type]


#: For each operator, whether the result is wrong if the left side is low, and if it is high.
_LESS = {
    "=": (True, True),
    "<>": (True, True),
    ">=": (True, False),
    "<": (True, False),
    ">": (False, True),
    "<=": (False, True),
}


class _Values:
    """The errors of all durations of some POUs, by variable."""

    def __init__(self, pous: Sequence[t.Pou]) -> None:
        self._known: dict[_Key, _Value] = defaultdict(_Value)
        flows = [flow for pou in pous for flow in _flows(pou)]
        for pou in pous:
            for symbol in pou.symbols.values():
                if _is_time(symbol.type) and isinstance(symbol.initial, int):
                    self._known[_key_of_symbol(pou, symbol)] = _literal(symbol.initial)
        changed = True
        while changed:
            changed = False
            for target, pou, source in flows:
                old = self._known[target]
                new = old | self.of(pou, source)
                if new != old:
                    self._known[target] = new
                    changed = True

    def of(self, pou: t.Pou, one: t.Expression | _Key) -> _Value:
        """Return the possible errors that a duration has on matiec."""
        if isinstance(one, tuple):
            return self._known[one]
        if isinstance(one, t.Constant):
            return _literal(one.value) if isinstance(one.value, int) else _EXACT
        if isinstance(one, t.Unary):
            inner = self.of(pou, one.operand)
            return _Value(inner.sum, inner.high, inner.low)
        if isinstance(one, t.Binary):
            return self._operation(pou, one)
        if isinstance(one, t.CallFunction):
            return self._known[one.function.upper(), one.function.upper()]
        if isinstance(one, t.Standard):
            values = [self.of(pou, item) for item in one.arguments if _is_time(item.type)]
            return _any(values) if _is_time(one.type) else _EXACT
        key = _key(pou, one)
        return self._known[key] if key else _EXACT

    def converts_sum(self, pou: t.Pou, one: t.Standard) -> bool:
        """Return whether a function converts a sum with 1000 ms to a type except REAL and LREAL."""
        source, _, target = one.name.partition("_TO_")
        return (
            source == "TIME"
            and target not in ("", "REAL", "LREAL")
            and self.of(pou, one.arguments[0]).sum
        )

    def _operation(self, pou: t.Pou, one: t.Binary) -> _Value:
        if not _is_time(one.type):
            return _EXACT
        left = self.of(pou, one.left)
        if not _is_time(one.right.type):
            return _Value(True, True, left.high)
        right = self.of(pou, one.right)
        if one.op == "+":
            if _is_zero(one.left) or _is_zero(one.right):
                return left | right
            return _Value(True, left.low or right.low, left.high or right.high)
        return _Value(left.sum, left.low or right.high, left.high or right.low)

    def wrong(self, pou: t.Pou, one: t.Binary, *, sums: bool) -> str | None:
        """Return the reason why a comparison may be wrong; None if it is right."""
        if isinstance(one.left, t.Constant) and isinstance(one.right, t.Constant):
            return None
        left, right = self.of(pou, one.left), self.of(pou, one.right)
        not_low, not_high = _LESS[one.op]
        if sums:
            if (left.sum and not_low and _may_be_whole(one.right)) or (
                right.sum and not_high and _may_be_whole(one.left)
            ):
                return one.op
            return None
        wrong_low = (left.low or right.high) and not_low
        wrong_high = (left.high or right.low) and not_high
        # In a comparison with 0, an error of a nanosecond is ignored.
        if _is_zero(one.left) or _is_zero(one.right):
            return None
        if wrong_low or wrong_high:
            literals = [item for item in (one.left, one.right) if isinstance(item, t.Constant)]
            inexact = [int(item.value) for item in literals if not is_exact(int(item.value))]
            return f"{one.op} T#{inexact[0] / 1e6:g}ms" if inexact else one.op
        return None


def _any(values: Sequence[_Value]) -> _Value:
    found = _EXACT
    for value in values:
        found = found | value
    return found


def _is_zero(one: t.Expression) -> bool:
    return isinstance(one, t.Constant) and one.value == 0


def _may_be_whole(one: t.Expression) -> bool:
    """Return whether a duration may be a whole number of seconds, but not 0."""
    if not isinstance(one, t.Constant) or not isinstance(one.value, int):
        return True
    return one.value != 0 and one.value % _SECOND == 0


def _literal(value: int) -> _Value:
    exact = is_exact(value)
    return _Value(False, not exact and value > 0, not exact and value < 0)


@lru_cache(maxsize=1024)
def is_exact(value: int) -> bool:
    """Return whether matiec stores a duration [ns] exactly, however its literal is written.

    The literal may be written in milliseconds (T#1300ms) or in several units (T#1s300ms).
    """
    seconds, nanoseconds = divmod(abs(value), _SECOND)
    rest = _rounded(Fraction(nanoseconds, _SECOND))
    whole = _rounded(Fraction(abs(value), _SECOND))
    return all(
        int(_rounded(_rounded(total - int(total)) * _SECOND)) == nanoseconds
        and int(total) == seconds
        for total in (whole, _rounded(seconds + rest))
    )


def _rounded(value: Fraction) -> Fraction:
    """Return a number rounded to `long double` of x86: to the nearest, ties to even."""
    if not value:
        return value
    exponent = _MANTISSA - (value.numerator.bit_length() - value.denominator.bit_length())
    scale = Fraction(2) ** exponent
    while value * scale >= 2**_MANTISSA:
        scale /= 2
    while value * scale < 2 ** (_MANTISSA - 1):
        scale *= 2
    return Fraction(round(value * scale)) / scale


def _flows(pou: t.Pou) -> Iterator[tuple[_Key, t.Pou, t.Expression | _Key]]:
    """Yield target, POU of the source, and source of each duration that the program passes on."""
    for node in nodes(pou.body):
        if isinstance(node, t.Assign) and _is_time(node.target.type):
            if key := _key(pou, node.target):
                yield key, pou, node.value
        elif isinstance(node, t.CallBlock):
            block = node.block.name.upper()
            for name, value in node.inputs:
                if _is_time(value.type):
                    yield (block, name.upper()), pou, value
            for name, variable in (*node.in_outs, *node.outputs):
                if _is_time(variable.type) and (key := _key(pou, variable)):
                    yield key, pou, (block, name.upper())
            for name, variable in node.in_outs:
                if _is_time(variable.type):
                    yield (block, name.upper()), pou, variable
        elif isinstance(node, t.CallFunction):
            name = node.function.upper()
            for number, given in enumerate(node.arguments):
                if given is not None and _is_time(given.type):
                    yield (name, f"{number}"), pou, given
    if pou.kind == "FUNCTION":
        name = pou.name.upper()
        for number, symbol in enumerate(pou.section("VAR_INPUT")):
            if _is_time(symbol.type):
                yield (name, symbol.name.upper()), pou, (name, f"{number}")


def _key_of_symbol(pou: t.Pou, symbol: t.Symbol) -> _Key:
    if symbol.section in ("VAR_EXTERNAL", "VAR_GLOBAL"):
        return "", (symbol.source or symbol.name).upper()
    return pou.name.upper(), symbol.name.upper()


def _key(pou: t.Pou, one: t.Expression) -> _Key | None:
    """Return the key of a variable; all elements of an array have the same key."""
    if isinstance(one, t.Use):
        return _key_of_symbol(pou, one.symbol)
    if isinstance(one, t.Member):
        kind = one.base.type
        if isinstance(kind, (BlockType, StructType)):
            return kind.name.upper(), one.name.upper()
        return None
    if isinstance(one, t.Index):
        return _key(pou, one.base)
    return None
