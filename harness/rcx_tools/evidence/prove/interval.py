"""The interval between dedicated inputs (chapter 5, 3, caution)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import z3

from rcx_harness.verify.prove.machine import Machine, Path
from rcx_harness.verify.prove.values import TIME_BITS, Value
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, milliseconds
from rcx_tools.evidence.prove.property import Goal, Property

__all__ = ["PROPERTIES"]

_PACE: Path = (*BLOCK, "MAKEHEAD", "DEDICATED", "PACE")
_NEVER = (1 << 62) - 1
#: SI(00) and SI(06), whose switch-off goes out at once.
_STOPS = 0x0041


def _at_least(machine: Machine, memory: Mapping[Path, Value]) -> Any:
    """max(100 ms, Interval) + max(0, Margin)."""
    interval = machine.term((*BLOCK, "INTERVAL"), memory)
    margin = machine.term((*BLOCK, "MARGIN"), memory)
    zero = milliseconds(0)
    longer = z3.If(interval > milliseconds(100), interval, milliseconds(100))
    return longer + z3.If(margin > zero, margin, zero)


def _goals(library: Library, block: str) -> Iterator[Goal]:
    """Induction over the calls of FB_WriteArea.

    Beside the program stand the moment of the last change (-1: none yet) and the least spacing
    that was asked for since then.
    """
    last, least, before = (
        z3.BitVec(name, TIME_BITS) for name in ("last change", "least spacing", "last call")
    )
    machine = library.machine()
    step = library.step(block, machine)
    now = machine.now
    assumed = [*machine.assumptions, before >= 0, before <= now, last >= -1, least <= _NEVER]
    applied = step.was((*ROBOT, "INNER", "APPLIED")), step.now((*ROBOT, "INNER", "APPLIED"))
    changed = applied[0] ^ applied[1]
    spacing = _at_least(machine, step.before)
    counts = step.was((*ROBOT, "INNER", "INSCAN"))
    least_now = z3.If(z3.And(counts, spacing < least), spacing, least)

    def holds(memory: Mapping[Path, Value], last: Any, least: Any, now: Any) -> Any:
        """What is true between two calls."""
        phase = machine.term((*_PACE, "phase"), memory)
        expired, on = (machine.term((*_PACE, name), memory) for name in ("Q", "before"))
        start = machine.term((*_PACE, "start"), memory)
        return z3.And(
            last <= now,
            z3.ULE(phase, 2),
            expired == (phase == 2),
            z3.Implies(phase == 0, z3.And(z3.Not(on), last == -1)),
            z3.Implies(phase == 1, start >= last),
            z3.Implies(phase == 2, now - last >= least),
        )

    assumed.append(holds(step.before, last, least, before))
    only_off = z3.And(changed & ~z3.BitVecVal(_STOPS, 16) == 0, applied[1] & changed == 0)
    alone = changed & (changed - 1) == 0
    spaced = z3.Or(last == -1, now - last >= least_now)
    show = {"changed": changed, "now": now, "last change": last, "least spacing": least_now}
    yield Goal(
        f"{block}: a change is late enough and alone, or a switch-off of SI(00), SI(06)",
        tuple(assumed),
        z3.Implies(changed != 0, z3.Or(only_off, z3.And(alone, spaced))),
        show,
    )
    after = holds(
        machine.snapshot(),
        z3.If(changed != 0, now, last),
        z3.If(changed != 0, z3.BitVecVal(_NEVER, TIME_BITS), least_now),
        now,
    )
    yield Goal(f"{block}: what holds between the calls is kept", tuple(assumed), after, show)


PROPERTIES = (
    Property(
        "interval",
        "Any two changes of dedicated inputs are at least max(100 ms, Interval) + max(0, Margin)"
        " apart, each alone in its scan; only a switch-off of SI(00) or SI(06) goes out at once.",
        "chapter 5, 3",
        ("inner", "clock", "area"),
        _goals,
        lambda _: ("FB_WRITEAREA", "FB_WRITEAREAWORDS"),
        lambda part: (part,),
    ),
)
