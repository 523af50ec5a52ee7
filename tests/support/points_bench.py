"""A bench for FB_PointBackup and FB_PointRestore. Its controller stores the data of points."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from plc_bench import ROOT, PlcBench

#: For each reference command, the alarm for missing data: "Point doesn't exist", "Undefined
#: pallet".
ABSENT = {0x101: (6, 204), 0x105: (6, 204), 0x109: (6, 236)}
_READY, _RUN, _NORMAL, _ABNORMAL = 0x0000, 0x0100, 0x0200, 0x4000
#: Codes of the definition commands. The code of each reference command is higher by 1 (guide 4.3).
_DEFINITIONS = (0x100, 0x104, 0x108, 0x10C, 0x110)


class PointsBench(PlcBench):
    """The bench with its controller.

    A command has the run status for one scan, then its end status until the reset.

    Attributes:
        stored: The stored data by two keys: the code of the definition command (with the robot
            number in bits 15 to 12), and the number of the point or other data. A value has the
            words n+2 and n+6 to n+30 of the definition.
        sent: The received telegrams, 16 words each.
        refuses: Alarms of refused commands, by the number of the point or other data.
    """

    def __init__(self, engine: str, program: Path = ROOT / "tests/data/library/Points.st") -> None:
        super().__init__(program=program, engine=engine)
        self.stored: dict[tuple[int, int], list[int]] = {}
        self.sent: list[list[int]] = []
        self.refuses: dict[int, tuple[int, int]] = {}
        self.silent = False
        self.power_up()
        assert self._monitor is not None
        self._judge = self._monitor
        self._start = self.program.snapshot(), self.now_us, bytes(self.so), self._judge.snapshot()

    def restart(self) -> None:
        """Return to the start. The controller has no points."""
        snapshot, self.now_us, so, judged = self._start
        self.program.restore(snapshot)
        self._judge.restore(judged)  # type: ignore[arg-type]
        self.so[:] = so
        self.stored, self.sent, self.refuses, self.silent = {}, [], {}, False

    def scan(self, count: int = 1) -> None:
        """Run scans. The controller answers in each."""
        for _ in range(count):
            super().scan()
            self._step()

    def _step(self) -> None:
        words, status = self.words, int.from_bytes(self.so[0:2], "little")
        if words[0] == 0:
            self.answer(_READY)
        elif status == _READY and not self.silent:
            self.sent.append(words)
            self.answer(_RUN)
        elif status == _RUN and not self.silent:
            self.answer(*self._end(words))

    def _end(self, words: Sequence[int]) -> tuple[int, Sequence[int]]:
        code, number = words[0], words[2]
        definition = code & ~1 if code & 0xFFE in _DEFINITIONS else code
        if number in self.refuses:
            return _ABNORMAL, self.refuses[number]
        if code == definition:
            self.stored[code, number] = [words[1], *words[3:]]
            return _NORMAL, ()
        if (definition, number) not in self.stored:
            return _ABNORMAL, ABSENT.get(code & 0xFFF, (6, 255))
        flag, *rest = self.stored[definition, number]
        if code & 0xFFF == 0x101:
            rest[0] = flag  # the reference has the point flag at m+6, the definition at n+2
        elif code & 0xFFF == 0x111:
            rest[0] = code >> 12 or 1
        return _NORMAL, (0, number, *rest)

    def run(self, block: str, most: int = 800, **inputs: Any) -> int:
        """Start a block with these inputs, run it to its end, and return the ErrorID."""
        for name, value in inputs.items():
            self[f"{block}.{name}"] = value
        self[f"{block}.Execute"] = True
        self.scan()
        self.scan_until(lambda: not self[f"{block}.Busy"], most=most)
        error = self[f"{block}.ErrorID"]
        assert self[f"{block}.Error"] is (error != 0)
        assert self[f"{block}.Done"] is (error == 0)
        self[f"{block}.Execute"] = False
        self.scan(2)
        assert isinstance(error, int)
        return error

    def row(self, number: int) -> tuple[bool, int, list[int]]:
        """Return Defined, Flag and Values of a row of the array."""
        point = self[f"Rows[{number}]"]
        assert isinstance(point, dict)
        return point["Defined"], point["Flag"], list(point["Values"])

    @property
    def codes(self) -> list[int]:
        """Return the command codes of the received telegrams."""
        return [words[0] for words in self.sent]


@cache
def _made(engine: str) -> PointsBench:
    return PointsBench(engine)


def points_bench(engine: str) -> PointsBench:
    """Return the bench of this engine, reset to its start."""
    made = _made(engine)
    made.restart()
    return made


def record(plc: PointsBench, first: int = 10, count: int = 4, missing: int = -1) -> None:
    """Back up points from `first` on, then clear the controller.

    Axis 1 of a point is its number.
    """
    for number in range(first, first + count):
        if number != missing:
            plc.stored[0x100, number] = [1, 0, number, 0, *[0] * 10]
    assert plc.run("Backup", First=first, Count=count) == 0
    plc.stored.clear()
    plc.sent.clear()
