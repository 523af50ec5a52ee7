"""Properties: the bytes of the process image that blocks write (chapter 1, 4; chapter 5, 1)."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import z3

from rcx_tools.evidence.prove.area import (
    DEDICATED,
    INPUTS,
    accepted,
    again,
    at_the_start,
    byte,
    legal_image,
    offset,
    word,
)
from rcx_tools.evidence.prove.guarantee import (
    COMMAND_RUN,
    INNER,
    READERS,
    WRITERS,
    guarantee,
    is_connected,
)
from rcx_tools.evidence.prove.library import BLOCK, IMAGE, ROBOT, Library, Step
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.machine import Machine

__all__ = ["PROPERTIES", "wire"]

#: Position of PHASE_COMMAND_DATA in RCX_PHASE.
_COMMAND_DATA = 2
_HEAD = (*BLOCK, "MAKEHEAD")
#: Blocks that write general-purpose inputs (chapter 1, 4.1 and 4.2; chapter 3, 2.1).
_BITS = ("FB_WRITEBIT", "FB_WRITEBITINWORDS")
_PORTS = ("FB_WRITEPORT", "FB_WRITEPORTINWORDS")
_WORDS = ("FB_WRITEWORD", "FB_WRITEWORDINWORDS")
_PAIRS = ("FB_WRITEDOUBLEWORD", "FB_WRITEDOUBLEWORDINWORDS")


def _unchanged(step: Step, address: Any) -> Any:
    """Return the claim that a byte of the image is unchanged."""
    return byte(step.machine, address, step.before) == byte(step.machine, address)


def _assumed(step: Step) -> list[Any]:
    return [*step.machine.assumptions, legal_image(step.machine)]


def _inside(address: Any, first: Any, count: int) -> Any:
    """Return the claim that an address is one of `count` addresses from `first` on."""
    return z3.And(address >= first, address < first + count)


# --- FB_WriteArea ---


def wire(step: Step, before: Any) -> Any:
    """Return bytes n + 32 and n + 33 after a call, computed from the bytes before the call."""
    off = z3.BitVecVal(0, 16)
    for pin, bit in (("EMERGENCYSTOPOK", 0x0001), ("STOPOK", 0x0040)):
        off |= z3.If(step.now((*BLOCK, pin)), z3.BitVecVal(0, 16), z3.BitVecVal(bit, 16))
    applied = step.now((*INNER, "APPLIED"))
    return z3.If(accepted(step), applied, z3.If(again(step), before & ~off, before))


def _dedicated(step: Step, name: str) -> Iterator[Goal]:
    """Yield the goals about bytes n + 32 and n + 33.

    The first call in a scan writes the applied inputs. Another call in the same scan may only clear
    SI(00) and SI(06). A refused call writes nothing.
    """
    machine, at = step.machine, offset(step.machine) + DEDICATED
    before, after = word(machine, at, step.before), word(machine, at)
    written = z3.Or(accepted(step), again(step))
    claim = z3.Implies(written, after == wire(step, before))
    yield Goal(f"{name}: bytes n + 32, n + 33", tuple(_assumed(step)), claim)
    same = machine.term(IMAGE, step.before) == machine.term(IMAGE)
    yield Goal(
        f"{name}: refused, nothing is written",
        tuple(_assumed(step)),
        z3.Implies(z3.Not(written), same),
    )


def _write_area(library: Library, name: str) -> Iterator[Goal]:
    step = library.step(name)
    machine = step.machine
    yield from _dedicated(step, name)
    assumed = _assumed(step)
    address, start = z3.BitVec("address", 32), offset(machine)
    there = z3.And(address >= 0, address < 512)
    show = {"address": address, "n": start}
    yield Goal(
        f"{name}: no byte except n to n + 33",
        (*assumed, there, z3.Not(_inside(address, start, 34))),
        _unchanged(step, address),
        show,
    )
    yield Goal(
        f"{name}: a second call, no byte except n + 32",
        (*assumed, there, z3.Not(accepted(step)), address != start + DEDICATED),
        _unchanged(step, address),
        show,
    )
    yield Goal(
        f"{name}: the code in bytes n, n + 1",
        tuple(assumed),
        z3.Implies(accepted(step), word(machine, start) == step.now((*_HEAD, "CODE"))),
    )
    for number in range(1, 16):
        yield Goal(
            f"{name}: word {number} in bytes n + {2 * number}, n + {2 * number + 1}",
            tuple(assumed),
            z3.Implies(
                accepted(step),
                word(machine, start + 2 * number) == step.now((*_HEAD, "WORDS", number - 1)),
            ),
        )


# --- general-purpose inputs ---


def _port(pin: Any) -> tuple[Any, Any]:
    """Return the byte of a port, and whether this port exists.

    The ports are SI2() to SI7() and SI10() to SI15().
    """
    low = z3.And(pin >= 2, pin <= 7)
    high = z3.And(pin >= 10, pin <= 15)
    number = z3.SignExt(16, pin)
    return z3.If(low, number + 32, number + 30), z3.Or(low, high)


def _bits(step: Step) -> Iterator[tuple[str, Any]]:
    machine, start = step.machine, offset(step.machine)
    pin, state = step.now((*BLOCK, "PORT")), step.now((*BLOCK, "VALUE"))
    at, exists = _port(pin / 10)
    digit = z3.SRem(pin, z3.BitVecVal(10, 16))
    mask = z3.BitVecVal(1, 8) << z3.Extract(7, 0, digit)
    before, after = byte(machine, start + at, step.before), byte(machine, start + at)
    yield "place", (start + at, 1, z3.And(exists, digit >= 0, digit <= 7))
    yield "value", z3.If(state, after == before | mask, after == before & ~mask)


def _ports(step: Step) -> Iterator[tuple[str, Any]]:
    at, exists = _port(step.now((*BLOCK, "PORT")))
    place = offset(step.machine) + at
    yield "place", (place, 1, exists)
    yield "value", byte(step.machine, place) == step.now((*BLOCK, "VALUE"))


def _number(step: Step) -> tuple[Any, Any, Any]:
    """Return a word number, and whether it is legal: 2 to 15, or 24 to 127 with 256 bytes."""
    number = step.now((*BLOCK, "NUMBER"))
    shared = z3.And(number >= 2, number <= 15)
    size = step.now((*BLOCK, "SIZE"))
    return number, shared, z3.And(number >= 24, number <= 127, size == 256)


def _words(step: Step) -> Iterator[tuple[str, Any]]:
    number, _, extended = _number(step)
    place = offset(step.machine) + 2 * z3.SignExt(16, number)
    yield "place", (place, 2, extended)
    yield "value", word(step.machine, place) == step.now((*BLOCK, "VALUE"))


def _pairs(step: Step) -> Iterator[tuple[str, Any]]:
    number, _, extended = _number(step)
    place = offset(step.machine) + 2 * z3.SignExt(16, number)
    yield "place", (place, 4, z3.And(extended, z3.Extract(0, 0, number) == 0))
    both = z3.Concat(word(step.machine, place + 2), word(step.machine, place))
    yield "value", both == step.now((*BLOCK, "VALUE"))


def _general(step: Step, count: int, name: str) -> Iterator[Goal]:
    """Yield the goals about words 2 to 15. FB_WriteArea sends these words between commands."""
    number, shared, _ = _number(step)
    if count == 2:
        shared = z3.And(shared, z3.Extract(0, 0, number) == 0)
    fine = step.now((*BLOCK, "ERRORID")) == 0
    value = step.now((*BLOCK, "VALUE"))
    claims = []
    for place in range(1, 16):
        now, was = (call((*INNER, "GENERAL", place - 1)) for call in (step.now, step.was))
        wanted = was
        for part in range(count):
            bits = z3.Extract(16 * part + 15, 16 * part, value)
            wanted = z3.If(z3.And(fine, shared, number == place - part), bits, wanted)
        claims.append(now == wanted)
    yield Goal(f"{name}: words 2 to 15", tuple(_assumed(step)), z3.And(*claims))


def _general_inputs(library: Library, name: str, facts: Any) -> Iterator[Goal]:
    step = library.step(name)
    assumed = _assumed(step)
    found = dict(facts(step))
    place, count, exists = found["place"]
    fine = step.now((*BLOCK, "ERRORID")) == 0
    address = z3.BitVec("address", 32)
    there = z3.And(address >= 0, address < 512)
    written = z3.And(fine, exists, _inside(address, place, count))
    show = {"address": address, "n": offset(step.machine), "place": place}
    yield Goal(
        f"{name}: no byte except its own",
        (*assumed, there, z3.Not(written)),
        _unchanged(step, address),
        show,
    )
    yield Goal(f"{name}: its value", (*assumed, fine, exists), found["value"], show)
    start = offset(step.machine)
    yield Goal(
        f"{name}: never bytes n to n + 33, n + 46, n + 47",
        (
            *assumed,
            z3.Or(_inside(address, start, 34), _inside(address, start + 46, 2)),
            start >= 0,
            start <= 512 - 48,
        ),
        _unchanged(step, address),
        show,
    )
    if count != 1:
        yield from _general(step, count // 2, name)


_GENERAL = {
    **dict.fromkeys(_BITS, _bits),
    **dict.fromkeys(_PORTS, _ports),
    **dict.fromkeys(_WORDS, _words),
    **dict.fromkeys(_PAIRS, _pairs),
}


def _readers(library: Library) -> list[str]:
    """Return all blocks with an image that write no byte of it."""
    return [
        name
        for name in library.blocks
        if name not in (*WRITERS, *_GENERAL) and is_connected(library, name, IMAGE)
    ]


def _bytes(library: Library, part: str) -> Iterator[Goal]:
    if part in WRITERS:
        yield from _write_area(library, part)
    elif part in _GENERAL:
        yield from _general_inputs(library, part, _GENERAL[part])
    else:
        step = library.step(part)
        machine = step.machine
        same = [machine.term(IMAGE, step.before) == machine.term(IMAGE)]
        if part not in READERS:
            same += [step.was(path) == step.now(path) for path in step.before if path[:1] == ROBOT]
        yield Goal(f"{part}: it writes nothing", tuple(machine.assumptions), z3.And(*same))


# --- reserved bits ---


def _clean(machine: Machine, memory: Any = None) -> Any:
    """Return the claim that no reserved bit is requested or applied."""
    reserved = z3.BitVecVal(~INPUTS & 0xFFFF, 16)
    applied = machine.term((*INNER, "APPLIED"), memory)
    request = machine.term((*INNER, "REQUEST"), memory)
    return z3.And(applied & reserved == 0, request & reserved == 0)


def _reserved(library: Library, part: str) -> Iterator[Goal]:
    start = at_the_start(library, part)
    yield Goal(f"{part}: at the start", tuple(start.assumptions), _clean(start))
    step = library.step(part)
    machine = step.machine
    calls = library.machine()
    calls.havoc(ROBOT, library.pou(part).symbols["ROBOT"].type)
    before = calls.snapshot()
    calls.havoc(ROBOT, library.pou(part).symbols["ROBOT"].type)
    after = calls.snapshot()
    yield Goal(
        f"{part}: blocks between",
        (*calls.assumptions, _clean(calls, before), guarantee(calls, before, after)),
        _clean(calls, after),
    )
    assumed = (*machine.assumptions, _clean(machine, step.before))
    applied, phase = step.now((*INNER, "APPLIED")), step.now((*INNER, "PHASE"))
    yield Goal(f"{part}: bytes n + 32, n + 33", assumed, _clean(machine))
    mask = z3.BitVecVal(~INPUTS & 0xFFFF, 16)
    yield Goal(f"{part}: the sent bytes", assumed, applied & mask == 0)
    idle = z3.And(phase != _COMMAND_DATA, phase != COMMAND_RUN)
    first = step.now((*_HEAD, "WORDS", 0))
    yield Goal(
        f"{part}: SIW(0) and SIW(1) without a command",
        (*machine.assumptions, accepted(step), idle),
        z3.And(first == 0, step.now((*_HEAD, "CODE")) == 0),
    )


PROPERTIES = (
    Property(
        "bytes",
        "FB_WriteArea writes bytes n to n+33 with their correct values, and no other byte. The "
        "blocks for general-purpose inputs write only the bytes of these inputs. No other block "
        "writes a byte of the process image.",
        "chapter 1, 4; chapter 3, 2.1; chapter 5, 1",
        ("area",),
        _bytes,
        lambda library: (*WRITERS, *_GENERAL, *_readers(library)),
        lambda part: (part,),
    ),
    Property(
        "reserved",
        "Reserved bits of the dedicated inputs are never ON. While no command is being sent, "
        "SIW(0) and SIW(1) are 16#0000.",
        "chapter 1, 4; chapter 5, 1",
        ("inner", "calls", "area"),
        _reserved,
        lambda _: WRITERS,
        lambda part: (part,),
    ),
)
