"""The robots of a controller: servos, what commands set for each, and each robot as one `Arm`."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

from rcx_harness.robot.alarms import CommandError
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.geometry import Frame
from rcx_harness.robot.kinematics import CARTESIAN, Scara
from rcx_harness.robot.memory import Memory
from rcx_harness.robot.stored import AXES, ROBOTS
from rcx_harness.spec.robots import law

__all__ = ["BRAKE", "FREE", "SERVO", "Arm", "RobotSettings", "Servos", "Settings"]

#: Servo state of an axis, as the servo status reference answers it (guide, 4.7.3).
BRAKE, SERVO, FREE = 0, 1, 2
#: Hand systems, as points and commands have them (guide, 4.2.1).
_RIGHT, _LEFT = 1, 2
#: Places of the axes that turn the arms of a SCARA robot.
_PLANE = (0, 1)
#: The max. torque command value that the parameter gives [%].
_FULL_TORQUE = 100
#: Highest speed of the tool on lines and arcs [mm/s]: SCARA robots, all others (guide, 4.2.1).
_SCARA_SPEED, _LINE_SPEED = 1000.0, 750.0


class Servos:
    """All off and braked at first.

    Attributes:
        motor_power: The motor power is ON; without it no servo is.
        states: Per index into the axes: BRAKE, SERVO or FREE.
    """

    def __init__(self, axes: int) -> None:
        self.motor_power = False
        self.states = [BRAKE] * axes

    def switch_all_on(self) -> None:
        """Motor power with all servos ON."""
        self.motor_power = True
        self.set(range(len(self.states)), SERVO)

    def switch_all_off(self, *, keep_free: bool = False) -> None:
        """Motor power and all servos OFF, with all brakes, or all but those of free axes."""
        self.motor_power = False
        kept = (FREE,) if keep_free else ()
        self.states = [state if state in kept else BRAKE for state in self.states]

    def set(self, indices: Iterable[int], state: int) -> None:
        """Bring these axes to a state."""
        for index in indices:
            self.states[index] = state

    def are_on(self, indices: Iterable[int]) -> bool:
        """The servo of each of these axes is on."""
        return all(self.states[index] == SERVO for index in indices)

    @property
    def all_on(self) -> bool:
        """The servo of every axis is on."""
        return self.are_on(range(len(self.states)))


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


class Arm:
    """One robot of the controller: its axes by their places, 0 to 5, where it is and how it is set.

    It looks at the controller's state and has none of its own.

    Attributes:
        number: 1 to 4.
        config: The controller's properties.
        indices: Of its axes in those of the controller; none if there is no such robot.
        axes: What they are like.
        model: Its type, if the robot file names one.
        scara: It is a SCARA robot.
    """

    def __init__(
        self,
        number: int,
        config: RobotConfig,
        memory: Memory,
        settings: Settings,
        positions: Sequence[int],
    ) -> None:
        """`positions` are those of all axes of the controller [pulses]."""
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
        """What commands have set for it."""
        return self._settings.of(self.number)

    @property
    def here(self) -> tuple[int, ...]:
        """Where its axes are [pulses]."""
        return tuple(self._positions[index] for index in self.indices)

    @property
    def frame(self) -> Frame:
        """Its coordinates, with the selected shift and hand, and the arm as it stands."""
        return self.frame_with(self.hand_system)

    def frame_with(self, hand_system: int) -> Frame:
        """Its coordinates, with the arm in that hand system: 1 right-handed, 2 left-handed."""
        hand = self._memory.hand(self.number, self.settings.hand)
        tool, kinematics = hand.data[:3], CARTESIAN
        if self.model and self.model.scara:
            arm1, arm2 = (1000 * arm for arm in self.model.arms)
            offset = 0.0
            if not hand.on_r_axis:  # a hand beside the R axis makes another arm 2 (guide, 4.3.5)
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
        """The arm as it stands: 1 right-handed, 2 left-handed.

        Where the file names the type it is where the joints are, else what was told last.
        """
        if not (self.model and self.model.scara):
            return _RIGHT + self.settings.arm_status
        bend = self.frame_with(_RIGHT).bend(self.here)
        return _LEFT if bend is not None and bend < 0 else _RIGHT

    @property
    def designated_hand(self) -> int:
        """The hand system of a target in millimetres that has none: the arm designation."""
        return _RIGHT + self.settings.arm

    @property
    def line_speed(self) -> float:
        """The highest speed of the tool on lines and arcs [mm/s]."""
        return _SCARA_SPEED if self.scara else _LINE_SPEED

    def parameter(self, name: str, place: int) -> int:
        """The parameter of one of its axes."""
        return self._memory.parameters.get(self.number, name, place)

    def acceleration(self, place: int) -> float:
        """The highest one of an axis, with the load of the parameter WEIGHT [pulses/s^2]."""
        highest = self.axes[place].max_acceleration
        if self.model is None or place >= len(self.model.joints):
            return highest
        load = self.parameter("WEIGHTG", place) / 1000
        return highest * self.model.joints[place].slower(law(), load)

    def pulses_of(self, data: Sequence[int], *, mm: bool, hand: int) -> tuple[int, ...]:
        """Point data as pulses of its axes; pulses know no shift and no hand.

        Args:
            data: Of each axis, at least as many as it has.
            mm: They are in 0.001 mm.
            hand: With which hand system it is to come there: 1 right-handed, 2 left-handed.

        Raises:
            UnreachableError: it cannot come there.
        """
        if mm:
            return _rounded(self.frame_with(hand).to_pulses(data))
        return tuple(data[: len(self.axes)])

    def place_pulses(self, place: int, value: int, *, mm: bool) -> int:
        """A coordinate of one axis as pulses; in mm the others are those of the robot now.

        Raises:
            CommandError: no single axis of this robot is that coordinate.
        """
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
        """The way of one axis as pulses, along that axis."""
        return round(value * self.axes[place].pulses_per_mm / 1000) if mm else value

    def beyond(self, ways: Mapping[int, float], *, mm: bool, hand: int = 0) -> dict[int, int]:
        """The target when each of these coordinates changes by its way [pulses or 0.001 mm].

        In millimetres these are the coordinates of the tool; other axes may have to move for them.
        `hand` is the hand system there, 0: as it stands.

        Raises:
            UnreachableError: it cannot come there.
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
        """Its position as a response has it: six axes in pulses or 0.001 mm.

        Axes that the robot does not have are 0, as in the guide's examples.
        """
        values = self.frame.to_mm(self.here) if mm else self.here
        fitting = [max(-(2**31), min(2**31 - 1, round(value))) for value in values]
        return tuple(fitting + [0] * (AXES - len(fitting)))


def _rounded(values: Iterable[float]) -> tuple[int, ...]:
    return tuple(round(value) for value in values)
