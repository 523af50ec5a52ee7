"""What the controller knows of itself: clock, torques, accumulated data, real time output."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcx_harness.robot.accumulated import Accumulated
from rcx_harness.robot.clock import Clock
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.realtime import RealTimeOutput
from rcx_harness.robot.torques import Torques

if TYPE_CHECKING:
    from rcx_harness.robot.machine import Machine

__all__ = ["Data"]


class Data:
    """It looks at the machine once in a cycle and changes nothing of it; kept without power."""

    def __init__(self, config: RobotConfig) -> None:
        positions = [axis.start for axis in config.axes]
        self.clock = Clock(config.clock)
        self.torques = Torques(positions)
        self.accumulated = Accumulated(positions)
        self.real_time = RealTimeOutput()

    def observe(self, machine: Machine) -> None:
        """The end of a cycle with the power ON."""
        self.torques.observe(machine.positions)
        self.accumulated.observe(machine.now_us, machine.positions, machine.servos)
        self.real_time.observe(machine)

    def next_due_us(self) -> int | None:
        """When there is something to look at although nothing else happens."""
        return self.real_time.next_due_us()
