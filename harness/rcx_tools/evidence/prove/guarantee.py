"""The changes that a block may make to RCX_REF, for any pins, inside or outside of a scan.

The relation `guarantee` is reflexive and transitive. It therefore holds for any number of calls of
any blocks in any order. The proofs about FB_ReadArea and FB_WriteArea use the relation. FB_ReadArea
itself satisfies another relation, `reading`.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.outline import ANY, COMMAND_RUN, RELEASES, REQUESTS, law_of
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value

__all__ = [
    "COMMAND_RUN",
    "INNER",
    "PROPERTIES",
    "READERS",
    "REQUESTS",
    "WRITERS",
    "between",
    "guarantee",
    "is_connected",
]

INNER: Path = (*ROBOT, "INNER")
READERS = ("FB_READAREA", "FB_READAREAWORDS")
WRITERS = ("FB_WRITEAREA", "FB_WRITEAREAWORDS")
#: The fields that FB_ReadArea writes.
_READ = ("CONNECTED", "SO", "STATUS", "RESPONSE")
_READ_INNER = ("ELAPSED", "SCAN", "INSCAN", "ANSWER")
#: Fields that FB_ReadArea clears, because their requests were made outside of a scan.
_TAKEN_BACK = ("REQUEST", "CODEREQUEST")
#: Blocks that are or contain an FB_PowerUp, with the path of the FB_PowerUp.
_POWER_UPS: dict[str, Path] = {
    "FB_POWERUP": BLOCK,
    "FB_OPERATOR": (*BLOCK, "SEQUENCES", "POWERING"),
}

Memory = Mapping[Path, Value]


def _leaf(machine: Machine, path: Path, before: Memory, after: Memory, request: int) -> Any:
    """Return the permitted change of a scalar of RCX_REF in a call.

    None if any change is permitted.
    """
    was, now = machine.term(path, before), machine.term(path, after)
    law = law_of(path[1:])
    if law == "free":
        return None
    if law == "rising":
        return z3.Implies(was, now)
    if law == "request":
        return z3.And(was & ~now == 0, now & ~was & ~z3.BitVecVal(request, 16) == 0)
    if was.eq(now):
        return None
    if law == "telegram":
        runs = machine.term((*INNER, "PHASE"), before) == COMMAND_RUN
        return z3.Implies(runs, z3.Not(written(was, now)))
    return was == now


def written(was: Any, now: Any) -> Any:
    """Return the condition under which a call has written a value.

    The new value does not matter. The solver therefore needs no reasoning about arithmetic, in
    particular of REAL.
    """
    return _written(was, now, {})


def _written(was: Any, now: Any, known: dict[int, Any]) -> Any:
    """Return the result of `written`. `known` caches the results of common subterms."""
    number = now.get_id()
    if number not in known:
        if now.eq(was):
            known[number] = z3.BoolVal(False)
        elif z3.is_app_of(now, z3.Z3_OP_ITE):
            condition, *ways = now.children()
            yes, no = (_written(was, way, known) for way in ways)
            known[number] = z3.If(condition, yes, no)
        else:
            known[number] = was != now if z3.is_const(now) else z3.BoolVal(True)
    return known[number]


def guarantee(machine: Machine, before: Memory, after: Memory, request: int = ANY) -> Any:
    """Return the guarantee: the relation between RCX_REF before and after calls of blocks.

    Blocks do not change fields of FB_ReadArea and FB_WriteArea. They may write Code and Data, but
    not while a command is sent. They may set requests and flags of the scan, but not clear them.
    They do not write General[1]. The words 2 to 15 belong to the program.
    """
    found = [_leaf(machine, path, before, after, request) for path in before if path[:1] == ROBOT]
    return z3.And(*[claim for claim in found if claim is not None])


def reading(machine: Machine, before: Memory, after: Memory) -> Any:
    """Return the relation of FB_ReadArea: it only writes what it has read, and clears requests."""
    claims = []
    for path in before:
        inner = path[2] if path[1:2] == ("INNER",) else ""
        if path[:1] != ROBOT or path[1] in _READ or inner in _READ_INNER:
            continue
        was, now = machine.term(path, before), machine.term(path, after)
        kept = was == now
        if inner in _TAKEN_BACK:
            kept = z3.Or(kept, z3.Not(now) if inner == "CODEREQUEST" else now == 0)
        claims.append(kept)
    return z3.And(*claims)


def is_connected(library: Library, name: str, path: Path) -> bool:
    """Return whether a block has a VAR_IN_OUT of this name."""
    return path in [(symbol.name.upper(),) for symbol in library.pou(name).section("VAR_IN_OUT")]


def between(library: Library) -> list[str]:
    """Return the blocks with a Robot that users call, except FB_ReadArea and FB_WriteArea."""
    return [
        name
        for name in library.blocks
        if name not in (*READERS, *WRITERS) and is_connected(library, name, ROBOT)
    ]


def _lemmas(library: Library) -> Iterator[Goal]:
    """Yield the lemmas that the guarantee is reflexive and transitive.

    If one call satisfies the guarantee, any number of calls does.
    """
    machine = library.machine()
    kind = library.pou("FB_STATUS").symbols["ROBOT"].type
    memories = []
    for _ in range(3):
        machine.havoc(ROBOT, kind)
        memories.append(machine.snapshot())
    first, second, third = memories
    yield Goal("no call at all", tuple(machine.assumptions), guarantee(machine, first, first))
    both = (guarantee(machine, first, second), guarantee(machine, second, third))
    yield Goal("two calls", (*machine.assumptions, *both), guarantee(machine, first, third))


def _releases(step: Step, name: str) -> Iterator[Goal]:
    """Yield the goals that only `RELEASES` and FB_Operator release SI(00) or SI(06).

    A hold keeps one of these inputs OFF. It is released only on a rising edge.
    """
    assumed = list(step.machine.assumptions)
    if name in _POWER_UPS:
        # FB_PowerUp starts FB_ServoOnFromEmergencyStop only if there is no hold. This invariant is
        # assumed here. The next goal proves it.
        place = _POWER_UPS[name]
        at_work = _servo_started(step.machine, step.before, place)
        yield Goal(
            f"{name}: its invariant about the inner block holds again",
            (*assumed, at_work),
            _servo_started(step.machine, step.machine.snapshot(), place),
        )
        assumed.append(at_work)
    for hold, owner in RELEASES.items():
        was, now = step.was((*INNER, hold)), step.now((*INNER, hold))
        kept = z3.Implies(was, now)
        if name == owner:
            starts = z3.And(step.now((*BLOCK, "EXECUTE")), z3.Not(step.was((*BLOCK, "BUSY"))))
            kept = z3.Or(starts, kept)
        if name == "FB_OPERATOR" and hold == "HOLDSTOP":
            kept = z3.Or(_key_pressed(step), kept)
        if not was.eq(now):
            yield Goal(f"{name}: {hold} is not released", tuple(assumed), kept)


def _key_pressed(step: Step) -> Any:
    """Return the claim that a pressed key of FB_Operator may release SI(06).

    Reset releases the hold if it comes from Stop of the same block. Start releases a hold unless a
    start is already busy.
    """
    keys = (*BLOCK, "KEYS", "PRESSED")
    own = z3.And(step.now((*keys, "RESET")), step.was((*BLOCK, "STOPPED")))
    starts = z3.And(
        step.now((*keys, "START")), z3.Not(step.was((*BLOCK, "SEQUENCES", "STARTING", "BUSY")))
    )
    return z3.Or(own, starts)


def _servo_started(machine: Machine, memory: Memory, at: Path) -> Any:
    """Return the claim that FB_PowerUp's inner block has detected the edge of Execute.

    The inner block is FB_ServoOnFromEmergencyStop. The claim holds in its stages.
    """
    stage = machine.term((*at, "STAGE"), memory)
    members = machine.type_of((*at, "STAGE")).members  # type: ignore[union-attr]
    places = {member.upper(): place for place, member in enumerate(members)}
    inside = [
        stage == places[f"POWER_UP_{name}"]
        for name in ("EMERGENCY_RELEASE", "ALARM_RESET", "MP_READY", "SERVO_ON")
    ]
    busy, same, scan, last, edge, execute, seen = (
        machine.term((*at, *path), memory)
        for path in (
            ("BUSY",),
            ("JOB", "BUSY"),
            ("SEEN",),
            ("JOB", "SEEN"),
            ("EDGE", "seen"),
            ("JOB", "WASEXECUTE"),
            ("SERVOON", "EDGE", "seen"),
        )
    )
    agree = (busy == same, scan == last, edge == execute)
    return z3.And(*agree, z3.Implies(z3.And(busy, z3.Or(*inside)), seen))


def _goals(library: Library, part: str) -> Iterator[Goal]:
    if part == "any number of calls":
        yield from _lemmas(library)
        return
    step = library.step(part, library.outline(part))
    machine, after = step.machine, step.machine.snapshot()
    if part in READERS:
        claim = reading(machine, step.before, after)
        yield Goal(f"{part}: it changes only what it has read", tuple(machine.assumptions), claim)
        return
    claim = guarantee(machine, step.before, after, REQUESTS.get(part, 0))
    yield Goal(f"{part}: one call", tuple(machine.assumptions), claim)
    yield from _releases(step, part)


PROPERTIES = (
    Property(
        "guarantee",
        "Every block with a Robot, except FB_ReadArea and FB_WriteArea, respects four limits. It "
        "changes no field of RCX_REF that only FB_ReadArea or FB_WriteArea may write. It does not "
        "change code and data of a command that is being sent. It requests only its own dedicated "
        "inputs. It does not release SI(00) or SI(06) while another block holds the input OFF. "
        "There are three exceptions to the last limit: a rising edge of Execute of "
        "FB_ServoOnFromEmergencyStop releases SI(00), a rising edge of Execute of "
        "FB_ProgramContinue releases SI(06), and FB_Operator releases SI(06) at its key Start, or "
        "at its key Reset after its own Stop. All limits hold for any number of calls in any "
        "order.",
        "chapter 5, 1 and 3; guide chapter 2",
        ("inner", "calls"),
        _goals,
        lambda library: ("any number of calls", *READERS, *between(library)),
        lambda part: ("FB_STATUS",) if part == "any number of calls" else (part,),
    ),
)
