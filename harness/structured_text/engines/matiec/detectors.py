"""Detectors: the places of a checked program that a known fault of matiec concerns.

Each detector has the name of its fault in `faults.toml`. The checked tree has a position for every
statement, not for every expression. The place of an expression is therefore its statement, or the
condition of ELSIF or UNTIL that contains it.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from pathlib import Path

from structured_text.engines.matiec.counter_blocks import other_counts
from structured_text.engines.matiec.counters import stale_reads
from structured_text.engines.matiec.durations import wrong_comparisons
from structured_text.engines.matiec.hits import Hit, Sources, expressions
from structured_text.language import syntax as s
from structured_text.language import tree as t
from structured_text.language.parser import parse
from structured_text.language.scalars import INT_RANGE
from structured_text.language.types import (
    NO_STORAGE,
    ArrayType,
    StructType,
    inside,
    type_name,
)
from structured_text.language.walk import nodes, statements

__all__ = ["DETECTORS"]

_Detector = Callable[[Sources], Iterator[Hit]]


def _for_once(sources: Sources) -> Iterator[Hit]:
    """Yield each FOR that runs once, or may run once because a bound is calculated."""
    for pou, loop in _loops(sources):
        rounds = _rounds(loop)
        if rounds is None:
            yield Hit(pou.file, loop.at, f"FOR {_name(loop.counter)}, with a calculated bound")
        elif rounds == 1:
            yield Hit(pou.file, loop.at, f"FOR {_name(loop.counter)}")


def _for_counter(sources: Sources) -> Iterator[Hit]:
    for pou in sources.pous:
        yield from stale_reads(pou)


def _for_limit(sources: Sources) -> Iterator[Hit]:
    """Yield each FOR that ends only if its counter exceeds the limit of its type."""
    for pou, loop in _loops(sources):
        limits = INT_RANGE.get(type_name(loop.counter.type))
        end, step = _number(loop.end), _number(loop.step)
        if limits is None or end is None or step is None or _rounds(loop) == 0:
            continue
        start = _number(loop.start)
        last = end if start is None or not step else start + (end - start) // step * step
        if not limits[0] <= last + step <= limits[1]:
            yield Hit(pou.file, loop.at, f"FOR {_name(loop.counter)}")


def _loops(sources: Sources) -> Iterator[tuple[t.Pou, t.For]]:
    for pou in sources.pous:
        for one in statements(pou.body):
            if isinstance(one, t.For):
                yield pou, one


def _rounds(loop: t.For) -> int | None:
    """Return the number of rounds of a loop; None if a bound is not constant."""
    start, end, step = map(_number, (loop.start, loop.end, loop.step))
    if start is None or end is None or step is None:
        return None
    if not step:
        return 2 if start <= end else 0  # it never ends
    return max(0, (end - start) // step + 1)


def _number(one: t.Expression) -> int | None:
    if isinstance(one, t.Constant) and isinstance(one.value, int):
        return int(one.value)
    if isinstance(one, t.Unary) and one.op == "-":
        value = _number(one.operand)
        return None if value is None else -value
    return None


def _name(variable: t.Variable) -> str:
    return variable.symbol.name if isinstance(variable, t.Use) else "the counter"


def _time_sum(sources: Sources) -> Iterator[Hit]:
    yield from wrong_comparisons(sources.pous, sums=True)


def _time_literal(sources: Sources) -> Iterator[Hit]:
    yield from wrong_comparisons(sources.pous, sums=False)


#: matiec multiplies the nanoseconds of a TIME by the factor in an `int` of C, which must not
#: overflow.
_MOST_NS = 2**31 - 1


def _time_product(sources: Sources) -> Iterator[Hit]:
    """Yield each product of a duration in which matiec's `int` may overflow."""
    for pou in sources.pous:
        for at, one in expressions(pou):
            if not isinstance(one, t.Binary) or one.op != "*" or type_name(one.type) != "TIME":
                continue
            left, right = _constant(one.left), _constant(one.right)
            part = abs(left) % 1_000_000_000 if isinstance(left, int) else 999_999_999
            if part == 0:
                continue
            if isinstance(right, (int, float)) and part * abs(right) <= _MOST_NS:
                continue
            yield Hit(pou.file, at, "")


def _constant(one: t.Expression) -> object:
    if isinstance(one, t.Unary) and one.op == "-":
        value = _constant(one.operand)
        return -value if isinstance(value, (int, float)) else None
    return one.value if isinstance(one, t.Constant) else None


def _replace(sources: Sources) -> Iterator[Hit]:
    """Yield each REPLACE with a new text that is, or may be, longer than the replaced part."""
    for pou in sources.pous:
        for at, one in expressions(pou):
            if isinstance(one, t.Standard) and one.name == "REPLACE":
                new, count = _constant(one.arguments[1]), _constant(one.arguments[2])
                if not isinstance(new, str) or (
                    len(new) > (count if isinstance(count, int) else 0)
                ):
                    yield Hit(pou.file, at, "")


def _find(sources: Sources) -> Iterator[Hit]:
    """Yield each FIND for a text that has, or may have, more than one character."""
    for pou in sources.pous:
        for at, one in expressions(pou):
            if isinstance(one, t.Standard) and one.name == "FIND":
                text = _constant(one.arguments[1])
                if not isinstance(text, str) or len(text) > 1:
                    yield Hit(pou.file, at, "")


def _limit(sources: Sources) -> Iterator[Hit]:
    """Yield each LIMIT with a constant lower limit above its constant upper limit."""
    for pou in sources.pous:
        for at, one in expressions(pou):
            if isinstance(one, t.Standard) and one.name == "LIMIT":
                low, high = _constant(one.arguments[0]), _constant(one.arguments[2])
                if isinstance(low, (int, float)) and isinstance(high, (int, float)) and low > high:
                    yield Hit(pou.file, at, "")


def _function_array(sources: Sources) -> Iterator[Hit]:
    for pou in sources.pous:
        if pou.kind == "FUNCTION":
            for symbol in pou.section("VAR_INPUT"):
                if isinstance(symbol.type, ArrayType):
                    yield Hit(pou.file, symbol.at, f"{symbol.name} of {pou.name}")


def _temp_array(sources: Sources) -> Iterator[Hit]:
    for pou in sources.pous:
        for symbol in pou.section("VAR_TEMP"):
            if isinstance(symbol.type, (ArrayType, StructType)):
                yield Hit(pou.file, symbol.at, f"{symbol.name} of {pou.name}")


#: An escape in a text, and the character after it. In C, $N and hexadecimal codes also take hex
#: digits that follow them.
_ESCAPE = re.compile(r"\$(?:([0-9A-Fa-f]{2}|[NnLl])|.)(?=(.))", re.DOTALL)
_HEX = frozenset("0123456789abcdefABCDEF")


def _text_escape(sources: Sources) -> Iterator[Hit]:
    for file, at, text in _texts(sources):
        for found in _ESCAPE.finditer(text):
            if found[1] and found[1] not in "Ll" and found[2] in _HEX:
                yield Hit(file, _inside(at, text, found.start()), found[0] + found[2])


def _nested_array(sources: Sources) -> Iterator[Hit]:
    """Yield each variable that is or contains an array of arrays."""
    for pou in sources.pous:
        for symbol in pou.symbols.values():
            nested = any(
                isinstance(kind, ArrayType) and isinstance(kind.element, ArrayType)
                for kind in inside(symbol.type)
            )
            if nested and symbol.section not in NO_STORAGE:
                yield Hit(pou.file, symbol.at, symbol.name)


#: Highest number of blocks in one declaration that iec2c accepts.
_MOST_BLOCKS = 2


def _three_blocks(sources: Sources) -> Iterator[Hit]:
    for file in sources.files:
        for pou in parse(file).declarations:
            for section in pou.sections if isinstance(pou, s.Pou) else ():
                for one in section.variables:
                    names = [name.text for name in one.names]
                    is_block = (
                        isinstance(one.spec, s.NamedSpec) and one.spec.name.key in sources.blocks
                    )
                    if is_block and len(names) > _MOST_BLOCKS:
                        yield Hit(str(file), one.at, ", ".join(names))


def _type_alias(sources: Sources) -> Iterator[Hit]:
    """Yield each type that is an alias of a structure."""
    for file in sources.files:
        for one in parse(file).declarations:
            if (
                isinstance(one, s.TypeDecl)
                and isinstance(one.spec, s.NamedSpec)
                and isinstance(sources.types.get(one.name.key), StructType)
            ):
                yield Hit(str(file), one.name.at, one.name.text)


def _text_line_feed(sources: Sources) -> Iterator[Hit]:
    for file, at, text in _texts(sources):
        for found in _ESCAPE.finditer(text):
            if found[1] in ("L", "l"):
                yield Hit(file, _inside(at, text, found.start()), "")


def _inside(at: s.Position, text: str, offset: int) -> s.Position:
    """Return the position of a character inside a literal."""
    before = text[:offset]
    if "\n" in before:
        return s.Position(at.line + before.count("\n"), offset - before.rfind("\n"))
    return s.Position(at.line, at.column + offset)


def _texts(sources: Sources) -> Iterator[tuple[str, s.Position, str]]:
    """Yield the literals of type STRING as they are written."""
    for file in sources.files:
        for at, text in _literals(file):
            yield str(file), at, text


def _literals(file: Path) -> list[tuple[s.Position, str]]:
    return [
        (node.at, node.text)
        for node in nodes(parse(file).declarations)
        if isinstance(node, s.Literal) and "'" in node.text and "$" in node.text
    ]


#: The detectors by the name of their fault.
DETECTORS: dict[str, _Detector] = {
    "for_once": _for_once,
    "for_counter": _for_counter,
    "for_limit": _for_limit,
    "time_sum": _time_sum,
    "time_literal": _time_literal,
    "time_product": _time_product,
    "text_escape": _text_escape,
    "replace": _replace,
    "find": _find,
    "limit": _limit,
    "function_array": _function_array,
    "temp_array": _temp_array,
    "nested_array": _nested_array,
    "three_blocks": _three_blocks,
    "type_alias": _type_alias,
    "text_line_feed": _text_line_feed,
    "counters": other_counts,
}
