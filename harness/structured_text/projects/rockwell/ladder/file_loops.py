"""FAL and FSC: a calculation or a comparison for each element of an array, in three modes.

POS is the element that the expression uses. ALL works on all elements at the rising edge of the
power; a number works on so many elements in each scan, from the rising edge on until the end,
whatever the power is then; INC works on one element at each rising edge. FSC stops at the first
element for which its expression is TRUE, and sets FD and IN; it goes on behind this element when
the program has cleared IN. Source: Studio 5000 help, FAL and FSC.

Assumed, from memory of 1756-RM003, selecting the mode of operation: DN and POS are cleared when the
power is FALSE after the last element, with a number one scan later than EN if the power was FALSE
then; FD and POS of a search that has found something stay without power. An overflow does not set
ER. Nothing is executed with a negative LEN or POS, which is a major fault on the controller.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from structured_text.projects.rockwell.expression_reader import COUNTER
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.elements import control_of, length_lines

__all__ = ["FILE_LOOPS"]

_Lines = Sequence[str]


def _calculate(call: Call) -> None:
    """Assign the value of the expression to the destination, for each element."""
    lines = [call.assigned(4, call.value(5))]
    control, mode = control_of(call, 0), _mode(call)
    if mode == "INC":
        _step(call, control, lines)
    else:
        _loop(call, control, mode, lines)


def _search(call: Call) -> None:
    text, kind = call.value(4)
    if kind != "BOOL":
        raise call.error(f"the expression of FSC is a {kind}, not a comparison")
    control, mode = control_of(call, 0), _mode(call)
    found = [f"{control}.FD := TRUE;", f"{control}.IN := TRUE;"]
    if mode == "INC":
        _step(call, control, [f"IF {text} THEN", *_indented(found), "END_IF;"], search=True)
    else:
        lines = [f"IF {text} THEN", *_indented([*found, "EXIT;"]), "END_IF;"]
        _loop(call, control, mode, lines, search=True)


def _mode(call: Call) -> str:
    """Return INC, ALL, or the number of elements for each scan."""
    mode = call.raw(3).upper()
    if mode in ("ALL", "INC") or (mode.isdigit() and int(mode) > 0):
        return mode
    raise call.error(f"{call.raw(3)} is not a mode", "write ALL, INC or a number of elements")


def _loop(call: Call, control: str, mode: str, lines: _Lines, *, search: bool = False) -> None:
    call.body.routine.needs.add(COUNTER)
    last = call.body.variable("Last", "DINT")
    end = f"{control}.LEN"
    if mode != "ALL":
        end = f"MIN({end}, {control}.POS + {int(mode)})"
    valid = f"{control}.LEN >= 0 AND {control}.POS >= 0"

    def statements(power: str) -> Iterator[str]:
        yield f"IF {power} AND NOT {control}.EN THEN"
        yield f"  {control}.EN := TRUE;"
        yield f"  {control}.DN := FALSE;"
        if not search:
            yield f"  {control}.POS := 0;"
        yield "END_IF;"
        goes_on = f"{control}.EN AND NOT {control}.DN AND {valid}"
        if search:
            goes_on += f" AND NOT {control}.IN"
        if mode == "ALL":
            goes_on = f"{power} AND {goes_on}"
        yield f"IF {goes_on} THEN"
        if search:
            yield from _indented(_behind_found(control))
        yield f"  {last} := {end} - 1;"
        yield f"  FOR {COUNTER} := {control}.POS TO {last} DO"
        yield f"    {control}.POS := {COUNTER};"
        yield from (f"    {line}" for line in lines)
        yield "  END_FOR;"
        done = [
            f"{control}.POS := {last} + 1;",
            f"{control}.DN := {control}.POS >= {control}.LEN;",
            f"{control}.EN := {power} OR NOT {control}.DN;",
        ]
        if search:
            done = [f"IF NOT {control}.FD THEN", *_indented(done), "END_IF;"]
        yield from _indented(done)
        yield f"ELSIF NOT {power} THEN"
        yield from _indented(_at_rest(control))
        yield "END_IF;"

    call.always(statements, named=True, anything=True)


def _step(call: Call, control: str, lines: _Lines, *, search: bool = False) -> None:
    def statements(power: str) -> Iterator[str]:
        free = f" AND NOT {control}.IN" if search else ""
        valid = f"{control}.LEN >= 0 AND {control}.POS >= 0"
        yield f"IF {power} AND NOT {control}.EN AND NOT {control}.DN AND {valid}{free} THEN"
        if search:
            yield from _indented(_behind_found(control))
        yield f"  IF {control}.POS < {control}.LEN THEN"
        yield from (f"    {line}" for line in lines)
        yield "  END_IF;"
        on = [
            f"{control}.POS := MIN({control}.POS + 1, {control}.LEN);",
            f"{control}.DN := {control}.POS >= {control}.LEN;",
        ]
        if search:
            on = [f"IF NOT {control}.FD THEN", *_indented(on), "END_IF;"]
        yield from _indented(on)
        yield f"ELSIF NOT {power} THEN"
        yield from _indented(_at_rest(control))
        yield "END_IF;"
        yield f"{control}.EN := {power};"

    call.always(statements, named=True, anything=True)


def _behind_found(control: str) -> _Lines:
    """Return the statements that go to the element behind the one that was found."""
    return (
        f"IF {control}.FD THEN",
        f"  {control}.FD := FALSE;",
        f"  {control}.POS := {control}.POS + 1;",
        "END_IF;",
    )


def _at_rest(control: str) -> _Lines:
    """Return the statements without power, if nothing is going on."""
    return (
        f"IF {control}.DN THEN",
        f"  {control}.DN := FALSE;",
        f"  {control}.POS := 0;",
        "END_IF;",
        f"{control}.EN := FALSE;",
    )


def _indented(lines: _Lines) -> list[str]:
    return [f"  {line}" for line in lines]


def _prescan(call: Call) -> Iterator[str]:
    """Do what the instruction does without power (assumed)."""
    control = control_of(call, 0)
    yield f"{control}.POS := SEL({control}.DN, {control}.POS, 0);"
    yield f"{control}.DN := FALSE;"
    yield f"{control}.EN := FALSE;"
    yield from length_lines(call, 0, 1)


_CONTROL = ("Control", "Length", "Position", "Mode")
_RM = "1756-RM003"
FILE_LOOPS = (
    Entry(
        "FAL",
        (*_CONTROL, "Dest", "Expression"),
        _calculate,
        f"{_RM}, FAL; bits behind the end are assumed",
        0,
        _prescan,
    ),
    Entry(
        "FSC",
        (*_CONTROL, "Expression"),
        _search,
        f"{_RM}, FSC; bits behind the end are assumed",
        0,
        _prescan,
    ),
)
