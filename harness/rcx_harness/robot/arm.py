"""The robots of a controller: servo states, settings, and a class `Arm` for each robot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.controller_memory import Memory
from rcx_harness.robot.geometry import Frame
from rcx_harness.robot.kinematics import CARTESIAN, Kinematics, Scara
from rcx_harness.robot.stored import AXES, ROBOTS
from rcx_harness.spec.robots import law

__all__ = ["BRAKE", "FREE", "SERVO", "Arm", "RobotSettings", "Servos", "Settings"]

#: The servo states of an axis, as numbers of the servo status reference (guide, 4.7.3).
BRAKE, SERVO, FREE = 0, 1, 2
#: Numbers of the hand systems in points and commands (guide, 4.2.1).
_RIGHT, _LEFT = 1, 2
#: Indices (from 0) of the two axes that turn the arms of a SCARA robot.
_PLANE = (0, 1)
#: Default of the max. torque command value [%].
_FULL_TORQUE = 100
#: Highest speed of the tool on lines and arcs [mm/s]: of SCARA robots, of all other robots (guide,
#: 4.2.1).
_SCARA_SPEED, _LINE_SPEED = 1000.0, 750.0


class Servos:
    """The motor power and the servo state of each axis; initially off, with all brakes applied.

    Attributes:
        motor_power: Whether the motor power is ON; without it no servo is ON.
        states: BRAKE, SERVO or FREE of each axis of the controller.
    """

    def __init__(self, axes: int) -> None:
        self.motor_power = False
        self.states = [BRAKE] * axes

    def switch_all_on(self) -> None:
        """Switch motor power and all servos ON."""
        self.motor_power = True
        self.set(range(len(self.states)), SERVO)

    def switch_all_off(self, *, keep_free: bool = False) -> None:
        """Switch motor power and servos OFF and apply the brakes.

        With `keep_free`, the brakes of free axes stay open.
        """
        self.motor_power = False
        kept = (FREE,) if keep_free else ()
        self.states = [state if state in kept else BRAKE for state in self.states]

    def set(self, indices: Iterable[int], state: int) -> None:
        """Set the servo state (BRAKE, SERVO or FREE) of the axes with these indices."""
        for index in indices:
            self.states[index] = state

    def are_on(self, indices: Iterable[int]) -> bool:
        """Return whether the servos of all axes with these indices are ON."""
        return all(self.states[index] == SERVO for index in indices)

    @property
    def all_on(self) -> bool:
        """Return whether the servo of every axis is ON."""
        return self.are_on(range(len(self.states)))


@dataclass
class RobotSettings:
    """The settings of one robot (guide, 4.2.8 and 4.2.14 to 4.2.19).

    Speeds are in % (1 to 100), `inching_amount` in pulses or 0.001 mm (1 to 10000). `arm` is the
    arm designation, `arm_status` the current arm: 0 right-handed, 1 left-handed.
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
        torque: Max. torque command value of each axis of the controller [%].
        torque_in_effect: The value of `torque` at the start of the latest movement of each axis
            [%].
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.restore()

    def restore(self) -> None:
        """Restore the configured speeds, amounts, designations and torques."""
        config = self._config
        self._robots = {
            robot: RobotSettings(
                config.manual_speed, config.auto_speed, config.program_speed, config.inching_amount
            )
            for robot in range(1, ROBOTS + 1)
        }
        self.restore_torque()

    def restore_torque(self) -> None:
        """Restore the default torque on every axis."""
        self.torque = [_FULL_TORQUE] * len(self._config.axes)
        self.torque_in_effect = list(self.torque)

    def lose_power(self) -> None:
        """Restore the torques after a loss of power; if so configured, also the other settings."""
        if self._config.power_loses_settings:
            self.restore()
        else:
            self.restore_torque()

    def of(self, robot: int) -> RobotSettings:
        """Return the settings of robot 1 to 4; 0 means robot 1."""
        return self._robots[robot or 1]

    def begin_movement(self, robot: int, indices: Iterable[int]) -> None:
        """Put the changed torques of the axes into effect, because a movement starts."""
        settings = self.of(robot)
        settings.arm_status = settings.arm
        for index in indices:
            self.torque_in_effect[index] = self.torque[index]


class Arm:
    """One robot of the controller: its axes, its position and its settings.

    The argument `place` of the methods is the index of an axis in the robot, 0 to 5.

    The object reads the state of the controller and has no state of its own.

    Attributes:
        number: Number of the robot, 1 to 4.
        indices: Indices of the robot's axes in the controller; empty if the robot does not exist.
        model: The type of the robot, if the robot file names a type.
        scara: Whether the robot is a SCARA robot.
    """

    def __init__(
        self,
        number: int,
        config: RobotConfig,
        memory: Memory,
        settings: Settings,
        positions: Sequence[int],
    ) -> None:
        """Create the robot; `positions` are those of all axes in the controller [pulses]."""
        self.number = number
        self.config = config
        self.indices = config.axes_of(number)
        self.axes = [config.axes[index] for index in self.indices]
        self.model = config.model(number)
        self.scara = self.model.scara if self.model else number in config.scara_robots
        self._settings = settings
        self._memory = memory
        self._positions = positions

    @property
    def settings(self) -> RobotSettings:
        """Return the robot's current settings, which remote commands can change."""
        return self._settings.of(self.number)

    @property
    def here(self) -> tuple[int, ...]:
        """Return the current positions of the robot's axes [pulses]."""
        return tuple(self._positions[index] for index in self.indices)

    @property
    def frame(self) -> Frame:
        """Return the robot's coordinates with the selected shift, hand and current hand system."""
        return self.frame_with(self.hand_system)

    def frame_with(self, hand_system: int) -> Frame:
        """Return the robot's coordinates for a hand system: 1 right-handed, 2 left-handed."""
        hand = self._memory.hand(self.number, self.settings.hand)
        tool = hand.data[:3]
        kinematics: Kinematics = CARTESIAN
        if self.model and self.model.scara:
            arm1, arm2 = (1000 * arm for arm in self.model.arms)
            offset = 0.0
            # a hand that is not on the R axis changes length and angle of arm 2 (guide, 4.3.5)
            if not hand.on_r_axis:
                offset = 1000 * tool[0] / self.axes[1].pulses_per_mm
                arm2, tool = arm2 + tool[1], (0, 0, tool[2])
            kinematics = Scara(arm1, arm2, offset, left=hand_system == _LEFT)
        zeros = tuple(axis.zero for axis in self.axes)
        return Frame(
            tuple(axis.pulses_per_mm for axis in self.axes),
            shift=self._memory.shift(self.settings.shift),
            hand=tool,
            on_r=hand.on_r_axis,
            zeros=zeros if any(zeros) else (),
            kinematics=kinematics,
        )

    @property
    def hand_system(self) -> int:
        """Return the current hand system: 1 right-handed, 2 left-handed.

        If the robot file names the robot's type, the joint angles determine the hand system.
        Otherwise the last command determines it.
        """
        if not (self.model and self.model.scara):
            return _RIGHT + self.settings.arm_status
        bend = self.frame_with(_RIGHT).bend(self.here)
        return _LEFT if bend is not None and bend < 0 else _RIGHT

    @property
    def designated_hand(self) -> int:
        """Return the arm designation, which is the hand system of targets in mm that name none."""
        return _RIGHT + self.settings.arm

    @property
    def line_speed(self) -> float:
        """Return the highest speed of the tool on lines and arcs [mm/s]."""
        return _SCARA_SPEED if self.scara else _LINE_SPEED

    def parameter(self, name: str, place: int) -> int:
        """Return the value of a parameter for one axis of the robot."""
        return self._memory.parameters.get(self.number, name, place)

    def acceleration(self, place: int) -> float:
        """Return the highest acceleration of an axis with the load of WEIGHT [pulses/s^2]."""
        highest = self.axes[place].max_acceleration
        if self.model is None or place >= len(self.model.joints):
            return highest
        load = self.parameter("WEIGHTG", place) / 1000
        return highest * self.model.joints[place].slower(law(), load)

    def pulses_of(self, data: Sequence[int], *, mm: bool, hand: int) -> tuple[int, ...]:
        """Convert point data to pulses of the robot's axes.

        Shift and hand apply only to data in mm.

        With `mm` the data are in 0.001 mm. `hand` is the hand system at the target: 1 right-handed,
        2 left-handed.
        """
        if mm:
            return _rounded(self.frame_with(hand).to_pulses(data))
        return tuple(data[: len(self.axes)])

    def place_pulses(self, place: int, value: int, *, mm: bool) -> int:
        """Convert a coordinate of one axis to pulses; in mm all other coordinates stay constant."""
        if not mm:
            return value
        frame = self.frame
        if not frame.straight:
            if place in _PLANE:
                raise CommandError(self.config.drive_xy_alarm)
            frame = replace(frame, hand=(0, 0, frame.hand[2]))
        position = list(frame.to_mm(self.here))
        position[place] = value
        return round(frame.to_pulses(position)[place])

    def way_pulses(self, place: int, value: int, *, mm: bool) -> int:
        """Convert a distance along one axis to pulses."""
        return round(value * self.axes[place].pulses_per_mm / 1000) if mm else value

    def beyond(self, ways: Mapping[int, float], *, mm: bool, hand: int = 0) -> dict[int, int]:
        """Return the target [pulses] for a change of the coordinates by `ways`.

        The unit of `ways` is pulses, or 0.001 mm with `mm`. In millimetres the coordinates belong
        to the tool, so other axes may have to move as well. `hand` is the hand system at the
        target; 0: the current hand system.
        """
        start = self.here
        if not mm:
            return {place: start[place] + round(way) for place, way in ways.items()}
        frame = self.frame
        position = [value + ways.get(place, 0) for place, value in enumerate(frame.to_mm(start))]
        there = self.frame_with(hand) if hand else frame
        ends = enumerate(_rounded(there.to_pulses(position)))
        return {place: end for place, end in ends if place in ways or end != start[place]}

    def shown(self, *, mm: bool) -> tuple[int, ...]:
        """Return the robot's position as in a response: six axes in pulses or 0.001 mm.

        Axes that the robot does not have are 0, as in the guide's examples.
        """
        values = self.frame.to_mm(self.here) if mm else self.here
        fitting = [max(-(2**31), min(2**31 - 1, round(value))) for value in values]
        return tuple(fitting + [0] * (AXES - len(fitting)))


def _rounded(values: Iterable[float]) -> tuple[int, ...]:
    return tuple(round(value) for value in values)
