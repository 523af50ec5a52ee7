"""A bench for FB_PickPlace. Its small robot ends each command at once and lists the commands.

The telegrams are described in guide 4.2.1, 4.2.5, 4.2.17 and 4.5.1.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from plc_bench import ROOT, PlcBench

_DI = 0x0304
_DATE = 0x0511
_OUTPUTS = 1  # port type DO


class PickBench(PlcBench):
    """The bench with the block `Pick` and its robot.

    Attributes:
        told: List of the received commands: `PTP 10 at 50`, `DO(20) ON`, `DI2?`, `DO2?`. The
        command `date` comes from another block, `Other`.
        on: Outputs that are ON.
        inputs_on: Inputs that are ON, as 20 for DI(20).
        follows: Inputs that follow an output: with {21: 20}, DI(21) is ON while DO(20) is ON.
        refuses: A command such as `PTP 20 at 50`. The robot ends it with the alarm 12.600, but only
        the first time.
        silent: A command that gets no end status.
    """

    def __init__(self, engine: str = "auto", **pins: Any) -> None:
        super().__init__(program=ROOT / "tests/data/library/PickPlace.st", engine=engine)
        self.told: list[str] = []
        self.inputs_on: set[int] = set()
        self.follows: Mapping[int, int] = {}
        self.refuses = self.silent = ""
        self.on: set[int] = set()
        self._busy = False
        self.power_up()
        self.outputs(SO02=True)
        super().scan()
        for name, value in pins.items():
            self[f"Pick.{name.replace('__', '.')}"] = value

    def scan(self, count: int = 1) -> None:
        """Run scans. A command is answered in the scan after it arrives."""
        for _ in range(count):
            super().scan()
            if self.words[0] and not self._busy:
                self._busy = True
                self._take(self.words)
            elif not self.words[0]:
                self._busy = False
                self.answer(0)

    def _take(self, words: list[int]) -> None:
        text = _text(words)
        self.told.append(text)
        if text == self.silent:
            return
        if text == self.refuses:
            self.refuses = ""
            self.answer(0x4000, [12, 600])
            return
        if text.startswith("DO("):
            number = int(text[3:-1].partition(")")[0])
            self.on = self.on | {number} if text.endswith("ON") else self.on - {number}
        port = _port(words[2])
        ons = self.inputs_on | {one for one, by in self.follows.items() if by in self.on}
        if words[2] >> 12 == _OUTPUTS:
            ons = self.on
        pattern = sum(1 << number % 10 for number in ons if number // 10 == port)
        self.answer(0x0200, [0, words[2], pattern] if words[0] == _DI else [])

    def start(self) -> None:
        """Give Execute a rising edge."""
        self["Pick.Execute"] = False
        self.scan(2)
        self["Pick.Execute"] = True
        self.scan()

    def work(self) -> list[str]:
        """Start the block, wait for its end, and return the commands that it sent."""
        before = len(self.told)
        self.start()
        if self["Pick.Busy"]:
            self.scan_until(lambda: not self["Pick.Busy"], most=600)
        return self.told[before:]

    def until(self, text: str) -> None:
        """Scan until this command arrives. If the block is idle, start it first."""
        if not self["Pick.Busy"]:
            self.start()
        self.scan_until(lambda: bool(self.told) and self.told[-1] == text, most=300)

    @property
    def end(self) -> tuple[str, int, str, bool]:
        """Return the block's end (Done or Error), ErrorID, Stage and Holds."""
        shown = " ".join(name for name in ("Done", "Busy", "Error") if self[f"Pick.{name}"])
        stage = str(self["Pick.Stage"])
        return shown, int(self["Pick.ErrorID"]), stage, bool(self["Pick.Holds"])


def picking(engine: str = "auto", **pins: Any) -> PickBench:
    """Return a bench that carries parts from point 10 to point 20 at half the speed."""
    return PickBench(engine, **{"SourcePoint": 10, "TargetPoint": 20, "Speed": 50.0, **pins})


def _port(word: int) -> int:
    """Return a port number from its bits in the telegram: tens in bits 8 to 11, units in 4 to 7."""
    return 10 * (word >> 8 & 15) + (word >> 4 & 15)


def _double(words: list[int], at: int) -> int:
    value = words[at] | words[at + 1] << 16
    return value - (value >> 31 << 32)


def _text(words: list[int]) -> str:
    code, robot = words[0] & 0x0FFF, words[0] >> 12
    speed = f" at {words[3]}" if words[1] & 0x0004 else ""
    speed += f" by robot {robot}" if robot else ""
    place = f"{words[4]}" if code in (0x001, 0x002) else f"{words[4]}/{words[5]}"
    if code == 0x301:
        return f"DO({10 * _port(words[2]) + (words[2] & 15)}) {'ON' if words[3] else 'OFF'}"
    if code == _DATE:
        return "date"
    if code == _DI:
        return f"{'DO' if words[2] >> 12 == _OUTPUTS else 'DI'}{_port(words[2])}?"
    if code == 0x03B:
        return f"shift {words[2]}"
    if code in (0x001, 0x018):
        return f"PTP {place}{speed}"
    assert code in (0x002, 0x019), hex(code)
    unit = "mm" if words[1] & 0x0010 else "pulses"
    data = [_double(words, at) for at in (8, 10, 12)]
    return f"arch {place}{speed}, {words[2] >> 8:06b} {data} {unit}"
