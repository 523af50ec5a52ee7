"""The telegrams of the command blocks: legal ones only, and those that the pins say.

Of every command block but FB_RemoteCommand, by induction over its calls: what it holds while its
job is busy is put together when the job starts, from the pins of that call; it stays as it is; and
only that is ever requested. Which pin is what on the wire is not taken from the tables of the
library but from the second reading of the guide that the tests have, tests/spec/second_reading.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path as File
from typing import TYPE_CHECKING, Any

import z3

from rcx_harness.engine.types import ArrayType, EnumType
from rcx_harness.verify.prove import reals
from rcx_harness.verify.prove.machine import Path
from rcx_harness.verify.prove.reals import Real
from rcx_harness.verify.prove.texts import Text, anything
from rcx_harness.verify.prove.values import Value
from rcx_tools.evidence.prove.legality import CODE_BITS, legal
from rcx_tools.evidence.prove.library import BLOCK, ROBOT, Library, Step
from rcx_tools.evidence.prove.property import Goal, Property
from rcx_tools.evidence.results import ROOT

if TYPE_CHECKING:
    from pin_reading import PinRow, Pins
    from second_reading import Place

__all__ = ["PROPERTIES"]

_WORDS = range(15)
_SPACE = 0x20
#: The part that proves what the others take for granted of REAL_TO_DINT and of characters.
_LEMMAS = "REAL_TO_DINT and FC_RcxCharCode"
#: Of a condition in the reading that names one number, all those that are meant (guide 4.4.1).
_SPANS = {("Variable1", "0"): (0, 31), ("Variable1", "256"): (256, 287)}
#: (factor, lowest and highest REAL, what they become); both signs where there is no lowest.
_ROUNDED = (
    (1000, None, 8191.999, 8_191_999),
    (100, 0.009, 100.0, 10_000),
    (1, 1.0, 100.0, 100),
    (1, 1.0, 1000.0, 1000),
)


def _reading(block: str) -> Pins:
    """What the pins of a block are by the guide; its name in upper case."""
    folder = str(ROOT / "tests/support")
    if folder not in sys.path:
        sys.path.append(folder)
    from pin_reading import every_block

    return {name.upper(): pins for name, pins in every_block().items()}[block]


def _blocks(library: Library) -> list[str]:
    files = {name: File(library.pou(name).file) for name in library.blocks}
    return [
        name
        for name, file in files.items()
        if library.folder / "command" in file.parents and name != "FB_REMOTECOMMAND"
    ]


# --- REAL ---


def _times(pattern: Any, factor: int) -> Real:
    """A REAL times a factor, as the engines calculate it."""
    number = Real(pattern)
    if factor == 1:
        return number
    return reals.arithmetic("*", number, reals.constant(float(factor), "REAL", wide=True), "REAL")


def _nearest(pattern: Any, factor: int) -> Any:
    """The product as a REAL, and the whole number nearest to it, halves to the even one."""
    return reals.to_integer(reals.settled(_times(pattern, factor), "REAL"), 32, signed=True)


def _pattern(number: float) -> int:
    return int(struct.unpack("<I", struct.pack("<f", number))[0])


def _bounds(pattern: Any, nearest: Any, factor: int) -> Iterator[tuple[str, Any, Any]]:
    """Within which limits of a REAL the nearest number has which: name, premise, conclusion."""
    for scale, low, high, most in _ROUNDED:
        if scale != factor:
            continue
        if low is None:
            inside = z3.ULE(pattern & 0x7FFF_FFFF, _pattern(high))
            found = z3.And(nearest >= -most, nearest <= most)
        else:
            inside = z3.And(z3.UGE(pattern, _pattern(low)), z3.ULE(pattern, _pattern(high)))
            found = z3.And(nearest >= 1, nearest <= most)
        yield f"{low or -high} to {high}, times {scale}, rounded", inside, found


def _finite(pattern: Any) -> Any:
    """Neither infinite nor NaN."""
    return pattern & 0x7F80_0000 != 0x7F80_0000


def _bits(pattern: Any) -> Any:
    """The pattern that is sent: -0.0 as 0.0."""
    return z3.If(pattern == 0x8000_0000, z3.BitVecVal(0, 32), pattern)


# --- texts ---


def _character(text: Text, place: int) -> Any:
    """The character at a place from 0 on; behind the end a space."""
    within = z3.UGT(text.size, place)
    return z3.If(within, text.char(place), z3.BitVecVal(_SPACE, 8))


def _code(machine: Any, arguments: list[Any]) -> Any:
    """FC_RcxCharCode for the first sixteen places: 0 for what no telegram carries."""
    text, position = arguments
    character = _character(text, position - 1)
    carried = z3.And(z3.UGE(character, 0x20), z3.ULE(character, 0x7E))
    return z3.ZeroExt(8, z3.If(carried, character, z3.BitVecVal(0, 8)))


# --- a block ---


@dataclass(frozen=True)
class _Held:
    """What a block holds: code and data, whether its job is busy, and whether it is refused."""

    busy: Any
    refused: Any
    code: Any
    data: tuple[Any, ...]

    @property
    def ready(self) -> Any:
        return z3.And(self.busy, self.refused == 0)

    def same(self, other: _Held) -> Any:
        return z3.And(
            self.refused == other.refused,
            self.code == other.code,
            *(one == two for one, two in zip(self.data, other.data, strict=True)),
        )


class _Call:
    """One call of a block: its job was busy before, or not."""

    def __init__(self, library: Library, block: str, *, busy: bool) -> None:
        self.block = block
        self._library = library
        machine = library.machine()
        machine.summaries["FC_RCXCHARCODE"] = _code
        pou = library.pou(block)
        assert pou.block is not None
        machine.havoc(BLOCK, pou.block)
        machine[(*BLOCK, "JOB", "BUSY")] = busy
        machine.havoc(ROBOT, pou.section("VAR_IN_OUT")[0].type)
        before = machine.snapshot()
        machine.call_block(BLOCK, pou.block.name, {"ROBOT": ROBOT})
        self.step = Step(machine, before, BLOCK)
        self.machine = machine

    @cached_property
    def was(self) -> _Held:
        return self._held(self.step.before)

    @cached_property
    def now(self) -> _Held:
        return self._held(self.machine.snapshot())

    def _held(self, memory: dict[Path, Value]) -> _Held:
        def term(*path: Any) -> Any:
            return self.machine.term((*BLOCK, *path), memory)

        busy = term("JOB", "BUSY")
        if self.block == "FB_CONTINUOUSPOSITION":  # it begins only what is legal
            data = tuple(z3.BitVecVal(int(k == 0), 16) for k in _WORDS)
            return _Held(busy, z3.BitVecVal(0, 16), term("CODE"), data)
        data = tuple(term("DATA", k) for k in _WORDS)
        if self.block == "FB_JOG":
            return _Held(busy, term("ILLEGAL"), term("CODE"), data)
        return _Held(busy, term("JOB", "TROUBLE"), term("JOB", "HOLDER"), data)

    def between(self, memory: dict[Path, Value], unused: Iterable[int]) -> Any:
        """What holds between two calls, besides what the goals say of what is held."""
        held = self._held(memory)
        rules = [z3.Implies(self.machine.term((*BLOCK, "JOB", "ACTIVE"), memory), held.busy)]
        rules += [held.data[k] == 0 for k in unused]
        if self.block == "FB_JOG":
            asked = (self.machine.term((*BLOCK, name), memory) for name in ("ASKED", "OUT"))
            rules.append(z3.Implies(z3.Or(*asked), held.ready))
        return z3.And(rules)

    @property
    def turn(self) -> Any:
        """A job that has its turn, and was called in the last scan, has the ticket of the turn."""
        was, job, channel = self.step.was, (*BLOCK, "JOB"), (*ROBOT, "INNER", "COMMAND")
        last = was((*job, "SEEN")) + 1 == was((*ROBOT, "INNER", "SCAN"))
        own = was((*job, "TICKET")) == was((*channel, "SERVING"))
        return z3.Implies(z3.And(was((*job, "BUSY")), was((*job, "ACTIVE")), last), own)

    @property
    def requested(self) -> Any:
        """This call has requested nothing, or what the block holds."""
        inner = (*ROBOT, "INNER")
        code, asked = (*inner, "CODE"), (*inner, "CODEREQUEST")
        data = [(*inner, "DATA", k) for k in _WORDS]
        step = self.step
        nothing = [step.now(path) == step.was(path) for path in (code, asked, *data)]
        held = [self.now.ready, step.now(asked), step.now(code) == self.now.code]
        held += [step.now(path) == one for path, one in zip(data, self.now.data, strict=True)]
        return z3.Or(z3.And(nothing), z3.And(held))

    @property
    def edge(self) -> Any:
        """The pin that starts a job has risen; of a block with Enable nothing is said."""
        if self.block in ("FB_JOG", "FB_CONTINUOUSPOSITION"):
            return z3.BoolVal(True)
        return z3.And(
            self.step.was((*BLOCK, "EXECUTE")), z3.Not(self.step.was((*BLOCK, "JOB", "WASEXECUTE")))
        )

    # --- pins ---

    def pin(self, name: str, place: int = 0) -> Any:
        """A pin as it is at the call, or an element of it: a term, or a text."""
        path = (*BLOCK, name.upper())
        pou = self._library.pou(self.block)
        if isinstance(pou.symbols[name.upper()].type, ArrayType):
            path = (*path, place)
        value = self.step.before[path]
        if isinstance(value, Text):
            return value
        return value.value if isinstance(value, Real) else self.machine.term(path, self.step.before)

    def member(self, name: str, member: str) -> Any:
        """A pin is this member of its enumeration."""
        kind = self._library.pou(self.block).symbols[name.upper()].type
        assert isinstance(kind, EnumType)
        return self.pin(name) == [one.upper() for one in kind.members].index(member)


@dataclass(frozen=True)
class _Expected:
    """The telegram that the pins of a call say, by the second reading."""

    call: _Call
    reading: Pins

    def code(self) -> Any:
        """Word n."""
        code = z3.BitVecVal(0, 16)
        chosen = self.reading.select[0]
        for member, number in self.reading.codes.items():
            here = self.call.member(chosen, member) if chosen else z3.BoolVal(True)
            code = z3.If(here, z3.BitVecVal(number, 16), code)
        if self.reading.robot:
            code |= self.call.pin("RobotNumber") << CODE_BITS
        return code

    def data(self) -> list[Any]:
        """Words n+2 to n+30."""
        words: list[Any] = [z3.BitVecVal(0, 16) for _ in _WORDS]
        for part in self.reading.fixed:
            _write(words, part, z3.BitVecVal(1, part.width), z3.BoolVal(True))
        for row in self.reading.inputs:
            counts = self.counts(row)
            for number, part in enumerate(row.places):
                _write(words, part, self._value(row, number), counts)
            if row.flag:
                _write(words, row.flag, z3.BitVecVal(1, 1), z3.And(counts, self._pin(row) != 0))
        return words

    def counts(self, row: PinRow) -> Any:
        """The condition of a row."""
        if row.where is None:
            return z3.BoolVal(True)
        name, wanted = row.where
        if row.where in _SPANS:
            low, high = _SPANS[row.where]
            return z3.And(self.call.pin(name) >= low, self.call.pin(name) <= high)
        if wanted in ("TRUE", "FALSE"):
            return self.call.pin(name) == (wanted == "TRUE")
        return self.call.member(name, wanted)

    def reals(self) -> Iterator[tuple[PinRow, Any]]:
        """The REAL pins with their elements' patterns."""
        for row in self.reading.inputs:
            if row.scale or row.how == "real":
                for number in range(len(row.places)):
                    yield row, self._pin(row, number)

    def keys(self) -> Iterator[Any]:
        """What the telegram has to tell: the command, the robot, and each pin where it counts."""
        if self.reading.select[0]:
            yield self.call.pin(self.reading.select[0])
        if self.reading.robot:
            yield self.call.pin("RobotNumber")
        for row in self.reading.inputs:
            flags = bool(row.members) and len(row.places) > 1
            for number in range(1 if flags else len(row.places)):
                raw = row.scale or row.how in ("real", "text")
                key = self._value(row, number) if raw else self._pin(row, number)
                key = z3.If(key, z3.BitVecVal(1, 1), z3.BitVecVal(0, 1)) if z3.is_bool(key) else key
                yield z3.If(self.counts(row), key, z3.BitVecVal(0, key.size()))

    def _pin(self, row: PinRow, number: int = 0) -> Any:
        return self.call.pin(row.pin, number)

    def _value(self, row: PinRow, number: int) -> Any:
        """What stands at one of the places of a row."""
        width, pin = row.places[number].width, self._pin(row, number)
        if row.members:
            value = z3.BitVecVal(0, width)
            flags = len(row.places) > 1
            for one in row.members:
                wire = int(one.value == number + 1) if flags else one.value
                value = z3.If(self.call.member(row.pin, one.name), z3.BitVecVal(wire, width), value)
            return value
        if row.how == "text":
            return _character(pin, number)
        if row.how == "bool":
            return z3.If(pin, z3.BitVecVal(1, width), z3.BitVecVal(0, width))
        if row.how == "real":
            return _bits(pin)
        if row.scale:
            return _cut(_nearest(pin, row.scale), width)
        if row.how == "bit":
            return _table(pin, {k: 1 << k - 1 for k in range(1, width + 1)}, width)
        if row.how == "bcd":
            return _table(pin, {k: int(str(k), 16) for k in range(100)}, width)
        return _cut(pin, width)


def _cut(term: Any, width: int) -> Any:
    size = term.size()
    return z3.SignExt(width - size, term) if size < width else z3.Extract(width - 1, 0, term)


def _table(term: Any, rows: dict[int, int], width: int) -> Any:
    value = z3.BitVecVal(0, width)
    for number, one in rows.items():
        value = z3.If(term == number, z3.BitVecVal(one, width), value)
    return value


def _write(words: list[Any], part: Place, value: Any, counts: Any) -> None:
    """Put a value where the section has it; the place is 0 until then."""
    first = part.at // 2 - 1
    value = z3.If(counts, value, z3.BitVecVal(0, part.width))
    for number in range(first, first + (part.width + 15) // 16):
        if part.width > 16:
            low = 16 * (number - first)
            words[number] |= z3.Extract(low + 15, low, value)
        else:
            words[number] |= z3.ZeroExt(16 - part.width, value) << part.low


# --- goals ---


class _Block:
    """Both calls of a block, and the goals about them."""

    def __init__(self, library: Library, block: str) -> None:
        self.name = block
        self._library = library
        self._start = _Call(library, block, busy=False)
        self._busy = _Call(library, block, busy=True)
        self._reading = _reading(block)
        self._expected = _Expected(self._start, self._reading)
        self._data = self._expected.data()
        self._unused = [k for k in _WORDS if z3.is_bv_value(self._data[k])]
        self._rounded = []
        self._lemmas = []
        for row, pattern in self._expected.reals():
            if row.scale:
                nearest = z3.BitVec(f"{pattern} times {row.scale}", 32)
                self._rounded.append((_nearest(pattern, row.scale), nearest))
                for _, inside, found in _bounds(pattern, nearest, row.scale):
                    self._lemmas.append(z3.Implies(inside, found))

    def _assumed(self, call: _Call) -> tuple[Any, ...]:
        before = call.between(call.step.before, self._unused)
        return (*call.machine.assumptions, before, call.turn)

    def _goal(self, call: _Call, name: str, claim: Any, **show: Any) -> Goal:
        """A goal without floating point: what REAL_TO_DINT gives is a number within its bounds."""
        assumed = self._plain(z3.And(*self._assumed(call), *self._lemmas))
        shown = {name: self._plain(term) for name, term in show.items()}
        return Goal(f"{self.name}: {name}", (assumed,), self._plain(claim), shown)

    def _plain(self, term: Any) -> Any:
        return z3.substitute(term, *self._rounded) if self._rounded else term

    def held(self) -> Iterator[Goal]:
        """What a job holds stays, and nothing else is requested."""
        first = self._library.machine()
        pou = self._library.pou(self.name)
        assert pou.block is not None
        first.create(BLOCK, pou.block)
        begin = self._start.between(first.snapshot(), self._unused)
        idle = z3.Not(first.term((*BLOCK, "JOB", "BUSY")))
        yield Goal(f"{self.name}: it begins idle", (), z3.And(begin, idle))
        for call, when in ((self._start, "no job was busy"), (self._busy, "a job was busy")):
            show = {"code": call.now.code, "refused": call.now.refused}
            name = f"only what is held and not refused is requested; {when}"
            yield self._goal(call, name, call.requested, **show)
            after = call.between(call.machine.snapshot(), self._unused)
            yield self._goal(call, f"what holds between the calls is kept; {when}", after)
        now, was = self._busy.now, self._busy.was
        stays = z3.Implies(now.busy, now.same(was))
        yield self._goal(self._busy, "what is held stays while the job is busy", stays)

    def legal(self) -> Iterator[Goal]:
        """What a job begins with is legal, unless it is refused."""
        now = self._start.now
        edge = self._start.edge
        yield self._goal(self._start, "a job begins at an edge", z3.Implies(now.ready, edge))
        codes = sorted(set(self._reading.codes.values()))
        claim = z3.Implies(z3.And(edge, now.ready), legal(now.code, now.data, codes))
        yield self._goal(self._start, "a telegram is legal", claim, **_shown(now.code, now.data))

    def pins(self) -> Iterator[Goal]:
        """It is what the pins say, and different pins make different telegrams."""
        now, expected = self._start.now, self._expected
        code = expected.code()
        same = [now.code == code, *map(_equal, now.data, self._data)]
        claim = z3.Implies(now.ready, z3.And(same))
        show = _shown(now.code, now.data) | _shown(code, self._data, " by the pins")
        yield self._goal(self._start, "a telegram is what the pins say", claim, **show)
        rules = []
        for row, pattern in expected.reals():
            fits = _finite(pattern)
            if row.scale:
                nearest = _nearest(pattern, row.scale)
                fits = z3.Or([inside for _, inside, _ in _bounds(pattern, nearest, row.scale)])
            rules.append(z3.Implies(expected.counts(row), fits))
        if rules:
            claim = z3.Implies(now.ready, z3.And(rules))
            yield self._goal(self._start, "a REAL that counts is a number and fits", claim)
        keys = list(expected.keys())
        if keys:
            yield self._told_apart(keys, code)

    def _told_apart(self, keys: list[Any], code: Any) -> Goal:
        """Two calls with the same telegram have the same pins, where these count."""
        terms = [
            self._plain(z3.And(*self._assumed(self._start), self._start.now.ready)),
            self._plain(code),
            *map(self._plain, self._data),
            *map(self._plain, keys),
        ]
        other = [(one, z3.Const(f"{one}'", one.sort())) for one in _constants(terms)]
        (one, *left), (two, *right) = terms, [z3.substitute(term, *other) for term in terms]
        words = 1 + len(_WORDS)
        assumed = [one, two, *map(_equal, left[:words], right[:words])]
        claim = z3.And(list(map(_equal, left[words:], right[words:])))
        name = f"{self.name}: different pins make different telegrams"
        return Goal(name, tuple(assumed), claim)


def _equal(one: Any, other: Any) -> Any:
    return one == other


def _shown(code: Any, data: Iterable[Any], more: str = "") -> dict[str, Any]:
    return {f"n+{2 * k}{more}": word for k, word in enumerate((code, *data))}


def _constants(terms: Iterable[Any]) -> list[Any]:
    """What is no number in the terms: variables of the solver."""
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
    for factor in dict.fromkeys(row[0] for row in _ROUNDED):
        for name, inside, found in _bounds(pattern, _nearest(pattern, factor), factor):
            yield Goal(name, (inside,), found)
    for position in range(1, 17):
        machine = library.machine(summaries=False)
        text = anything("text")
        body = machine.call_function("FC_RCXCHARCODE", [text, position])
        claim = body == _code(machine, [text, position])
        yield Goal(f"FC_RcxCharCode {position}", (z3.ULE(text.size, text.most),), claim)


def _legal_goals(library: Library, part: str) -> Iterator[Goal]:
    if part == _LEMMAS:
        yield from _lemma_goals(library)
        return
    block = _Block(library, part)
    yield from block.held()
    yield from block.legal()


def _exact_goals() -> Iterator[Goal]:
    """Of a REAL that is nearest to a number of 0.001 mm or 0.01 %, that number is sent.

    It is less than a quarter away: half the distance of REALs is 0.000244 below 8192.
    """
    double = z3.Float64()
    pattern, number = z3.BitVec("pattern", 32), z3.BitVec("number", 32)
    middle, quarter = z3.fpSignedToFP(z3.RNE(), number, double), z3.FPVal(0.25, double)
    for factor, limit in ((1000, 8191.999), (100, 100.0)):
        product = _times(pattern, factor).value
        assumed = (
            z3.ULE(pattern & 0x7FFF_FFFF, _pattern(limit)),
            z3.And(number >= -round(limit * factor), number <= round(limit * factor)),
            z3.fpLT(z3.fpSub(z3.RNE(), middle, quarter), product),
            z3.fpLT(product, z3.fpAdd(z3.RNE(), middle, quarter)),
        )
        yield Goal(f"exact, times {factor}", assumed, _nearest(pattern, factor) == number)


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
        "Every command block but FB_RemoteCommand, whatever its pins hold, requests only telegrams"
        " that the guide calls legal; where an input is refused it requests nothing.",
        "remote command guide 4.2 to 4.9",
        ("inner", "turn"),
        _legal_goals,
        _parts,
        _rests_on,
    ),
    Property(
        "telegram-pins",
        "Every command block but FB_RemoteCommand requests the telegram that its pins said when its"
        " job began; pins that differ where they count make different telegrams, but for what"
        " rounds to the same 0.001 mm or step of the speed, spaces at the end of a text, and -0.0.",
        "remote command guide 4.2 to 4.9",
        ("inner", "turn"),
        _pins_goals,
        _parts,
        _rests_on,
    ),
)
