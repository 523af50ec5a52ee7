"""Proofs that the summaries of functions with long loops agree with the function bodies.

A loop is not unrolled. Its loop invariant must hold before the loop (base) and again after each
round (induction step). `n` counts the rounds. A bound of `n` proves that the loop ends.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import z3

from rcx_tools.evidence.prove.library import BLOCK, Library
from rcx_tools.evidence.prove.overflow import none_leaves
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.prove.safety import impossible, rows_of
from rcx_tools.evidence.prove.summaries import (
    LONGEST_MS,
    bits_of,
    is_first_row,
    nearest_milliseconds,
    pattern_of,
)
from structured_text.language import tree as t
from structured_text.prove import reals
from structured_text.prove.logic import UnsupportedError, both, negated
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path
from structured_text.prove.values import TIME_BITS, anything, scalar

__all__ = ["PROPERTIES"]


@dataclass(frozen=True)
class _Loop:
    """The claims about a loop.

    Attributes:
        keeps: Loop invariant as a function of the variables before the loop, the present variables,
            and the number of rounds.
        gives: Consequence of the invariant for the values after the loop. Later goals use only this
            consequence. If it is None, they use the invariant itself.
    """

    keeps: Callable[[Mapping[str, Any], Mapping[str, Any], Any], Any]
    gives: Callable[[Mapping[str, Any], Mapping[str, Any]], Any] | None = None


class _Cut(Machine):
    """A machine that collects goals for loop invariants instead of unrolling the loops.

    Integers that a loop changes are widened, so that they cannot wrap. The invariant includes the
    claim that they fit their type.

    Args:
        library: The library with the functions.
        loops: The claims about each loop, in the order of the loops.
    """

    def __init__(self, library: Library, loops: Iterable[_Loop]) -> None:
        super().__init__(library.project)
        self.now = z3.BitVec("now", TIME_BITS)
        self.assume(z3.And(self.now >= 0, self.now < 1 << 62))
        self.goals: list[Goal] = []
        self.last: dict[str, Any] = {}
        self._rooms: dict[str, Any] = {}
        self._ends: list[Any] = []
        self._loops = iter(loops)

    def _variables(self, nodes: tuple[t.Statement, ...]) -> dict[str, Path]:
        """Return the variables that a loop assigns, with their paths."""
        found = {}
        for node in nodes:
            if not isinstance(node, t.Assign) or not isinstance(node.target, t.Use):
                raise UnsupportedError("a loop with other statements than assignments")
            ((_, path),) = self.expressions.places(node.target)
            found[node.target.symbol.name] = path
        return found

    def _values(self, variables: Mapping[str, Path]) -> dict[str, Any]:
        """Return the values of the variables: REALs as bit patterns, integers with more bits."""
        values = {}
        for name, path in variables.items():
            value = self[path]
            if isinstance(value, reals.Real):
                values[name] = pattern_of(value)
            else:
                values[name] = self._rooms.get(name, scalar(self.type_of(path), value))
                if values[name].size() < TIME_BITS:
                    values[name] = z3.SignExt(TIME_BITS - values[name].size(), values[name])
        return values

    def _reached(self) -> list[Any]:
        return [z3.BoolVal(g) if isinstance(g, bool) else g for g in self._guards]

    def _ask(self, name: str, claim: Any, *more: Any) -> None:
        self.goals.append(Goal(name, (*self.assumptions, *self._reached(), *more), claim))

    def _anything(self, variables: Mapping[str, Path]) -> None:
        for name, path in variables.items():
            kind = self.type_of(path)
            value = anything(kind, self.fresh(name))
            if not isinstance(value, reals.Real) and value.size() < TIME_BITS:
                self._rooms[name] = z3.BitVec(self.fresh(name), TIME_BITS)
                value = z3.Extract(value.size() - 1, 0, self._rooms[name])
            self[path] = value

    def _loop(self, node: t.For | t.While | t.Repeat) -> Any:
        if not isinstance(node, t.While):
            raise UnsupportedError("a loop other than WHILE")
        loop, told = next(self._loops), f"the loop of line {node.at.line}"
        variables = self._variables(node.body)
        # 1. The invariant holds before the first round. 2. All assigned variables become arbitrary,
        # restricted by the invariant. 3. One round from there must restore the invariant for n + 1.
        # 4. After the loop the invariant and the negated condition are assumed. The goals of 1 and
        # 3 justify the assumption of the invariant.
        first = self._values(variables)
        n = z3.ZeroExt(TIME_BITS - 10, z3.BitVec(self.fresh("rounds"), 10))
        zero = z3.BitVecVal(0, TIME_BITS)
        self._ask(f"{told} begins", z3.And(_fit(first), loop.keeps(first, first, zero)))
        self._anything(variables)
        now = self.last = self._values(variables)
        kept = z3.And(_fit(now), loop.keeps(first, now, n))
        goes_on = self.expressions.exact(node.condition)
        ended = self.snapshot()
        self._guards.append(z3.And(kept, goes_on))
        self._statements(node.body)
        self._guards.pop()
        again, fits = self._after_a_round(variables, now)
        claim = z3.And(fits, _fit(again), loop.keeps(first, again, n + 1))
        round_from = (*self._reached(), _fit(first), kept, goes_on)
        known = self._ends if loop.gives else self.assumptions
        self.goals.append(Goal(f"{told} goes on", (*known, *round_from), claim))
        self.restore(ended)
        if loop.gives:
            given = loop.gives(first, now)
            self.goals.append(Goal(f"{told} gives", (_fit(first), kept), given))
            kept = z3.And(_fit(now), given)
        reached = both(*self._reached())
        self._ends = [z3.Implies(reached, z3.And(_fit(now), negated(goes_on)))]
        self.assume(z3.Implies(reached, z3.And(kept, negated(goes_on))))
        return self._statements(())

    def _after_a_round(
        self, variables: Mapping[str, Path], before: Mapping[str, Any]
    ) -> tuple[dict[str, Any], Any]:
        """Return the widened variables after one round.

        An integer may change only by a constant.
        """
        after, fits = {}, []
        for name, path in variables.items():
            value = self[path]
            after[name] = pattern_of(value) if isinstance(value, reals.Real) else value
            if name in self._rooms:
                step = z3.simplify(value - z3.Extract(value.size() - 1, 0, before[name]))
                after[name] = before[name] + step.as_signed_long()
                fits.append(value == z3.Extract(value.size() - 1, 0, after[name]))
        return after, z3.And(fits)


def _fit(values: Mapping[str, Any]) -> Any:
    """Return the claim that all durations fit into 64 bits, so that their sums do not wrap."""
    limit = 1 << 63
    durations = [values[name] for name in values if name == "Rest" and values[name].size() > 32]
    return z3.And([z3.And(value >= -limit, value < limit) for value in durations])


_HOUR, _MINUTE, _SECOND, _MS = 3_600_000_000_000, 60_000_000_000, 1_000_000_000, 1_000_000


def _counts(step: int, most: int, count: str) -> _Loop:
    """Return the claims about a loop that moves `step` ns at a time from Rest to a count in ms.

    The loop runs at most `most` rounds.
    """
    by = step // _MS

    def keeps(first: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
        return z3.And(
            z3.ULE(n, most),
            now["Rest"] == first["Rest"] - n * step,
            now[count] == first[count] + n * by,
            z3.Or(n == 0, now["Rest"] >= 0),
        )

    def gives(first: Mapping[str, Any], now: Mapping[str, Any]) -> Any:
        same = z3.And(now["Rest"] == first["Rest"], now[count] == first[count])
        counted = now[count] - first[count]
        return z3.And(
            now["Rest"] + now[count] * _MS == first["Rest"] + first[count] * _MS,
            z3.If(first["Rest"] < 0, same, now["Rest"] >= 0),
            counted >= 0,
            z3.Or(counted <= (most - 1) * by, counted == most * by),
        )

    return _Loop(keeps, gives)


def _milliseconds(library: Library) -> Iterator[Goal]:
    """Yield the goals of FC_RcxMilliseconds, for all TIME values of 64 bits."""
    steps = (
        (_HOUR, LONGEST_MS * _MS // _HOUR),
        (_MINUTE, 60),
        (_SECOND, 60),
        (100 * _MS, 10),
        (10 * _MS, 10),
        (_MS, 10),
    )
    machine = _Cut(library, [_counts(step, most, "Count") for step, most in steps])
    value = z3.BitVec("value", TIME_BITS)
    machine.assume(z3.And(value >= -(1 << 63), value < 1 << 63))
    result = machine.call_function("FC_RCXMILLISECONDS", [value])
    yield from machine.goals
    rest, count = machine.last["Rest"], machine.last["Count"]
    longest = z3.And(count == LONGEST_MS, value >= LONGEST_MS * _MS, rest == 0)
    below = value < LONGEST_MS * _MS
    facts = {
        "nothing is lost": z3.If(below, value == rest + count * _MS, longest),
        "the rest is below one millisecond": z3.And(rest < _MS, rest >= -(1 << 63)),
        "below 0 the count stays 0": z3.If(value < 0, count == 0, rest >= 0),
        "the count fits": z3.And(count >= 0, count < LONGEST_MS + 3_700_000),
    }
    for name, fact in facts.items():
        yield Goal(f"all loops: {name}", tuple(machine.assumptions), fact)
    left = z3.And(list(facts.values()))
    wide = z3.BitVec("result", TIME_BITS)
    rounded = z3.If(rest + rest >= _MS, count + 1, count)
    fits = z3.SignExt(TIME_BITS - 32, result) == rounded
    yield Goal("the result is rounded", (left,), fits)
    yield Goal(
        "the result is the nearest number of milliseconds",
        (left, wide == rounded),
        nearest_milliseconds(value, wide),
        {"value": value, "result": wide},
    )


# --- REAL: Size is the bit pattern without sign; _STEP is the lowest bit of its exponent ---

_STEP, _INFINITE, _SIGN = 0x80_0000, 0x7F80_0000, 1 << 31
#: Bit patterns of the REALs 2^23 and 2^24. The mantissa of a REAL between these limits is equal to
#: the number.
_WHOLE, _ABOVE = 0x4B00_0000, 0x4B80_0000
#: After this number of doublings, the mantissa of every denormal number is a whole number.
_DOUBLINGS = 149


def _doubled(size: Any, n: Any) -> Any:
    """Return the pattern of a denormal number, or 0, after `n` doublings (at most 149).

    `n` has 32 bits. While the mantissa fits, a doubling shifts it to the left. After that, a
    doubling adds 1 to the exponent.
    """
    result = z3.BitVecVal(0, 32)
    for high in range(23):
        room = 23 - high
        moved = z3.If(z3.ULE(n, room), size << n, (size << room) + (n - room) * _STEP)
        result = z3.If(z3.Extract(high, high, size) == 1, moved, result)
    return result


def _narrow(n: Any) -> Any:
    return z3.Extract(31, 0, n)


def _halvings(first: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
    """Return the invariant of the loop of halvings in FC_RcxRealBits.

    The loop halves numbers of 2^24 and more. Infinity stays infinity until Exponent ends the loop.
    """
    infinite = first["Rest"] == _INFINITE
    return z3.And(
        z3.ULE(n, 105),
        now["Exponent"] == first["Exponent"] + n,
        now["Rest"] == z3.If(infinite, first["Rest"], first["Rest"] - _narrow(n) * _STEP),
        z3.Or(n == 0, z3.UGE(first["Rest"], _WHOLE + _narrow(n) * _STEP)),
    )


def _doublings(first: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
    """Return the invariant of the loop of doublings in FC_RcxRealBits.

    The loop doubles numbers below 2^23. For a denormal number, Exponent may end the loop earlier.
    """
    rest, steps = first["Rest"], _narrow(n)
    return z3.And(
        z3.ULE(n, _DOUBLINGS),
        now["Exponent"] == first["Exponent"] - n,
        now["Rest"] == z3.If(z3.ULT(rest, _STEP), _doubled(rest, steps), rest + steps * _STEP),
        z3.Or(n == 0, z3.ULT(now["Rest"], _ABOVE)),
    )


def _real_bits(library: Library) -> Iterator[Goal]:
    """Yield the goals of FC_RcxRealBits for all patterns, including infinities and NaN."""
    machine = _Cut(library, [_Loop(_halvings), _Loop(_doublings)])
    pattern = z3.BitVec("value", 32)
    result = machine.call_function("FC_RCXREALBITS", [reals.Real(pattern)])
    yield from machine.goals
    claims = {
        "of a number that is denormal or 0": z3.ULT(pattern & ~_SIGN, _STEP),
        "of any other number": z3.And(
            z3.UGE(pattern & ~_SIGN, _STEP), z3.ULT(pattern & ~_SIGN, _INFINITE)
        ),
        "of infinity": pattern & ~_SIGN == _INFINITE,
    }
    for name, among in claims.items():
        yield Goal(
            f"the pattern {name}",
            (*machine.assumptions, among),
            result == bits_of(pattern),
            {"value": pattern, "result": result},
        )


def _bits_real(library: Library) -> Iterator[Goal]:
    """Yield the goals of FC_RcxBitsReal for all patterns, including those that are not numbers."""
    pattern = z3.BitVec("pattern", 32)
    mantissa, exponent = pattern & _STEP - 1, z3.LShR(pattern, 23) & 0xFF
    start = z3.If(exponent == 0, z3.BitVecVal(1, 32), exponent)
    whole = z3.If(
        exponent == 0, _doubled(mantissa, z3.BitVecVal(_DOUBLINGS, 32)), _WHOLE + mantissa
    )

    def doublings(_: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
        return z3.And(
            z3.Or(n == 0, z3.And(z3.ULE(exponent, 254), z3.ULE(150 + _narrow(n), exponent))),
            now["Exponent"] == z3.ZeroExt(TIME_BITS - 32, start) - n,
            now["Value"] == whole + _narrow(n) * _STEP,
        )

    def halvings(first: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
        steps = _narrow(n)
        denormal = _doubled(mantissa, _DOUBLINGS - steps)
        return z3.And(
            z3.Or(n == 0, z3.ULE(start + steps, 150)),
            first["Exponent"] == z3.If(z3.ULE(start, 150), z3.ZeroExt(TIME_BITS - 32, start), 150),
            now["Exponent"] == first["Exponent"] + n,
            z3.Implies(exponent == 0, now["Value"] == denormal),
            z3.Implies(
                z3.And(exponent != 0, z3.ULE(exponent, 150)),
                now["Value"] == _WHOLE + mantissa - steps * _STEP,
            ),
            z3.Implies(z3.UGT(exponent, 150), now["Value"] == whole + (exponent - 150) * _STEP),
        )

    machine = _Cut(library, [_Loop(doublings), _Loop(halvings)])
    result = pattern_of(machine.call_function("FC_RCXBITSREAL", [pattern]))
    yield from machine.goals
    size, sign = pattern & _SIGN - 1, pattern & _SIGN
    largest = z3.If(size == _INFINITE, _INFINITE - 1 | sign, z3.BitVecVal(0, 32))
    claims = {
        "of a pattern of a number": (z3.ULT(size, _INFINITE), bits_of(pattern)),
        "of infinity and NaN": (z3.UGE(size, _INFINITE), largest),
    }
    for name, (among, claim) in claims.items():
        yield Goal(
            f"the REAL {name}",
            (*machine.assumptions, among),
            result == claim,
            {"pattern": pattern, "result": result},
        )


def _first_row(library: Library) -> Iterator[Goal]:
    """Yield the goals of FB_RcxFirstRow for any pins and any table with a legal MovesSize."""
    name = "FB_RCXFIRSTROW"

    def upwards(first: Mapping[str, Any], now: Mapping[str, Any], n: Any) -> Any:
        return z3.And(now["Last"] == first["Last"] + n, first["Last"] == 1, now["Last"] <= wide)

    machine = _Cut(library, [_Loop(upwards)])
    pou = library.pou(name)
    assert pou.block is not None
    machine.havoc(BLOCK, pou.block)
    machine.havoc(("MOVES",), pou.symbols["MOVES"].type)
    rows, size = (machine.term((*BLOCK, pin)) for pin in ("ROWS", "MOVESSIZE"))
    wide = z3.SignExt(TIME_BITS - rows.size(), rows)
    machine.assume(size <= rows_of(machine))
    machine.call_block(BLOCK, pou.block.name, {"MOVES": ("MOVES",)})
    yield from machine.goals
    known = tuple(machine.assumptions)
    row, error = (machine.term((*BLOCK, pin)) for pin in ("ROW", "ERRORID"))
    yield Goal("the row is in use, or refused", known, is_first_row(row, error, rows, size))
    yield from impossible(name, machine, known)
    yield none_leaves(name, known, machine.operations, (0, 0))


_PARTS: dict[str, Callable[[Library], Iterator[Goal]]] = {
    "FC_RCXMILLISECONDS": _milliseconds,
    "FC_RCXREALBITS": _real_bits,
    "FC_RCXBITSREAL": _bits_real,
    "FB_RCXFIRSTROW": _first_row,
}

PROPERTIES = (
    Property(
        "functions",
        "FC_RcxMilliseconds returns the nearest number of milliseconds for every TIME; below 0 it "
        "returns 0, and from 20 days on it returns 20 days. FC_RcxRealBits returns the IEEE 754 "
        "bit pattern of every REAL that is a number; for -0.0 this is the pattern of 0.0. "
        "FC_RcxBitsReal returns the REAL for every bit pattern; for infinity it returns the "
        "largest REAL with the same sign, and for NaN 0.0. FB_RcxFirstRow returns a used row or "
        "an error.",
        "docs/reference/blocks/functions.md",
        ("table",),
        lambda library, part: _PARTS[part](library),
        lambda _: tuple(_PARTS),
        lambda part: (part,),
    ),
)
