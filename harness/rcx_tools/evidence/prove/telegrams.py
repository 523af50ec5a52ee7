"""Properties: command blocks send legal telegrams, and those that belong to their pins.

The proof covers every command block except FB_RemoteCommand. It is an induction over the calls of a
block. The telegram is composed when the job starts, from the pins of that call. It stays unchanged
while the job is busy, and nothing else is ever requested. The mapping from pins to words does not
come from the tables of the library. It comes from a second interpretation of the guide
(pin_telegrams.py).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from pathlib import Path as File
from typing import Any

import z3

from rcx_tools.evidence.prove.command_calls import Call
from rcx_tools.evidence.prove.legality import legal
from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.pin_telegrams import (
    ROUNDED,
    WORDS,
    Expected,
    bounds,
    char_code,
    nearest,
    pattern_of,
    reading_of,
    times,
)
from rcx_tools.evidence.prove.property import Goal, Property
from structured_text.prove.texts import anything

__all__ = ["PROPERTIES"]

#: Name of the part with the lemmas about REAL_TO_DINT and characters. All other parts use them.
_LEMMAS = "REAL_TO_DINT and FC_RcxCharCode"


def _blocks(library: Library) -> list[str]:
    files = {name: File(library.pou(name).file) for name in library.blocks}
    return [
        name
        for name, file in files.items()
        if library.folder / "command" in file.parents and name != "FB_REMOTECOMMAND"
    ]


class _Block:
    """Two calls of a block, one that starts a job and one while a job is busy, with their goals."""

    def __init__(self, library: Library, block: str) -> None:
        self.name = block
        self._library = library
        self._start = Call(library, block, busy=False)
        self._busy = Call(library, block, busy=True)
        self._reading = reading_of(block)
        self._expected = Expected(self._start, self._reading)
        self._data = self._expected.data()
        self._unused = [k for k in WORDS if z3.is_bv_value(self._data[k])]
        self._rounded: list[tuple[Any, Any]] = []
        self._lemmas: list[Any] = []
        for row, pattern in self._expected.scaled():
            number = z3.BitVec(f"{pattern} times {row.scale}", 32)
            self._rounded.append((nearest(pattern, row.scale), number))
            for _, inside, found in bounds(pattern, number, row.scale):
                self._lemmas.append(z3.Implies(inside, found))

    def _assumed(self, call: Call) -> tuple[Any, ...]:
        before = call.between(call.step.before, self._unused)
        return (*call.machine.assumptions, before, call.turn)

    def _goal(self, call: Call, name: str, claim: Any, **show: Any) -> Goal:
        """Return a goal without floating-point arithmetic.

        REAL_TO_DINT is replaced by a number within bounds.
        """
        assumed = self._plain(z3.And(*self._assumed(call), *self._lemmas))
        shown = {name: self._plain(term) for name, term in show.items()}
        return Goal(f"{self.name}: {name}", (assumed,), self._plain(claim), shown)

    def _plain(self, term: Any) -> Any:
        return z3.substitute(term, *self._rounded) if self._rounded else term

    def held(self) -> Iterator[Goal]:
        """Yield the goals that the stored command is unchanged, and nothing else is requested."""
        first = self._library.machine()
        pou = self._library.pou(self.name)
        assert pou.block is not None
        first.create(BLOCK, pou.block)
        begin = self._start.between(first.snapshot(), self._unused)
        idle = z3.Not(first.term((*BLOCK, "JOB", "BUSY")))
        yield Goal(f"{self.name}: the block is idle at the start", (), z3.And(begin, idle))
        for call, when in ((self._start, "no job was busy"), (self._busy, "a job was busy")):
            show = {"code": call.now.code, "refused": call.now.refused}
            name = f"only the held command is requested, and only if not refused; {when}"
            yield self._goal(call, name, call.requested, **show)
            after = call.between(call.machine.snapshot(), self._unused)
            yield self._goal(call, f"the invariant between the calls holds again; {when}", after)
        now, was = self._busy.now, self._busy.was
        stays = z3.Implies(now.busy, now.same(was))
        yield self._goal(self._busy, "the held command stays while the job is busy", stays)

    def legal(self) -> Iterator[Goal]:
        """Yield the goals that a command is legal at the start of a job or is refused."""
        now = self._start.now
        edge = self._start.edge
        yield self._goal(self._start, "a job begins at an edge", z3.Implies(now.ready, edge))
        codes = sorted(set(self._reading.codes.values()))
        claim = z3.Implies(z3.And(edge, now.ready), legal(now.code, now.data, codes))
        yield self._goal(self._start, "a telegram is legal", claim, **_shown(now.code, now.data))

    def pins(self) -> Iterator[Goal]:
        """Yield the goals that pins give the expected telegram, and other pins another one."""
        now, expected = self._start.now, self._expected
        code = expected.code()
        same = [now.code == code, *map(_equal, now.data, self._data)]
        claim = z3.Implies(now.ready, z3.And(same))
        show = _shown(now.code, now.data) | _shown(code, self._data, " by the pins")
        yield self._goal(self._start, "a telegram is that of the pins", claim, **show)
        fits = list(expected.fits())
        if fits:
            claim = z3.Implies(now.ready, z3.And(fits))
            yield self._goal(self._start, "a REAL is a number, and no digits are cut off", claim)
        keys = list(expected.keys())
        if keys:
            yield self._told_apart(keys, code)

    def _told_apart(self, keys: list[Any], code: Any) -> Goal:
        """Return the goal that equal telegrams come from equal pins, except pins without effect."""
        terms = [
            self._plain(z3.And(*self._assumed(self._start), self._start.now.ready)),
            self._plain(code),
            *map(self._plain, self._data),
            *map(self._plain, keys),
        ]
        other = [(one, z3.Const(f"{one}'", one.sort())) for one in _constants(terms)]
        (one, *left), (two, *right) = terms, [z3.substitute(term, *other) for term in terms]
        words = 1 + len(WORDS)
        assumed = [one, two, *map(_equal, left[:words], right[:words])]
        claim = z3.And(list(map(_equal, left[words:], right[words:])))
        name = f"{self.name}: different pins make different telegrams"
        return Goal(name, tuple(assumed), claim)


def _equal(one: Any, other: Any) -> Any:
    return one == other


def _shown(code: Any, data: Iterable[Any], more: str = "") -> dict[str, Any]:
    return {f"n+{2 * k}{more}": word for k, word in enumerate((code, *data))}


def _constants(terms: Iterable[Any]) -> list[Any]:
    """Return the variables of the solver that the terms contain."""
    seen: set[int] = set()
    found, waiting = [], list(terms)
    while waiting:
        term = waiting.pop()
        if term.get_id() in seen:
            continue
        seen.add(term.get_id())
        if z3.is_const(term) and term.decl().kind() == z3.Z3_OP_UNINTERPRETED:
            found.append(term)
        waiting += term.children()
    return found


def _lemma_goals(library: Library) -> Iterator[Goal]:
    pattern = z3.BitVec("pattern", 32)
    for factor in dict.fromkeys(row[0] for row in ROUNDED):
        for name, inside, found in bounds(pattern, nearest(pattern, factor), factor):
            yield Goal(name, (inside,), found)
    for position in range(1, 17):
        machine = library.machine(summaries=False)
        text = anything("text")
        body = machine.call_function("FC_RCXCHARCODE", [text, position])
        claim = body == char_code(machine, [text, position])
        yield Goal(f"FC_RcxCharCode {position}", (z3.ULE(text.size, text.most),), claim)


def _legal_goals(library: Library, part: str) -> Iterator[Goal]:
    if part == _LEMMAS:
        yield from _lemma_goals(library)
        return
    block = _Block(library, part)
    yield from block.held()
    yield from block.legal()


def _exact_goals() -> Iterator[Goal]:
    """Yield the goals that the REAL nearest to a multiple of 0.001 mm or 0.01 % is sent exactly.

    The product differs from the whole number by less than a quarter: below 8192, half the distance
    of two REALs is 0.000244.
    """
    double = z3.Float64()
    pattern, number = z3.BitVec("pattern", 32), z3.BitVec("number", 32)
    middle, quarter = z3.fpSignedToFP(z3.RNE(), number, double), z3.FPVal(0.25, double)
    for factor, limit in ((1000, 8191.999), (100, 100.0)):
        product = times(pattern, factor).value
        assumed = (
            z3.ULE(pattern & 0x7FFF_FFFF, pattern_of(limit)),
            z3.And(number >= -round(limit * factor), number <= round(limit * factor)),
            z3.fpLT(z3.fpSub(z3.RNE(), middle, quarter), product),
            z3.fpLT(product, z3.fpAdd(z3.RNE(), middle, quarter)),
        )
        yield Goal(f"exact, times {factor}", assumed, nearest(pattern, factor) == number)


def _pins_goals(library: Library, part: str) -> Iterator[Goal]:
    if part == _LEMMAS:
        yield from _lemma_goals(library)
        yield from _exact_goals()
        return
    block = _Block(library, part)
    yield from block.held()
    yield from block.pins()


def _parts(library: Library) -> list[str]:
    return [_LEMMAS, *_blocks(library)]


def _rests_on(part: str) -> tuple[str, ...]:
    return ("FC_RCXCHARCODE",) if part == _LEMMAS else (part,)


PROPERTIES = (
    Property(
        "telegram-legal",
        "Whatever the values of its pins are, every command block except FB_RemoteCommand "
        "requests only commands that are legal by the guide. If the block refuses an input value, "
        "it requests nothing. The proof does not cover the blocks outside of plc/lib/command that "
        "send commands themselves: FB_Override, FB_ToolPosition, FB_PointBackup and "
        "FB_PointRestore.",
        "remote command guide 4.2 to 4.9",
        ("inner",),
        _legal_goals,
        _parts,
        _rests_on,
        ("turn-once", "functions"),
    ),
    Property(
        "telegram-pins",
        "Every command block except FB_RemoteCommand sends the values that its pins had when it "
        "was started. A number in whole steps of 0.001 mm or 0.01 % is sent exactly. Different "
        "values at a used pin give different words, with three exceptions: REALs that round to "
        "the same step, spaces at the end of a text, and -0.0.",
        "remote command guide 4.2 to 4.9",
        ("inner",),
        _pins_goals,
        _parts,
        _rests_on,
        ("turn-once", "functions"),
    ),
)
