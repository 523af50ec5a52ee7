"""The interval between changes of dedicated inputs on the wire (chapter 5, 3, caution).

The proof is an induction over the calls of FB_WriteArea. Ghost variables record the inputs on the
wire and the time of their last change. The difficult case is a second call in a scan. It may clear
SI(00) or SI(06) immediately. The wire and the variable Applied then differ until the next scan.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import z3

from rcx_tools.evidence.prove.area import STOPS, accepted, at_the_start
from rcx_tools.evidence.prove.guarantee import INNER, WRITERS
from rcx_tools.evidence.prove.image import wire
from rcx_tools.evidence.prove.library import BLOCK, Library, Step, milliseconds
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import TIME_BITS, Value

__all__ = ["PROPERTIES"]

_HEAD: Path = (*BLOCK, "MAKEHEAD")
_PACE: Path = (*_HEAD, "DEDICATED", "PACE")
_NEVER = (1 << 62) - 1
#: The least time between two changes in FB_RcxDedicatedInputs.
_SPACING: Path = (*_HEAD, "SPACING")


def _at_least(machine: Machine, memory: Mapping[Path, Value]) -> Any:
    """Return max(100 ms, Interval) + max(0, Margin), each limited to 8 days."""
    interval = machine.term((*BLOCK, "INTERVAL"), memory)
    margin = machine.term((*BLOCK, "MARGIN"), memory)
    zero = milliseconds(0)
    longer = z3.If(interval > milliseconds(100), interval, milliseconds(100))
    margin = z3.If(margin > zero, margin, zero)
    most = milliseconds(8 * 86_400_000)
    return z3.If(longer > most, most, longer) + z3.If(margin > most, most, margin)


@dataclass(frozen=True)
class _Ghost:
    """The ghost variables of the induction; the program does not contain them.

    Attributes:
        wire: Bytes n + 32 and n + 33, the dedicated inputs as they are sent.
        last: Time of the last change of the wire. -1 if there was no change.
        least: Shortest spacing that was requested since the last change.
    """

    wire: Any
    last: Any
    least: Any


def _holds(machine: Machine, memory: Mapping[Path, Value], ghost: _Ghost, now: Any) -> list[Any]:
    """Return the invariant between two calls.

    The wire equals Applied, except for bits that a second call in a scan has cleared. Those bits
    are kept OFF by the flags Keep..., and the next call of FB_WriteArea adopts them.
    """
    phase = machine.term((*_PACE, "phase"), memory)
    expired, on = (machine.term((*_PACE, name), memory) for name in ("Q", "before"))
    start = machine.term((*_PACE, "start"), memory)
    applied = machine.term((*INNER, "APPLIED"), memory)
    kept = z3.BitVecVal(0, 16)
    for name, bit in (("KEEPEMERGENCY", 0x0001), ("KEEPSTOP", 0x0040)):
        flag = machine.term((*INNER, name), memory)
        kept |= z3.If(flag, z3.BitVecVal(bit, 16), z3.BitVecVal(0, 16))
    same = ghost.wire == applied
    return [
        machine.term((*INNER, "REQUEST"), memory) & STOPS == 0,
        ghost.wire & ~applied == 0,
        applied & ~ghost.wire & ~kept == 0,
        ghost.last <= now,
        z3.ULE(phase, 2),
        expired == (phase == 2),
        z3.And(start >= 0, start <= now),
        z3.Implies(phase == 0, z3.And(z3.Not(on), ghost.last == -1, applied == 0)),
        z3.Implies(z3.And(phase == 1, same), start >= ghost.last),
        z3.Implies(z3.And(phase == 2, same), now - ghost.last >= ghost.least),
    ]


def _base(library: Library, block: str) -> Iterator[Goal]:
    machine = at_the_start(library, block)
    never = z3.BitVecVal(_NEVER, TIME_BITS)
    ghost = _Ghost(z3.BitVecVal(0, 16), z3.BitVecVal(-1, TIME_BITS), never)
    claim = z3.And(*_holds(machine, machine.snapshot(), ghost, z3.BitVecVal(0, TIME_BITS)))
    yield Goal(f"{block}: the invariant holds at the start", tuple(machine.assumptions), claim)


def _goals(library: Library, block: str) -> Iterator[Goal]:
    """Yield the goals that every call of FB_WriteArea preserves the invariant `_holds`.

    By property `bytes`, bytes n + 32 and n + 33 equal `wire`. By property `guarantee`, calls of
    other blocks do not change Applied and do not request SI(00) or SI(06). They may only set the
    flags Keep..., so they preserve `_holds`, too.
    """
    yield from _base(library, block)
    last, least, before = (
        z3.BitVec(name, TIME_BITS) for name in ("last change", "least spacing", "last call")
    )
    machine = library.machine()
    step = library.step(block, machine)
    now = machine.now
    ghost = _Ghost(z3.BitVec("wire", 16), last, least)
    times = [before >= 0, before <= now, last >= -1, least <= _NEVER]
    assumed = [*machine.assumptions, *times]
    assumed += _holds(machine, step.before, ghost, before)

    # The requested spacing is the same as in the block. The goals hold for any valid spacing.
    counts, spacing = accepted(step), step.now(_SPACING)
    asked = z3.Implies(counts, spacing == _at_least(machine, step.before))
    yield Goal(f"{block}: the spacing", tuple(machine.assumptions), asked)
    longest = milliseconds(0) + (1 << 65)
    sane = z3.And(spacing >= milliseconds(100), spacing <= longest)
    yield Goal(
        f"{block}: the spacing is a valid TIME",
        tuple(machine.assumptions),
        z3.Implies(counts, sane),
    )
    assumed.append(z3.Implies(counts, sane))

    after = wire(step, ghost.wire)
    changed = ghost.wire ^ after
    least_now = z3.If(z3.And(counts, spacing < least), spacing, least)
    only_off = z3.And(changed & ~z3.BitVecVal(STOPS, 16) == 0, after & changed == 0)
    spaced = z3.Or(last == -1, now - last >= least_now)
    show = {"changed": changed, "now": now, "last change": last, "least spacing": least_now}
    yield Goal(
        f"{block}: a change is alone, or a switch-off of SI(00), SI(06)",
        tuple(assumed),
        z3.Or(only_off, changed & (changed - 1) == 0),
        show,
    )
    late = z3.Implies(changed != 0, z3.Or(only_off, spaced))
    text = f"{block}: a change is late enough, or a switch-off of SI(00), SI(06)"
    yield from _by_phase(step, Goal(text, tuple(assumed), late, show))
    later = _Ghost(
        after,
        z3.If(changed != 0, now, last),
        z3.If(changed != 0, z3.BitVecVal(_NEVER, TIME_BITS), least_now),
    )
    *simple, waited = _holds(machine, machine.snapshot(), later, now)
    for number, claim in enumerate(simple, 1):
        yield Goal(f"{block}: the invariant holds again ({number})", tuple(assumed), claim, show)
    text = f"{block}: if the timer has expired, the interval has passed"
    yield from _by_phase(step, Goal(text, tuple(assumed), waited, show))


def _by_phase(step: Step, goal: Goal) -> Iterator[Goal]:
    """Split a goal into three simpler goals: the timer is idle, it runs, it has expired."""
    phase = step.was((*_PACE, "phase"))
    for case, told in enumerate(("rests", "runs", "is over")):
        yield Goal(
            f"{goal.name} (the timer {told})", (*goal.assumed, phase == case), goal.claim, goal.show
        )


PROPERTIES = (
    Property(
        "interval",
        "Only one dedicated input changes in a scan, and two changes are at least max(100 ms, "
        "Interval) + max(0, Margin) apart. Interval and Margin each count up to 8 days. The only "
        "exception is switching SI(00) or SI(06) OFF, which is sent at once.",
        "chapter 5, 3",
        ("inner", "calls", "clock", "area"),
        _goals,
        lambda _: WRITERS,
        lambda part: (part,),
    ),
)
