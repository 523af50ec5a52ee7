"""What holds between two calls of the blocks that are proved by what is proved of others."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import z3

from rcx_harness.engine.types import BlockType, EnumType
from rcx_harness.verify.prove.machine import Machine, Path
from rcx_harness.verify.prove.values import Value
from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.outline import is_outside

__all__ = ["inside", "keeps"]

Memory = Mapping[Path, Value]

#: The kinds of rows by the block of FB_RcxMove that does them, and those that only go forwards.
_KINDS = {
    "PTP": "PTP",
    "STRAIGHT": "LINEAR",
    "ARCH": "ARCH",
    "CIRCULAR": "CIRCULAR",
    "DIRECT": "MM",
    "BYPTP": "BY_PTP",
    "BYLINEAR": "BY_LINEAR",
    "BYDIRECT": "BY_MM",
    "PALLETPTP": "PALLET",
    "PALLETARCH": "PALLET_ARCH",
}
_FORWARDS = ("CIRCULAR", "BY_PTP", "BY_LINEAR", "BY_MM")


def inside(library: Library, name: str, path: Path = BLOCK) -> Iterator[tuple[Path, str]]:
    """The blocks that it works through, that users call, too, with their types."""
    for symbol in library.pou(name).section("VAR"):
        kind = symbol.type
        if not isinstance(kind, BlockType) or kind.name.upper() not in library.project.pous:
            continue
        at = (*path, symbol.name.upper())
        if is_outside(library.project, kind.name):
            yield at, kind.name.upper()
        else:
            yield from inside(library, kind.name.upper(), at)


class _State:
    """The scalars of a block in one state of the memory."""

    def __init__(self, machine: Machine, memory: Memory) -> None:
        self._machine, self._memory = machine, memory

    def get(self, *path: Any) -> Any:
        """A scalar by its path inside of the block."""
        return self._machine.term((*BLOCK, *path), self._memory)

    def among(self, path: tuple[str, ...], *members: str) -> Any:
        """An enumeration is one of these."""
        kind = self._machine.type_of((*BLOCK, *path))
        assert isinstance(kind, EnumType)
        places = [member.upper() for member in kind.members]
        return z3.Or([self.get(*path) == places.index(member) for member in members])


def keeps(library: Library, machine: Machine, memory: Memory, name: str) -> Iterator[Any]:
    """What holds of the blocks inside, beside what each of them shows."""
    state = _State(machine, memory)
    if name == "FB_MOVETABLE":
        yield from _table(library, state)


def _table(library: Library, state: _State) -> Iterator[Any]:
    """At most the block of the row that runs is busy, unless it was withdrawn in the last call."""
    get = state.get
    yield get("STARTEDGE", "seen") == get("JOB", "WASEXECUTE")
    busy, withdrawn = get("BUSY"), get("WITHDRAWN")
    moving = state.among(("STAGE",), "TABLE_MOVE", "TABLE_ARRIVAL")
    paths = [path[1:] for path, _ in inside(library, "FB_MOVETABLE")]
    yield z3.Implies(get("RUN", "ACTIVE"), z3.Or([get(*path, "BUSY") for path in paths]))
    yield z3.Implies(z3.And(busy, withdrawn), z3.And(get("FAILURE") != 0, z3.Not(moving)))
    for path in paths:
        seen = get(*path, "JOB", "SEEN")
        runs = (busy, z3.Not(withdrawn), seen == get("SEEN"), get(*path, "JOB", "WASEXECUTE"))
        lost = z3.And(withdrawn, seen + 1 == get("SEEN"))
        works = z3.And(*runs, moving, _row(state, path[-1]))
        yield z3.Implies(get(*path, "BUSY"), z3.Or(lost, works))


def _row(state: _State, block: str) -> Any:
    """The row that runs is one for this block."""
    get = state.get
    kind = ("PRESENT", "KIND")
    if block == "PORT":
        there = z3.Or(get("ARRIVED"), state.among(kind, "MOVE_STAY", "MOVE_END"))
        sets = state.among(("PRESENT", "ATARRIVAL"), "ARRIVE_SET")
        return z3.And(there, sets, z3.Not(get("BACK")))
    own = _KINDS[block]
    forwards = z3.Not(get("BACK")) if own in _FORWARDS else z3.BoolVal(True)
    return z3.And(z3.Not(get("ARRIVED")), state.among(kind, f"MOVE_{own}"), forwards)
