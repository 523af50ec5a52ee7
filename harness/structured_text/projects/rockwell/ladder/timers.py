"""Timers and counters. Source: Rockwell 1756-RM003N, timer and counter instructions.

The values of PRE and ACC are in the data of the tag; the operands only show them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from structured_text.projects.rockwell.ladder.call import Call, Entry
from structured_text.projects.rockwell.ladder.functions import USED

__all__ = ["TIMERS"]

_STATUS = {
    "TIMER": ("EN", "TT", "DN"),
    "COUNTER": ("CU", "CD", "DN", "OV", "UN"),
    "CONTROL": ("EN", "EU", "DN", "EM", "ER", "UL", "IN", "FD"),
}


def _structure(call: Call, kind: str) -> str:
    text, data = call.tag(0)
    if data.sizes or data.type.upper() != kind:
        raise call.error(f"{call.raw(0)} is not a {kind}", f"use a tag of the type {kind}")
    return text


def _run(kind: str, parameter: str) -> Callable[[Call], None]:
    """Return the translation of a timer or counter: the call of its function in each scan."""

    def translate(call: Call) -> None:
        tag, function = _structure(call, kind), f"L5X_{call.entry.name}"
        call.body.routine.needs |= {function, *USED[function]}
        call.always(lambda power: [f"{function}({parameter} := {tag}, Power := {power});"])

    return translate


def _reset(call: Call) -> None:
    tag, data = call.tag(0)
    kind = data.type.upper()
    if data.sizes or kind not in _STATUS:
        raise call.error(f"{call.raw(0)} is not a TIMER, COUNTER or CONTROL")
    number = "POS" if kind == "CONTROL" else "ACC"
    status = [f"{tag}.{name} := FALSE;" for name in _STATUS[kind]]
    call.when(f"{tag}.{number} := 0;", *status)


def _idle(accumulated: str) -> Callable[[Call], Iterator[str]]:
    """Return the prescan of a timer: its bits are cleared, and ACC gets a value if one is given."""

    def prescan(call: Call) -> Iterator[str]:
        tag = _structure(call, "TIMER")
        yield from (f"{tag}.{name} := FALSE;" for name in _STATUS["TIMER"])
        if accumulated:
            yield f"{tag}.ACC := {accumulated.format(tag=tag)};"

    return prescan


def _counted(bit: str) -> Callable[[Call], Iterator[str]]:
    """Return the prescan of a counter: its bit is set, so that the first scan does not count."""

    def prescan(call: Call) -> Iterator[str]:
        yield f"{_structure(call, 'COUNTER')}.{bit} := TRUE;"

    return prescan


_TIMER, _COUNTER = ("Timer", "Preset", "Accum"), ("Counter", "Preset", "Accum")
_RM = "1756-RM003N, page"
TIMERS = (
    Entry("TON", _TIMER, _run("TIMER", "Timer"), f"{_RM} 118", 2, _idle("0")),
    Entry("TOF", _TIMER, _run("TIMER", "Timer"), f"{_RM} 122", 2, _idle("{tag}.PRE")),
    Entry("RTO", _TIMER, _run("TIMER", "Timer"), f"{_RM} 127", 2, _idle("")),
    Entry("CTU", _COUNTER, _run("COUNTER", "Counter"), f"{_RM} 143", 2, _counted("CU")),
    Entry("CTD", _COUNTER, _run("COUNTER", "Counter"), f"{_RM} 147", 2, _counted("CD")),
    Entry("RES", ("Structure",), _reset, f"{_RM} 153"),
)
