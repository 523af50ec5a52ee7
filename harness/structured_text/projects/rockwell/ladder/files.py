"""Instructions for arrays and bit fields. Source: Rockwell 1756-RM003N, chapters 7 to 9."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from structured_text.projects.rockwell.copies import copied, filled
from structured_text.projects.rockwell.expression_reader import COUNTER, bare
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.elements import (
    control_of,
    element_for,
    length_lines,
    place_of,
    whole_of,
    words_of,
)
from structured_text.projects.rockwell.ladder.operands import BIT_STRINGS
from structured_text.projects.rockwell.ladder.texts import as_structured_text

__all__ = ["FILES"]

#: The orders of SWPB, also as numbers.
_ORDERS = {**{name: name for name in ("REVERSE", "WORD", "HIGH/LOW")}, "HIGHLOW": "HIGH/LOW"}
_ORDERS |= {"0": "REVERSE", "1": "WORD", "2": "HIGH/LOW"}
_WIDTHS = {"BYTE": 8, "WORD": 16, "DWORD": 32, "LWORD": 64}


def _counted(call: Call, made: Callable[[], tuple[list[str], bool]]) -> None:
    try:
        lines, counts = made()
    except ValueError as error:
        raise call.error(f"{call.entry.name} {error}", "convert element by element") from None
    if counts:
        call.body.routine.needs.add(COUNTER)
    call.when(*lines)


def _copy(call: Call) -> None:
    source, target = place_of(call, 0), place_of(call, 1, written=True)
    length = whole_of(call, 2)
    _counted(call, lambda: copied(source, target, length))


def _fill(call: Call) -> None:
    target, length = place_of(call, 1, written=True), whole_of(call, 2)
    element = target.data.element if target.data.sizes else target.data
    value = element_for(call, 0, element)
    _counted(call, lambda: filled(target, bare(value), length))


def _distribute(call: Call) -> None:
    """Copy bits of a number to bits of another one; the rest of the destination stays."""
    start, to, count = (_literal(call, number) for number in (1, 3, 4))
    text, data = call.tag(2)
    bits = BIT_STRINGS.get(data.type, "")
    if data.sizes or not bits:
        raise call.error(f"{call.raw(2)} is not a whole number")
    width = _WIDTHS[bits]
    source, kind = call.bits(0)
    mask = (1 << min(count, max(width - to, 0))) - 1
    moved = (
        f"{kind}_TO_{bits}(SHR({source}, {start}))" if kind != bits else f"SHR({source}, {start})"
    )
    own = text if data.stored else f"{data.type}_TO_{bits}({text})"
    rest = ((1 << width) - 1) ^ (mask << to)
    value = f"{own} AND {bits}#16#{rest:X} OR SHL({moved} AND {bits}#16#{mask:X}, {to})"
    call.when(f"{text} := {value if data.stored else f'{bits}_TO_{data.type}({value})'};")


def _swap(call: Call) -> None:
    """Rearrange the bytes of an INT or DINT."""
    kind, order = call.tag(0, written=False)[1].type, call.raw(1).upper()
    if order not in _ORDERS:
        raise call.error(f"{call.raw(1)} is not an order of bytes", "write REVERSE")
    text = call.bits(0)[0]
    if kind == "INT":
        swapped = f"SHL({text}, 8) AND DWORD#16#FF00 OR SHR({text}, 8)"
        call.when(call.assigned(2, (f"WORD_TO_INT(DWORD_TO_WORD({swapped}))", "INT")))
        return
    if kind != "DINT":
        raise call.error(f"SWPB of a {kind} is not supported", "use an INT or a DINT")
    inner = f"SHL({text}, 8) AND DWORD#16#FF00FF00 OR SHR({text}, 8) AND DWORD#16#FF00FF"
    swapped = {
        "WORD": f"ROL({text}, 16)",
        "HIGH/LOW": inner,
        "REVERSE": f"ROL({inner}, 16)",
    }[_ORDERS[order]]
    call.when(call.assigned(2, (f"DWORD_TO_DINT({swapped})", "DINT")))


def _literal(call: Call, number: int) -> int:
    text = call.raw(number)
    if not text.isdigit():
        raise call.error(f"{text} is not a number, as {call.entry.operands[number]} of BTD is")
    return int(text)


def _shift(call: Call) -> None:
    """Shift the bits of an array by one at the rising edge of the power."""
    place, control, bit = words_of(call, 0), control_of(call, 1), call.bit(2)
    carry = call.body.variable("Carry")
    top = call.body.variable("Top")
    call.body.routine.needs.add(COUNTER)
    last = f"({control}.LEN - 1) / 32"
    word = place.element(COUNTER)
    if call.entry.name == "BSL":
        end = place.element(last)
        unloaded = f"(SHR(DINT_TO_DWORD({end}), ({control}.LEN - 1) MOD 32) AND DWORD#1) = DWORD#1"
        loop = [
            f"FOR {COUNTER} := 0 TO {last} DO",
            f"  {top} := {word}.31;",
            f"  {word} := DWORD_TO_DINT(SHL(DINT_TO_DWORD({word}), 1));",
            f"  {word}.0 := {carry};",
            f"  {carry} := {top};",
            "END_FOR;",
        ]
        begin = [f"{carry} := {bit};"]
    else:
        unloaded = f"{place.element('0')}.0"
        loop = [
            f"FOR {COUNTER} := {last} TO 0 BY -1 DO",
            f"  {top} := {word}.0;",
            f"  {word} := DWORD_TO_DINT(SHR(DINT_TO_DWORD({word}), 1));",
            f"  {word}.31 := {carry};",
            f"  {carry} := {top};",
            "END_FOR;",
        ]
        # the source bit comes to the bit LEN - 1, which is the bit LEN before the shift
        final = place.element(last)
        mask = f"SHL(DWORD#1, ({control}.LEN - 1) MOD 32)"
        own = f"DINT_TO_DWORD({final})"
        begin = [f"{carry} := FALSE;"]
        loop += [
            f"IF {bit} THEN",
            f"  {final} := DWORD_TO_DINT({own} OR {mask});",
            "ELSE",
            f"  {final} := DWORD_TO_DINT({own} AND NOT {mask});",
            "END_IF;",
        ]
    lines = (*begin, f"{control}.UL := {unloaded};", *loop)

    def statements(power: str) -> Iterator[str]:
        yield f"IF {power} AND NOT {control}.EN THEN"
        yield f"  {control}.ER := {control}.LEN < 0;"
        yield f"  IF {control}.LEN > 0 THEN"
        yield from (f"    {line}" for line in lines)
        yield "  END_IF;"
        yield f"  {control}.POS := {control}.LEN;"
        yield "END_IF;"
        yield f"{control}.EN := {power};"
        yield f"{control}.DN := {power} AND NOT {control}.ER;"

    call.always(statements, named=True, anything=True)


def _cleared(number: int, *names: str) -> Callable[[Call], Iterator[str]]:
    def prescan(call: Call) -> Iterator[str]:
        control = control_of(call, number)
        yield from (f"{control}.{name} := FALSE;" for name in names)
        yield f"{control}.POS := 0;"
        yield from length_lines(call, number, 3)

    return prescan


_COPY = ("Source", "Dest", "Length")
_SHIFTED = ("Array", "Control", "Source Bit", "Length")
_BTD = ("Source", "Source Bit", "Dest", "Dest Bit", "Length")
_RM = "1756-RM003N"
_PRESCAN = _cleared(1, "EN", "DN", "ER")
FILES = (
    Entry("COP", _COPY, _copy, f"{_RM}, page 371"),
    Entry("CPS", _COPY, _copy, f"{_RM}, page 371"),
    Entry("FLL", _COPY, _fill, f"{_RM}, FLL"),
    Entry("SIZE", ("Source", "Dimension", "Size"), as_structured_text, f"{_RM}, SIZE"),
    Entry("BTD", _BTD, _distribute, f"{_RM}, page 303"),
    Entry("SWPB", ("Source", "Order Mode", "Dest"), _swap, "1756-RM003, SWPB"),
    Entry("BSL", _SHIFTED, _shift, f"{_RM}, BSL; its last word is assumed", 1, _PRESCAN),
    Entry("BSR", _SHIFTED, _shift, f"{_RM}, BSR; its last word is assumed", 1, _PRESCAN),
)
