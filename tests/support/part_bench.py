"""A bench for FB_PickPlace beside other blocks, with a simulated robot, hand and parts.

The controller executes a command two scans after its code has come, and then answers.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from plc_bench import ROOT, PlcBench

SOURCE, TARGET, AWAY = 10, 20, 30

_MOVE, _BIT, _PORT, _READ = 0x001, 0x301, 0x300, 0x304
_FINGERS = 0x0040  # DI4()
_CLOSES, _OPENS = 20, 21

#: The name of a command's fault; `PartBench.fault` lists the names.
Fault = str


@cache
def _powered_up(engine: str) -> tuple[PlcBench, tuple[Any, int, bytes]]:
    """Return the program after power-up, with the state of the PLC at that time."""
    plc = PlcBench(program=ROOT / "tests/data/library/TwoBlocks.st", engine=engine, contract=False)
    plc.power_up()
    plc.outputs(SO02=True)
    plc.scan(3)
    return plc, (plc.program.snapshot(), plc.now_us, bytes(plc.so))


class PartBench:
    """The block `Pick` with a robot between SOURCE and TARGET.

    The source is never empty. If the hand opens at a wrong place, or a second part is fetched, the
    bench raises an error.

    Attributes:
        told: List of the commands that were executed or refused: `move 10`, `DO(20) ON`, `read
        DO2`.
        place: Point at which the robot is.
        closed: Whether the hand is closed.
        held: Whether a part is in the hand.
        delivered: Parts that were put down at the target.
        fault: The end of the next command: `refused`; `lost` (not executed, without an end status);
            `lost-done` (executed, without an end status); `late` (it ends when `fault` is reset);
            empty for a normal end.
        powered: Whether the controller is on. Without power, a hand with one output opens.
        fingers: Whether the fingers move. DI(43) shows that they have closed.
        foreign: Whether another block switches the hand. If so, the hand may open at any point.
    """

    def __init__(self, engine: str = "builtin", *, outputs: int = 1, sensor: bool = False) -> None:
        self.plc, (state, now_us, so) = _powered_up(engine)
        self.plc.now_us = now_us
        self.plc.program.restore(state)
        self.plc.so[:] = so
        self.told: list[str] = []
        self.place = AWAY
        self.closed = self.held = False
        self.delivered = 0
        self.fault: Fault = ""
        self.powered, self.foreign, self.fingers = True, False, True
        self._two = outputs == 2
        self._on: set[int] = set()
        self._age = self._sent = 0
        for block in ("Pick", "Second"):
            self[f"{block}.SourcePoint"], self[f"{block}.TargetPoint"] = SOURCE, TARGET
            self[f"{block}.Timeout"] = "T#200ms"
            self[f"{block}.Gripper.OpenOutput"] = _OPENS if self._two else 0
            self[f"{block}.Gripper.PartInput"] = 30 if sensor else 0
            self[f"{block}.Gripper.MaxWait"] = "T#100ms"

    @property
    def sent(self) -> int:
        """Return the number of commands that the controller has received, without read commands."""
        return self._sent

    def __getitem__(self, path: str) -> Any:
        return self.plc[path]

    def __setitem__(self, path: str, value: Any) -> None:
        self.plc[path] = value

    @property
    def end(self) -> tuple[str, int, bool]:
        """Return which of Done, Busy and Error are TRUE, the ErrorID, and Holds."""
        shown = " ".join(name for name in ("Done", "Busy", "Error") if self[f"Pick.{name}"])
        return shown, int(self["Pick.ErrorID"]), bool(self["Pick.Holds"])

    def scan(self, count: int = 1) -> None:
        """Run scans. The controller of the bench answers in each."""
        for _ in range(count):
            self.plc.scan()
            self._controller()

    def until(self, condition: Callable[[], bool], most: int = 200) -> None:
        """Scan until the condition holds."""
        for _ in range(most):
            if condition():
                return
            self.scan()
        raise AssertionError(f"not within {most} scans: {self.told}, {self.end}")

    def ends(self, block: str = "Pick") -> None:
        """Scan until the block is no longer Busy."""
        self.until(lambda: not self[f"{block}.Busy"])

    def work(self, block: str = "Pick", **pins: Any) -> str:
        """Give Execute a new edge, wait for the end, and return Done or the ErrorID."""
        self[f"{block}.Execute"] = False
        self.scan(2)
        for pin, value in pins.items():
            self[f"{block}.{pin}"] = value
        self[f"{block}.Execute"] = True
        self.scan()
        self.ends(block)
        return "Done" if self[f"{block}.Done"] else f"{int(self[f'{block}.ErrorID']):04X}"

    def send(self, code: int, *data: int) -> None:
        """Let another block send a command. This block waits until the command channel is free."""
        self["Other.Execute"] = False
        self.scan()
        self["Other.Code"] = code
        for k in range(1, 16):
            self[f"Other.Data[{k}]"] = data[k - 1] if k <= len(data) else 0
        self["Other.Execute"] = True

    def moved_by_hand(self) -> None:
        """Move the robot away with the programming box."""
        self.place = AWAY

    def taken_out(self) -> None:
        """Take the part out of the hand."""
        self.held = False

    def power_cycle(self) -> None:
        """Switch the controller off and on."""
        self.powered = False
        self._on = set()
        self._hand()
        self.plc.answer(0)
        self["Connected"] = False
        self.scan(5)
        self["Connected"] = True
        self.plc.outputs(SO01=False, SO02=False)
        self.powered = True
        self.scan(40)
        self.plc.outputs(SO01=True, SO02=True)
        self.scan(40)

    def link_loss(self) -> None:
        """Interrupt the link for five scans. The command that was sent is abandoned."""
        self["Connected"] = False
        self.plc.answer(0)
        self.scan(5)
        self["Connected"] = True
        self.scan(40)

    def _controller(self) -> None:
        words = self.plc.words
        if not words[0] or not self.powered or not self["Connected"]:
            self._age = 0
            if not words[0]:
                self.plc.answer(0)
            return
        self._age += 1
        self._sent += self._age == 1 and words[0] != _READ
        if self._age == 1 and self.fault != "refused":
            self.plc.answer(0x0100)
        if self.fault == "late":
            self._age = min(self._age, 2)
        elif self._age == 3:
            self._execute(words)

    def _execute(self, words: list[int]) -> None:
        fault, self.fault = self.fault, ""
        text = _text(words)
        self.told.append(text + (f" {fault}" if fault else ""))
        if fault == "refused":
            self.plc.answer(0x4000, [12, 76])
            return
        pattern = 0
        if fault != "lost":
            pattern = self._act(words)
        if fault.startswith("lost"):
            self.plc.answer(0)
        else:
            self.plc.answer(0x0200, [0, words[2], pattern] if words[0] == _READ else [])

    def _act(self, words: list[int]) -> int:
        if words[0] == _MOVE:
            self.place = words[4]
            assert not (self.held and self.place == SOURCE), "fetched a second part"
        elif words[0] == _BIT:
            number = 10 * (words[2] >> 4 & 15) + (words[2] & 15)
            self._on = self._on | {number} if words[3] else self._on - {number}
            self._hand()
        elif words[0] == _READ and words[2] == 0x1020:
            return sum(1 << number % 10 for number in self._on)
        elif words[0] == _PORT and words[2] == 0x1020:
            self._on = {20 + k for k in range(8) if words[3] >> k & 1}
            self._hand()
        elif words[0] == _READ and words[2] == _FINGERS:
            return 8 * (self.closed and self.fingers)
        elif words[0] == _READ:
            return int(self.held)
        return 0

    def _hand(self) -> None:
        closed = _CLOSES in self._on
        if self._two and closed == (_OPENS in self._on):
            return  # equal signals do not move a hand with two outputs
        if closed and not self.closed:
            self.held = self.place == SOURCE
        elif self.closed and not closed and self.held:
            free = self.place == TARGET or self.foreign or not self.powered
            assert free, f"the hand opens with a part at point {self.place}"
            self.delivered += self.place == TARGET
            self.held = False
        self.closed = closed


def _text(words: list[int]) -> str:
    if words[0] == _MOVE:
        return f"move {words[4]}"
    if words[0] == _BIT:
        number = 10 * (words[2] >> 4 & 15) + (words[2] & 15)
        return f"DO({number}) {'ON' if words[3] else 'OFF'}"
    if words[0] == _READ:
        return f"read {'DO' if words[2] >> 12 else 'DI'}{words[2] >> 4 & 15}"
    return f"{words[0]:03X}"
