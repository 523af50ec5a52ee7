"""A panel and a PLC without a robot: the test presses keys and plays the controller."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from plc_bench import ROOT, PlcBench

_JOGS = (0x0020, 0x0021, 0x0022)


class OperatorBench(PlcBench):
    """FB_Operator with servos on, in AUTO mode.

    The panel is in manual operation, and nothing moves.

    Args:
        engine: The engine that runs the program.
        up: Whether the robot is powered up; if not, the PLC has just started.
        contract: Whether the contract monitor checks each scan; False for tests that restore an
            earlier state.
        panel: Values of members of the panel, which are written after power-up.

    Attributes:
        refuse: Code of a command that ends with `alarm`; 0 for none.
        hold: Code of a command that gets no answer; 0 for none.
        alarm: Group and category of the alarm.
        sent: The words of each command that was sent, in their order.
    """

    def __init__(
        self, engine: str = "auto", *, up: bool = True, contract: bool = True, **panel: Any
    ) -> None:
        program = ROOT / "tests/data/library/Operator.st"
        super().__init__(program=program, engine=engine, contract=contract)
        self.refuse = self.hold = 0
        self.alarm = (2, 334)
        self.sent: list[list[int]] = []
        self._out = 0
        if up:
            self.power_up()
            self.outputs(SO02=True, SO11=True, scans=2)
        self.set(**panel)

    def scan(self, count: int = 1) -> None:
        """Run scans. The bench answers each command in the scan after it."""
        for _ in range(count):
            self.scan_once()
            self._play()

    def scan_once(self) -> None:
        """Run a scan without an answer. The test itself plays the controller."""
        super().scan()

    def _play(self) -> None:
        words = self.words
        if words[0] and words[0] != self._out:
            self.sent.append(words)
        self._out = words[0]
        if not words[0]:
            self.answer(0)
        elif words[0] == self.refuse:
            self.answer(0x4000, self.alarm)
        elif words[0] & 0x0FFF in _JOGS:
            self.answer(*((0x0100,) if "SI06" in self.inputs else (0x4000, (12, 400))))
        elif words[0] != self.hold:
            self.answer(0x0200)

    @property
    def codes(self) -> list[int]:
        """Return the command codes of the telegrams in `sent`."""
        return [words[0] for words in self.sent]

    def set(self, *, scans: int = 0, **members: Any) -> None:
        """Write members of the panel, then run scans."""
        for name, value in members.items():
            self[f"Panel.{name}"] = value
        self.scan(scans)

    def key(self, name: str, down: bool = True, *, scans: int = 0) -> None:
        """Press or release a key of the panel, then run scans."""
        self[f"Panel.Key.{name}"] = down
        self.scan(scans)

    def press(self, *names: str, scans: int = 1, then: int = 0) -> None:
        """Press keys for `scans` scans, release them for one scan, and run `then` more scans."""
        for name in names:
            self.key(name)
        self.scan(scans)
        for name in names:
            self.key(name, False)
        self.scan(1 + then)

    def can(self, *names: str) -> list[bool]:
        """Return for each of these keys whether the panel offers it."""
        return [bool(self[f"Panel.Can.{name}"]) for name in names]

    def lamps(self) -> list[str]:
        """Return the names of the panel's lamps that are ON."""
        names: Sequence[str] = (
            *("Connected", "EmergencyStop", "Alarm", "Warning", "ServoOn", "AutoMode", "Origin"),
            *("Running", "Stopped", "Moving", "Busy", "Taught", "Fault"),
        )
        return [name for name in names if self[f"Panel.Lamp.{name}"]]

    @property
    def message(self) -> int:
        """Return the number of the message on the panel."""
        number = self["Panel.MessageID"]
        assert isinstance(number, int)
        return number
