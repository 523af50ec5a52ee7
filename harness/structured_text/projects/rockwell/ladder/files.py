"""Instructions for arrays and bit fields. Source: Rockwell 1756-RM003N, chapters 7 to 9."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from structured_text.projects.rockwell.copies import Place, copied, filled
from structured_text.projects.rockwell.data import INTEGERS, STORED, Data
from structured_text.projects.rockwell.expression_reader import COUNTER, bare
from structured_text.projects.rockwell.instructions import BLOCKS
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.operands import BIT_STRINGS
from structured_text.projects.rockwell.ladder.texts import as_structured_text

__all__ = ["FILES"]

_WIDTHS = {"BYTE": 8, "WORD": 16, "DWORD": 32, "LWORD": 64}


def _place(call: Call, number: int, *, written: bool = False) -> Place:
    """Return an array with the index at which it begins, or a tag."""
    text, data, first = call.operand(number).place(written=written)
    return Place(text, data, first)


def _whole(call: Call, number: int) -> str:
    text, kind = call.number(number)
    if kind not in INTEGERS:
        raise call.error(f"{call.raw(number)} is a {kind}, not a whole number")
    return bare(text)


def _counted(call: Call, made: Callable[[], tuple[list[str], bool]]) -> None:
    try:
        lines, counts = made()
    except ValueError as error:
        raise call.error(f"{call.entry.name} {error}", "convert element by element") from None
    if counts:
        call.body.routine.needs.add(COUNTER)
    call.when(*lines)


def _copy(call: Call) -> None:
    source, target = _place(call, 0), _place(call, 1, written=True)
    length = _whole(call, 2)
    _counted(call, lambda: copied(source, target, length))


def _fill(call: Call) -> None:
    target, length = _place(call, 1, written=True), _whole(call, 2)
    types = call.body.routine.types
    element = target.data.element if target.data.sizes else target.data
    if types.is_simple(element):
        value = call.operand(0).converted(call.number(0), element.type)
        if target.data.sizes and element.type in STORED:
            value = f"{element.type}_TO_{STORED[element.type]}({bare(value)})"
    elif call.raw(0) == "0":
        value = _zero(call, element)
    else:
        value, data = call.tag(0, written=False)
        if (data.type.upper(), data.sizes) != (element.type.upper(), ()):
            raise call.error(f"FLL of a {element.type} with a {data.type} is not supported")
    _counted(call, lambda: filled(target, bare(value), length))


def _zero(call: Call, data: Data) -> str:
    """Return a text without characters, or a structure that no statement sets: all of it is 0."""
    types = call.body.routine.types
    if types.is_string(data):
        return "''"
    if data.type.upper() not in types.members or data.type.upper() in (
        *types.instructions,
        *BLOCKS,
    ):
        raise call.error(f"FLL of a {data.type} with 0 is not supported")
    return call.body.variable(f"Zero_{data.type}", data.type)


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


def _literal(call: Call, number: int) -> int:
    text = call.raw(number)
    if not text.isdigit():
        raise call.error(f"{text} is not a number, as {call.entry.operands[number]} of BTD is")
    return int(text)


def _words(call: Call) -> Place:
    place = _place(call, 0, written=True)
    if place.data.type != "DINT" or len(place.data.sizes) != 1:
        raise call.error(f"{call.raw(0)} is not an array of DINT")
    return place


def _control(call: Call, number: int) -> str:
    text, data = call.tag(number)
    if data != Data("CONTROL") and (data.type.upper() != "CONTROL" or data.sizes):
        raise call.error(f"{call.raw(number)} is not a CONTROL")
    return text


def _shift(call: Call) -> None:
    """Shift the bits of an array by one at the rising edge of the power."""
    place, control, bit = _words(call), _control(call, 1), call.bit(2)
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
        control = _control(call, number)
        yield from (f"{control}.{name} := FALSE;" for name in names)
        yield f"{control}.POS := 0;"

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
    Entry("BSL", _SHIFTED, _shift, f"{_RM}, BSL; its last word is assumed", 1, _PRESCAN),
    Entry("BSR", _SHIFTED, _shift, f"{_RM}, BSR; its last word is assumed", 1, _PRESCAN),
)
