"""What happens around a client program, by a seed: a controller, pins that change, lost links.

In half of the runs all is used as it should be; in the others sizes, times and calls are absurd.
"""

from __future__ import annotations

import random
import re
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from rcx_harness.spec.wire import DEDICATED_AT, ENDS, READY, RUN, SIZE
from rcx_harness.watch.wire import word
from rcx_tools.evidence.prove.client import IMAGE_BYTES, Client, less
from rcx_tools.evidence.prove.library import Library
from structured_text.language.types import ArrayType, ElementaryType, EnumType, StructType, Type

__all__ = ["Environment", "Hints", "Moment", "numbers_in"]

#: Values of pins that a solver has found, by the place of each: ("AXIS",), ("DATA", "3"); of a text
#: its length and its characters: ("NAME", "len"), ("NAME", "[0]").
Hints = Mapping[tuple[str, ...], Any]

_TIMES_MS = (0, 1, 50, 100, 150, 300, 1000, 5000)
_SPACINGS_MS = (0, 0, 50, 100, 100, 150, 300, 5000)
_LONG_MS = (10**5, 65_535, 65_536, 1_728_000_000, 1_728_000_001, 1_730_000_000, 2_592_000_000)
_REALS = (0.0, 1.0, -1.0, 0.5, 0.004, 50.0, 99.999, 100.0, 100.1, 1234.567, -8388.61, 1e9, -3e38)
_TEXTS = (
    "",
    "A",
    "P1",
    "PICK_AND_PLACE",
    "a name that is far too long for any field of it",
    "\x7f",
    "A B",
    "A ",
)
_COUNTS = (
    *(0, 1, 2, 3, 4, 5, 7, 8, 15, 16, 17, 31, 32, 33, 63, 64, 99, 100, 127, 128, 255, 256),
    *(999, 1000, 9999, 10000, 29999, 30000, 32767, -1, -2, -32768),
)
#: Offsets and sizes of areas: legal ones that are seldom, and others.
_OFFSETS = (2, 48, 100, 256, 462, 464, 466, 1, -1, 510, 512, 32767, -32768)
_SIZES = (48, 48, 48, 256, 256, 0, 47, 49, 255, 257, 512, -1, 32767, -32768)
_IMAGES = (IMAGE_BYTES, IMAGE_BYTES, 48, 256, 300, 100, 47, 0, -1, -32768, -32767)
_PLACES = {"M": _OFFSETS, "N": _OFFSETS, "SIZE": _SIZES, "IMAGESIZE": _IMAGES}
#: Periods of scans [us]: usual ones, and others.
_USUAL_US = (10_000, 20_000, 50_000, 100_000, 100_000, 250_000, 250_000)
_ODD_US = (100, 1_000, 1_500, 7_000, 33_300, 333_000, 1_000_000, 5_000_000, 10_000_000)
#: With them a quiet environment lasts longer than the time limits that are tried.
_LONG_US = (100_000, 250_000)
#: Dedicated outputs: CPU_OK; with MP RDY, AUTO mode and the origin where all is well; what is then
#: OFF: emergency stop, alarm.
_CPU_OK, _WELL, _ILL = 0x0002, 0x0312, 0x0009
_NOTHING = bytes(DEDICATED_AT - 2)
_BOOL, _TIME = ElementaryType("BOOL"), ElementaryType("TIME")


@dataclass(frozen=True)
class Moment:
    """What happens before a scan."""

    number: int
    t_us: int
    values: dict[str, Any]
    area: bytes
    connected: bool
    quiet: int = 0
    """For how many scans nobody has asked for anything."""


class Environment:
    """Chooses what happens.

    Args:
        library: Where the pins are found.
        client: The program.
        seed: Two of the same seed choose the same.
        numbers: Numbers that may matter to the pins; every second one is of these.
        hints: Values that may matter to single pins.
        first: So many blocks of the client are what the run is about; 0: all of them.
        long: Scans that are long enough for time limits.

    Attributes:
        blocks: The numbers of the blocks that are called in this run, from 1 on.
        scan_us: The period of the scans.
        n: Where the output area is in its image; where that is illegal none is written.
    """

    def __init__(
        self,
        library: Library,
        client: Client,
        seed: int,
        numbers: Iterable[int],
        hints: Hints,
        *,
        first: int = 0,
        long: bool = False,
    ) -> None:
        self._random = random.Random(seed)
        self._numbers = (*numbers,) or _COUNTS
        self._hints = hints
        draw = self._random.random
        # Lossless and polite, or everything may happen; well, or in any state; all are called
        # in the end, or those that are not are gone for good; the values that were found.
        self._calm, self._well, self._gone, self._told = (draw() < 0.4 for _ in range(4))
        # How soon somebody thinks otherwise: orders last for some scans, or for most of the run.
        self._pace = self._random.choice((0.03, 0.1, 0.2, 0.4))
        # All is as it should be: what comes after long and undisturbed work is reached, too.
        self._smooth = draw() < 0.25
        if self._smooth:
            self._calm = self._well = True
        absurd = draw() < 0.5 and not self._smooth and not client.steady
        self._skips, self._again, self._late = (absurd and draw() < 0.4 for _ in range(3))
        self._areas = dict(self._odd_areas(absurd and draw() < 0.4))
        n, size = self._areas.get("n", 0), self._areas.get("OutSize", SIZE)
        room = self._areas.get("ImageSize", IMAGE_BYTES) - size
        self.n = n if size >= SIZE and 0 <= n <= room else 0
        self.blocks = self._chosen(library, client, first)
        pins = [
            (f"Main.B{number}.{symbol.name}", symbol.type)
            for number in self.blocks
            for symbol in library.pou(client.blocks[number - 1].upper()).section("VAR_INPUT")
        ]
        starts = [pin for pin in pins if pin[0].endswith(("Execute", "Enable"))]
        others = [pin for pin in pins if pin not in starts]
        # A few pins vary, the others stay as they are declared, which is legal; or all do.
        few = self._random.choice((1, 2, 3, len(others)))
        self._pins = starts + self._random.sample(others, min(few, len(others)))
        self._pins += [
            (f"Main.F{number}{symbol.name}", symbol.type)
            for number, name in enumerate(client.functions, 1)
            for symbol in library.pou(name.upper()).section("VAR_INPUT")
        ]
        self._less = {
            f"Main.{less(number, path.rpartition('.')[2])}": timedelta(
                milliseconds=self._random.choice((1, 100, 5000, 10**9))
            )
            for number in self.blocks
            for path, kind in self._pins
            if path.startswith(f"Main.B{number}.") and kind == _TIME and absurd and draw() < 0.3
        }
        # In their order, or the other way round: before others, or behind them.
        self._calls = [
            f"Main.{self._random.choice(client.places)}{number}"
            for number in (() if client.steady else self.blocks)
        ]
        self._values: dict[str, Any] = {}
        self._status, self._response = READY, _NOTHING
        self._out = _CPU_OK | self._random.getrandbits(16)
        self._connected, self._cpu_ok = False, True
        odd = (*_USUAL_US, *_ODD_US) if absurd else _USUAL_US
        self.scan_us = self._random.choice(_LONG_US if long else odd)

    def _chosen(self, library: Library, client: Client, first: int) -> tuple[int, ...]:
        """Some of the blocks; of the first ones at least one, the others often of one channel."""
        every = range(1, len(client.blocks) + 1)
        if client.steady:
            return tuple(every)
        own, others = list(every[:first]), list(every[first:])
        channel = self._random.choice(("", "", "sequence", "command"))
        others = [
            number
            for number in others
            if Path(library.pou(client.blocks[number - 1].upper()).file).parts[-3:].count(channel)
            or not channel
        ]
        found = self._random.sample(own, self._random.randint(1, len(own))) if own else []
        most = min(len(others), 5)
        if not own or self._random.random() < 0.5:
            found += self._random.sample(others, self._random.randint(0 if own else 1, most))
        return tuple(sorted(found))

    def before(self, number: int, si: bytes, quiet: int) -> Moment:
        """What happens before scan `number`; `si` is what was written in the one before."""
        draw = self._random.random
        values: dict[str, Any] = dict(self._first()) if number == 0 else {}
        if quiet:
            values |= self._quiet()
        else:
            values |= dict(self._changes())
        values = {name: value for name, value in values.items() if self._values.get(name) != value}
        self._values |= values
        self._answer(word(si, 0), quiet > 0)
        # Often in the scan after one that nobody wrote the area of.
        lost = 0.0 if self._calm else 0.3 if self._values.get("Main.SkipWrite") else 0.03
        self._connected = draw() > lost if self._connected or quiet else draw() < 0.5
        self._connected = self._connected or quiet > 0
        if draw() < 0.3 and not quiet:
            self._out ^= 1 << self._random.randrange(16)
        if self._well and (self._smooth or draw() < 0.7):
            self._out = self._out & ~_ILL | _WELL
        if self._calm or quiet:
            self._cpu_ok = True
        else:
            self._cpu_ok = draw() > (0.03 if self._cpu_ok else 0.6)
        self._out = self._out | _CPU_OK if self._cpu_ok else self._out & ~_CPU_OK
        if draw() < 0.3:
            self._response = self._random.randbytes(DEDICATED_AT - 2) if draw() < 0.7 else _NOTHING
        area = self._status.to_bytes(2, "little") + self._response
        area += self._out.to_bytes(2, "little")
        return Moment(
            number, number * self.scan_us, values, area.ljust(SIZE, b"\0"), self._connected, quiet
        )

    def _answer(self, code: int, quiet: bool) -> None:
        """The status: mostly what a controller says to the code that is out."""
        draw = self._random.random()
        if draw < 0.02 and not self._calm and not quiet:
            self._status = self._random.choice((READY, RUN, *ENDS, 0x8000, 1))
        elif draw < 0.6 or quiet:
            if not code:
                self._status = READY
            elif self._status == READY:
                self._status = RUN
            elif self._status == RUN:
                self._status = ENDS[self._random.random() < 0.3]

    def _odd_areas(self, odd: bool) -> Iterator[tuple[str, int]]:
        """Sizes and places of the areas, which stay as they are."""
        pick = self._random.choice
        for name, values in (("n", _OFFSETS), ("OutSize", _SIZES), ("ImageSize", _IMAGES)):
            if odd and self._random.random() < 0.6:
                yield name, pick(values)
        for name, values in (("m", _OFFSETS), ("InSize", _SIZES)):
            if odd and self._random.random() < 0.2:
                yield name, pick(values)

    def _first(self) -> Iterator[tuple[str, Any]]:
        pick = self._random.choice
        yield "Main.EmergencyStopOk", True
        yield "Main.StopOk", True
        for name in ("Interval", "Margin"):
            spacings = _SPACINGS_MS[: 4 if self._smooth else None]
            yield f"Main.{name}", timedelta(milliseconds=pick(spacings))
            yield f"Main.Less{name}", timedelta(milliseconds=pick((0, 0, 0, 60, 100, 1000)))
        for name, value in self._areas.items():
            yield f"Main.{name}", value
        yield from self._less.items()
        for path, kind in self._pins:
            yield path, self._value(kind, path)
        for path in self._calls:
            yield path, True

    def _changes(self) -> Iterator[tuple[str, Any]]:
        draw = self._random.random
        for name in ("Main.EmergencyStopOk", "Main.StopOk"):
            if draw() < (0.02 * (not self._smooth) if self._values.get(name) else 0.4):
                yield name, not self._values.get(name)
        for path, kind in self._pins:
            if kind == _BOOL:
                if draw() < self._pace:
                    yield path, not self._values.get(path)
            elif draw() < 0.1:
                yield path, self._value(kind, path)
        for path in self._calls:
            if draw() < (0.03 if self._values.get(path) else 0.5):
                yield path, not self._values.get(path)
        for path in self._calls if self._late else ():
            if draw() < 0.1:
                other = path.replace(*(("Call", "Late") if "Call" in path else ("Late", "Call")))
                yield other, not self._values.get(other)
        for name in ("Main.SkipRead", "Main.SkipWrite") if self._skips else ():
            if draw() < (0.5 if self._values.get(name) else 0.04):
                yield name, not self._values.get(name)
        if self._again:
            for name in ("Main.Again", "Main.Other"):
                if draw() < (0.5 if self._values.get(name) else 0.1):
                    yield name, not self._values.get(name)
            for name in ("Main.AgainEmergencyStopOk", "Main.AgainStopOk"):
                if draw() < 0.2:
                    yield name, not self._values.get(name)

    def _quiet(self) -> dict[str, Any]:
        """Nobody asks for anything."""
        values: dict[str, Any] = {"Main.EmergencyStopOk": True, "Main.StopOk": True}
        values |= {path: False for path, kind in self._pins if kind == _BOOL}
        odd = ("Call", "Late", "Before", "Behind", "SkipRead", "SkipWrite", "Again", "Other")
        values |= {
            path: False
            for path in self._values
            if path.startswith(tuple(f"Main.{k}" for k in odd)) and path not in self._calls
        }
        return values if self._gone else values | dict.fromkeys(self._calls, True)

    def _value(self, kind: Type, path: str, place: Sequence[str] | None = None) -> Any:
        """A value of a pin; one that was found for it, in the runs that take those."""
        pick = self._random.choice
        if place is None:
            place = (re.sub(r"^Main\.(B\d+\.|F\d+)", "", path).upper(),)
        if isinstance(kind, ArrayType):
            low, high = kind.bounds[0]
            return [self._value(kind.element, path, (*place, str(k))) for k in range(low, high + 1)]
        if isinstance(kind, StructType):
            return {
                name: self._value(part, path, (*place, name.upper())) for name, part in kind.fields
            }
        found = _as_pin(self._hints, tuple(place), kind)
        if found is not None and self._random.random() < (0.7 if self._told else 0.1):
            return found
        if isinstance(kind, EnumType):
            return pick(kind.members)
        name = kind.name if isinstance(kind, ElementaryType) else ""
        if name == "BOOL":
            return self._random.random() < 0.3
        if name == "TIME":
            return self._time()
        if name in ("REAL", "LREAL"):
            return pick(_REALS)
        if name == "STRING":
            return pick(_TEXTS)
        odd = _PLACES.get(place[-1])
        if odd is not None and self._random.random() < 0.8:
            return pick(odd)
        counts = pick((self._numbers, _COUNTS))
        return _fitting(pick(counts) if self._random.random() < 0.9 else 0, name)

    def _time(self) -> timedelta:
        """A usual one, some scans, or one that is odd."""
        pick, draw = self._random.choice, self._random.random()
        if draw < 0.5:
            return timedelta(milliseconds=pick(_TIMES_MS))
        if draw < 0.8:
            return timedelta(microseconds=self.scan_us * pick(range(1, 8)) + pick((-1000, 0, 1000)))
        return timedelta(milliseconds=pick(_LONG_MS), microseconds=pick((0, 0, 1, 499, 500, 501)))


def _as_pin(hints: Hints, place: tuple[str, ...], kind: Type) -> Any:
    """What the solver has found, as a pin of this type takes it; None: nothing."""
    if kind == ElementaryType("STRING"):
        return _as_text(hints, place)
    value = hints.get(place)
    if value is None:
        return None
    if isinstance(kind, EnumType):
        return kind.members[int(value) % len(kind.members)]
    name = kind.name if isinstance(kind, ElementaryType) else ""
    if name == "BOOL":
        return bool(value)
    if name == "TIME":
        signed = int(value) - (1 << 64 if int(value) >> 63 & 1 else 0)
        return timedelta(microseconds=max(0, min(signed // 1000, 365 * 86_400_000_000)))
    if name == "REAL":
        return struct.unpack("<f", struct.pack("<I", int(value) & 0xFFFF_FFFF))[0]
    return _fitting(int(value), name)


def _as_text(hints: Hints, place: tuple[str, ...]) -> str | None:
    """A text by its length and its characters; those that do not matter are A."""
    length = hints.get((*place, "len"))
    if length is None:
        return None
    return "".join(chr(hints.get((*place, f"[{k}]")) or ord("A")) for k in range(length))


def _fitting(value: int, name: str) -> int:
    """The number as the type takes it."""
    width = {"INT": 16, "UINT": 16, "WORD": 16, "DINT": 32, "UDINT": 32, "DWORD": 32}.get(name, 8)
    value %= 1 << width
    return value - (1 << width) if name in ("INT", "DINT", "SINT") and value >> width - 1 else value


def numbers_in(file: Path) -> set[int]:
    """The numbers of a source, and those beside them."""
    text = file.read_text(encoding="utf-8")
    found = {int(digits, 16) for digits in re.findall(r"16#([0-9A-F]+)", text)}
    found |= {int(digits) for digits in re.findall(r"(?<![\w#.])\d{1,9}\b", text)}
    return {number + more for number in found for more in (-1, 0, 1)}
