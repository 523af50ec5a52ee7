"""Invariants of composite blocks. Their proofs use the proofs of their inner blocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import z3

from rcx_tools.evidence.prove.invariants import ABNORMAL
from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.outline import is_outside
from structured_text.language.types import BlockType, EnumType
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value

__all__ = ["COLLECTS", "inside", "keeps"]

Memory = Mapping[Path, Value]

#: The block that shows the alarm of its inner command if this command ends abnormally.
COLLECTS = "FB_PICKPLACE"

#: Maps an inner block of FB_RcxMove to the kind of rows that it executes. `_FORWARDS` has the kinds
#: that run only in forward direction.
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
    """Yield path and type of the inner blocks that users can also call directly."""
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
    """Access to the scalars of a block in one state of the memory."""

    def __init__(self, machine: Machine, memory: Memory) -> None:
        self._machine, self._memory = machine, memory

    def get(self, *path: Any) -> Any:
        """Return a scalar by its path below the block."""
        return self._machine.term((*BLOCK, *path), self._memory)

    def among(self, path: tuple[str, ...], *members: str) -> Any:
        """Return the claim that the value of an enumeration is one of these members."""
        kind = self._machine.type_of((*BLOCK, *path))
        assert isinstance(kind, EnumType)
        places = [member.upper() for member in kind.members]
        return z3.Or([self.get(*path) == places.index(member) for member in members])

    def stage(self, *names: str) -> Any:
        """Return the claim that FB_PickPlace is in one of these stages."""
        return self.among(("STAGE",), *(f"PICK_{name}" for name in names))


def keeps(library: Library, machine: Machine, memory: Memory, name: str) -> Iterator[Any]:
    """Yield the invariants about the inner blocks, in addition to those of their outputs."""
    state = _State(machine, memory)
    if name == "FB_MOVETABLE":
        yield from _table(library, state)
    if name == "FB_PICKPLACE":
        yield from _pick(library, state)


def _table(library: Library, state: _State) -> Iterator[Any]:
    """Yield the claims that only the block of the running row is busy.

    A block that was withdrawn in the last call may still be busy.
    """
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
    """Return the claim that this inner block executes the running row."""
    get = state.get
    kind = ("PRESENT", "KIND")
    if block == "PORT":
        there = z3.Or(get("ARRIVED"), state.among(kind, "MOVE_STAY", "MOVE_END"))
        sets = state.among(("PRESENT", "ATARRIVAL"), "ARRIVE_SET")
        return z3.And(there, sets, z3.Not(get("BACK")))
    own = _KINDS[block]
    forwards = z3.Not(get("BACK")) if own in _FORWARDS else z3.BoolVal(True)
    return z3.And(z3.Not(get("ARRIVED")), state.among(kind, f"MOVE_{own}"), forwards)


#: Maps an inner block of FB_PickPlace to the stages in which it works. `_NEAR` and `_AT_TARGET` are
#: stages close to source or target.
_MOVES = ("TO_SOURCE", "TO_PART", "LIFT", "TO_TARGET", "LOWER", "LEAVE", "SHIFT")
_NEAR = ("TO_PART", "LIFT", "LOWER", "LEAVE")
_AT_TARGET = ("TO_TARGET", "LOWER", "LEAVE")
_GRIPS = ("OPEN", "CLOSE", "RELEASE")
_LOOKS = ("EMPTY", "CHECK", "STILL")


def _pick(library: Library, state: _State) -> Iterator[Any]:
    """Yield the claims that only the block of the current stage is busy, and the outputs agree.

    A block that was withdrawn in the last call may still be busy.
    """
    get = state.get
    yield get("EDGE", "seen") == get("JOB", "WASEXECUTE")
    yield get("STAGE") == get("STAGES", "STAGE")
    for group, stages in (("MOVES", _MOVES), ("GRIPS", _GRIPS)):
        yield get("STAGES", group) == state.stage(*stages)
    reads = get("STAGES", "READS")
    yield get("STAGES", "ASKS") == z3.And(state.stage("CHECK"), reads)
    yield get("STAGES", "LOOKS") == z3.And(state.stage(*_LOOKS), z3.Not(get("STAGES", "ASKS")))
    busy, withdrawn = get("BUSY"), get("WITHDRAWN")
    yield z3.Implies(z3.And(busy, withdrawn), get("FAILURE") != 0)
    yield get("FAILURE") != ABNORMAL
    paths = [path[1:] for path, _ in inside(library, "FB_PICKPLACE")]
    parts = {path[:-1] for path in paths}
    for part in parts:
        for pin in ("BUSY", "ACTIVE"):
            within = z3.Or([get(*path, pin) for path in paths if path[: len(part)] == part])
            yield get(*part, pin) == within
    active = z3.Or([get(*path, "ACTIVE") for path in paths])
    yield get("ACTIVE") == z3.And(busy, z3.Not(withdrawn), active)
    yield z3.Implies(z3.Not(withdrawn), get("CARRY", "WITHSHIFT") == _shifts(state))
    grips = z3.And(state.stage(*_GRIPS), get("GRIP", "CLOSE") == state.stage("CLOSE"))
    works = {
        ("CARRY",): z3.And(state.stage(*_MOVES), get("CARRY", "STAGE") == get("STAGE")),
        ("GRIP",): grips,
        ("GRIP", "AWAIT"): grips,
        ("LOOK",): z3.And(get("STAGES", "ASKS"), state.stage("CHECK")),
        ("LOOK", "PART"): z3.And(state.stage(*_LOOKS), get("STAGES", "LOOKS")),
    }
    for path in paths:
        seen = get(*path, "JOB", "SEEN")
        now = z3.And(z3.Not(withdrawn), seen == get("SEEN"))
        alone = z3.And(get("BUSY"), now, works[path[:-1]], _task(state, path))
        lost = z3.And(withdrawn, seen + 1 == get("SEEN"))
        yield z3.Implies(get(*path, "BUSY"), z3.Or(lost, alone))
        yield z3.Implies(get(*path, "BUSY"), get(*path, "ERRORID") == 0)


def _shifts(state: _State) -> Any:
    names = ("SOURCE", "SOURCEABOVE", "TARGET", "TARGETABOVE")
    return z3.Or([state.get("CARRY", "WORK", "SHIFTS", name) != 0 for name in names])


def _task(state: _State, path: Path) -> Any:
    """Return the claim that the state of FB_PickPlace selects this inner block."""
    get = state.get
    if path[0] == "CARRY":
        return _movement(state, path[-1])
    if path == ("GRIP", "SWITCH"):
        switches = state.among(("GRIP", "STAGE"), "GRIP_OFF", "GRIP_SWITCH")
        return z3.And(switches, get("GRIP", "STAGE") == get("GRIP", "LAST"))
    if path == ("LOOK", "READ"):
        closes, opens = (get("GRIP", "GRIPPER", f"{name}OUTPUT") for name in ("CLOSE", "OPEN"))
        number = z3.If(get("LOOK", "SECOND"), opens, closes)
        return z3.Or(number == 0, _legal(number))
    if path[0] == "LOOK":
        unread = z3.And(get("HAND", "RELEASES"), z3.Not(state.stage("EMPTY")))
        return z3.And(_legal(get("GRIP", "GRIPPER", "PARTINPUT")), z3.Not(unread))
    fingers = z3.If(
        get("GRIP", "CLOSE"),
        get("GRIP", "GRIPPER", "CLOSEDINPUT"),
        get("GRIP", "GRIPPER", "OPENEDINPUT"),
    )
    confirms = state.among(("GRIP", "STAGE"), "GRIP_CONFIRM")
    number = z3.If(confirms, fingers, get("GRIP", "GRIPPER", "PARTINPUT"))
    return z3.And(state.among(("GRIP", "STAGE"), "GRIP_CONFIRM", "GRIP_PART"), _legal(number))


def _legal(number: Any) -> Any:
    """Return the claim that a digital input with this number exists; 20 means DI(20)."""
    return z3.And(number > 0, z3.SRem(number, z3.BitVecVal(10, number.size())) <= 7)


def _movement(state: _State, block: str) -> Any:
    get = state.get
    selects, selected = get("CARRY", "WITHSHIFT"), get("CARRY", "SELECTED")
    last = state.stage("SHIFT")
    if block == "SELECT":
        return z3.And(z3.Or(selects, last), z3.Not(selected))
    pallet = z3.If(
        state.stage(*_AT_TARGET),
        get("CARRY", "WORK", "TARGETPALLET"),
        get("CARRY", "WORK", "SOURCEPALLET"),
    )
    arch = z3.And(get("CARRY", "WORK", "ARCHAXIS") != 0, z3.Not(state.stage(*_NEAR)))
    there = z3.And(z3.Or(selected, z3.Not(selects)), z3.Not(last))
    return z3.And(there, (pallet != -1) == ("PALLET" in block), arch == ("ARCH" in block))
