"""A master that drives a served controller over a real cyclic connection.

The controller's time is virtual: each poll is a cycle of 5 ms, however long it takes. Waits on the
network poll, too, with limits that only a failure reaches.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.robot.area import INPUTS, OUTPUTS
from rcx_harness.serve.station import Station
from rcx_harness.spec.wire import CYCLE_US

#: Longest wait for a condition [controller cycles]. A cycle takes a millisecond or more of real
#: time.
_MOST_CYCLES = 20_000
_PAUSE_S = 0.001
_INTERVAL_CYCLES = 30


class LiveMaster:
    """A master with adapter, controller and scanner. Keyword arguments are those of RobotConfig.

    Attributes:
        robot: The controller.
        station: The controller on its network.
        scanner: The scanner of the master. The test opens its connection.
    """

    def __init__(self, multiplier: int = 5, **config: Any) -> None:
        self.robot = Controller(RobotConfig(**config))
        self.si = bytearray(self.robot.config.size)
        self._now_us = 0
        self._pause = threading.Event()
        self.adapter = Adapter(self.robot.config.size, cyclic=0)
        try:
            self.station = Station(self.robot, self.adapter.shared)
            self.scanner = self.connect(multiplier)
        except BaseException:
            self.adapter.close()
            raise

    def connect(self, multiplier: int = 5, **options: Any) -> Scanner:
        """Return another scanner for the same adapter. Its connection is not open yet."""
        host, port = self.adapter.address
        size = self.robot.config.size
        return Scanner(host, size, port=port, io_port=0, multiplier=multiplier, **options)

    def cycle(self, cycles: int = 1) -> None:
        """Let controller cycles pass; the network gets a millisecond for each."""
        for _ in range(cycles):
            self.station.step(self._now_us)
            self._now_us += CYCLE_US
            self._pause.wait(_PAUSE_S)

    def until(self, what: Callable[[], bool]) -> None:
        """Run controller cycles until the condition holds."""
        for _ in range(_MOST_CYCLES):
            if what():
                return
            self.cycle()
        raise AssertionError(f"no success in {_MOST_CYCLES} cycles; {self.station.report()}")

    def on(self, name: str) -> bool:
        """Return whether a dedicated output is ON, as the master receives it."""
        area = self.scanner.read().image
        return bool((area[32] | area[33] << 8) & OUTPUTS[name])

    def shows(self, name: str) -> bool:
        """Return whether a dedicated output is ON, as the controller sends it."""
        area = self.adapter.shared.to_master.read()
        return bool((area[32] | area[33] << 8) & OUTPUTS[name])

    def turn(self, name: str, on: bool) -> None:
        """Change a dedicated input, and wait for the minimum interval until the next change."""
        mask = INPUTS[name]
        word = self.si[32] | self.si[33] << 8
        self.si[32:34] = (word | mask if on else word & ~mask).to_bytes(2, "little")
        wanted = bytes(self.si)
        self.scanner.write(wanted)
        self.until(lambda: self.adapter.read_to_robot() == wanted)
        self.cycle(_INTERVAL_CYCLES)

    def pulse(self, name: str) -> None:
        """Switch a dedicated input ON, then OFF."""
        self.turn(name, True)
        self.turn(name, False)

    def servo_on(self) -> None:
        """Connect and switch the servos on (manual chapter 5, 3.1)."""
        self.until(lambda: self.robot.online)
        self.scanner.write(bytes(self.si))
        self.scanner.open()
        self.until(lambda: self.scanner.read().connected and self.connected)
        self.turn("SI00", True)
        self.turn("SI06", True)
        self.pulse("SI01")
        self.until(lambda: self.on("SO02"))

    @property
    def connected(self) -> bool:
        """Return whether the controller has a connection."""
        return self.station.report().si != ""

    @property
    def alarms(self) -> list[str]:
        """Return the numbers of the active alarms."""
        return [alarm.number for alarm in self.robot.alarms.active]

    def close(self) -> None:
        """Close the scanner and the adapter."""
        self.scanner.close()
        self.adapter.close()
