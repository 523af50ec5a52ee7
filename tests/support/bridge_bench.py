"""PLC, bridge and robot in one process: real Modbus TCP and EtherNet/IP in virtual time.

A step is a scan of the PLC of 20 ms: the PLC scans, the bridge makes its exchange, the packets of
both directions arrive, and four cycles of the controller pass. The bench waits for packets by
polling the receiver. Virtual time does not depend on the length of this wait.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from typing import Any

from modbus_plc import ModbusPlc
from rcx_harness.bridge.core import Actions, Limits, Registers, State
from rcx_harness.bridge.loop import Loop, RobotLink
from rcx_harness.bridge.plc import PlcLink
from rcx_harness.enip.options import AdapterOptions
from rcx_harness.enip.originator.scanner import Scanner
from rcx_harness.enip.target.adapter import Adapter
from rcx_harness.robot import Controller, RobotConfig
from rcx_harness.serve.station import Station
from rcx_harness.spec.wire import CYCLE_US

_SCAN_US = 20_000
_RPI_US = 2_000
_PAUSE_S = 0.001
_MOST_POLLS = 60_000


class BridgeBench:
    """A bench with robot and PLC; the bridge has not exchanged data yet.

    Args:
        scan: A function for a scan of the PLC at a time [us], which writes its registers.
        multiplier: Coded multiplier of the cyclic connection's time-out.

    Attributes:
        scan: The function for a scan of the PLC. A test may replace it.
        plc: The Modbus server of the PLC.
        controller: The robot.
        adapter: The robot's end of the network.
        loop: The bridge.
        news: The bridge's changes of state.
        last: The bridge's last actions.
    """

    def __init__(
        self,
        scan: Callable[[int, dict[int, int]], None],
        registers: Registers | None = None,
        multiplier: int = 5,
        robot: Mapping[str, Any] | None = None,
    ) -> None:
        registers = registers or Registers()
        self.now_us = 0
        self.news: list[State] = []
        self.scan = scan
        self._cycle_us = 0
        self._pause = threading.Event()
        config = RobotConfig(size=registers.size, boot_time=100, **dict(robot or {}))
        self.controller = Controller(config)
        options = AdapterOptions(rpi_min_us=1_000)
        self.adapter = Adapter(registers.size, cyclic=0, options=options)
        self.plc = ModbusPlc()
        self.station = Station(self.controller, self.adapter.shared)

        def connect() -> Scanner:
            host, port = self.adapter.address
            return Scanner(
                *(host, registers.size, _RPI_US), port=port, io_port=0, multiplier=multiplier
            )

        self.robot = RobotLink("robot", registers.size, connect)
        link = PlcLink("127.0.0.1", self.plc.port, registers, timeout_s=30.0)
        self._link = link
        self.loop = Loop(
            *(link, self.robot, registers, Limits()),
            on_state=lambda state, reason: self.news.append(state),
            clock_us=lambda: self.now_us,
        )
        self.last: Actions | None = None

    def step(self, steps: int = 1) -> None:
        """Run scans of the PLC, and run the bridge and the robot in the meantime."""
        for _ in range(steps):
            self.now_us += _SCAN_US
            with self.plc.between_scans() as holds:
                self.scan(self.now_us, holds)
            self.last = actions = self.loop.turn()
            self._packets(actions.to_robot)
            while self._cycle_us < self.now_us:
                self.station.step(self._cycle_us)
                self._cycle_us += CYCLE_US
            self._packets(actions.to_robot)

    def until(self, what: Callable[[], bool], most: int = 500) -> None:
        """Run scans of the PLC until the condition holds, at most `most`."""
        for _ in range(most):
            if what():
                return
            self.step()
        raise AssertionError(f"not within {most} scans; {self.loop.state}: {self.loop.reason}")

    def close(self) -> None:
        """End everything."""
        self._link.close()
        self.robot.close()
        self.adapter.close()
        self.plc.close()

    def __enter__(self) -> BridgeBench:
        """Return the started bench."""
        return self

    def __exit__(self, *_: object) -> None:
        """End everything."""
        self.close()

    def _packets(self, to_robot: bytes) -> None:
        """Wait until the areas of both directions have arrived.

        Without a connection, return at once.
        """
        for _ in range(_MOST_POLLS):
            seen = self.robot.read()
            if not isinstance(seen, bytes):
                return
            there = self.adapter.shared.to_robot.read() == to_robot
            if there and seen == self.adapter.shared.to_master.read():
                return
            self._pause.wait(_PAUSE_S)
        raise AssertionError("the packets of a step did not arrive")
