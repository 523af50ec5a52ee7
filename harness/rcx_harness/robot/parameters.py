"""The parameters that remote commands reach (guide, 4.4.2): per robot, and per axis."""

from __future__ import annotations

from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import ROBOT_PARAMETERS, ROBOTS

__all__ = ["Parameters"]

#: Values as delivered; the manual gives none.
_DEFAULTS = {
    "WEIGHTG": 0,
    "ACCEL": 100,
    "DECEL": 100,
    "TOLE": 80,
    "OUTPOS": 2000,
    "AXWGHT": 0,
    "ARCHP1": 2000,
    "ARCHP2": 2000,
    "PSHFRC": 100,
    "PSHTIME": 1000,
    "PSHMTD": 0,
    "PSHJGSP": 0,
    "PSHSPD": 100,
}
_GRAMS = 1000


class Parameters:
    """The parameters of all robots and axes; a robot's two payloads are one, in kg and in g."""

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self._values: dict[tuple[str, int], int] = {}
        for name, given in config.parameters.items():
            count = ROBOTS if name in ROBOT_PARAMETERS else len(config.axes)
            every = given if isinstance(given, tuple) else (given,) * count
            for place, value in enumerate(every):
                self._put(name, place, value)

    def get(self, robot: int, name: str, axis: int = 0) -> int:
        """A value as in the guide's table; robot 0 is robot 1, `axis` is 0 to 5 in the robot."""
        place = self._place(robot, name, axis)
        if name == "WEIGHT":
            return self.get(robot, "WEIGHTG") // _GRAMS
        return self._values.get((name, place), _DEFAULTS[name])

    def set(self, robot: int, name: str, value: int, axis: int = 0) -> None:
        """Store a value; its range is the caller's."""
        self._put(name, self._place(robot, name, axis), value)

    def _put(self, name: str, place: int, value: int) -> None:
        if name == "WEIGHT":
            name, value = "WEIGHTG", value * _GRAMS
        self._values[name, place] = value

    def _place(self, robot: int, name: str, axis: int) -> int:
        """The robot's index, or the axis' index into the controller's axes."""
        if name in ROBOT_PARAMETERS:
            return (robot or 1) - 1
        return self._config.axes_of(robot)[axis]
