"""Random environment of a client program: a controller, changing pins, lost links.

The seed determines all choices. In half of the runs the library is used correctly. In the others
sizes, times and calls are absurd.
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

#: Pin values found by the solver, by the path of the pin: ("AXIS",), ("DATA", "3"). A text has its
#: length and its characters: ("NAME", "len"), ("NAME", "[0]").
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
#: Offsets and sizes of areas: rare legal ones, and illegal ones.
_OFFSETS = (2, 48, 100, 256, 462, 464, 466, 1, -1, 510, 512, 32767, -32768)
_SIZES = (48, 48, 48, 256, 256, 0, 47, 49, 255, 257, 512, -1, 32767, -32768)
_IMAGES = (IMAGE_BYTES, IMAGE_BYTES, 48, 256, 300, 100, 47, 0, -1, -32768, -32767)
_PLACES = {"M": _OFFSETS, "N": _OFFSETS, "SIZE": _SIZES, "IMAGESIZE": _IMAGES}
#: Periods of scans [us]: usual ones, and unusual ones.
_USUAL_US = (10_000, 20_000, 50_000, 100_000, 100_000, 250_000, 250_000)
_ODD_US = (100, 1_000, 1_500, 7_000, 33_300, 333_000, 1_000_000, 5_000_000, 10_000_000)
#: With these periods a quiet environment lasts longer than the time limits tried.
_LONG_US = (100_000, 250_000)
#: Dedicated outputs: CPU_OK; _WELL: MP RDY, AUTO mode and origin are also ON; _ILL: emergency stop
#: and alarm, OFF in a healthy state.
_CPU_OK, _WELL, _ILL = 0x0002, 0x0312, 0x0009
_NOTHING = bytes(DEDICATED_AT - 2)
_BOOL, _TIME = ElementaryType("BOOL"), ElementaryType("TIME")


@dataclass(frozen=True)
class Moment:
    """The events before a scan."""

    number: int
    t_us: int
    values: dict[str, Any]
    area: bytes
    connected: bool
    quiet: int = 0
    """For how many scans nobody has asked for anything."""


class Environment:
    """Source of random events around a client program.

    Args:
        library: Where the pins are found.
        client: The program.
        seed: Two environments of the same seed make the same choices.
        numbers: Numbers that may matter to the pins; half of the values are drawn from these.
        hints: Values that may matter to single pins.
        first: The first blocks of the client, which the run is about; 0: all of them.
        long: Use scan periods that are long enough for time limits.

    Attributes:
        blocks: The numbers of the blocks that are called in this run, from 1.
        scan_us: The period of the scans.
        n: The offset of the output area in its image; 0 if it is illegal.
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
        # _calm: no losses and a correct controller, or anything may happen. _well: a healthy state,
        # or any. _gone: blocks without a call at the end stay uncalled. _told: prefer the solver's
        # values.
        self._calm, self._well, self._gone, self._told = (draw() < 0.4 for _ in range(4))
        # How soon inputs change: orders last for a few scans, or for most of the run.
        self._pace = self._random.choice((0.03, 0.1, 0.2, 0.4))
        # No disturbance at all: this reaches states that need long undisturbed work.
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
        # A few pins vary and the others keep their declared values, which are legal; or all vary.
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
        # Call in order, or in another place: early or late.
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
        """Choose some of the blocks: at least one of the first; the others often of one channel."""
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
        """Return the events before scan `number`; `si` is the area written in the scan before."""
        draw = self._random.random
        values: dict[str, Any] = dict(self._first()) if number == 0 else {}
        if quiet:
            values |= self._quiet()
        else:
            values |= dict(self._changes())
        values = {name: value for name, value in values.items() if self._values.get(name) != value}
        self._values |= values
        self._answer(word(si, 0), quiet > 0)
        # The link is often lost in the scan after a skipped FB_WriteArea.
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
        """Update the status: usually the controller's answer to the code on the wire."""
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
        """Yield sizes and offsets of the areas; they are constant over the run."""
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
        """Return the values for a quiet environment, in which nothing is requested."""
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
        """Return a random value for a pin; some runs prefer the value found by the solver."""
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
        """Return a usual duration, a few scans, or an unusual duration."""
        pick, draw = self._random.choice, self._random.random()
        if draw < 0.5:
            return timedelta(milliseconds=pick(_TIMES_MS))
        if draw < 0.8:
            return timedelta(microseconds=self.scan_us * pick(range(1, 8)) + pick((-1000, 0, 1000)))
        return timedelta(milliseconds=pick(_LONG_MS), microseconds=pick((0, 0, 1, 499, 500, 501)))


def _as_pin(hints: Hints, place: tuple[str, ...], kind: Type) -> Any:
    """Return the solver's value in the type of the pin; None if there is none."""
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
    """Return a text from its length and its characters; characters that do not matter become A."""
    length = hints.get((*place, "len"))
    if length is None:
        return None
    return "".join(chr(hints.get((*place, f"[{k}]")) or ord("A")) for k in range(length))


def _fitting(value: int, name: str) -> int:
    """Return the number, wrapped to the range of the type."""
    width = {"INT": 16, "UINT": 16, "WORD": 16, "DINT": 32, "UDINT": 32, "DWORD": 32}.get(name, 8)
    value %= 1 << width
    return value - (1 << width) if name in ("INT", "DINT", "SINT") and value >> width - 1 else value


def numbers_in(file: Path) -> set[int]:
    """Return the numbers in a source, and their neighbours."""
    text = file.read_text(encoding="utf-8")
    found = {int(digits, 16) for digits in re.findall(r"16#([0-9A-F]+)", text)}
    found |= {int(digits) for digits in re.findall(r"(?<![\w#.])\d{1,9}\b", text)}
    return {number + more for number in found for more in (-1, 0, 1)}
