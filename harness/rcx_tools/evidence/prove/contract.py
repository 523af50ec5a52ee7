"""The contract of each block: rules for its pins Execute, Enable, Busy, Done, Valid and Error.

The proof needs an invariant between two calls. Templates give candidates for it, such as equal pins
of inner blocks, or outputs that exclude each other. Candidates that a call can violate are dropped
until the remaining candidates are inductive (Houdini).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import z3

from rcx_tools.evidence.prove.composites import COLLECTS
from rcx_tools.evidence.prove.invariants import (
    ABNORMAL,
    PINS,
    View,
    alarms,
    assumed,
    at_start,
    call,
    exclusive,
    invariant,
    linked,
    without_floats,
)
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.outline import OUTLINED
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.restart import CARRIERS
from structured_text.prove import reals, texts
from structured_text.prove.logic import both, truth
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import Value, scalar

__all__ = ["PROPERTIES", "kind_of"]

#: The word that these blocks read may contain a command response. Then they set neither Valid nor
#: Error.
_SHARED = ("WORD", "WORDINWORDS")
#: Blocks that clear their error when its cause ends, even while Enable is TRUE.
_PASSING = ("FB_AUTOMODE", "FB_STATUS")
#: Blocks without a pin Error. Their outputs depend only on their pins.
_TEXTS = ("FB_ALARMTEXT", "FB_ERRORTEXT", "FB_ENTRYTEXT", "FB_DEDICATEDBITS", "FB_RCXSTAGETEXT")
#: Blocks with outputs that depend on arithmetic. A proof allows any result of the arithmetic, so
#: two instances with equal pins may have different outputs.
_COMPUTING = ("FB_HANDFROMPOINTS", "FB_SCARAFORWARD", "FB_SCARAINVERSE", "FB_SHIFTFROMPOINTS")
#: Blocks that remember the last result. While their data are old, they set neither Valid nor Error.
_WATCHING = ("FB_ATPOINT", "FB_AXISAREA", "FB_WORKAREA")
_ALARM = ("ALARMGROUP", "ALARMCATEGORY")
#: The only block that reports both the link and the answer of the controller.
_TAKER = "FB_RCXTAKEHEAD"
#: Blocks that send nothing to the controller, so they may be called anywhere in a scan.
_LOOKING = ("FB_AUTOMODE", "FB_INTERLOCK", "FB_STATUS")
#: ErrorID of a block that is called outside of FB_ReadArea and FB_WriteArea
#: (docs/reference/errors.md).
_OUT_OF_PLACE = 0x8017


def kind_of(library: Library, block: str) -> str:
    """Return the set of rules that applies to a block, according to its pins.

    The result is "edge", "level", "reader" or "error"; "" if no rules apply.
    """
    pou = library.pou(block)
    inputs = {symbol.name.upper() for symbol in pou.section("VAR_INPUT")}
    outputs = {symbol.name.upper() for symbol in pou.section("VAR_OUTPUT")}
    if "EXECUTE" in inputs and {"BUSY", "DONE", "ERROR", "ERRORID"} <= outputs:
        return "edge"
    if "ENABLE" in inputs and {"VALID", "ERROR", "ERRORID"} <= outputs:
        return "level"
    if {"VALID", "ERROR", "ERRORID"} <= outputs and block not in _WATCHING:
        return "reader"
    if {"ERROR", "ERRORID"} <= outputs:
        return "error"
    return ""


# --- goals ---


def _edge(block: str, was: View, now: View, saw: Any) -> dict[str, Any]:
    """Return the claims about one call of a block with Execute, by name."""
    execute, placed = now["EXECUTE"], _placed(was)
    edge = z3.And(execute, z3.Not(saw), z3.Not(was["BUSY"]))
    refused = z3.And(now["ERROR"], now["ERRORID"] == _OUT_OF_PLACE, z3.Not(now["BUSY"]))
    ends = ("DONE", "ERROR", "ERRORID")
    quiet = z3.And(z3.Not(edge), z3.Not(was["BUSY"]))
    return {
        "at most one of Busy, Done, Error": exclusive(now, ("BUSY", "DONE", "ERROR")),
        "Error exactly with ErrorID": now["ERROR"] == (now["ERRORID"] != 0),
        # For FB_PickPlace, property `response` proves the same rule about Active.
        "Active only with Busy": z3.Implies(
            z3.And(now.bit("ACTIVE"), block != COLLECTS), now["BUSY"]
        ),
        "a rising edge gives Busy in its call": z3.Implies(z3.And(edge, placed), now["BUSY"]),
        "out of place a block that starts or is busy ends with an error": z3.Implies(
            z3.And(z3.Not(placed), z3.Or(edge, was["BUSY"])), refused
        ),
        "Busy ends in Done or Error": z3.Implies(was["BUSY"], now.shown),
        "an end stays while Execute is TRUE": z3.Implies(
            z3.And(quiet, execute), z3.And(now.same(was, ends), z3.Not(now["BUSY"]), now.shown)
        ),
        "without Execute the end disappears in the next call": z3.Implies(
            z3.And(quiet, z3.Not(execute)), z3.Not(now.shown)
        ),
    }


def _level(block: str, was: View, now: View, saw: Any) -> dict[str, Any]:
    """Return the claims about one call of a block with Enable, by name."""
    enable = now["ENABLE"]
    shown = z3.Or(now["VALID"], now.bit("BUSY"), now["ERROR"])
    claims = {
        "at most one of Valid, Busy, Error": exclusive(now, ("VALID", "BUSY", "ERROR")),
        "Error exactly with ErrorID": now["ERROR"] == (now["ERRORID"] != 0),
        "one of them is TRUE exactly while Enable is TRUE": shown == enable,
    }
    if block not in _PASSING:
        claims["Error stays until Enable is FALSE"] = z3.Implies(
            z3.And(enable, was["ERROR"]), now["ERROR"]
        )
    if block not in _LOOKING:
        # If a jog has ended by itself, Valid stays TRUE.
        ended = z3.And(now["VALID"], now.bit("LOCKED"))
        claims["out of place Error is TRUE"] = z3.Implies(
            z3.And(z3.Not(_placed(was)), enable), z3.Or(now["ERROR"], ended)
        )
    return claims


def _placed(was: View) -> Any:
    """Return the claim that the call is between FB_ReadArea and FB_WriteArea."""
    if "INSCAN" in was:
        return was["INSCAN"]
    return was.machine.term((*ROBOT, "INNER", "INSCAN"), was.memory)


def _error(block: str, was: View, now: View, saw: Any) -> dict[str, Any]:
    return {"Error exactly with ErrorID": now["ERROR"] == (now["ERRORID"] != 0)}


def _reader(block: str, was: View, now: View, saw: Any) -> dict[str, Any]:
    claims = _error(block, was, now, saw)
    claims["Valid and Error are never both TRUE"] = z3.Not(z3.And(now["VALID"], now["ERROR"]))
    if not block.endswith(_SHARED):
        claims["Valid or Error"] = z3.Or(now["VALID"], now["ERROR"])
    return claims


_CLAIMS = {"edge": _edge, "level": _level, "error": _error, "reader": _reader}


def _answers(library: Library, block: str, machine: Machine) -> list[Path]:
    """Return the paths of the scalars that a block reads from the controller."""
    return [
        (*BLOCK, symbol.name.upper(), *leaf.suffix)
        for symbol in library.pou(block).section("VAR_OUTPUT")
        if symbol.name.upper() not in PINS
        for leaf in machine.leaves(symbol.type)
    ]


def _equal(machine: Machine, path: Path, one: Value, other: Value) -> Any:
    """Return the claim that two values of a scalar have the same bits."""
    if isinstance(one, reals.Real) or isinstance(other, reals.Real):
        one, other = (z3.BitVecVal(0, 32) if v.known else v.value for v in (one, other))
        return one == other
    if isinstance(one, texts.Text):
        return texts.equal(one, other)
    kind = machine.type_of(path)
    return scalar(kind, one) == scalar(kind, other)


def _data(library: Library, block: str, step: Step, was: View, now: View) -> dict[str, Any]:
    """Return the claims about the response that a command block shows after its last command."""
    machine = step.machine
    _, initial = at_start(library, block)
    ended = z3.And(was["BUSY"], z3.Not(now["BUSY"]))
    if (*BLOCK, "JOB", "ENDED") in now.memory:  # outside of a scan the job ends in the same call
        ended = z3.Or(ended, z3.And(z3.Not(_placed(was)), step.now((*BLOCK, "JOB", "ENDED"))))
    kept, cleared = [], []
    for path in _answers(library, block, machine):
        value = now.memory[path]
        kept.append(_equal(machine, path, value, step.before[path]))
        cleared.append(_equal(machine, path, value, initial[path]))
    words = ((pin, (*ROBOT, "RESPONSE", place)) for place, pin in enumerate(_ALARM))
    claims = {
        "the alarm is the alarm of the response": z3.Implies(
            z3.And(ended, now["ERRORID"] == ABNORMAL),
            z3.And([now[pin] == machine.term(word, step.before) for pin, word in words]),
        )
    }
    if not kept or block in OUTLINED:
        return claims
    without = now["ERROR"]
    if block == "FB_REMOTECOMMAND":
        without = z3.And(without, now["ERRORID"] != ABNORMAL)
    return claims | {
        "the results of the last command stay until the end": z3.Implies(
            z3.Not(ended), z3.And(kept)
        ),
        "an end without an answer clears the results": z3.Implies(
            z3.And(ended, without), z3.And(cleared)
        ),
    }


def _memoryless(library: Library, block: str, step: Step) -> Goal:
    """Return the goal that the outputs of a block depend only on its pins.

    Two instances with different histories and the same pins must have the same outputs.
    """
    machine, pou = step.machine, library.pou(block)
    first = machine.snapshot()
    again = call(library, block, machine, step.before)
    same = [
        _equal(machine, path, first[path], again.machine[path])
        for symbol in pou.section("VAR_OUTPUT")
        for leaf in machine.leaves(symbol.type)
        for path in [(*BLOCK, symbol.name.upper(), *leaf.suffix)]
    ]
    claim = without_floats(both(*[truth(one) for one in same]))
    return Goal(
        f"{block}: the outputs do not depend on earlier calls", tuple(machine.assumptions), claim
    )


def _empty(library: Library, block: str, step: Step, now: View) -> dict[str, Any]:
    """Return the claim that a reading block shows initial values while it is not Valid.

    Outputs that the call does not write keep their initial values, so they are left out.
    """
    machine = step.machine
    _, initial = at_start(library, block)
    cleared = [
        _equal(machine, path, now.memory[path], initial[path])
        for path in _answers(library, block, machine)
        if now.memory[path] is not step.before[path]
    ]
    return {"nothing unless Valid": z3.Or(now["VALID"], z3.And(cleared))}


def _goals(library: Library, block: str) -> Iterator[Goal]:
    step = call(library, block)
    machine, kind = step.machine, kind_of(library, block)
    was, now = View(machine, step.before), View(machine, machine.snapshot())
    saw = z3.Bool("Execute of the last call")
    given = assumed(step)
    claims: dict[str, Any] = {}
    if kind in ("edge", "level") or (kind and (*BLOCK, "JOB", "BUSY") in step.before):
        before, after = invariant(library, block, step, saw)
        given = (*given, *before)
        yield Goal(f"{block}: the invariant between the calls holds again", given, z3.And(after))
    if kind:
        claims = _CLAIMS[kind](block, was, now, saw) | alarms(now)
    if kind == "reader":
        claims |= _empty(library, block, step, now)
    if (*ROBOT, "CONNECTED") in step.before:
        claims["the answer fits CPU_OK"] = linked(machine, now.memory)
    show = {pin: now[pin] for pin in ("EXECUTE", "ENABLE", *PINS) if pin in now}
    if claims:
        claim = z3.And(list(claims.values()))
        if block in _COMPUTING:
            claim = without_floats(claim)
        yield Goal(f"{block}: {'; '.join(claims)}", given, claim, show)
    if block == _TAKER:
        taken = z3.Or(now["AGAIN"], linked(machine, now.memory))
        yield Goal(f"{block}: the type of the answer", tuple(machine.assumptions), taken)
    if kind == "edge" and "ALARMGROUP" in now and block not in (*CARRIERS, COLLECTS):  # `response`
        data = _data(library, block, step, was, now)
        claim = without_floats(z3.And(list(data.values())))
        yield Goal(f"{block}: {'; '.join(data)}", given, claim, show)
    if (kind == "reader" or block in _TEXTS) and block not in _COMPUTING:
        yield _memoryless(library, block, step)


def _parts(library: Library) -> list[str]:
    blocks = [name for name, pou in library.project.pous.items() if pou.kind == "FUNCTION_BLOCK"]
    return [
        name
        for name in blocks
        if kind_of(library, name) or name in _TEXTS or _uses_robot(library, name)
    ]


def _uses_robot(library: Library, block: str) -> bool:
    return any(symbol.name == "Robot" for symbol in library.pou(block).section("VAR_IN_OUT"))


PROPERTIES = (
    Property(
        "contract",
        "The outputs of every block follow the PLCopen rules in every call. At most one of Busy, "
        "Done and Error is TRUE; for a block with Enable, at most one of Valid, Busy and Error. "
        "Error is TRUE exactly while ErrorID is not 0. Active is TRUE only while Busy is TRUE. A "
        "rising edge of Execute sets Busy in the same call. If the call is not between "
        "FB_ReadArea and FB_WriteArea, it sets Error instead. Busy ends with Done or Error. Done "
        "or Error stays TRUE while Execute is TRUE, and the next call without Execute clears it. "
        "The outputs show the results of the last command until the next command ends; a command "
        "that ends without an answer clears them. Blocks that send several commands show their "
        "progress instead. The outputs of a block without memory depend only on its pins. "
        "FB_ScaraForward and FB_ScaraInverse are left out of this last rule, because the proof "
        "allows any result of their arithmetic.",
        "docs/reference/blocks.md",
        ("inner", "area"),
        _goals,
        _parts,
        lambda part: (part,),
        ("guarantee",),
    ),
)
