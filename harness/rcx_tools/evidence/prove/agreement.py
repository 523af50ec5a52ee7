"""`python -m rcx_tools.evidence.prove.agreement`: the translation against an engine.

A block is translated once, from any state. Its terms are then evaluated for random states and
pins, several calls of an instance in a row, and each variable afterwards, or the fault that stops
the program, is compared with what the engine makes of the same state. The functions with long
loops (`SUMMARIES`) are translated anew for each value, and in a block they are the engine's.
With `--engine matiec` the same with matiec (`agreement_matiec`): a scan that the translation says
is stopped, or left open, is not run there.
"""

from __future__ import annotations

import os
import struct
import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path as File
from typing import Any

import z3
from rich.console import Console

from rcx_harness.engine.frontend import tree as t
from rcx_harness.engine.frontend.values import array_length
from rcx_harness.engine.types import ArrayType, ElementaryType, Type
from rcx_harness.verify.prove import reals, texts, values
from rcx_harness.verify.prove.machine import Machine, Path
from rcx_tools.evidence.prove.agreement_builtin import (
    BuiltinEngine,
    Subject,
    double,
    shown,
    single,
)
from rcx_tools.evidence.prove.agreement_matiec import Bench, MatiecEngine, missing
from rcx_tools.evidence.prove.evaluate import REST, program
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.states import States
from rcx_tools.evidence.prove.summaries import SUMMARIES
from rcx_tools.evidence.results import ROOT
from rcx_tools.evidence.workers import results

__all__ = [
    "MATIEC_SCANS",
    "SCANS",
    "Outcome",
    "Subject",
    "agree",
    "compare",
    "compare_matiec",
    "main",
    "missing",
]

#: Random scans of every block and function.
SCANS = 600
#: The same on matiec.
MATIEC_SCANS = 100
#: Calls of an instance in a row.
_RUN = 8
#: Scans of each block from a state that is known when it is translated.
_KNOWN = 3
#: Where an engine stops the program; a conversion out of range and a TIME of more than 64 bits
#: mean something else on each.
_OPEN = ("conversion", "time")
_B: Path = ("B",)


@dataclass(frozen=True)
class Outcome:
    """What came out for a POU.

    Attributes:
        pou: Its name.
        scans: Scans that were compared, `faults` of which stopped the program on both sides.
        known: Scans of those that ran on known values.
        open: Scans besides, whose result the engines leave open.
        seconds: Processor time.
        disagreement: The first one; empty where there is none.
    """

    pou: str
    scans: int
    faults: int
    known: int
    open: int
    seconds: float
    disagreement: str


@lru_cache(maxsize=2)
def _subject(folder: str) -> Subject:
    return Subject.of(sorted(File(folder).rglob("*.st")))


@lru_cache(maxsize=2)
def _bench(folder: str) -> Bench:
    return Bench.of(sorted(File(folder).rglob("*.st")), _subject(folder).project)


class _Translation:
    """The terms of a POU after one call, as Python."""

    def __init__(
        self,
        machine: Machine,
        leaves: Sequence[tuple[Path, Type]],
        start: Mapping[Path, Any] | None,
        functions: Mapping[str, Callable[[int], int]],
    ) -> None:
        terms: list[Any] = []
        self._slots: list[tuple[int, int, int, Type]] = []
        for place, (path, kind) in enumerate(leaves):
            value = machine[path]
            if start is not None and value is start.get(path):
                continue
            parts = _parts(kind, value)
            self._slots.append((place, len(terms), len(parts), kind))
            terms += parts
        self._end = len(terms)
        strict = [one.when for one in machine.obligations if one.kind not in _OPEN]
        loose = [one.when for one in machine.obligations if one.kind in _OPEN]
        self._strict = len(strict)
        self._program = program([*terms, *strict, *loose], functions)
        self._given = _given(self._program.inputs, leaves, start) if start is not None else None

    def run(self, before: list[Any], now: int) -> tuple[list[Any], bool, bool]:
        """The leaves after a call, whether it stops the program, and whether its result is open."""
        given = self._given(before, now) if self._given is not None else ()
        found = self._program.run(given)
        after = list(before)
        for place, at, count, kind in self._slots:
            after[place] = _joined(kind, found[at : at + count])
        bad = self._end + self._strict
        return after, any(found[self._end : bad]), any(found[bad:])


def _parts(kind: Type, value: Any) -> list[Any]:
    if isinstance(value, texts.Text):
        return [value.size, *(value.char(place) for place in range(value.most))]
    if isinstance(value, reals.Real):
        if value.known:
            return [double(value.value) if kind == _LREAL else single(value.value)]
        return [z3.fpToIEEEBV(value.value) if kind == _LREAL else value.value]
    if isinstance(value, int) and not isinstance(value, bool):
        return [value & (1 << values.bits(kind)) - 1]
    return [value]


_REAL, _LREAL = ElementaryType("REAL"), ElementaryType("LREAL")


def _joined(kind: Type, parts: Sequence[Any]) -> Any:
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name == "STRING":
        return "".join(chr(code) for code in parts[1 : 1 + parts[0]])
    (value,) = parts
    if isinstance(kind, ArrayType) and len(value) <= array_length(kind):
        places = range(array_length(kind))
        return {place: value.get(place, value[REST]) for place in places} | {REST: 0}
    if name == "REAL" and value & 0x7FFF_FFFF > 0x7F80_0000:
        return 0x7FC0_0000
    return value


def _given(
    inputs: Sequence[str], leaves: Sequence[tuple[Path, Type]], start: Mapping[Path, Any]
) -> Callable[[list[Any], int], tuple[Any, ...]]:
    """What the variables of the solver stand for, from the leaves."""
    codes = {"now": "now"}
    for place, (path, kind) in enumerate(leaves):
        value = start.get(path)
        if isinstance(value, texts.Text):
            codes[str(value.size)] = f"len(b[{place}])"
            for at in range(value.most):
                letter = f"b[{place}][{at}:{at + 1}]"
                codes[str(value.char(at))] = f"ord({letter} or chr(0))"
        elif isinstance(value, reals.Real):
            code = f"b[{place}]"
            codes[str(value.value)] = f"double_of({code})" if kind == _LREAL else code
        elif value is not None:
            codes[str(value)] = f"b[{place}]"
    wanted = "".join(f"{codes[name]}, " for name in inputs)
    scope = {"double_of": lambda raw: struct.unpack("<d", raw.to_bytes(8, "little"))[0]}
    found: Callable[[list[Any], int], tuple[Any, ...]] = eval(f"lambda b, now: ({wanted})", scope)
    return found


# --- functions with long loops: in a block a symbol, which the engine's own function stands for ---


def _long(subject: Subject) -> list[str]:
    """Those that are there; a block that has a summary is compared as it is."""
    pous = subject.project.pous
    return [name for name in SUMMARIES if name in pous and pous[name].kind == "FUNCTION"]


def _argument(subject: Subject, name: str) -> tuple[Type, Type]:
    """Types of the only argument of a function, and of its result."""
    pou = subject.project.pous[name]
    (symbol,) = pou.section("VAR_INPUT")
    assert pou.result is not None
    return symbol.type, pou.result.type


def _symbols(subject: Subject) -> dict[str, Callable[[Machine, list[Any]], Any]]:
    """What stands for a call of each of them: a symbol of the solver."""
    return {name: _symbol(subject, name) for name in _long(subject)}


def _symbol(subject: Subject, name: str) -> Callable[[Machine, list[Any]], Any]:
    source, target = _argument(subject, name)
    sort = z3.BitVecSort(_width(source))

    def summary(machine: Machine, arguments: list[Any]) -> Any:
        function = z3.Function(name, sort, z3.BitVecSort(_width(target)))
        (raw,) = _parts(source, arguments[0])
        term = function(z3.BitVecVal(raw, sort) if isinstance(raw, int) else raw)
        return reals.Real(term) if target == _REAL else term

    return summary


def _bodies(subject: Subject) -> dict[str, Callable[[int], int]]:
    """What the symbols are evaluated by: the engine's functions."""
    return {name: _body(subject, name) for name in _long(subject)}


def _body(subject: Subject, name: str) -> Callable[[int], int]:
    source, target = _argument(subject, name)
    body = subject.module.names[f"f_{name}"]
    show: Callable[[Any], int] = eval(f"lambda value: {shown('value', target)}", dict(_SHOWN))
    return lambda raw: show(body(_held(source, raw)))


_SHOWN = {"single": single, "double": double, "REST": REST}


def _width(kind: Type) -> int:
    return 32 if kind == _REAL else values.bits(kind)


def _held(kind: Type, raw: int) -> Any:
    """What the engine holds, of a number as the solver has it."""
    if kind == _REAL:
        return struct.unpack("<f", raw.to_bytes(4, "little"))[0]
    width = values.bits(kind)
    signed = getattr(kind, "name", "") in ("TIME", "SINT", "INT", "DINT", "LINT")
    return raw - (1 << width) if signed and raw >> width - 1 else raw


# --- a comparison ---


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
    """Call it with the memory of the machine as it is."""
    if pou.kind == "FUNCTION":
        assert pou.result is not None
        inputs = [machine["B", symbol.name.upper()] for symbol in pou.section("VAR_INPUT")]
        machine["B", pou.name.upper()] = machine.call_function(pou.name.upper(), inputs)
        return
    in_outs = {symbol.name.upper(): (symbol.name.upper(),) for symbol in pou.section("VAR_IN_OUT")}
    machine.call_block(_B, pou.name, in_outs)


def _anything(subject: Subject, pou: t.Pou) -> _Translation:
    machine = Machine(subject.project, _symbols(subject))
    machine.now = z3.BitVec("now", values.TIME_BITS)
    machine.assume(z3.And(machine.now >= 0, machine.now < 1 << 62))
    leaves = _leaves(machine, pou)
    for path, kind in leaves:
        machine.havoc(path, kind)
    start = machine.snapshot()
    _call(machine, pou)
    return _Translation(machine, leaves, start, _bodies(subject))


def _from_known(
    subject: Subject, pou: t.Pou, leaves: Sequence[tuple[Path, Type]], held: Sequence[Any], now: int
) -> _Translation:
    """The same from values that are known when it is translated."""
    symbols = {} if pou.kind == "FUNCTION" else _symbols(subject)
    machine = Machine(subject.project, symbols)
    machine.now = now
    for (path, kind), value in zip(leaves, held, strict=True):
        machine.create(path, kind, value)
    _call(machine, pou)
    return _Translation(machine, leaves, None, _bodies(subject))


class _Comparison:
    """A POU on both sides, from one random state to the next."""

    def __init__(self, subject: Subject, pou: t.Pou, seed: int, bench: Bench | None) -> None:
        self._subject, self._pou = subject, pou
        self._states = States(f"{seed} {pou.name.upper()}")
        self._leaves = _leaves(Machine(subject.project), pou)
        self._engine: BuiltinEngine | MatiecEngine = BuiltinEngine(subject, pou, self._leaves)
        if bench is not None:
            self._engine = MatiecEngine(bench, pou, self._leaves)
        self._held: list[Any] = [None] * len(self._leaves)
        self.scans = self.faults = self.known = self.open = 0
        self.problem = ""
        pins = {symbol.name.upper() for symbol in pou.section("VAR_INPUT")}
        self._pins = [path[0] == "B" and path[1] in pins for path, _ in self._leaves]
        self._long = pou.name.upper() in _long(subject)

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
        """Compare so many scans, or until they disagree."""
        translation = None if self._long else _anything(self._subject, self._pou)
        left = 0
        while self.scans < scans and not self.problem and self.open < scans:
            if left == 0:
                left = self._states.random.randint(1, _RUN)
                self._begin()
            else:
                self._states.later()
                self._draw(0.3, self._states.random.choice((0.0, 0.02, 0.1)))
            left -= 1
            if not self._scan(translation):
                left = 0

    def _scan(self, translation: _Translation | None) -> bool:
        """One scan; whether the instance can go on."""
        now = self._states.now // self._engine.step * self._engine.step
        before = self._engine.read()
        ways = [] if translation is None else [("", translation)]
        if translation is None or self.known < _KNOWN:
            self.known += 1
            held = [_python(kind, raw) for (_, kind), raw in zip(self._leaves, before, strict=True)]
            known = _from_known(self._subject, self._pou, self._leaves, held, now)
            ways.append((" (known)", known))
        told = [(how, *way.run(before, now)) for how, way in ways]
        if not self._engine.checks and any(stops or open_ for _, _, stops, open_ in told):
            self.open += 1
            return False
        goes_on = self._engine.call(now)
        self._engine.follow(told[0][1])
        got = self._engine.read()
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
    """What the engine holds, of what `shown` gave."""
    if isinstance(kind, ArrayType):
        return [_held(kind.element, raw[place]) for place in range(len(raw) - 1)]
    if kind == _LREAL:
        return struct.unpack("<d", raw.to_bytes(8, "little"))[0]
    if isinstance(raw, (bool, str)):
        return raw
    return _held(kind, raw)


def _told(path: Path) -> str:
    return ".".join(str(part) for part in path)


def agree(
    subject: Subject, name: str, scans: int = SCANS, seed: int = 1, bench: Bench | None = None
) -> Outcome:
    """Compare a block or function with the built-in engine, or with matiec on its bench.

    The same seed gives the same scans.
    """
    begin = time.process_time()
    pou = subject.project.pous[name]
    comparison = _Comparison(subject, pou, seed, bench)
    comparison.run(scans)
    told = f"{pou.name}, seed {seed}, {comparison.problem}" if comparison.problem else ""
    return Outcome(
        pou.name,
        comparison.scans,
        comparison.faults,
        comparison.known,
        comparison.open,
        time.process_time() - begin,
        told,
    )


def compare(job: tuple[str, str, int, int]) -> Outcome:
    """`agree` as a job of its own: the folder of the sources, the POU, scans and seed."""
    folder, name, scans, seed = job
    return agree(_subject(folder), name, scans, seed)


def compare_matiec(job: tuple[str, str, int, int]) -> Outcome:
    """The same with matiec; only where `missing` gives nothing."""
    folder, name, scans, seed = job
    return agree(_subject(folder), name, scans, seed, _bench(folder))


def main(arguments: list[str] | None = None) -> int:
    """Compare; 0 where all agree, 1 where something does not, 2 on bad input."""
    parser = ArgumentParser(prog="python -m rcx_tools.evidence.prove.agreement")
    parser.add_argument("pous", nargs="*", help="blocks and functions (default: all)")
    parser.add_argument("--lib", default=str(ROOT / "plc/lib"), help="another copy of plc/lib")
    parser.add_argument("--scans", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--engine", choices=("builtin", "matiec"), default="builtin")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    options = parser.parse_args(arguments)
    console = Console(highlight=False)
    if not File(options.lib).is_dir():
        console.print(f"there is no folder {options.lib}: name a copy of plc/lib", markup=False)
        return 2
    known = Library(File(options.lib)).pous
    wanted = [name.upper() for name in options.pous] or known
    unknown = [name for name in wanted if name not in known]
    if unknown:
        console.print(f"there is no block or function {', '.join(unknown)} in {options.lib}")
        return 2
    run, scans = compare, options.scans or SCANS
    if options.engine == "matiec":
        if reason := missing():
            console.print(f"skipped: {reason}", markup=False)
            return 0
        _bench(options.lib)  # compiled once, for all jobs
        run, scans = compare_matiec, options.scans or MATIEC_SCANS
    work = [(options.lib, name, scans, options.seed) for name in wanted]
    found = list(results(run, work, options.jobs))
    for one in found:
        if one.disagreement:
            console.print(one.disagreement, markup=False)
    scans = sum(one.scans for one in found)
    bad = sum(bool(one.disagreement) for one in found)
    seconds = sum(one.seconds for one in found)
    stopped = sum(one.faults for one in found)
    console.print(
        f"{len(found)} POUs, {scans:,} scans ({stopped:,} stopped by a fault on both sides), "
        f"{seconds:.0f} s, {bad} disagree"
    )
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
