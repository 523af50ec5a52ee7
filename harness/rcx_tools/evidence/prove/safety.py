"""Proof that no operation stops a PLC, such as an index out of range or a division by zero."""

from __future__ import annotations

import math
import operator
import struct
from collections.abc import Callable, Iterator
from ctypes import c_float
from functools import partial
from pathlib import Path as File
from typing import Any

import z3

from rcx_tools.evidence.prove.invariants import Memory, assumed, call, without_floats
from rcx_tools.evidence.prove.library import BLOCK, IMAGE, Library, Step
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.signs import by_sign
from structured_text.language.types import ArrayType, EnumType
from structured_text.prove import reals
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path

__all__ = ["PROPERTIES", "exactly", "impossible", "log_keeps", "rows_of"]

_COMPARES = {
    z3.Z3_OP_FPA_GE: ">=",
    z3.Z3_OP_FPA_GT: ">",
    z3.Z3_OP_FPA_LE: "<=",
    z3.Z3_OP_FPA_LT: "<",
}


# --- comparisons of scaled and rounded numbers ---


def _number(pattern: int) -> float:
    return float(struct.unpack("<f", struct.pack("<I", pattern))[0])


def _ordered(key: int) -> int:
    """Return the bit pattern of the REAL at a position in ascending order.

    Position 0 is -infinity.
    """
    return 0xFF80_0000 - key if key <= 0x7F80_0000 else key - 0x7F80_0001


def _first(grown: Callable[[float], bool]) -> int:
    """Return the first position in ascending order at which the monotonic `grown` is True."""
    low, high = 0, 2 * 0x7F80_0000 + 2
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if grown(_number(_ordered(middle))) else (middle + 1, high)
    return low


def _grown(term: Any) -> tuple[Any, Callable[[float], float]] | None:
    """Split a term into a bit pattern and a monotonic function of the number with this pattern.

    Return None if the term does not have this form.
    """
    kind, arguments = term.decl().kind(), term.children()
    if kind == z3.Z3_OP_FPA_TO_FP and z3.is_bv(arguments[-1]):
        pattern = arguments[-1]
        if pattern.decl().kind() == z3.Z3_OP_FPA_TO_IEEE_BV:
            return _grown(pattern.arg(0))
        return (pattern, float) if term.sort() == z3.Float32() else None
    make: Callable[[float], float]
    if kind == z3.Z3_OP_FPA_ROUND_TO_INTEGRAL:
        make = _whole
    elif kind == z3.Z3_OP_FPA_TO_FP and len(arguments) == 2 and z3.is_fp(arguments[1]):
        make = _single if term.sort() == z3.Float32() else float
    elif kind == z3.Z3_OP_FPA_MUL and (factor := _constant(arguments[2]) or 0.0) > 0:
        make = partial(operator.mul, factor)
    else:
        return None
    inner = _grown(arguments[1])
    if inner is None:
        return None
    pattern, first = inner
    return pattern, lambda number: make(first(number))


def _whole(number: float) -> float:
    return number if math.isinf(number) else float(round(number))


def _single(number: float) -> float:
    return float(c_float(number).value)


def _constant(term: Any) -> float | None:
    """Return a finite literal in double precision, or None for any other term."""
    bits = z3.simplify(z3.fpToIEEEBV(term))
    if not z3.is_bv_value(bits) or term.sort() != z3.Float64():
        return None
    value = float(struct.unpack("<d", struct.pack("<Q", bits.as_long()))[0])
    return value if math.isfinite(value) else None


def exactly(term: Any) -> Any:
    """Replace comparisons of rounded numbers in a term by comparisons of bit patterns.

    A product with a positive constant is monotonic in the number, and so is each rounding. The
    result of a comparison with a limit therefore changes at exactly one number. Bisection finds
    this number.
    """
    if isinstance(term, bool):
        return z3.BoolVal(term)
    swaps, seen, waiting = [], set(), [term]
    while waiting:
        node = waiting.pop()
        if node.get_id() in seen:
            continue
        seen.add(node.get_id())
        op = _COMPARES.get(node.decl().kind())
        limit = _constant(node.arg(1)) if op else None
        grown = _grown(node.arg(0)) if limit is not None else None
        if op and grown and limit is not None:
            swaps.append((node, _compared(op, *grown, limit)))
        else:
            waiting += node.children()
    return z3.substitute(term, swaps) if swaps else term


def _compared(op: str, pattern: Any, make: Callable[[float], float], limit: float) -> Any:
    reached = operator.ge if op in (">=", "<") else operator.gt
    first = _number(_ordered(_first(lambda number: reached(make(number), limit))))
    return reals.compare(">=" if ">" in op else "<", reals.Real(pattern), reals.Real(first))


# --- goals ---


def _limits(library: Library, block: str, step: Step) -> Iterator[Any]:
    """Yield the claims that a pin for the size of an array does not exceed the array."""
    machine = step.machine
    for symbol in library.pou(block).section("VAR_IN_OUT"):
        if symbol.name.upper().endswith(IMAGE[0]) and isinstance(symbol.type, ArrayType):
            ((low, high),) = symbol.type.bounds
            unit = 2 if getattr(symbol.type.element, "name", "") == "WORD" else 1
            size = machine.term((*BLOCK, "IMAGESIZE"), step.before)
            yield size <= (high - low + 1) * unit


_TABLE, _ILLEGAL_ROW = "FB_MOVETABLE", 0x8051
#: Path of the log in the blocks that contain it.
_LOGS = {"FB_EVENTLOG": BLOCK, "FB_COMMANDRECORDER": (*BLOCK, "EVENTS")}


def log_keeps(machine: Machine, log: Path, memory: Memory, size: Any) -> Any:
    """Return the claim that the newest entry is in the log, with at most LogSize entries."""
    ring = machine.project.pous["FB_EVENTLOG"].symbols["RING"].type
    assert isinstance(ring, ArrayType)
    ((_, last),) = ring.bounds
    newest, count = (machine.term((*log, name), memory) for name in ("NEWEST", "COUNT"))
    return z3.And(size <= last + 1, newest >= 0, newest <= last, z3.Or(count <= 0, count <= size))


def _log_keeps(block: str, step: Step, memory: Memory) -> Any:
    size = step.machine.term((*BLOCK, "LOGSIZE"), step.before)
    return log_keeps(step.machine, _LOGS[block], memory, size)


def _table_keeps(machine: Machine, memory: Memory) -> Any:
    """Return the claim that Row is one of the used rows.

    After a refused start it may be any row.
    """
    last, row, stage, failure = (
        machine.term((*BLOCK, name), memory) for name in ("LAST", "ROW", "STAGE", "FAILURE")
    )
    kind = machine.type_of((*BLOCK, "STAGE"))
    assert isinstance(kind, EnumType)
    members = [member.upper() for member in kind.members]
    under_way = [members.index(f"TABLE_{name}") for name in ("HELD", "MOVE", "ARRIVAL")]
    begun = z3.And(failure != _ILLEGAL_ROW, z3.Or([stage == one for one in under_way]))
    return z3.Implies(begun, z3.And(row >= 1, row <= last, last <= rows_of(machine)))


def rows_of(machine: Machine) -> int:
    """Return the number of rows of RCX_MOVES."""
    moves = machine.project.pous[_TABLE].symbols["MOVES"].type
    assert isinstance(moves, ArrayType)
    ((_, last),) = moves.bounds
    return last


def _goals(library: Library, block: str) -> Iterator[Goal]:
    step = call(library, block)
    known = (*assumed(step), *_limits(library, block, step))
    if block == _TABLE:
        enough = step.machine.term((*BLOCK, "MOVESSIZE"), step.before) <= rows_of(step.machine)
        known = (*known, enough, _table_keeps(step.machine, step.before))
        kept = _table_keeps(step.machine, step.machine.snapshot())
        yield Goal(f"{block}: Row stays in the table", known, kept)
    if block in _LOGS:
        known = (*known, _log_keeps(block, step, step.before))
        kept = _log_keeps(block, step, step.machine.snapshot())
        yield Goal(f"{block}: the entries stay in the log", known, kept)
    yield from impossible(block, step.machine, known)


def impossible(name: str, machine: Machine, known: tuple[Any, ...]) -> Iterator[Goal]:
    """Yield a goal for each kind of fault that must be impossible.

    Each conversion has its own goal.
    """
    places: dict[str, list[Any]] = {}
    for one in machine.obligations:
        told = f"{File(one.file).name}:{one.line}"
        group = f"{one.kind} {told}" if one.kind == "conversion" else one.kind
        made = by_sign if one.kind == "argument" else exactly
        places.setdefault(group, []).append((told, without_floats(made(one.when))))
    if not places:
        yield Goal(f"{name}: no operation that could exceed a range", known, z3.BoolVal(True))
    for group, found in places.items():
        claim = z3.Not(z3.Or([when for _, when in found]))
        yield Goal(f"{name}: {group}, {len(found)} places", known, claim, dict(found))


#: Blocks that are replaced by a summary in their callers, or that are proved only inside their
#: callers.
_ELSEWHERE = ("FB_RCXFIRSTROW", "FB_RCXSCANTIME", "FB_RCXSHAREDWORDS")


def _parts(library: Library) -> list[str]:
    return [
        name
        for name, pou in library.project.pous.items()
        if pou.kind == "FUNCTION_BLOCK" and name not in _ELSEWHERE
    ]


PROPERTIES = (
    Property(
        "safety",
        "Whatever the values of the pins are, no array index is out of range and no division is "
        "by zero. No REAL is converted to an integer type that cannot hold it. No shift, text or "
        "time is out of range.",
        "docs/explanation/architecture.md",
        ("inner", "clock", "area", "log", "table"),
        _goals,
        _parts,
        lambda part: (part,),
    ),
)
