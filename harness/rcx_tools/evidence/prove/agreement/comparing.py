"""Comparison of a block or function with an engine, from one random state to the next.

A block is translated once, from an arbitrary state. The terms are then evaluated for random states
and pins, in several consecutive calls of an instance. After each call, the variables or the fault
are compared with the result of the engine for the same state. Functions with long loops
(`SUMMARIES`) are translated separately for each value. On matiec a scan is skipped if the
translation predicts a fault, or if the result is open (different engines may give different
results).
"""

from __future__ import annotations

import struct
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import z3

from rcx_tools.evidence.prove.agreement.bench import Engine, Subject
from rcx_tools.evidence.prove.agreement.builtin import BuiltinEngine
from rcx_tools.evidence.prove.agreement.matiec import MatiecEngine
from rcx_tools.evidence.prove.agreement.terms import (
    LREAL,
    Translation,
    bodies,
    held,
    long,
    symbols,
)
from rcx_tools.evidence.prove.evaluate import REST
from rcx_tools.evidence.prove.states import States
from structured_text.language import tree as t
from structured_text.language.types import ArrayType, Type
from structured_text.prove import values
from structured_text.prove.machine import Machine
from structured_text.prove.symbolic_memory import Path

__all__ = ["ENGINES", "MATIEC_SCANS", "SCANS", "Outcome", "agree", "agreed"]

#: Number of random scans of every block and function on the built-in engine.
SCANS = 600
#: Number of random scans of every block and function on matiec.
MATIEC_SCANS = 300
#: Maps the name of an engine to its class.
ENGINES: dict[str, type[Engine]] = {"builtin": BuiltinEngine, "matiec": MatiecEngine}
#: Largest number of consecutive calls of an instance.
_RUN = 8
#: Number of scans of each block that are translated from a known state.
_KNOWN = 3
#: Blocks with a loop whose length depends on their pins, and callers of such blocks. These POUs are
#: translated again for each state.
_LOOPING = ("FB_RCXFIRSTROW", "FB_MOVETABLE")
_B: Path = ("B",)


@dataclass(frozen=True)
class Outcome:
    """The result of comparing a POU.

    Attributes:
        pou: Name of the POU.
        scans: Scans that were compared, including `faults`.
        faults: Compared scans in which engine and translation stopped at the same fault.
        known: Compared scans that were translated from a known state.
        open: Scans that were not compared, because the result may differ between engines.
        seconds: Processor time [s].
        disagreement: The first disagreement; empty if there is none.
    """

    pou: str
    scans: int
    faults: int
    known: int
    open: int
    seconds: float
    disagreement: str


def _leaves(machine: Machine, pou: t.Pou) -> list[tuple[Path, Type]]:
    if pou.kind == "FUNCTION":
        assert pou.result is not None
        symbols = [*pou.section("VAR_INPUT"), pou.result]
        return [(("B", symbol.name.upper()), symbol.type) for symbol in symbols]
    assert pou.block is not None
    found = [(_B + leaf.suffix, leaf.type) for leaf in machine.leaves(pou.block)]
    for symbol in pou.section("VAR_IN_OUT"):
        name = symbol.name.upper()
        found += [((name, *leaf.suffix), leaf.type) for leaf in machine.leaves(symbol.type)]
    return found


def _call(machine: Machine, pou: t.Pou) -> None:
    """Run a call of the POU on the machine."""
    if pou.kind == "FUNCTION":
        assert pou.result is not None
        inputs = [machine["B", symbol.name.upper()] for symbol in pou.section("VAR_INPUT")]
        machine["B", pou.name.upper()] = machine.call_function(pou.name.upper(), inputs)
        return
    in_outs = {symbol.name.upper(): (symbol.name.upper(),) for symbol in pou.section("VAR_IN_OUT")}
    machine.call_block(_B, pou.name, in_outs)


def _translated(subject: Subject, name: str) -> Translation | None:
    """Translate a POU from an arbitrary state.

    Return None if the POU must be translated separately for each state.
    """
    pou = subject.project.pous[name]
    if name in (*long(subject), *_LOOPING):
        return None
    machine = Machine(subject.project, symbols(subject))
    machine.now = z3.BitVec("now", values.TIME_BITS)
    machine.assume(z3.And(machine.now >= 0, machine.now < 1 << 62))
    leaves = _leaves(machine, pou)
    for path, kind in leaves:
        machine.havoc(path, kind)
    start = machine.snapshot()
    _call(machine, pou)
    return Translation(machine, leaves, start, bodies(subject))


def _from_known(
    subject: Subject,
    pou: t.Pou,
    leaves: Sequence[tuple[Path, Type]],
    given: Sequence[Any],
    now: int,
) -> Translation:
    """Translate a POU from a known state."""
    stand_ins = {} if pou.kind == "FUNCTION" else symbols(subject)
    machine = Machine(subject.project, stand_ins)
    machine.now = now
    for (path, kind), value in zip(leaves, given, strict=True):
        machine.create(path, kind, value)
    _call(machine, pou)
    return Translation(machine, leaves, None, bodies(subject))


class _Comparison:
    """The comparison of a POU: engine and translation run from the same random states."""

    def __init__(
        self, subject: Subject, pou: t.Pou, seed: int, engine: str, term: Translation | None
    ) -> None:
        self._subject, self._pou = subject, pou
        self._states = States(f"{seed} {pou.name.upper()}")
        self._leaves = _leaves(Machine(subject.project), pou)
        self._engine = ENGINES[engine](subject, pou, self._leaves)
        self._translation = term
        self._from_known = _KNOWN if self._engine.checks else 0
        self._held: list[Any] = [None] * len(self._leaves)
        self.scans = self.faults = self.known = self.open = 0
        self.problem = ""
        pins = {symbol.name.upper() for symbol in pou.section("VAR_INPUT")}
        self._pins = [path[0] == "B" and path[1] in pins for path, _ in self._leaves]

    def _draw(self, share_pins: float, share: float) -> None:
        states = self._states
        for place, (path, kind) in enumerate(self._leaves):
            if states.chance(share_pins if self._pins[place] else share):
                self._held[place] = states.value(kind, str(path[-1]))
                self._engine.write(place, self._held[place])

    def _begin(self) -> None:
        states = self._states
        states.begin()
        if self._pou.kind == "FUNCTION":
            self._engine.reset()
            self._draw(1.0, 1.0)
            return
        self._engine.reset()
        self._draw(1.0, states.random.choice((0.0, 0.1, 0.5, 1.0)))

    def run(self, scans: int) -> None:
        """Compare a number of scans. Stop at the first disagreement."""
        left = 0
        while self.scans < scans and not self.problem and self.open < scans:
            if left == 0:
                left = self._states.random.randint(1, _RUN)
                self._begin()
            else:
                self._states.later()
                self._draw(0.3, self._states.random.choice((0.0, 0.02, 0.1)))
            left -= 1
            if not self._scan():
                left = 0
        if self.scans < scans and not self.problem:
            self.problem = f"only {self.scans} of {scans} scans could be compared"

    def _scan(self) -> bool:
        """Compare one scan. Return whether the instance can be called again."""
        translation = self._translation
        now = self._states.now // self._engine.step * self._engine.step
        before = self._engine.read()
        ways = [] if translation is None else [("", translation)]
        if translation is None or self.known < self._from_known:
            self.known += 1
            given = [
                _python(kind, raw) for (_, kind), raw in zip(self._leaves, before, strict=True)
            ]
            known = _from_known(self._subject, self._pou, self._leaves, given, now)
            ways.append((" (known)", known))
        told = [(how, *way.run(before, now)) for how, way in ways]
        if not self._engine.checks and any(stops or open_ for _, _, stops, open_ in told):
            self.open += 1
            return False
        goes_on = self._engine.call(now)
        self._engine.follow(told[0][1])
        got = self._engine.read()
        # The translation runs before the engine. matiec does not stop at a fault, and in C some
        # results are undefined. A scan with a fault or an open result is therefore never run on an
        # engine that does not check faults. The built-in engine also runs such a scan, because it
        # must stop at the same faults.
        for how, after, stops, open_ in told:
            if not stops and open_:
                self.open += 1
                return goes_on
            where = f"scan {self.scans}{how}"
            if stops == goes_on:
                says = "stops" if stops else "goes on"
                self.problem = f"{where}: the translation {says}, the engine does not"
            elif goes_on and after != got:
                self.problem = f"{where}: {self._first(after, got)}"
        self.scans += 1
        self.faults += not goes_on
        return goes_on

    def _first(self, after: list[Any], got: list[Any]) -> str:
        for (path, kind), one, other in zip(self._leaves, after, got, strict=True):
            if isinstance(kind, ArrayType) and one != other:
                for place in range(len(other) - 1):
                    left = one.get(place, one[REST])
                    if left != other[place]:
                        return f"{_told((*path, place))} is {left}, on the engine {other[place]}"
            elif one != other:
                return f"{_told(path)} is {one!r}, on the engine {other!r}"
        return ""


def _python(kind: Type, raw: Any) -> Any:
    """Convert a value from the representation of `shown` to a Python value of the engine."""
    if isinstance(kind, ArrayType):
        return [held(kind.element, raw[place]) for place in range(len(raw) - 1)]
    if kind == LREAL:
        return struct.unpack("<d", raw.to_bytes(8, "little"))[0]
    if isinstance(raw, (bool, str)):
        return raw
    return held(kind, raw)


def _told(path: Path) -> str:
    return ".".join(str(part) for part in path)


def agree(
    subject: Subject, name: str, scans: int = SCANS, seed: int = 1, engine: str = "builtin"
) -> Outcome:
    """Compare a block or function with one engine. The same seed gives the same scans."""
    return agreed(subject, name, {engine: scans}, seed)[engine]


def agreed(
    subject: Subject, name: str, scans: Mapping[str, int], seed: int = 1
) -> dict[str, Outcome]:
    """Compare a POU with several engines. The POU is translated only once."""
    begin = time.process_time()
    pou, term, found = subject.project.pous[name], _translated(subject, name), {}
    for engine, count in scans.items():
        one = _Comparison(subject, pou, seed, engine, term)
        one.run(count)
        told = f"{pou.name}, {engine}, seed {seed}, {one.problem}" if one.problem else ""
        end = time.process_time()
        figures = (one.scans, one.faults, one.known, one.open, end - begin)
        found[engine] = Outcome(pou.name, *figures, told)
        begin = end
    return found
