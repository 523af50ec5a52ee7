"""STRING values as terms of the solver: a length, and characters that are created on demand."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import z3

from structured_text.language.scalars import STRING_MAX
from structured_text.prove.logic import (
    Bool,
    UnsupportedError,
    both,
    either,
    is_known,
    negated,
    truth,
)

__all__ = [
    "Text",
    "anything",
    "choose",
    "compare",
    "concat",
    "constant",
    "equal",
    "find",
    "known",
    "left",
    "legal",
    "length",
    "mid",
    "plain",
]


@dataclass(frozen=True)
class Text:
    """The value of a STRING.

    Attributes:
        size: Number of characters, an `int` or a bit-vector of 16 bits.
        most: The upper limit of `size`.
        make: A function that returns the character at a position, from 0 on. A character after the
            end has no meaning.
        made: The characters created so far.
    """

    size: Any
    most: int
    make: Callable[[int], Any]
    made: dict[int, Any] = field(default_factory=dict, compare=False)

    def char(self, place: int) -> Any:
        """Return a character, an `int` or a bit-vector of 8 bits; 0 from position `most` on."""
        if place >= self.most:
            return 0
        if place not in self.made:
            self.made[place] = self.make(place)
        return self.made[place]


def constant(value: str) -> Text:
    """Return the text of a literal."""
    codes = [ord(letter) for letter in value]
    return Text(len(codes), len(codes), codes.__getitem__)


def anything(name: str, most: int = STRING_MAX, *, exact: bool = False) -> Text:
    """Return an arbitrary text of up to `most` characters, or of exactly `most`."""
    size = most if exact else z3.BitVec(f"{name}.len", 16)
    return Text(size, most, lambda i: z3.BitVec(f"{name}[{i}]", 8))


def legal(text: Text) -> Bool:
    """Return the condition that the length is within its limit."""
    return True if is_known(text.size) else z3.ULE(text.size, text.most)


def known(text: Text) -> bool:
    """Return whether the length and all characters are known."""
    return is_known(text.size) and all(is_known(text.char(i)) for i in range(text.size))


def plain(text: Text) -> str:
    """Return a known text as `str`."""
    return "".join(chr(text.char(i)) for i in range(text.size))


def length(text: Text, width: int) -> Any:
    """Return LEN, as an integer of this width."""
    if is_known(text.size):
        return text.size
    return z3.ZeroExt(width - 16, text.size) if width > 16 else z3.Extract(width - 1, 0, text.size)


def _one(value: Any, width: int) -> Any:
    return z3.BitVecVal(value, width) if is_known(value) else value


def _pick(condition: Bool, yes: Any, no: Any, width: int) -> Any:
    if condition is True or yes is no or (is_known(yes) and is_known(no) and yes == no):
        return yes
    return no if condition is False else z3.If(condition, _one(yes, width), _one(no, width))


def choose(condition: Any, yes: Text, no: Text) -> Text:
    """Return `yes` if the condition holds, else `no`."""
    return Text(
        _pick(condition, yes.size, no.size, 16),
        max(yes.most, no.most),
        lambda i: _pick(condition, yes.char(i), no.char(i), 8),
    )


def _within(place: int, size: Any) -> Bool:
    return place < size if is_known(size) else truth(z3.UGT(size, place))


def _same(left: Any, right: Any) -> Bool:
    if is_known(left) and is_known(right):
        return bool(left == right)
    return truth(_one(left, 8) == _one(right, 8))


def equal(left: Text, right: Text) -> Bool:
    """Return the condition that two texts have the same length and the same characters."""
    if is_known(left.size) and is_known(right.size):
        sizes: Bool = left.size == right.size
    else:
        sizes = truth(_one(left.size, 16) == _one(right.size, 16))
    places = range(min(left.most, right.most))
    same = [_implied(_within(i, left.size), _same(left.char(i), right.char(i))) for i in places]
    return both(sizes, *same)


def compare(op: str, left: Text, right: Text) -> Bool:
    """Return the comparison of two texts, by the codes of the first characters that differ."""
    opposite = {"<>": "=", "<=": ">", ">=": "<"}
    if op in opposite:
        return negated(compare(opposite[op], left, right))
    if op == "=":
        return equal(left, right)
    return _below(left, right) if op == "<" else _below(right, left)


def _below(left: Text, right: Text) -> Bool:
    """Return the condition that the first text is less than the second."""
    if known(left) and known(right):
        return plain(left) < plain(right)
    result: Bool = False
    for at in reversed(range(min(left.most, right.most) + 1)):
        one, other = _within(at, left.size), _within(at, right.size)
        a, b = _one(left.char(at), 8), _one(right.char(at), 8)
        less = either(z3.ULT(a, b), both(a == b, result))
        result = both(other, either(negated(one), less))
    return result


def _implied(condition: Bool, value: Bool) -> Bool:
    if condition is False or value is True:
        return True
    if condition is True:
        return value
    return z3.Implies(condition, value)


def left(text: Text, count: Any) -> Text:
    """Return LEFT for a count that is not negative."""
    if is_known(count) and is_known(text.size):
        size: Any = max(min(text.size, count), 0)
    else:
        wanted, size = _wide(count), _wide(text.size)
        size = z3.If(z3.ULT(wanted, size), wanted, size)
    most = max(min(text.most, count), 0) if is_known(count) else text.most
    return Text(size, most, text.char)


def _wide(value: Any) -> Any:
    """Return a count that is not negative as 16 bits; greater counts become 65535."""
    if is_known(value):
        return z3.BitVecVal(min(max(value, 0), 0xFFFF), 16)
    if value.size() <= 16:
        return z3.ZeroExt(16 - value.size(), value) if value.size() < 16 else value
    return z3.If(z3.UGT(value, 0xFFFF), z3.BitVecVal(0xFFFF, 16), z3.Extract(15, 0, value))


def mid(text: Text, count: Any, position: Any) -> Text:
    """Return MID for a count that is not negative and a position from 1 on."""
    most = max(min(count, text.most), 0) if is_known(count) else text.most
    start: Any = (
        min(max(position - 1, 0), STRING_MAX) if is_known(position) else _wide(position) - 1
    )
    if is_known(position) and is_known(text.size) and is_known(count):
        size: Any = max(min(text.size - start, count), 0)
    else:
        whole, limit = _wide(text.size), _wide(count)
        rest = z3.If(z3.UGT(whole, start), whole - start, z3.BitVecVal(0, 16))
        size = z3.If(z3.ULT(rest, limit), rest, limit)

    def char(place: int) -> Any:
        if is_known(position):
            return text.char(start + place)
        term: Any = z3.BitVecVal(0, 8)
        for at in range(text.most):
            term = z3.If(start + place == at, _one(text.char(at), 8), term)
        return term

    return Text(size, most, char)


def find(text: Text, other: Text) -> Any:
    """Return FIND as an integer of 16 bits: the first position from 1 on, or 0.

    Raise UnsupportedError if the text to find may be longer than four characters.
    """
    if known(text) and known(other):
        return plain(text).find(plain(other)) + 1 if other.size else 0
    if other.most > 4:
        raise UnsupportedError("FIND searches a text that may be longer than four characters")
    result: Any = z3.BitVecVal(0, 16)
    for at in reversed(range(text.most)):
        here = [
            _implied(
                _within(i, other.size),
                both(_within(at + i, text.size), _same(text.char(at + i), other.char(i))),
            )
            for i in range(other.most)
        ]
        result = _pick(both(*here), at + 1, result, 16)
    return _pick(_within(0, other.size), result, 0, 16)


def concat(first: Text, second: Text) -> Text:
    """Return CONCAT, truncated to the longest STRING."""
    most = min(first.most + second.most, STRING_MAX)
    if is_known(first.size) and is_known(second.size):
        size: Any = min(first.size + second.size, STRING_MAX)
    else:
        whole = _wide(first.size) + _wide(second.size)
        size = z3.If(z3.UGT(whole, STRING_MAX), z3.BitVecVal(STRING_MAX, 16), whole)

    def char(place: int) -> Any:
        if is_known(first.size):
            ours = place < first.size
            return first.char(place) if ours else second.char(place - first.size)
        term: Any = _one(first.char(place), 8)
        for cut in range(min(place, first.most) + 1):
            term = z3.If(first.size == cut, _one(second.char(place - cut), 8), term)
        return term

    return Text(size, most, char)
