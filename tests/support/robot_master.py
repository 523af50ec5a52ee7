"""A master without a PLC. It sets bits and words, and runs controller cycles."""

from __future__ import annotations

import struct
from typing import Any

from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.area import INPUTS, OUTPUTS
from rcx_harness.spec.wire import CYCLE_US

#: The words m to m+30 after a normal end without response data.
NORMAL_END = (0x0200,) + (0,) * 15


def abnormal_end(number: str) -> tuple[int, ...]:
    """Return words m to m+30 of an end with this alarm (`"12.600"`)."""
    group, category = number.split(".")
    return (0x4000, int(group), int(category)) + (0,) * 13


class Master:
    """A master that drives a controller. Keyword arguments are those of RobotConfig.

    All delays are fixed and short by default, so that a test can count cycles.
    """

    def __init__(self, seed: int = 0, **config: Any) -> None:
        self.robot = Controller(RobotConfig(**config), seed)
        self.si = bytearray(self.robot.config.size)
        self.so = bytes(len(self.si))
        self.now_us = 0
        self.connected = True

    def run(self, ms: float, *, idle: bool = False) -> None:
        """Let `ms` pass, in cycles of 5 ms.

        By default a general-purpose input changes in every cycle, and no cycle is skipped. With
        `idle`, no input changes, and the controller skips idle cycles. This is faster.
        """
        for _ in range(round(ms * 1000) // CYCLE_US):
            self.si[45] ^= 0 if idle else 0x80
            self.so = self.robot.cycle(self.now_us, bytes(self.si) if self.connected else None)
            self.now_us += CYCLE_US

    def turn(self, name: str, on: bool) -> None:
        """Change a dedicated input without letting time pass."""
        at, mask = 32 + (INPUTS[name] > 0xFF), INPUTS[name] >> (8 if INPUTS[name] > 0xFF else 0)
        self.si[at] = self.si[at] | mask if on else self.si[at] & ~mask

    def turn_and_wait(self, name: str, on: bool, ms: float = 150) -> None:
        """Change a dedicated input, and wait longer than the interval."""
        self.turn(name, on)
        self.run(ms)

    def pulse(self, name: str, ms: float = 150) -> None:
        """Switch a dedicated input ON, then OFF, each for `ms`."""
        self.turn_and_wait(name, True, ms)
        self.turn_and_wait(name, False, ms)

    def drop(self, name: str, ms: float = 150) -> None:
        """Switch a dedicated input OFF, then ON again, each for `ms`."""
        self.turn_and_wait(name, False, ms)
        self.turn_and_wait(name, True, ms)

    def general_on(self, number: int) -> None:
        """Turn one of SI(20) to SI(27) ON, and let two cycles pass."""
        self.si[34] |= 1 << number - 20
        self.run(10)

    def on(self, name: str) -> bool:
        """Return whether a dedicated output is ON."""
        return bool((self.so[32] | self.so[33] << 8) & OUTPUTS[name])

    def send(self, *words: int) -> None:
        """Set words n, n+2 and so on; the rest of n to n+30 becomes 0."""
        struct.pack_into("<16H", self.si, 0, *(words + (0,) * (16 - len(words))))

    @property
    def words(self) -> tuple[int, ...]:
        """Return words m to m+30 as the controller sends them."""
        return struct.unpack_from("<16H", self.so)

    @property
    def status(self) -> int:
        """Return word m, the remote status."""
        return self.words[0]

    def finish(self, within_ms: float = 5000) -> tuple[int, ...]:
        """Let the command end, and return words m to m+30."""
        for _ in range(round(within_ms) // 5):
            self.run(5)
            if self.status in (0x0200, 0x4000):
                return self.words
        raise AssertionError(
            f"the command did not end within {within_ms} ms; status 0x{self.status:04X}"
        )

    def execute(self, *words: int) -> tuple[int, ...]:
        """Send a command, let it end, return words m to m+30 at its end, and reset the status."""
        self.send(*words)
        answer = self.finish()
        self.send()
        self.run(50)
        assert self.status == 0
        return answer

    def power_up(self) -> None:
        """Wait until the controller has booted, then switch SI(00) and SI(06) ON."""
        self.run(300, idle=True)
        for name in ("SI00", "SI06"):
            self.turn(name, True)
            self.run(150, idle=True)

    def servo_on(self) -> None:
        """Power up, and switch the servos on."""
        self.power_up()
        for on in (True, False):
            self.turn("SI01", on)
            self.run(150, idle=True)
        assert self.on("SO02")

    def texts(self) -> list[str]:
        """Return the violations since the last call as `rule: text`."""
        return [f"{found.rule}: {found.text}" for found in self.robot.drain_violations()]


def powered_up(**config: Any) -> Master:
    """Return the master of a robot with these properties that is powered up."""
    master = Master(**config)
    master.power_up()
    return master


def servos_on(**config: Any) -> Master:
    """Return the master of a robot with these properties, with its servos on."""
    master = Master(**config)
    master.servo_on()
    return master


def answer_of(master: Master, *words: int) -> tuple[int, ...]:
    """Send a command, and return words m+2 to m+30 of its normal end."""
    status, *response = master.execute(*words)
    assert status == 0x0200
    return tuple(response)
