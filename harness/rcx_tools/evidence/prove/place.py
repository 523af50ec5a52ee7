"""Property: a call outside of FB_ReadArea and FB_WriteArea may only clear SI(00) and SI(06)."""

from __future__ import annotations

from collections.abc import Iterator

import z3

from rcx_tools.evidence.prove.area import accepted
from rcx_tools.evidence.prove.guarantee import INNER, READERS, WRITERS, between
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.outline import ASKS, RELEASES
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.symbolic_memory import Path

__all__ = ["PROPERTIES"]

_PLACED: Path = (*INNER, "INSCAN")


def _called(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goal that a call outside of a scan requests nothing and releases no hold."""
    step = library.step(name, library.outline(name))
    machine = step.machine
    assumed = (*machine.assumptions, z3.Not(step.was(_PLACED)))
    claims = []
    for path in step.before:
        if path[: len(INNER)] != INNER:
            continue
        was, now = step.was(path), step.now(path)
        if path[2] in ASKS and not was.eq(now):
            claims.append(was == now)
        if path[2] in RELEASES and not was.eq(now):
            claims.append(z3.Implies(was, now))
    yield Goal(f"{name}: it makes no request, and ends no hold", assumed, z3.And(claims))


def _read_area(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals that FB_ReadArea begins a scan and withdraws earlier requests."""
    step = library.step(name)
    first = z3.Not(step.was(_PLACED))
    none = z3.And(step.now((*INNER, "REQUEST")) == 0, z3.Not(step.now((*INNER, "CODEREQUEST"))))
    yield Goal(
        f"{name}: earlier requests are withdrawn",
        tuple(step.machine.assumptions),
        z3.And(step.now(_PLACED), z3.Implies(first, none)),
    )


def _write_area(library: Library, name: str) -> Iterator[Goal]:
    """Yield the goals that FB_WriteArea ends a scan, and sends requests of this scan only."""
    step = library.step(name)
    assumed = tuple(step.machine.assumptions)
    yield Goal(f"{name}: it ends the scan", assumed, z3.Not(step.now(_PLACED)))
    yield Goal(
        f"{name}: outside of a scan it sends nothing",
        assumed,
        z3.Implies(z3.Not(step.was(_PLACED)), z3.Not(accepted(step))),
    )


def _goals(library: Library, part: str) -> Iterator[Goal]:
    if part in READERS:
        yield from _read_area(library, part)
    elif part in WRITERS:
        yield from _write_area(library, part)
    else:
        yield from _called(library, part)


PROPERTIES = (
    Property(
        "place",
        "If a block is called before FB_ReadArea or after FB_WriteArea, it requests nothing, "
        "takes no turn, and does not release SI(00) or SI(06). FB_WriteArea never sends a request "
        "that was made there. The block can still switch SI(00) and SI(06) OFF. Property "
        "`contract` proves that the block ends with an error.",
        "docs/explanation/scan-model.md",
        ("inner",),
        _goals,
        lambda library: (*READERS, *WRITERS, *between(library)),
        lambda part: (part,),
    ),
)
