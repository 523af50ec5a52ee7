"""A client program around some blocks: every pin is free in each scan, and so is the area."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from typing import Any

from rcx_harness.engine.types import ArrayType, ElementaryType, EnumType, StructType, Type
from rcx_harness.spec.wire import DEDICATED_AT, ENDS, READY, RUN, SIZE
from rcx_harness.watch.wire import word
from rcx_tools.evidence.prove.library import Library

__all__ = ["Client", "Environment", "Moment"]

_TIMES_MS = (0, 1, 50, 100, 150, 300, 1000, 5000)
_REALS = (0.0, 1.0, -1.0, 0.5, 0.004, 50.0, 99.999, 100.0, 100.1, 1234.567, -8388.61, 1e9, -3e38)
_TEXTS = (
    "",
    "A",
    "P1",
    "PICK_AND_PLACE",
    "a name that is far too long for any field of it",
    "\x7f",
)
_COUNTS = (
    *(0, 1, 2, 3, 4, 5, 7, 8, 15, 16, 17, 31, 32, 33, 63, 64, 99, 100, 127, 128, 255, 256),
    *(999, 1000, 9999, 10000, 29999, 30000, 32767, -1, -2, -32768),
)
#: Dedicated outputs: CPU_OK; with MP RDY, AUTO mode and the origin where all is well; what is then
#: OFF: emergency stop, alarm.
_CPU_OK, _WELL, _ILL = 0x0002, 0x0312, 0x0009
_NOTHING = bytes(DEDICATED_AT - 2)


@dataclass(frozen=True)
class Client:
    """A program with some blocks between FB_ReadArea and FB_WriteArea.

    Attributes:
        blocks: Their types.
        steady: They are called in every scan.
        words: The process image is one of words.
    """

    blocks: tuple[str, ...]
    steady: bool = False
    words: bool = False

    def source(self, library: Library) -> str:
        """Structured Text."""
        more = "Words" if self.words else ""
        image = "RCX_IMAGE_WORDS" if self.words else "RCX_IMAGE"
        numbered = list(enumerate(self.blocks, 1))
        instances = [f"    B{number} : {block};" for number, block in numbered]
        calls = [f"    Call{number} : BOOL := TRUE;" for number, _ in numbered]
        body = []
        for number, block in numbered:
            area = "OutputArea" if block.startswith("FB_Write") else "InputArea"
            names = (one.name for one in library.pou(block.upper()).section("VAR_IN_OUT"))
            arguments = (f"{name} := {'Robot' if name == 'Robot' else area}" for name in names)
            call = f"B{number}({', '.join(arguments)});"
            body.append(f"  {call}" if self.steady else f"  IF Call{number} THEN {call} END_IF;")
        return "\n".join(
            [
                "(* All pins are free: they are set between the scans. *)",
                "PROGRAM Client",
                "  VAR",
                f"    InputArea, OutputArea : {image};",
                "    Connected, EmergencyStopOk, StopOk : BOOL;",
                "    Interval, Margin, LessInterval, LessMargin : TIME;",
                "    Robot : RCX_REF;",
                f"    ReadArea : FB_ReadArea{more};",
                f"    WriteArea : FB_WriteArea{more};",
                *instances,
                *([] if self.steady else calls),
                "  END_VAR",
                "",
                "  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);",
                *body,
                "  WriteArea(Robot := Robot, Image := OutputArea,",
                "            EmergencyStopOk := EmergencyStopOk, StopOk := StopOk,",
                "            Interval := Interval - LessInterval, Margin := Margin - LessMargin);",
                "END_PROGRAM",
                "",
            ]
        )


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
    """Chooses what happens, by its seed: a controller that mostly answers, pins that change.

    Args:
        library: Where the pins are found.
        client: The program.
        seed: Two of the same seed choose the same.
        numbers: Numbers that may matter to the pins.
        long: Scans that are long enough for time limits.
    """

    def __init__(
        self, library: Library, client: Client, seed: int, numbers: Iterable[int], *, long: bool
    ) -> None:
        self._random = random.Random(seed)
        self._numbers = (*_COUNTS, *numbers)
        # Lossless and polite, or everything may happen; well, or in any state; all are called
        # in the end, or those that are not are gone for good.
        self._calm, self._well, self._gone = (self._random.random() < 0.4 for _ in range(3))
        pins = [
            (f"Main.B{number}.{symbol.name}", symbol.type)
            for number, block in enumerate(client.blocks, 1)
            for symbol in library.pou(block.upper()).section("VAR_INPUT")
        ]
        starts = [pin for pin in pins if pin[0].endswith(("Execute", "Enable"))]
        others = [pin for pin in pins if pin not in starts]
        # A few pins vary, the others stay as they are declared, which is legal; or all do.
        few = self._random.choice((1, 2, 3, len(others)))
        self._pins = starts + self._random.sample(others, min(few, len(others)))
        self._calls = (
            [] if client.steady else [f"Main.Call{k + 1}" for k in range(len(client.blocks))]
        )
        self._values: dict[str, Any] = {}
        self._status, self._response = READY, _NOTHING
        self._out = _CPU_OK | self._random.getrandbits(16)
        self._connected = False
        periods = (100_000, 250_000) if long else (10_000, 20_000, 50_000, 100_000, 250_000)
        self.scan_us = self._random.choice(periods)

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
        lost = 0.0 if self._calm else 0.03
        self._connected = draw() > lost if self._connected or quiet else draw() < 0.5
        self._connected = self._connected or quiet > 0
        if draw() < 0.3 and not quiet:
            self._out ^= 1 << self._random.randrange(16)
        if self._well and draw() < 0.7:
            self._out = self._out & ~_ILL | _WELL
        if self._calm or quiet or draw() > 0.05:
            self._out |= _CPU_OK
        if draw() < 0.3:
            self._response = self._random.randbytes(DEDICATED_AT - 2) if draw() < 0.7 else _NOTHING
        area = self._status.to_bytes(2, "little") + self._response
        area += self._out.to_bytes(2, "little")
        return Moment(
            number, number * self.scan_us, values, area.ljust(SIZE, b"\0"), self._connected
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

    def _first(self) -> Iterator[tuple[str, Any]]:
        pick = self._random.choice
        yield "Main.EmergencyStopOk", True
        yield "Main.StopOk", True
        for name in ("Interval", "Margin"):
            yield f"Main.{name}", timedelta(milliseconds=pick(_TIMES_MS))
            yield f"Main.Less{name}", timedelta(milliseconds=pick((0, 0, 0, 60, 100, 1000)))
        for path, kind in self._pins:
            yield path, self._value(kind, path)
        for path in self._calls:
            yield path, True

    def _changes(self) -> Iterator[tuple[str, Any]]:
        draw = self._random.random
        for name in ("Main.EmergencyStopOk", "Main.StopOk"):
            if draw() < (0.02 if self._values.get(name) else 0.4):
                yield name, not self._values.get(name)
        for path, kind in self._pins:
            if kind == ElementaryType("BOOL"):
                if draw() < 0.2:
                    yield path, not self._values.get(path)
            elif draw() < 0.1:
                yield path, self._value(kind, path)
        for path in self._calls:
            if draw() < (0.03 if self._values.get(path) else 0.5):
                yield path, not self._values.get(path)

    def _quiet(self) -> dict[str, Any]:
        """Nobody asks for anything."""
        values: dict[str, Any] = {"Main.EmergencyStopOk": True, "Main.StopOk": True}
        values |= {path: False for path, kind in self._pins if kind == ElementaryType("BOOL")}
        return values if self._gone else values | dict.fromkeys(self._calls, True)

    def _value(self, kind: Type, path: str) -> Any:
        pick = self._random.choice
        if isinstance(kind, EnumType):
            return pick(kind.members)
        if isinstance(kind, ArrayType):
            low, high = kind.bounds[0]
            return [self._value(kind.element, path) for _ in range(low, high + 1)]
        if isinstance(kind, StructType):
            return {name: self._value(part, path) for name, part in kind.fields}
        name = kind.name if isinstance(kind, ElementaryType) else ""
        if name == "BOOL":
            return self._random.random() < 0.3
        if name == "TIME":
            return timedelta(milliseconds=pick(_TIMES_MS))
        if name in ("REAL", "LREAL"):
            return pick(_REALS)
        if name == "STRING":
            return pick(_TEXTS)
        return _fitting(pick(self._numbers) if self._random.random() < 0.9 else 0, name)


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
