"""Other constants: what a number, a mask, a time or a member of an enumeration may become."""

from __future__ import annotations

import re
from collections.abc import Iterator

from rcx_harness.engine.frontend import syntax as s
from rcx_harness.engine.types import EnumType, Type
from rcx_harness.verify.mutants.text import Span
from rcx_harness.verify.mutants.walk import Body, Place

__all__ = ["constants"]

_BITS = re.compile(r"(BYTE|WORD|DWORD)#16#([0-9A-F]+)", re.IGNORECASE)
_TIME = re.compile(r"T#(\d+)(ms|s|m)", re.IGNORECASE)
_TYPED_INTEGER = re.compile(r"(U?[SDL]?INT)#(\d+)", re.IGNORECASE)
#: ErrorIDs of the library, docs/errors.md.
_ERRORS = range(0x8000, 0x8100)


def constants(
    place: Place, body: Body, kind: Type | None = None
) -> Iterator[tuple[str, Span, str]]:
    """Other values of a literal or a member of an enumeration.

    Args:
        place: Where it stands.
        body: The POU.
        kind: Its type, where the place gives it one.

    Yields:
        The operator, what is replaced, and by what.
    """
    node = place.node
    if isinstance(node, s.Literal):
        span = body.source.span(node)
        for operator, text in _literal(node):
            yield operator, span, text
    elif isinstance(node, s.Name) and body.scope.symbol(node.key) is None:
        found = kind or body.type_of(node)
        if isinstance(found, EnumType):
            members = list(found.members)
            keys = [member.upper() for member in members]
            other = members[(keys.index(node.key) + 1) % len(members)]
            yield "constant", body.source.span(node), other


def _literal(node: s.Literal) -> Iterator[tuple[str, str]]:
    text = node.text
    if node.kind == "BOOLEAN":
        yield "constant", "FALSE" if text.upper() == "TRUE" else "TRUE"
    elif node.kind == "INTEGER" and "#" not in text:
        yield "off-by-one", str(int(text) + 1)
        yield "off-by-one", str(int(text) - 1)
    elif node.kind == "REALNUM":
        value = float(text)
        yield "constant", repr(value * 10 if value else 1.0)
        yield "constant", repr(value + 1.0 if abs(value) > 2 else value / 2)
    elif node.kind == "STRING":
        yield "constant", "'X'" if text == "''" else "''"
    elif node.kind == "TYPED":
        yield from _typed(text)


def _typed(text: str) -> Iterator[tuple[str, str]]:
    bits, time = _BITS.fullmatch(text), _TIME.fullmatch(text)
    integer = _TYPED_INTEGER.fullmatch(text)
    if bits:
        name, digits = bits[1], bits[2]
        yield from (
            (operator, f"{name}#16#{value:0{len(digits)}X}")
            for operator, value in _pattern(int(digits, 16), 4 * len(digits))
        )
    elif integer:
        yield "off-by-one", f"{integer[1]}#{int(integer[2]) + 1}"
        if int(integer[2]):
            yield "off-by-one", f"{integer[1]}#{int(integer[2]) - 1}"
    elif time:
        value = int(time[1])
        yield "constant", f"T#{value * 2 or 1}{time[2]}"
        if value > 1:
            yield "constant", f"T#{value // 2}{time[2]}"


def _pattern(value: int, width: int) -> Iterator[tuple[str, int]]:
    """Other bit patterns: a mask slides by one place, a code counts on."""
    if value in _ERRORS and value != 0x8000:
        yield "error-id", value + 1
        return
    top = 1 << (width - 1)
    if value == 0:
        yield "code", 1
    elif value & (value - 1) == 0 or _is_run(value):
        if not value & top:
            yield "mask", value << 1
        if not value & 1:
            yield "mask", value >> 1
        if value & top and value & 1:
            yield "mask", value >> 1
    else:
        yield "code", value + 1 if value + 1 < 1 << width else value - 1


def _is_run(value: int) -> bool:
    """Whether the set bits are side by side."""
    value //= value & -value
    return value & (value + 1) == 0
