"""Statements for COP and CPS: a copy of elements, or of the bytes of whole numbers.

The length counts elements of the destination. A copy ends at the end of an array; what a controller
reads behind the end of the source is not predictable, so that the copy ends there, too.

Source: 1756-RM003N, page 371: a byte-to-byte copy; the byte count is Length times the size of an
element of the destination.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from structured_text.projects.rockwell.data import STORED, Data
from structured_text.projects.rockwell.expression_reader import COUNTER

__all__ = ["Place", "copied", "filled"]

_BYTES = {"SINT": 1, "USINT": 1, "INT": 2, "UINT": 2, "DINT": 4, "UDINT": 4}
_BITS = {1: "BYTE", 2: "WORD", 4: "DWORD"}


@dataclass(frozen=True)
class Place:
    """A tag, its type, and the index of the first element; the index is 0 without an array."""

    text: str
    data: Data
    first: str = "0"

    def element(self, index: str) -> str:
        """Return an element, counted from the first one."""
        if not self.data.sizes:
            return self.text
        return f"{self.text}[{_plus(self.first, index)}]"

    @property
    def whole(self) -> bool:
        """Return whether the place is the begin of a tag."""
        return self.first == "0"

    @property
    def count(self) -> int:
        """Return the number of elements of the tag."""
        return math.prod(self.data.sizes)

    def behind(self) -> str:
        """Return the number of elements from the first one on."""
        if self.first.isdigit():
            return str(max(self.count - int(self.first), 0))
        return f"{self.count} - {self.first}"


def copied(source: Place, target: Place, length: str) -> tuple[list[str], bool]:
    """Return the statements of a copy, and whether they need the counter.

    Raise ValueError with the reason if the copy is not supported.
    """
    data, kind = source.data, target.data
    if len(data.sizes) > 1 or len(kind.sizes) > 1:
        if data == kind and source.whole and target.whole and length == str(source.count):
            return [f"{target.text} := {source.text};"], False
        raise ValueError("of a part of an array with several dimensions is not supported")
    if data.type.upper() != kind.type.upper():
        return _bytes(source, target, length)
    if data.sizes == kind.sizes and source.whole and target.whole and length == str(source.count):
        return [f"{target.text} := {source.text};"], False
    if length == "1":
        return [f"{target.element('0')} := {source.element('0')};"], False
    end = _end(length, target.behind(), source.behind())
    return _loop(end, lambda index: f"{target.element(index)} := {source.element(index)};")


def filled(target: Place, value: str, length: str) -> tuple[list[str], bool]:
    """Return the statements of FLL, which sets elements to a value, and whether they count."""
    if len(target.data.sizes) > 1:
        raise ValueError("of an array with several dimensions is not supported")
    if length == "1":
        return [f"{target.element('0')} := {value};"], False
    return _loop(
        _end(length, target.behind()), lambda index: f"{target.element(index)} := {value};"
    )


def _loop(end: str, statement: Callable[[str], str]) -> tuple[list[str], bool]:
    if end == "1":
        return [statement("0")], False
    last = str(int(end) - 1) if end.isdigit() else f"{end} - 1"
    return [f"FOR {COUNTER} := 0 TO {last} DO", f"  {statement(COUNTER)}", "END_FOR;"], True


def _bytes(source: Place, target: Place, length: str) -> tuple[list[str], bool]:
    """Return a copy between whole numbers of different sizes, from the lowest byte on."""
    wide, narrow = _BYTES.get(source.data.type, 0), _BYTES.get(target.data.type, 0)
    if not wide or not narrow:
        raise ValueError(f"between {source.data.type} and {target.data.type} is not supported")
    if not length.isdigit() and not (source.data.sizes and target.data.sizes):
        raise ValueError("with a varying length is not supported for a tag that is not an array")
    part = max(narrow // wide, 1)  # elements of the source in one of the destination
    parts = max(wide // narrow, 1)  # elements of the destination in one of the source
    most = source.behind()
    most = f"{most} * {parts} / {part}" if not most.isdigit() else str(int(most) * parts // part)
    end = _end(length, target.behind(), most)

    def statement(index: str) -> str:
        if narrow >= wide:
            pieces = [
                _shifted(source, _plus(_times(index, part), str(number)), 8 * wide * number, narrow)
                for number in range(part)
            ]
        else:
            place = index if parts == 1 else f"{index} / {parts}"
            shift = str(8 * narrow * (int(index) % parts)) if index.isdigit() else ""
            shift = shift or f"{8 * narrow} * ({index} MOD {parts})"
            place = str(int(index) // parts) if index.isdigit() else place
            text = _bits(source, place)
            pieces = [f"{_BITS[wide]}_TO_{_BITS[narrow]}(SHR({text}, {shift}))"]
        value = " OR ".join(pieces)
        if (not target.data.stored and not target.data.sizes) or target.data.type not in STORED:
            value = f"{_BITS[narrow]}_TO_{target.data.type}({value})"
        return f"{target.element(index)} := {value};"

    if end.isdigit() and (not source.data.sizes or not target.data.sizes):
        return [statement(str(number)) for number in range(int(end))], False
    return _loop(end, statement)


def _shifted(source: Place, index: str, by: int, width: int) -> str:
    """Return an element of the source in a wider bit string, shifted to the left."""
    own = _BITS[_BYTES[source.data.type]]
    text = _bits(source, index)
    if own != _BITS[width]:
        text = f"{own}_TO_{_BITS[width]}({text})"
    return f"SHL({text}, {by})" if by else text


def _bits(source: Place, index: str) -> str:
    """Return an element of the source as a bit string."""
    kind = source.data.type
    text = source.element(index)
    if source.data.stored or (source.data.sizes and kind in STORED):
        return text
    return f"{kind}_TO_{_BITS[_BYTES[kind]]}({text})"


def _end(length: str, *most: str) -> str:
    """Return the least of a length and the numbers of elements behind the first one."""
    known = [int(one) for one in (length, *most) if one.isdigit()]
    others = list(dict.fromkeys(one for one in (length, *most) if not one.isdigit()))
    parts = [*others, *([str(min(known))] if known else [])]
    text = parts[0]
    for part in parts[1:]:
        text = f"MIN({text}, {part})"
    return text


def _plus(one: str, other: str) -> str:
    if one.isdigit() and other.isdigit():
        return str(int(one) + int(other))
    return other if one == "0" else one if other == "0" else f"{one} + {other}"


def _times(text: str, factor: int) -> str:
    if factor == 1:
        return text
    return str(int(text) * factor) if text.isdigit() else f"{text} * {factor}"
