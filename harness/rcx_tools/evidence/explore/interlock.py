"""All states of FB_Interlock with up to three robots at one shared area.

Before each scan up to `at_once` robots change one of their inputs: Enable, Outside, Acknowledge,
whether link and servos are ready, and whether the instance is called at all. There is no
controller. The program sets the values of Robot that the block reads. `_Judge` uses only the inputs
and Valid, Busy and Error, never the internal variables of the block.

A second check starts from every reachable state. If a robot keeps requesting and the other robots
leave, it must get the area. The other robots leave by one input per scan, in the order of their
numbers. When all have left, the robot must get the area within `_PROMPT` scans, whatever the others
did before.

A state omits the origin of the tickets, gaps of more than one, the phase of the beat, and the
number of the scan. To check that they have no effect, some scans are repeated with arbitrary values
for them.
"""

from __future__ import annotations

import tempfile
from array import array
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations, product
from pathlib import Path
from random import Random
from typing import Any, ClassVar, NamedTuple

from rcx_tools.evidence.broken import BUGS, bugs
from rcx_tools.evidence.explore.search import LIBRARY, longest
from rcx_tools.evidence.explore.seeded import Seeded
from structured_text.engines.builtin import BuiltinProgram
from structured_text.explore.search import Broken, Paths, Result, Search, World
from structured_text.language.load import load
from structured_text.projects.needed import needed

__all__ = ["MODELS", "SEEDED", "InterlockModel", "explored", "replay", "told"]

#: Greatest number of scans from a free area to the next grant. Requests that were given up do not
#: count.
_PROMPT = 5
#: Number of scans that the replay of a hang shows. Without the hang, the grant would be in these
#: scans.
_SHOWN = 40
_WIDE = 1 << 32


@dataclass(frozen=True)
class InterlockModel:
    """A model of robots at one shared area.

    Attributes:
        name: Short name.
        title: Subject of the model.
        robots: Number of robots.
        moves: Inputs that may change, out of `go out ack ready called`.
        at_once: Largest number of robots that change an input before one scan.
        timeout: Time limit of the last robot in scans; 0 means no limit.
        tick_ms: Interval of the scans [ms].
    """

    tick_ms: ClassVar[int] = 10
    name: str
    title: str
    robots: int = 3
    moves: tuple[str, ...] = ("go", "out", "ack", "ready", "called")
    at_once: int = 1
    timeout: int = 0

    def limit_ms(self, robot: int) -> int:
        """Return the value of the pin Timeout of a robot; 0 means no limit."""
        return self.timeout * self.tick_ms if robot == self.robots - 1 else 0

    def write(self, folder: Path) -> Path:
        """Write the program of the model into a folder."""
        path = folder / "Interlocks.st"
        path.write_text(_program(self), encoding="utf-8")
        return path


_LOSSES = ("go", "out", "ack", "ready")
MODELS = (
    InterlockModel("loss", "a shared area: two robots, losses, intruders", 2, _LOSSES, 2),
    InterlockModel("gone", "a shared area: three robots that come and go", moves=("go", "called")),
    InterlockModel("entry", "a shared area: three robots, at once", 3, ("go", "out"), 2),
    InterlockModel("limit", "a shared area: two robots, one with a time limit", 2, _LOSSES, 2, 2),
)


class _Seat(NamedTuple):
    """The inputs of one robot, and what the judge remembers about the robot."""

    go: bool = False
    out: bool = False
    ack: bool = False
    ready: bool = False
    called: bool = True
    was_ready: bool = False
    was_ack: bool = False
    in_the_way: bool = True
    """Whether the robot is in the area or may be there.

    This is the case until a second call shows that it is outside, and after a loss in the area
    until the loss is acknowledged.
    """
    met: bool = False
    """Whether the block of this robot has been called."""
    kept: bool = False
    valid: bool = False
    had: bool = False
    """Whether the robot got the area since Enable rose.

    This includes the scan in which an error ends it.
    """
    failed: bool = False
    """Whether the block has shown an error since Enable rose."""
    queue: int = 0
    """Position in the queue of waiting robots that are called in every scan.

    0: the robot does not wait.
    """
    free: int = 0
    """Number of scans of waiting in which no robot had the area and no robot before it gave up."""


#: Inputs that change before a scan, each as robot and name of the input.
_Changes = tuple[tuple[int, str], ...]


class _Choice(NamedTuple):
    """The changes of the robots' inputs before a scan."""

    number: int
    changes: _Changes


@dataclass(frozen=True)
class _State:
    """All values that influence later scans: seats of the judge, and program variables."""

    seats: tuple[_Seat, ...]
    inner: tuple[Any, ...]


#: Variables of each instance that are part of a state. Tickets are added separately. All other
#: variables are written before they are read.
_KEPT = (
    *("KNOWN", "WASENABLE", "WASREADY", "GRANTED", "WAITING", "HOLDS", "KEPT", "ERRORID"),
    *("BUSY", "WAITED", "LONGEST"),
)


class _World(World[_Choice]):
    """The program, and the rules that it must obey."""

    def __init__(self, model: InterlockModel, library: Sequence[Path]) -> None:
        self._model = model
        with tempfile.TemporaryDirectory() as folder:
            path = model.write(Path(folder))
            self.program = BuiltinProgram.build(load([path, *needed([path], library)]))
        self._root: Any = self.program.holder(next(iter(self.program.instances())))
        robots = range(model.robots)
        self._locks = [getattr(self._root, f"LOCK{k}") for k in robots]
        self._area = self._root.AREA
        inputs = ("GO", "OUT", "ACK", "READY", "CALLED")  # the first fields of a seat: inputs
        self._inputs = [[f"{name}{k}" for name in inputs] for k in robots]
        self._judged = cache(_judged)  # cached, because many scans have the same inputs and outputs
        self.every = [_Choice(k, one) for k, one in enumerate(_changes(model))]
        self._states: dict[bytes, _State] = {}
        seat = _Seat(out="out" not in model.moves, ready="ready" not in model.moves)
        self.start = (seat,) * model.robots
        self._after = self.start
        self._numbers = {choice.changes: choice.number for choice in self.every}
        self._waits = [_Wait(k, self.start) for k in robots if not model.limit_ms(k)]

    def first(self) -> bytes:
        """Return the state before the first call of any instance."""
        return self._pack(_State(self.start, self._freeze()))

    def choices(self, state: bytes) -> Sequence[_Choice]:
        """Return all choices. In the first scan all instances are called."""
        if self._states[state].seats == self.start:
            return [one for one in self.every if all(name != "called" for _, name in one.changes)]
        return self.every

    def step(self, state: bytes, choice: _Choice) -> tuple[bytes, list[str]]:
        """Run one scan from a state, and return the next state and the broken rules."""
        here = self._states[state]
        return self._scan(here, choice, here.inner)

    def check(self, state: bytes, choice: _Choice, following: bytes, random: Random) -> None:
        """Repeat the scan with other tickets. Raise AssertionError if the next state differs."""
        here = self._states[state]
        there, _ = self._scan(here, choice, _disturbed(here.inner, random))
        if there != following:
            raise AssertionError(f"{self._model.name}: tickets have an effect: {here} {choice}")

    def added(self) -> None:
        """Record the robots that request the area in a new state and do not have it."""
        for wait in self._waits:
            wait.add(self._after)

    def entered(self, state: bytes) -> None:
        """Record how the other robots leave in the state that is explored next."""
        for wait in self._waits:
            wait.quiet = self._numbers[leaving(self._states[state].seats, wait.robot)]

    def followed(self, number: int, choice: _Choice, following: int) -> None:
        """Record the successor of a state."""
        for wait in self._waits:
            wait.follow(number, choice, following)

    def look(self, result: Result, states: Paths) -> None:
        """Search for a robot that never gets the area although all others leave."""
        for wait in self._waits:
            title = f"robot {wait.robot + 1} keeps asking, the others leave"
            bound, stuck, _ = longest(wait.nexts, wait.ends)
            result.bounds[title] = bound
            if stuck >= 0 and result.broken is None:
                text = f"hang: never gets the area: {title}"
                result.broken = Broken((text,), states.path(stuck), wait.robot)

    def _scan(
        self, here: _State, choice: _Choice, inner: tuple[Any, ...]
    ) -> tuple[bytes, list[str]]:
        self._thaw(inner, here.seats)
        self._after, broken = self.run(here.seats, choice.changes)
        return self._pack(_State(self._after, self._freeze())), broken

    def run(
        self, before: Sequence[_Seat], changes: _Changes
    ) -> tuple[tuple[_Seat, ...], list[str]]:
        """Run one scan from the present state of the program.

        Return the seats and the broken rules.
        """
        seats = list(before)
        for k, name in changes:
            seats[k] = seats[k]._replace(**{name: not getattr(seats[k], name)})
        for seat, names in zip(seats, self._inputs, strict=True):
            for name, value in zip(names, seat[: len(names)], strict=True):
                setattr(self._root, name, value)
        self.program.scan(0)
        shown = [(bool(one.VALID), bool(one.BUSY), int(one.ERRORID)) for one in self._locks]
        wrong = [
            f"contract: robot {k + 1}: Error without ErrorID, or the other way round"
            for k, one in enumerate(self._locks)
            if bool(one.ERROR) != bool(one.ERRORID)
        ]
        after, broken = self._judged(tuple(before), tuple(seats), tuple(shown))
        return after, [*wrong, *broken]

    def _pack(self, state: _State) -> bytes:
        key = repr((state.seats, state.inner)).encode()
        self._states.setdefault(key, state)
        return key

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

    def _thaw(self, inner: tuple[Any, ...], seats: Sequence[_Seat]) -> None:
        root, area = self._root, self._area
        area.HOLDERS, first, after, rows, waits, beat = inner
        area.FIRST, area.NEXTTICKET, area.BEAT = first % _WIDE, after % _WIDE, beat
        for k, (one, seat) in enumerate(zip(self._locks, seats, strict=True)):
            for name, value in zip(_KEPT, rows[k], strict=True):
                setattr(one, name, value)
            if waits[k]:
                one.TICKET, one.WASFIRST = waits[k][0] % _WIDE, waits[k][1] % _WIDE
                one.WASBEAT = waits[k][2] != beat
            getattr(root, f"ROBOT{k}").INNER.SCAN = 4
            one.EDGE.seen, one.SEEN = seat.was_ack, 4 if seat.called else 2
            one.VALID, one.ERROR = seat.valid, bool(one.ERRORID)


class _Wait:
    """The graph of states in which one robot keeps requesting and the others leave."""

    def __init__(self, robot: int, start: Sequence[_Seat]) -> None:
        self.robot, self.quiet = robot, 0
        self.nexts, self.ends, self._failed = array("i"), bytearray(), bytearray()
        self.add(start)

    def add(self, seats: Sequence[_Seat]) -> None:
        """Add a state. It is an end if the robot has the area, has failed, or does not request."""
        seat = seats[self.robot]
        self._failed.append(seat.failed)
        self.ends.append(seat.valid or seat.failed or not (seat.go and seat.called))

    def follow(self, number: int, choice: _Choice, following: int) -> None:
        """Add the step from a state in which the other robots leave the area.

        If the robot fails in this step, the state leads to itself. A state that leads to itself is
        reported as a hang.
        """
        if choice.number == self.quiet:
            self.nexts.append(number if self._failed[following] else following)


def leaving(seats: Sequence[_Seat], alone: int) -> _Changes:
    """Return the next input change of the robots that leave. Empty if all have left."""
    for k, seat in enumerate(seats):
        if k == alone:
            continue
        for name, wanted in (("called", True), ("go", False), ("out", True)):
            if getattr(seat, name) is not wanted:
                return ((k, name),)
        if seat.kept:
            return ((k, "ack"),)
    return ()


def _closer(numbers: Sequence[int], held: Sequence[int]) -> list[int]:
    """Return ticket numbers with the same order and smaller gaps, from 0 on.

    Numbers are signed, as in the comparison of tickets. After a ticket in `held`, a distance of one
    is preserved, because the turn advances by one only from such a ticket.
    """
    signed = {one: (one + _WIDE // 2) % _WIDE - _WIDE // 2 for one in numbers}
    owned = {signed[one] for one in held}
    places, last, place = {}, None, 0
    for one in sorted(set(signed.values())):
        place += 0 if last is None else min(one - last, 2) if last in owned else 2
        places[one], last = place, one
    return [places[signed[one]] for one in numbers]


def _disturbed(inner: tuple[Any, ...], random: Random) -> tuple[Any, ...]:
    """Return an equivalent state with another origin, wider gaps and a random phase."""
    holders, first, after, rows, waits, _ = inner
    beat, origin, wide = bool(random.randrange(2)), random.randrange(_WIDE), random.randrange(1, 99)
    held = [first, after, *(one for wait in waits if wait for one in wait[:2])]
    moved, last = {}, None
    for one in sorted(set(held)):
        origin += 0 if last is None else one - last if one - last == 1 else wide + 1
        moved[one], last = origin, one
    there = tuple((moved[one[0]], moved[one[1]], one[2]) if one else () for one in waits)
    return (holders, moved[first], moved[after], rows, there, beat)


def _changes(model: InterlockModel) -> Iterator[_Changes]:
    for count in range(model.at_once + 1):
        for robots in combinations(range(model.robots), count):
            for names in product(model.moves, repeat=count):
                yield tuple(zip(robots, names, strict=True))


def _judged(
    before: tuple[_Seat, ...], now: tuple[_Seat, ...], shown: tuple[tuple[bool, bool, int], ...]
) -> tuple[tuple[_Seat, ...], tuple[str, ...]]:
    """Judge a scan by inputs and outputs. Return the seats after the scan, and the broken rules.

    Args:
        before: The seats after the previous scan.
        now: The same seats with the inputs of this scan.
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
        had = seat.go and not was.failed and (was.had or valid)
        kept = (was.kept and not (seat.ack and not was.was_ack)) or (
            was.was_ready and not seat.ready and (was.in_the_way or was.had)
        )
        queue = (was.queue or last + 1) if busy and not had else 0
        last = max(last, queue)
        if valid and not (was.had or was.in_the_way):
            others = [one.queue for one in (*after, *before[k + 1 :]) if one.queue]
            if any(one < (was.queue or last + 1) for one in others):
                broken.append(f"turn: robot {k + 1} gets the area before a robot that came first")
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
            broken.append(f"wait: the area is free, but robot {k + 1} does not get it")
    return tuple(after), tuple(broken)


def _contract(k: int, was: _Seat, seat: _Seat, shown: tuple[bool, bool, int]) -> list[str]:
    """Return the rules that one robot breaks. Its block was called in this scan."""
    valid, busy, number = shown
    name = f"robot {k + 1}"
    broken = []
    if valid + busy + bool(number) != seat.go:
        broken.append(f"contract: {name}: Enable {seat.go}, Valid {valid}, Busy {busy}, {number:X}")
    if valid and not seat.ready:
        broken.append(f"loss: {name} has the area without link or servos")
    if was.go and was.failed and (valid or busy):
        broken.append(f"restart: {name} requests again by itself after an error")
    if valid and (was.kept and not (seat.ack and not was.was_ack)):
        broken.append(f"kept: {name} continues without Acknowledge")
    return broken


def _safety(before: Sequence[_Seat], after: Sequence[_Seat]) -> Iterator[str]:
    """Yield violations of mutual exclusion: one robot has the area, and another may be in it."""
    for k, seat in enumerate(after):
        if not (seat.valid and seat.called):
            continue
        for j, other in enumerate(after):
            came = j > k and other.in_the_way and not (before[j].in_the_way or before[j].had)
            if j != k and (other.valid or ((other.in_the_way or other.had) and not came)):
                yield f"safety: robot {k + 1} may enter, but robot {j + 1} is or may be there"


def _program(model: InterlockModel) -> str:
    robots = range(model.robots)
    held = "".join(
        f"    Robot{k} : RCX_REF;\n    Lock{k} : FB_Interlock;\n"
        f"    Go{k}, Out{k}, Ack{k}, Ready{k}, Called{k} : BOOL;\n"
        for k in robots
    )
    calls = "".join(
        f"  Robot{k}.Connected := Ready{k};\n  Robot{k}.SO.SO01_CpuOk := TRUE;\n"
        f"  Robot{k}.SO.SO02_ServoOn := TRUE;\n"
        f"  Robot{k}.Inner.Elapsed := UINT#{model.tick_ms};\n"
        f"  Robot{k}.Inner.Scan := Robot{k}.Inner.Scan + UINT#1;\n"
        f"  IF Called{k} THEN\n"
        f"    Lock{k}(Robot := Robot{k}, Area := Area, Enable := Go{k}, Outside := Out{k},\n"
        f"          Acknowledge := Ack{k}, Timeout := T#{model.limit_ms(k)}ms);\n  END_IF;\n"
        for k in robots
    )
    return (
        f"PROGRAM Interlocks\n  VAR\n    Area : RCX_SHARED_AREA;\n{held}  END_VAR\n"
        f"{calls}END_PROGRAM\n"
    )


def explored(
    model: InterlockModel,
    library: Sequence[Path] = LIBRARY,
    limit: int = 0,
    seed: int = 1,
) -> Result:
    """Explore a model completely, or up to a number of states."""
    world = _World(model, library)
    return Search(world, world.every, seed).run(model.name, limit)


def replay(
    model: InterlockModel, broken: Broken, library: Sequence[Path] = LIBRARY
) -> tuple[str, ...]:
    """Replay the path to a broken rule without abstraction, and return the broken rules."""
    world = _World(model, library)
    seats, rules = world.start, []
    for choice in broken.path:
        seats, wrong = world.run(seats, choice.changes)
        rules += wrong
    if broken.quiet is not None:
        for _ in range(_SHOWN):
            seats, wrong = world.run(seats, leaving(seats, broken.quiet))
            rules += wrong
        if not seats[broken.quiet].valid:
            rules += broken.rules
    return tuple(rules)


def told(path: Sequence[_Choice]) -> list[str]:
    """Return the path to a broken rule as text, scan by scan."""
    return [
        f"scan {k}: " + (", ".join(f"robot {r + 1} {name}" for r, name in one.changes) or "nothing")
        for k, one in enumerate(path, 1)
    ]


SEEDED = tuple(bugs([BUGS / "interlock.toml"], Seeded))
