"""Proof that no arithmetic exceeds its type. A table lists the intended exceptions.

Each POU is run alone, from any state and with any pins. A called block may give any values to its
instance and its VAR_IN_OUTs. The proof therefore holds for any caller of the POU.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path as File
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, Library, milliseconds
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.safety import log_keeps
from rcx_tools.evidence.prove.summaries import SUMMARIES
from rcx_tools.evidence.results import ROOT
from structured_text.errors import InputError
from structured_text.language.printer import expression_text
from structured_text.language.standard import BLOCKS
from structured_text.output.toml_files import load_toml
from structured_text.prove.logic import both
from structured_text.prove.machine import Machine
from structured_text.prove.overflow import Operation, Span
from structured_text.prove.symbolic_memory import Alternatives, Path
from structured_text.prove.values import TIME_BITS, anything, legal

__all__ = ["PROPERTIES", "WRAPS", "Wrap", "none_leaves", "wraps"]

#: Table of the operations that are intended to exceed their type.
WRAPS = ROOT / "tests" / "tools" / "evidence" / "wraps.toml"
_KEYS = ("file", "pou", "operation", "reason")
#: Range of a TIME with 32 bits of milliseconds. No PLC has a smaller range.
_LEAST_TIME = (-(1 << 31) * 1_000_000, ((1 << 31) - 1) * 1_000_000)
#: Blocks that are executed inside their callers, because their results limit counters of the
#: callers.
_INSIDE = ("FB_RCXSHAREDWORDS", "FB_RCXPOINTHEAD")
#: Blocks with loops that are replaced by a loop invariant (see `functions`).
_CUT = ("FB_RCXFIRSTROW",)
#: Functions that are proved once for any arguments. They are not checked again in their callers.
_ALONE = ("FC_RCXCHARCODE",)
_CLOCK, _REST = (*BLOCK, "CLOCK"), (*BLOCK, "REST")


@dataclass(frozen=True)
class Wrap:
    """An operation that exceeds its type on purpose: its file, POU and text, and the reason."""

    file: str
    pou: str
    operation: str
    reason: str


@lru_cache(maxsize=4)
def wraps(table: File) -> tuple[Wrap, ...]:
    """Return the rows of the table.

    Raises:
        InputError: invalid TOML, an incomplete row, or a duplicate row.
    """
    found: dict[tuple[str, str], Wrap] = {}
    for number, row in enumerate(load_toml(table).get("wrap", []), 1):
        if set(row) != set(_KEYS) or not all(row.values()):
            hint = f"it needs {', '.join(_KEYS)}"
            raise InputError(f"wrap {number} has {', '.join(row)}", file=table, hint=hint)
        wrap = Wrap(**row)
        key = wrap.pou, wrap.operation
        if key in found:
            raise InputError(f"a second row for {wrap.operation} of {wrap.pou}", file=table)
        found[key] = wrap
    return tuple(found.values())


class _Alone(Machine):
    """A machine that runs the body of one block.

    Called blocks may change all variables they can access.
    """

    def call_block(
        self, instance: Path, block: str, in_outs: Mapping[str, Path | Alternatives]
    ) -> None:
        """Run a block, or make everything that it can change arbitrary."""
        if not self._frames or block in BLOCKS or block.upper() in _INSIDE:
            super().call_block(instance, block, in_outs)
            return
        pou = self.project.pous[block.upper()]
        assert pou.block is not None
        self.havoc(instance, pou.block)
        for symbol in pou.section("VAR_IN_OUT"):
            places = in_outs[symbol.name.upper()]
            for _, path in places if isinstance(places, list) else [(True, places)]:
                self.havoc(path, symbol.type)


def _char_code(machine: Machine, arguments: list[Any]) -> Any:
    return z3.BitVec(machine.fresh("code"), 16)


def _machine(library: Library, name: str) -> Machine:
    """Return a machine for one POU at any time of the PLC's operation."""
    summaries = {**SUMMARIES, "FC_RCXCHARCODE": _char_code}
    summaries.pop(name, None)
    machine = _Alone(library.project, summaries)
    machine.now = z3.BitVec("now", TIME_BITS)
    machine.assume(z3.And(machine.now >= 0, machine.now < 1 << 62))
    return machine


# --- invariants of blocks ---


def _scan_time_keeps(machine: Machine, memory: Mapping[Path, Any]) -> Any:
    """Return the claim that Rest is below 1 s, and that the clock shows at most 100 s.

    The clock started in the past. The claim does not include Rest >= 0: Rest is only 0 or the
    result of a TIME operation, and `_span` requires that such a result is not below 0.
    """

    def term(*path: Any) -> Any:
        return machine.term(path, memory)

    rest, shown = term(*_REST), term(*_CLOCK, "ET")
    start = term(*_CLOCK, "start")
    return z3.And(
        *(rest < milliseconds(1000), shown >= 0, shown <= milliseconds(100_000)),
        *(start >= 0, start <= machine.now),
    )


def _tool_position_keeps(machine: Machine, memory: Mapping[Path, Any]) -> Any:
    """Return the claim that the clock shows at most one day, and that no age exceeds two days.

    The clock started in the past. Its time and the ages are not negative.
    """

    def term(*path: Any) -> Any:
        return machine.term((*BLOCK, *path), memory)

    day = milliseconds(86_400_000)
    ages = [z3.And(term(name) >= 0, term(name) <= 2 * day) for name in ("AGE", "OUT")]
    shown, start = term("CLOCK", "ET"), term("CLOCK", "start")
    return z3.And(*ages, shown >= 0, shown <= day, start >= 0, start <= machine.now)


def _log_keeps(machine: Machine, memory: Mapping[Path, Any]) -> Any:
    """Return the invariant of the log: the invariant of `safety` and one more claim.

    The claim is that the number of entries is above 0 while entries are counted down.
    """

    def term(name: str) -> Any:
        return machine.term((*BLOCK, name), memory)

    counts_down = z3.And(term("ENDING"), z3.Not(term("FROZEN")))
    return z3.And(
        z3.Implies(counts_down, term("STILL") > 0),
        log_keeps(machine, BLOCK, memory, term("LOGSIZE")),
    )


def _backup_keeps(machine: Machine, memory: Mapping[Path, Any]) -> Any:
    """Return the claim that a backup record has legal numbers and not too many rows.

    The record is in progress. It has at most 100 rows, and its first point is at most 29,999.
    """

    def term(*path: str) -> Any:
        return machine.term((*BLOCK, *path), memory)

    wanted, taken, first = term("WANTED"), term("HEAD", "COUNT"), term("HEAD", "FIRST")
    return z3.And(taken >= 0, taken <= wanted, wanted <= 100, first >= 0, first <= 29_999)


def _restore_keeps(machine: Machine, memory: Mapping[Path, Any]) -> Any:
    """Return the claim that Row and the counts are within the limits of a legal record.

    Each row before Row counts at most one difference.
    """

    def term(*path: str) -> Any:
        return machine.term((*BLOCK, *path), memory)

    row, start, different = term("ROW"), term("STARTROW"), term("DIFFERENCES")
    first, count = term("ROWS", "FIRST"), term("ROWS", "COUNT")
    return z3.And(
        *(row >= 1, row <= 100, start >= 1, start <= 100, first >= 0, first <= 29_999),
        *(count >= 0, count <= 100, different >= 0, different <= 100),
        z3.Or(term("THROUGH"), different < row),
        *(z3.Implies(term("CHECKS"), different == 0), term("BUSY") == term("JOB", "BUSY")),
    )


def _span(name: str) -> Span:
    """Return the range in which the results of TIME operations must be."""
    low, high = _LEAST_TIME
    return (0 if name == "FB_RCXSCANTIME" else low), high


_KEEPS = {
    "FB_RCXSCANTIME": _scan_time_keeps,
    "FB_EVENTLOG": _log_keeps,
    "FB_TOOLPOSITION": _tool_position_keeps,
    "FB_POINTBACKUP": _backup_keeps,
    "FB_POINTRESTORE": _restore_keeps,
}


# --- goals ---


def _goals(library: Library, name: str) -> Iterator[Goal]:
    pou = library.pou(name)
    machine = _machine(library, name)
    if pou.kind == "FUNCTION":
        machine.call_function(name, list(_any_arguments(library, name, machine)))
        known: tuple[Any, ...] = ()
    else:
        step = library.step(name, machine)
        keeps = _KEEPS.get(name)
        known = (keeps(machine, step.before),) if keeps else ()
        if name == "FB_RCXSCANTIME":
            known = (*known, step.was(_REST) >= 0)
        if keeps:
            kept = keeps(machine, machine.snapshot())
            yield Goal(f"{name}: what it keeps", (*machine.assumptions, *known), kept)
    known = (*machine.assumptions, *known)
    own = machine.operations
    meant = {wrap.operation: wrap for wrap in wraps(WRAPS) if wrap.pou == pou.name}
    listed = {(wrap.pou, wrap.operation) for wrap in wraps(WRAPS)}
    asked = [one for one in own if (one.pou, expression_text(one.node)) not in listed]
    yield none_leaves(name, known, asked, _span(name))
    for wrap in meant.values():
        found = [
            one for one in own if (one.pou, expression_text(one.node)) == (wrap.pou, wrap.operation)
        ]
        right = str(library.folder / wrap.file) == pou.file and _can(known, found)
        text = f"{name}: {wrap.operation} of {wrap.file} leaves its type, as {WRAPS.name} says"
        yield Goal(text, (), z3.BoolVal(right))


def _any_arguments(library: Library, name: str, machine: Machine) -> Iterator[Any]:
    for symbol in library.pou(name).section("VAR_INPUT"):
        value = anything(symbol.type, machine.fresh(symbol.name))
        machine.assume(legal(symbol.type, value))
        yield value


def none_leaves(name: str, known: tuple[Any, ...], asked: Iterable[Operation], time: Span) -> Goal:
    """Return the goal that no operation exceeds its type.

    `time` is the permitted range of TIME results.
    """
    places: dict[str, list[Any]] = {}
    count = 0
    for one in asked:
        when = one.when(time)
        if when is not False:
            count += 1
            told = f"{File(one.file).name}:{one.line}: {expression_text(one.node)}"
            places.setdefault(told, []).append(z3.BoolVal(True) if when is True else when)
    show = {told: z3.Or(found) for told, found in places.items()}
    return Goal(f"{name}: {count} operations", known, z3.Not(z3.Or(list(show.values()))), show)


def _can(known: tuple[Any, ...], found: Iterable[Operation]) -> bool:
    """Return the claim that one of these operations exceeds its type."""
    solver = z3.SolverFor("QF_AUFBVFP")
    solver.set("timeout", 10_000)
    for one in found:
        when = one.when(_LEAST_TIME)
        if when is not False and solver.check(*known, both(when)) == z3.sat:
            return True
    return False


def _parts(library: Library) -> list[str]:
    """Return the blocks and functions that are checked alone.

    Raises:
        InputError: a row of the table names a POU that does not exist.
    """
    rows = wraps(WRAPS)
    for wrap in rows:
        if wrap.pou.upper() not in library.project.pous:
            raise InputError(f"a row is about {wrap.pou}, which does not exist", file=WRAPS)
    listed = {*_ALONE, *(wrap.pou.upper() for wrap in rows)}
    return [
        name
        for name, pou in library.project.pous.items()
        if name in listed or (pou.kind == "FUNCTION_BLOCK" and name not in (*_INSIDE, *_CUT))
    ]


PROPERTIES = (
    Property(
        "overflow",
        "No integer arithmetic exceeds its type. No conversion to a narrower type loses bits. No "
        "sum of TIME values exceeds 32 bits of milliseconds. The intended exceptions are listed "
        "in tests/tools/evidence/wraps.toml.",
        "docs/explanation/architecture.md",
        ("inner", "clock", "log", "real-bits"),
        _goals,
        _parts,
        lambda part: (part,),
    ),
)
