"""Compare instructions. Source: Rockwell 1756-RM003, compare instructions."""

from __future__ import annotations

from collections.abc import Callable

from structured_text.projects.rockwell.expression_reader import Value, bare
from structured_text.projects.rockwell.ladder.call import Call, Entry

__all__ = ["COMPARES"]


def _compare(sign: str) -> Callable[[Call], None]:
    def translate(call: Call) -> None:
        left, right = call.value(0), call.value(1)
        call.condition(call.operand(0).calculated(left, sign, right)[0])

    return translate


def _cmp(call: Call) -> None:
    text, kind = call.value(0)
    if kind != "BOOL":
        raise call.error(f"the expression of CMP is a {kind}, not a comparison")
    call.condition(text)


def _lim(call: Call) -> None:
    """Pass power inside the limits; outside of them if the low limit is above the high one."""
    low, test, high = call.number(0), call.number(1), call.number(2)
    reader = call.operand(1)

    def text(left: Value, sign: str, right: Value) -> str:
        return bare(reader.calculated(left, sign, right)[0])

    above, below = text(low, "<=", test), text(test, "<=", high)
    limits = [_literal(low), _literal(high)]
    known = None not in limits
    inside, outside = f"{above} AND {below}", f"{above} OR {below}"
    if known and float(limits[0] or 0) <= float(limits[1] or 0):
        call.condition(f"({inside})")
    elif known:
        call.condition(f"({outside})")
    else:
        order = text(low, "<=", high)
        call.condition(f"({order} AND {inside} OR NOT ({order}) AND ({outside}))")


def _literal(value: Value) -> str | None:
    """Return a number as a text for Python; None if the value is not a literal."""
    text = value[0].replace("(", "").replace(")", "")
    try:
        float(text)
    except ValueError:
        return None
    return text


def _meq(call: Call) -> None:
    reader = call.operand(0)
    source, mask, compared = reader.alike_bits(*(call.number(place) for place in range(3)))
    call.condition(f"(({source[0]} AND {mask[0]}) = ({compared[0]} AND {mask[0]}))")


_OPERANDS = ("Source A", "Source B")
_SIGNS = {
    "=": ("EQU", "EQ"),
    "<>": ("NEQ", "NE"),
    "<": ("LES", "LT"),
    "<=": ("LEQ", "LE"),
    ">": ("GRT", "GT"),
    ">=": ("GEQ", "GE"),
}
_LIMITS = ("Low Limit", "Test", "High Limit")

COMPARES = (
    *(
        Entry(name, _OPERANDS, _compare(sign), f"1756-RM003, {names[0]}")
        for sign, names in _SIGNS.items()
        for name in names
    ),
    Entry("CMP", ("Expression",), _cmp, "1756-RM003, CMP"),
    Entry("LIM", _LIMITS, _lim, "1756-RM003, LIM"),
    Entry("LIMIT", _LIMITS, _lim, "1756-RM003, LIM"),
    Entry("MEQ", ("Source", "Mask", "Compare"), _meq, "1756-RM003, MEQ"),
)
