"""All states of FB_Interlock: three robots at one shared area, each of which may do anything.

Before each scan up to `at_once` robots change one of their inputs: Enable, Outside, Acknowledge,
whether link and servos are there, and whether the instance is called at all. There is no
controller: the program sets what the block reads of its Robot. What is demanded is judged from the
inputs and from Valid, Busy, Error (`_Judge`), never from the block's own bookkeeping.

Left out of a state, and arbitrary when a scan is repeated to check that: the tickets' origin and
gaps beyond one, the phase of the beat, and the number of the scan.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from rich.console import Console
from rich.table import Table

from rcx_harness.engine.builtin import BuiltinProgram
from rcx_harness.engine.frontend import load
from rcx_harness.engine.needed import needed
from rcx_harness.verify.explore.search import Result, Search, World
from rcx_tools.evidence.explore.search import LIBRARY
from rcx_tools.evidence.explore.seeded import Seeded

__all__ = ["MODELS", "SEEDED", "InterlockModel", "explored", "main", "told"]

#: From a free area to a grant, with any number of requests that were given up before [scans].
_PROMPT = 5
_WIDE = 1 << 32


@dataclass(frozen=True)
class InterlockModel:
    """What is explored.

    Attributes:
        name: One word.
        title: What it is about.
        robots: How many there are.
        moves: Which inputs change: of `go out ack ready called`.
        at_once: How many robots change an input before one scan.
        timeout: Of the last robot, in scans; 0 = no limit.
    """

    name: str
    title: str
    robots: int = 3
    moves: tuple[str, ...] = ("go", "out", "ack", "ready", "called")
    at_once: int = 1
    timeout: int = 0


MODELS = (
    InterlockModel("loss", "three robots, losses, intruders", moves=("go", "out", "ack", "ready")),
    InterlockModel("gone", "three robots that come and go", moves=("go", "called")),
    InterlockModel("entry", "three robots, at once", moves=("go", "out"), at_once=2),
    InterlockModel("limit", "two robots, one with a time limit", robots=2, at_once=2, timeout=2),
)


class _Seat(NamedTuple):
    """One robot's inputs, and what the judge remembers of it."""

    go: bool = False
    out: bool = False
    ack: bool = False
    ready: bool = False
    called: bool = True
    was_ready: bool = False
    was_ack: bool = False
    in_the_way: bool = True
    """It is not known to be out, or was lost there and not acknowledged since. So also after its
    first call: one more shows that it is out."""
    met: bool = False
    """It has been called."""
    kept: bool = False
    valid: bool = False
    had: bool = False
    """It has been granted since Enable rose."""
    failed: bool = False
    """It has shown an error since Enable rose."""
    queue: int = 0
    """Its place among those that wait and are called in each scan; 0 = it does not."""
    free: int = 0
    """So many scans it has waited while nobody had the area, or gave up before it."""


class _Choice(NamedTuple):
    """What changes before a scan."""

    number: int
    changes: tuple[tuple[int, str], ...]


@dataclass(frozen=True)
class _State:
    """All that counts later: the judge's seats, and what the program holds."""

    seats: tuple[_Seat, ...]
    inner: tuple[Any, ...]


#: Of each instance: what is no ticket. The others are written before they are read.
_KEPT = (
    *("KNOWN", "WASENABLE", "WASREADY", "GRANTED", "WAITING", "HOLDS", "KEPT", "ERRORID"),
    *("BUSY", "WAITED", "LONGEST"),
)


class _World(World[_Choice]):
    """The program, and what is demanded of it."""

    def __init__(self, model: InterlockModel, library: Sequence[Path]) -> None:
        self._model = model
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "Interlocks.st"
            path.write_text(_program(model), encoding="utf-8")
            self.program = BuiltinProgram.build(load([path, *needed([path], library)]))
        self._root: Any = self.program.holder(next(iter(self.program.instances())))
        robots = range(model.robots)
        self._locks = [getattr(self._root, f"LOCK{k}") for k in robots]
        self._area = self._root.AREA
        self.every = [_Choice(k, one) for k, one in enumerate(_changes(model))]
        self._states: dict[bytes, _State] = {}
        seat = _Seat(out="out" not in model.moves, ready="ready" not in model.moves)
        self._start = (seat,) * model.robots

    def first(self) -> bytes:
        """Nothing has been called yet."""
        return self._pack(_State(self._start, self._freeze()))

    def choices(self, state: bytes) -> Sequence[_Choice]:
        """Anything; but all are called in the first scan."""
        if self._states[state].seats == self._start:
            return [one for one in self.every if all(name != "called" for _, name in one.changes)]
        return self.every

    def step(self, state: bytes, choice: _Choice) -> tuple[bytes, list[str]]:
        """One scan."""
        here = self._states[state]
        return self._scan(here, choice, here.inner)

    def check(self, state: bytes, choice: _Choice, following: bytes, random: Random) -> None:
        """Again, with other tickets."""
        here = self._states[state]
        there, _ = self._scan(here, choice, _disturbed(here.inner, random))
        if there != following:
            raise AssertionError(f"{self._model.name}: tickets have an effect: {here} {choice}")

    def _scan(
        self, here: _State, choice: _Choice, inner: tuple[Any, ...]
    ) -> tuple[bytes, list[str]]:
        seats = list(here.seats)
        for k, name in choice.changes:
            seats[k] = seats[k]._replace(**{name: not getattr(seats[k], name)})
        self._thaw(inner, here.seats, seats)
        self.program.scan(0)
        shown = [(bool(one.VALID), bool(one.BUSY), int(one.ERRORID)) for one in self._locks]
        wrong = [
            f"contract: robot {k + 1}: Error without ErrorID, or the other way round"
            for k, one in enumerate(self._locks)
            if bool(one.ERROR) != bool(one.ERRORID)
        ]
        after, broken = _judged(here.seats, seats, shown)
        return self._pack(_State(after, self._freeze())), wrong + broken

    def _pack(self, state: _State) -> bytes:
        key = repr((state.seats, state.inner)).encode()
        self._states.setdefault(key, state)
        return key

    def known_as(self, state: bytes) -> bytes:
        """Itself."""
        return state

    def _freeze(self) -> tuple[Any, ...]:
        area = self._area
        origin = area.FIRST
        tickets = [area.NEXTTICKET - origin]
        rows: list[tuple[Any, ...]] = []
        for one in self._locks:
            one.WAITED *= one.LONGEST > 0
            rows.append(tuple(getattr(one, name) for name in _KEPT))
            if one.WAITING:
                tickets += [one.TICKET - origin, one.WASFIRST - origin]
        near = _closer([0, *tickets], tickets[1::2])
        left = iter(near[2:])
        waits = tuple(
            (next(left), next(left), one.WASBEAT != area.BEAT) if one.WAITING else ()
            for one in self._locks
        )
        return (area.HOLDERS, near[0], near[1], tuple(rows), waits, False)

    def _thaw(
        self, inner: tuple[Any, ...], before: Sequence[_Seat], seats: Sequence[_Seat]
    ) -> None:
        root, area = self._root, self._area
        area.HOLDERS, first, after, rows, waits, beat = inner
        area.FIRST, area.NEXTTICKET, area.BEAT = first % _WIDE, after % _WIDE, beat
        for k, (one, seat) in enumerate(zip(self._locks, seats, strict=True)):
            for name, value in zip(_KEPT, rows[k], strict=True):
                setattr(one, name, value)
            if waits[k]:
                one.TICKET, one.WASFIRST = waits[k][0] % _WIDE, waits[k][1] % _WIDE
                one.WASBEAT = waits[k][2] != beat
            one.EDGE.seen, one.SEEN = seat.was_ack, 4 if before[k].called else 2
            one.VALID, one.ERROR = seat.valid, bool(one.ERRORID)
            for name in ("GO", "OUT", "ACK", "READY", "CALLED"):
                setattr(root, f"{name}{k}", getattr(seat, name.lower()))


def _closer(numbers: Sequence[int], held: Sequence[int]) -> list[int]:
    """The same order and neighbours from 0 on, without the gaps; signed, as tickets compare.

    The next number counts behind a ticket that is `held`: only from there the turn goes on by one.
    """
    signed = {one: (one + _WIDE // 2) % _WIDE - _WIDE // 2 for one in numbers}
    owned = {signed[one] for one in held}
    places, last, place = {}, None, 0
    for one in sorted(set(signed.values())):
        place += 0 if last is None else min(one - last, 2) if last in owned else 2
        places[one], last = place, one
    return [places[signed[one]] for one in numbers]


def _disturbed(inner: tuple[Any, ...], random: Random) -> tuple[Any, ...]:
    """Another origin, wider gaps, the other phase."""
    holders, first, after, rows, waits, _ = inner
    beat, origin, wide = bool(random.randrange(2)), random.randrange(_WIDE), random.randrange(1, 99)
    held = [first, after, *(one for wait in waits if wait for one in wait[:2])]
    moved, last = {}, None
    for one in sorted(set(held)):
        origin += 0 if last is None else one - last if one - last == 1 else wide + 1
        moved[one], last = origin, one
    there = tuple((moved[one[0]], moved[one[1]], one[2]) if one else () for one in waits)
    return (holders, moved[first], moved[after], rows, there, beat)


def _changes(model: InterlockModel) -> Iterator[tuple[tuple[int, str], ...]]:
    for count in range(model.at_once + 1):
        for robots in combinations(range(model.robots), count):
            for names in product(model.moves, repeat=count):
                yield tuple(zip(robots, names, strict=True))


def _judged(
    before: Sequence[_Seat], now: Sequence[_Seat], shown: Sequence[tuple[bool, bool, int]]
) -> tuple[tuple[_Seat, ...], list[str]]:
    """What is demanded, told from outside: the seats after a scan, and what is broken.

    Args:
        before: The seats after the last scan.
        now: The same with the inputs of this scan.
        shown: Valid, Busy and ErrorID of each robot.
    """
    broken: list[str] = []
    last = max(seat.queue for seat in before)
    after: list[_Seat] = []
    for k, (was, seat) in enumerate(zip(before, now, strict=True)):
        if not seat.called:
            after.append(seat._replace(queue=0, free=0))
            continue
        broken += _contract(k, was, seat, shown[k])
        valid, busy, number = shown[k]
        had = seat.go and not number and (was.had or valid)
        kept = (was.kept and not (seat.ack and not was.was_ack)) or (
            was.was_ready and not seat.ready and (was.in_the_way or was.had)
        )
        queue = (was.queue or last + 1) if busy and not had else 0
        last = max(last, queue)
        if valid and not (was.had or was.in_the_way):
            others = [one.queue for one in (*after, *before[k + 1 :]) if one.queue]
            if any(one < (was.queue or last + 1) for one in others):
                broken.append(f"turn: robot {k + 1} is let in before one that came first")
        known = {"was_ready": seat.ready, "was_ack": seat.ack, "valid": valid, "had": had}
        way = {"kept": kept, "in_the_way": not (seat.out and was.met) or kept, "met": True}
        failed = seat.go and (was.failed or bool(number))
        after.append(seat._replace(**known, **way, queue=queue, failed=failed))
    broken += _safety(before, after)
    taken = any(seat.in_the_way or seat.had for seat in after)
    ranks = {one: k + 1 for k, one in enumerate(sorted(s.queue for s in after if s.queue))}
    left = [was.queue for was, seat in zip(before, after, strict=True) if was.queue > seat.queue]
    for k, seat in enumerate(after):
        waits = seat.queue > 0 and not taken and not any(one < before[k].queue for one in left)
        free = seat.free + 1 if waits else 0
        after[k] = seat._replace(queue=ranks.get(seat.queue, 0), free=free)
        if free > _PROMPT:
            broken.append(f"wait: the area is free, but robot {k + 1} is not let in")
    return tuple(after), broken


def _contract(k: int, was: _Seat, seat: _Seat, shown: tuple[bool, bool, int]) -> list[str]:
    """Of one robot that was called."""
    valid, busy, number = shown
    name = f"robot {k + 1}"
    broken = []
    if valid + busy + bool(number) != seat.go:
        broken.append(f"contract: {name}: Enable {seat.go}, Valid {valid}, Busy {busy}, {number:X}")
    if valid and not seat.ready:
        broken.append(f"loss: {name} has the area without link or servos")
    if was.go and was.failed and (valid or busy):
        broken.append(f"restart: {name} asks again by itself after an error")
    if valid and (was.kept and not (seat.ack and not was.was_ack)):
        broken.append(f"kept: {name} goes on without Acknowledge")
    return broken


def _safety(before: Sequence[_Seat], after: Sequence[_Seat]) -> Iterator[str]:
    """Never two owners, and none beside one that is in the way."""
    for k, seat in enumerate(after):
        if not (seat.valid and seat.called):
            continue
        for j, other in enumerate(after):
            came = j > k and other.in_the_way and not (before[j].in_the_way or before[j].had)
            if j != k and (other.valid or ((other.in_the_way or other.had) and not came)):
                yield f"safety: robot {k + 1} may go in, robot {j + 1} is or may be there"


def _program(model: InterlockModel) -> str:
    robots = range(model.robots)
    held = "".join(
        f"    Robot{k} : RCX_REF;\n    Lock{k} : FB_Interlock;\n"
        f"    Go{k}, Out{k}, Ack{k}, Ready{k}, Called{k} : BOOL;\n"
        for k in robots
    )
    calls = "".join(
        f"  Robot{k}.Connected := Ready{k};\n  Robot{k}.SO.SO01_CpuOk := TRUE;\n"
        f"  Robot{k}.SO.SO02_ServoOn := TRUE;\n  Robot{k}.Inner.Elapsed := UINT#10;\n"
        f"  Robot{k}.Inner.Scan := UINT#5;\n"
        f"  IF Called{k} THEN\n"
        f"    Lock{k}(Robot := Robot{k}, Area := Area, Enable := Go{k}, Outside := Out{k},\n"
        f"          Acknowledge := Ack{k}, Timeout := T#{_limit(model, k)}ms);\n  END_IF;\n"
        for k in robots
    )
    return (
        f"PROGRAM Interlocks\n  VAR\n    Area : RCX_SHARED_AREA;\n{held}  END_VAR\n"
        f"{calls}END_PROGRAM\n"
    )


def _limit(model: InterlockModel, robot: int) -> int:
    return 10 * model.timeout if robot == model.robots - 1 else 0


def explored(
    model: InterlockModel, library: Sequence[Path] = LIBRARY, limit: int = 0, seed: int = 1
) -> Result:
    """Explore a model, to its end or to so many states."""
    world = _World(model, library)
    return Search(world, world.every, seed).run(model.name, limit)


def told(path: Sequence[_Choice]) -> list[str]:
    """The way to a broken rule, scan by scan."""
    return [
        f"scan {k}: " + (", ".join(f"robot {r + 1} {name}" for r, name in one.changes) or "nothing")
        for k, one in enumerate(path, 1)
    ]


def _bug(name: str, text: str, instead: str, model: str, rule: str) -> Seeded:
    return Seeded(name, "FB_Interlock", text, instead, model, rule)


SEEDED = (
    _bug("two hold it", "Known AND Others = UINT#0 THEN", "Known THEN", "entry", "safety"),
    _bug("granted in the first scan", "AND NOT (Known AND Outside)", "AND NOT Outside",
         "entry", "safety"),
    _bug("a loss gives the area back", " OR (Holds AND WasReady AND Loss <> WORD#16#0000)", "",
         "loss", "kept"),
    _bug("Acknowledge is not asked for", "AND NOT Granted AND NOT Kept", "AND NOT Granted",
         "loss", "safety"),
    _bug("Acknowledge that is held counts", "NOT Edge.Q", "NOT Acknowledge", "loss", "kept"),
    _bug("released while it is inside", "Holds AND Outside AND NOT Granted",
         "Holds AND NOT Granted", "entry", "safety"),
    _bug("an intruder is not seen", "Valid := Granted AND Others = UINT#0;", "Valid := Granted;",
         "entry", "safety"),
    _bug("no turns", "IF Ticket = Area.First THEN\n      Holds", "IF TRUE THEN\n      Holds",
         "entry", "turn"),
    _bug("those who have gone are waited for",
         " OR (Area.First = WasFirst AND Area.Beat = WasBeat)", "", "gone", "wait"),
    _bug("a place is kept for one that is not called", " OR Seen <> Robot.Inner.Scan", "",
         "gone", "turn"),
    _bug("it asks again by itself", "IF NOT Enable THEN",
         "IF NOT Enable OR Loss = WORD#16#0000 THEN", "loss", "restart"),
    _bug("goes on without Acknowledge", "ELSIF Kept THEN", "ELSIF FALSE THEN", "loss", "kept"),
    _bug("the limit does not end it", "    Busy := FALSE;\n", "", "limit", "contract"),
)  # fmt: skip


def main() -> int:
    """Explore every model to its end, and look for every seeded bug."""
    console, met = Console(), True
    table = Table("model", "what", "states", "scans", "depth", "result")
    for model in MODELS:
        one = explored(model)
        result = "explored to the end" if one.met else "NOT COMPLETE"
        if one.broken is not None:
            result = "; ".join([*one.broken.rules, *told(one.broken.path)])
        met = met and one.met
        figures = (f"{one.states:,}", f"{one.transitions:,}", str(one.depth))
        table.add_row(model.name, model.title, *figures, result)
    console.print(table)
    bugs = Table("seeded bug", "model", "scans", "found as")
    for bug in SEEDED:
        with tempfile.TemporaryDirectory() as folder:
            model = next(one for one in MODELS if one.name == bug.model)
            one = explored(model, bug.library(Path(folder)))
        rules = one.broken.rules if one.broken else ("NOT FOUND",)
        met = met and any(rule.startswith(bug.rule) for rule in rules)
        scans = str(len(one.broken.path)) if one.broken else "-"
        bugs.add_row(bug.name, bug.model, scans, rules[0])
    console.print(bugs)
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
