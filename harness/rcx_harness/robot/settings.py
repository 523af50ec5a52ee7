"""What remote commands set per robot and axis: speeds, designations, inching amount, torque."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import ROBOTS

__all__ = ["RobotSettings", "Settings"]

#: The max. torque command value that the parameter gives [%].
_FULL_TORQUE = 100


@dataclass
class RobotSettings:
    """The settings of one robot (guide, 4.2.8 and 4.2.14 to 4.2.19).

    Speeds are in % (1 to 100), `inching_amount` in pulses or 0.001 mm (1 to 10000). `arm` is the
    arm designation, `arm_status` the arm as it stands: 0 right-handed, 1 left-handed.
    """

    manual_speed: int
    auto_speed: int
    program_speed: int
    inching_amount: int
    shift: int = 0
    hand: int = 0
    arm: int = 0
    arm_status: int = 0


class Settings:
    """The settings of all robots.

    Attributes:
        torque: Per index into the axes: max. torque command value [%].
        torque_in_effect: Per index: the one that the axis' last movement took over [%].
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.restore()

    def restore(self) -> None:
        """As configured: speeds, amounts, designations, torque."""
        config = self._config
        self._robots = {
            robot: RobotSettings(
                config.manual_speed, config.auto_speed, config.program_speed, config.inching_amount
            )
            for robot in range(1, ROBOTS + 1)
        }
        self.restore_torque()

    def restore_torque(self) -> None:
        """The parameter's torque counts again on every axis."""
        self.torque = [_FULL_TORQUE] * len(self._config.axes)
        self.torque_in_effect = list(self.torque)

    def lose_power(self) -> None:
        """The torque is lost; what else is, the configuration says."""
        if self._config.power_loses_settings:
            self.restore()
        else:
            self.restore_torque()

    def of(self, robot: int) -> RobotSettings:
        """The settings of robot 1 to 4; robot 0 is robot 1."""
        return self._robots[robot or 1]

    def begin_movement(self, robot: int, indices: Iterable[int]) -> None:
        """A movement of these axes starts: what waited for it comes into effect."""
        settings = self.of(robot)
        settings.arm_status = settings.arm
        for index in indices:
            self.torque_in_effect[index] = self.torque[index]
