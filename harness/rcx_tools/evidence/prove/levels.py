"""Property: SI(00), SI(06) are ON only with their pin, a link and no hold (chapter 5, 2 and 3)."""

from __future__ import annotations

from collections.abc import Iterator

import z3

from rcx_tools.evidence.prove.area import STOPS, accepted, again
from rcx_tools.evidence.prove.guarantee import INNER, WRITERS
from rcx_tools.evidence.prove.image import wire
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library
from rcx_tools.evidence.prove.property import Goal, Property

__all__ = ["PROPERTIES"]

#: For SI(00) and SI(06): input, bit in byte n + 32 (chapter 5, 1), pin of FB_WriteArea, variable
#: that holds the input OFF, and flag of the scan.
_LEVELS = (
    ("SI(00)", 0, "EMERGENCYSTOPOK", "HOLDEMERGENCY", "KEEPEMERGENCY"),
    ("SI(06)", 6, "STOPOK", "HOLDSTOP", "KEEPSTOP"),
)
#: Maps a block that clears SI(00) or SI(06) to the flag that it sets for this (chapter 5, 3.1 and
#: 3.3).
_STOPPERS = {"FB_EMERGENCYSTOP": "KEEPEMERGENCY", "FB_PROGRAMSTOP": "KEEPSTOP"}


def _on(word: z3.BitVecRef, bit: int) -> z3.BoolRef:
    return z3.Extract(bit, bit, word) == 1


def _stopper(library: Library, name: str) -> Iterator[Goal]:
    step = library.step(name)
    keep = _STOPPERS[name]
    hold = keep.replace("KEEP", "HOLD")
    asked = z3.Or(step.now((*BLOCK, "EXECUTE")), step.now((*BLOCK, "BUSY")))
    claim = z3.Implies(asked, z3.And(step.now((*INNER, keep)), step.now((*INNER, hold))))
    yield Goal(f"{name}: it holds the input OFF", tuple(step.machine.assumptions), claim)


def _goals(library: Library, part: str) -> Iterator[Goal]:
    """Yield the goals of one call of FB_WriteArea.

    `wire` gives the bytes n + 32 and n + 33. Property `bytes` proves that they are right.
    """
    if part in _STOPPERS:
        yield from _stopper(library, part)
        return
    step = library.step(part)
    # No block requests SI(00) or SI(06) (property `guarantee`), and FB_WriteArea requests nothing.
    none = [memory((*INNER, "REQUEST")) & STOPS == 0 for memory in (step.was, step.now)]
    assumed = (*step.machine.assumptions, none[0])
    yield Goal(f"{part}: no request of a level", assumed, none[1])
    before = z3.BitVec("wire", 16)
    after = wire(step, before)
    for name, bit, pin, hold, keep in _LEVELS:
        wanted = step.now((*BLOCK, pin))
        free = z3.Not(z3.Or(step.was((*INNER, hold)), step.was((*INNER, keep))))
        may = z3.And(wanted, step.was((*ROBOT, "CONNECTED")), free)
        yield Goal(
            f"{part}: {name} is ON only with pin and link, and without a hold",
            assumed,
            z3.Implies(z3.And(accepted(step), _on(after, bit)), may),
        )
        yield Goal(
            f"{part}: a second call switches {name} OFF without its pin, and never ON",
            assumed,
            z3.Implies(z3.And(again(step), _on(after, bit)), z3.And(wanted, _on(before, bit))),
        )
        yield Goal(
            f"{part}: without its pin {name} is then held OFF",
            assumed,
            z3.Implies(z3.And(again(step), z3.Not(wanted)), step.now((*INNER, keep))),
        )
        yield Goal(
            f"{part}: it ends no hold of {name}",
            assumed,
            z3.And(
                z3.Implies(z3.Not(free), z3.Or(step.now((*INNER, hold)), step.now((*INNER, keep)))),
                z3.Implies(z3.And(accepted(step), z3.Not(free)), step.now((*INNER, hold))),
            ),
        )


PROPERTIES = (
    Property(
        "stop-inputs",
        "SI(00) and SI(06) are ON only while three conditions hold: the pin of the input is TRUE, "
        "the link is up, and no block holds the input OFF. If one of the conditions is lost, the "
        "input goes OFF in the same scan.",
        "chapter 5, 2 and 3",
        ("inner", "calls", "area"),
        _goals,
        lambda _: (*WRITERS, *_STOPPERS),
        lambda part: (part,),
    ),
)
