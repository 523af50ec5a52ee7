"""A cell for tests of sentences in the manual: library blocks, a robot and a signal history."""

from __future__ import annotations

from typing import Any

from rcx_harness import Cell
from rcx_harness.cell.clock import Timing
from rcx_harness.cell.link import DirectLink
from rcx_harness.robot import Controller, RobotConfig, RobotProgram
from rcx_harness.robot.area import INPUTS, OUTPUTS
from structured_text.engines.base import Program, Value


def steps_once(*steps: str) -> dict[str, Any]:
    """Return the properties of a robot whose program runs these steps once."""
    return {"programs": (RobotProgram(steps=steps, loop=False),)}


class ChapterCell:
    """The program Chapters.st in a cell.

    Scans and packets both come every 10 ms, the first at time 0.
    """

    def __init__(self, program: Program, initial: object, config: RobotConfig, size: int) -> None:
        program.restore(initial)
        timing = Timing.make(scan="10ms", rpi="10ms")
        self.cell = Cell(program, Controller(config), DirectLink(size), timing)
        self.robot = self.cell.robot
        self["Size"] = size

    def __getitem__(self, path: str) -> Value:
        return self.cell[f"Main.{path}"]

    def __setitem__(self, path: str, value: Value) -> None:
        self.cell[f"Main.{path}"] = value

    def run(self, duration: str) -> None:
        """Let time pass."""
        self.cell.run(duration)

    def run_short_program(self) -> None:
        """Start a program that ends before the PLC can read SO(13) ON."""
        self.settle()
        self["AutoStart.Timeout"] = "T#200ms"
        self.execute("AutoStart")

    def on(self, output: str) -> bool:
        """Return whether a dedicated output such as `SO02` is ON, as the PLC has read it."""
        low, high = (int(str(self[f"InputArea[{at}]"])) for at in (32, 33))
        return bool((low | high << 8) & OUTPUTS[output])

    def is_on(self, *outputs: str) -> tuple[bool, ...]:
        """Return whether all these dedicated outputs are ON."""
        return tuple(self.on(output) for output in outputs)

    def wait(self, output: str, on: bool = True) -> None:
        """Let time pass until a dedicated output has this value, as the PLC reads it."""
        self.cell.run_until(lambda: self.on(output) is on, within="3s")

    def execute(self, block: str, within: str = "8s") -> int:
        """Run a block to its end by an edge of Execute, reset Execute, and return the ErrorID."""
        self[f"{block}.Execute"] = True
        ended = (f"{block}.Done", f"{block}.Error")
        self.cell.run_until(lambda: any(self[path] is True for path in ended), within=within)
        error = self[f"{block}.ErrorID"]
        self[f"{block}.Execute"] = False
        self.cell.scan(2)
        assert isinstance(error, int)
        return error

    def return_to_origin(self, axes: str) -> int:
        """Return these axes to their origin, and return the ErrorID of the block."""
        self["Axes"], self["ReturnToOrigin.Timeout"] = axes, "T#2s"
        return self.execute("ReturnToOrigin")

    def settle(self) -> ChapterCell:
        """Power on, and wait until SI(00) and SI(06) are ON and the robot has answered them."""
        self.cell.run_until(lambda: self["Robot.Settled"] is True, within="2s")
        self.run("200ms")
        return self

    def servo_on(self) -> ChapterCell:
        """Power on, and switch the servos on."""
        self.settle()
        assert self.execute("ServoOn") == 0
        return self

    def program(self) -> ChapterCell:
        """Power on, switch the servos on, and start the program."""
        self.servo_on()
        assert self.execute("ProgramReset") == 0
        assert self.execute("AutoStart") == 0
        return self

    def from_now(self) -> int:
        """Wait until the cell is idle, and return the time for a later call of `steps`."""
        self.run("500ms")
        return self.cell.now_us

    def steps_of(self, block: str) -> list[str]:
        """Run a block to its end without an error.

        Return the signal changes until the cell is idle.
        """
        since = self.from_now()
        assert self.execute(block) == 0
        self.from_now()
        return self.steps(since)

    def alarms(self) -> list[str]:
        """Return the active alarms."""
        return [alarm.number for alarm in self.robot.alarms.active]

    def steps(self, since_us: int) -> list[str]:
        """Return the signal changes at the controller after a time, as `SI01 ON`, `SO02 ON`.

        Outputs that change in the same controller cycle share an entry, and so do inputs.
        """
        before: tuple[int, int] | None = None
        found = []
        for one in self.cell.trace.cycles():
            inputs = one.rcx_si or bytes(34)
            now = (inputs[32] | inputs[33] << 8, one.rcx_so[32] | one.rcx_so[33] << 8)
            if before is not None and one.t_us > since_us:
                for names, old, new in zip((INPUTS, OUTPUTS), before, now, strict=True):
                    changed = [name for name, mask in names.items() if (old ^ new) & mask]
                    if changed:
                        found.append(
                            ", ".join(
                                f"{name} {'ON' if new & names[name] else 'OFF'}" for name in changed
                            )
                        )
            before = now
        return found
