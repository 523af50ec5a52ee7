"""Queues and stacks: FFL and FFU (first in, first out), LFL and LFU (last in, first out).

Each acts at the rising edge of its power. DN says that the queue is full, EM that it is empty; both
are TRUE if LEN or POS is not valid. An unload from an empty queue gives 0. Source: Studio 5000
help, array (file)/shift instructions, and Rockwell 1756-RM003N, page 429 (LFU).

Assumed: DN and EM are set without power, too. The last element of FFU becomes 0. A POS beyond LEN
is LEN for an unload.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from structured_text.projects.rockwell.expression_reader import COUNTER
from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.elements import (
    array_of,
    control_of,
    element_for,
    length_lines,
    moved,
    zero_of,
)

__all__ = ["QUEUES"]


def _load(call: Call) -> None:
    queue, control = array_of(call, 1), control_of(call, 2)
    value = element_for(call, 0, queue.data.element)
    lines = (
        f"IF {control}.POS < {control}.LEN THEN",
        f"  {queue.element(f'{control}.POS')} := {value};",
        f"  {control}.POS := {control}.POS + 1;",
        "END_IF;",
    )
    _act(call, control, "EN", lines)


def _unload_first(call: Call) -> None:
    queue, control = array_of(call, 0), control_of(call, 2)
    element = queue.data.element
    call.body.routine.needs.add(COUNTER)
    last = queue.element(f"{control}.LEN - 1")
    behind = queue.element(f"{COUNTER} + 1")
    lines = (
        moved(call, 1, queue.element("0"), element),
        f"FOR {COUNTER} := 0 TO {control}.LEN - 2 DO",
        f"  {queue.element(COUNTER)} := {behind};",
        "END_FOR;",
        f"{last} := {zero_of(call, element)};",
        f"{control}.POS := MIN({control}.POS, {control}.LEN) - 1;",
    )
    _act(call, control, "EU", _if_filled(control, lines, _empty(call)))


def _unload_last(call: Call) -> None:
    queue, control = array_of(call, 0), control_of(call, 2)
    element = queue.data.element
    last = queue.element(f"{control}.POS")
    lines = (
        f"{control}.POS := MIN({control}.POS, {control}.LEN) - 1;",
        moved(call, 1, last, element),
        f"{last} := {zero_of(call, element)};",
    )
    _act(call, control, "EU", _if_filled(control, lines, _empty(call)))


def _empty(call: Call) -> str:
    """Return the statement that sets the destination to 0."""
    element = array_of(call, 0).data.element
    text, data = call.tag(1)
    types = call.body.routine.types
    return f"{text} := {zero_of(call, data if types.is_simple(data) else element)};"


def _if_filled(control: str, lines: tuple[str, ...], otherwise: str) -> tuple[str, ...]:
    inner = (f"  {line}" for line in lines)
    return (f"IF {control}.POS > 0 THEN", *inner, "ELSE", f"  {otherwise}", "END_IF;")


def _act(call: Call, control: str, enabled: str, lines: tuple[str, ...]) -> None:
    """Add statements that are executed at the rising edge, and those that set the bits."""

    def statements(power: str) -> Iterator[str]:
        valid = f"{control}.LEN > 0 AND {control}.POS >= 0"
        yield f"IF {power} AND NOT {control}.{enabled} AND {valid} THEN"
        yield from (f"  {line}" for line in lines)
        yield "END_IF;"
        yield f"{control}.DN := {control}.POS < 0 OR {control}.POS >= {control}.LEN;"
        yield f"{control}.EM := {control}.POS <= 0 OR {control}.LEN <= 0;"
        yield f"{control}.{enabled} := {power};"

    call.always(statements, named=True, anything=True)


def _enabled(bit: str) -> Callable[[Call], Iterator[str]]:
    """Return the prescan: the bit is set, so that power in the first scan does not act."""

    def prescan(call: Call) -> Iterator[str]:
        yield f"{control_of(call, 2)}.{bit} := TRUE;"
        yield from length_lines(call, 2, 3)

    return prescan


_RM = "1756-RM003"
QUEUES = (
    Entry(
        "FFL",
        ("Source", "FIFO", "Control", "Length", "Position"),
        _load,
        f"{_RM}, FFL",
        2,
        _enabled("EN"),
    ),
    Entry(
        "FFU",
        ("FIFO", "Dest", "Control", "Length", "Position"),
        _unload_first,
        f"{_RM}, FFU; its last element is assumed",
        2,
        _enabled("EU"),
    ),
    Entry(
        "LFL",
        ("Source", "LIFO", "Control", "Length", "Position"),
        _load,
        f"{_RM}, LFL",
        2,
        _enabled("EN"),
    ),
    Entry(
        "LFU",
        ("LIFO", "Dest", "Control", "Length", "Position"),
        _unload_last,
        "1756-RM003N, page 429",
        2,
        _enabled("EU"),
    ),
)
