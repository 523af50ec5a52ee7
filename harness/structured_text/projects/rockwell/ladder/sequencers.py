"""Sequencers: SQO (output), SQI (input) and SQL (load).

SQO and SQL go to the next position at the rising edge of their power, and from LEN to 1. They write
in each scan with power. Source: Rockwell 1756-RM003N, pages 436 to 446. A number that is not a DINT
is converted with its sign (page 436). Assumed: DN is FALSE at other positions than LEN.
"""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.projects.rockwell.copies import Place
from structured_text.projects.rockwell.expression_reader import bare
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.elements import (
    control_of,
    length_lines,
    whole_of,
    words_of,
)

__all__ = ["SEQUENCERS"]


def _output(call: Call) -> None:
    array, mask, control = words_of(call, 0), _bits(call, 1), control_of(call, 3)
    before = _bits(call, 2)
    element = f"DINT_TO_DWORD({array.element(f'{control}.POS')})"
    value = f"DWORD_TO_DINT(({before} AND NOT {mask}) OR ({element} AND {mask}))"
    _steps(call, control, call.assigned(2, (value, "DINT")))


def _load(call: Call) -> None:
    array, control = words_of(call, 0), control_of(call, 2)
    value = bare(_dint(call, 1))
    _steps(call, control, f"{array.element(f'{control}.POS')} := {value};")


def _steps(call: Call, control: str, writes: str) -> None:
    """Add the statements that go to the next position and write there."""

    def statements(power: str) -> Iterator[str]:
        yield f"IF {power} AND ({control}.LEN <= 0 OR {control}.POS < 0) THEN"
        yield f"  {control}.ER := TRUE;"
        yield f"ELSIF {power} THEN"
        yield f"  IF NOT {control}.EN THEN"
        yield f"    {control}.ER := FALSE;"
        yield f"    {control}.POS := SEL({control}.POS >= {control}.LEN, {control}.POS + 1, 1);"
        yield "  END_IF;"
        yield f"  {control}.DN := {control}.POS = {control}.LEN;"
        yield f"  IF {control}.POS > {control}.LEN THEN"
        yield f"    {control}.ER := TRUE;"
        yield "  ELSE"
        yield f"    {writes}"
        yield "  END_IF;"
        yield "END_IF;"
        yield f"{control}.EN := {power};"

    call.always(statements, named=True, anything=True)


def _input(call: Call) -> None:
    """Pass power if the bits of the source that the mask selects are those of the position."""
    array, mask, control = words_of(call, 0), _bits(call, 1), control_of(call, 3)
    source = _bits(call, 2)
    # The element of a position that is not valid is not read.
    place = f"LIMIT(0, {control}.POS, {_last(array)})"
    element = f"DINT_TO_DWORD({array.element(place)})"
    wrong = f"{control}.LEN <= 0 OR {control}.POS < 0 OR {control}.POS > {control}.LEN"
    call.when(f"{control}.ER := {wrong};")
    call.condition(f"(NOT {control}.ER AND ({source} AND {mask}) = ({element} AND {mask}))")


def _last(array: Place) -> str:
    behind = array.behind()
    return str(int(behind) - 1) if behind.isdigit() else f"{behind} - 1"


def _dint(call: Call, number: int) -> str:
    whole_of(call, number)  # to refuse a REAL
    return call.operand(number).converted(call.number(number), "DINT")


def _bits(call: Call, number: int) -> str:
    text = bare(_dint(call, number))
    if text.lstrip("-").isdigit():
        return call.operand(number).bits((text, "DINT"))[0]
    return f"DINT_TO_DWORD({text})"


def _sqo_prescan(call: Call) -> Iterator[str]:
    yield f"{control_of(call, 3)}.EN := TRUE;"
    yield from length_lines(call, 3, 4)


def _sqi_prescan(call: Call) -> Iterator[str]:
    yield from length_lines(call, 3, 4)


def _sql_prescan(call: Call) -> Iterator[str]:
    yield f"{control_of(call, 2)}.EN := TRUE;"
    yield from length_lines(call, 2, 3)


_LONG = ("Array", "Mask", "Dest", "Control", "Length", "Position")
_SOURCE = ("Array", "Mask", "Source", "Control", "Length", "Position")
_SHORT = ("Array", "Source", "Control", "Length", "Position")
_RM = "1756-RM003N, page"
SEQUENCERS = (
    Entry("SQO", _LONG, _output, f"{_RM} 442", 2, _sqo_prescan),
    Entry("SQI", _SOURCE, _input, f"{_RM} 438", 2, _sqi_prescan),
    Entry("SQL", _SHORT, _load, f"{_RM} 446", 2, _sql_prescan),
)
