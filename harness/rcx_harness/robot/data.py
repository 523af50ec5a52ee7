"""The controller's data about itself: clock, torques, accumulated data, real time output."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta

from rcx_harness.robot.arm import SERVO, Servos, Settings
from rcx_harness.robot.config import RobotConfig
from rcx_harness.robot.stored import HIGH_WORD, QUANTITIES_OF_AXIS
from rcx_harness.spec.wire import EXTENDED_SIZE

__all__ = ["Data", "Definition"]

_CENTURY = 2000  # only the lower two digits of a year go over the wire
_HIGHEST_OF_RATED = 1000
_S = 1_000_000  # [us]


class Clock:
    """Date and time of the controller, which advance with virtual time.

    The clock shows `start` at time 0. It also runs while the controller is switched off.
    """

    def __init__(self, start: str) -> None:
        self._zero = datetime.fromisoformat(start)

    def now(self, now_us: int) -> datetime:
        """Return date and time at `now_us`, without fractions of a second."""
        return (self._zero + timedelta(microseconds=now_us)).replace(microsecond=0)

    def set_date(self, now_us: int, year: int, month: int, day: int) -> None:
        """Change the date; the time continues.

        `year` has the lower two digits of a year from 2000 on.
        """
        shown = self._zero + timedelta(microseconds=now_us)
        self._set(now_us, datetime.combine(date(_CENTURY + year, month, day), shown.time()))

    def set_time(self, now_us: int, hour: int, minute: int, second: int) -> None:
        """Set the clock to the beginning of the given second; the date does not change."""
        today = self.now(now_us).date()
        self._set(now_us, datetime.combine(today, time(hour, minute, second)))

    def _set(self, now_us: int, moment: datetime) -> None:
        self._zero = moment - timedelta(microseconds=now_us)


class Torques:
    """Current torque of each axis, by a simple model.

    With the servo off the torque is 0. At rest it is the holding torque. During a movement the
    moving torque is added in the direction of the movement. Both values come from the
    configuration. The max. torque command value limits the sum.

    Attributes:
        directions: Direction of each axis in the last cycle: -1, 0 or 1.
    """

    def __init__(self, config: RobotConfig, servos: Servos, settings: Settings) -> None:
        self._config, self._servos, self._settings = config, servos, settings
        self._before = [axis.start for axis in config.axes]
        self.directions = [0] * len(config.axes)

    def observe(self, positions: Sequence[int]) -> None:
        """Update `directions`; called once in a cycle, after the axes have moved."""
        if positions == self._before and not any(self.directions):
            return
        pairs = zip(positions, self._before, strict=True)
        self.directions = [(now > before) - (now < before) for now, before in pairs]
        self._before = list(positions)

    def of_max(self, index: int) -> int:
        """Return the torque of an axis relative to the maximum torque, -100 to 100 [%]."""
        if self._servos.states[index] != SERVO:
            return 0
        axis = self._config.axes[index]
        torque = axis.holding_torque + self.directions[index] * axis.moving_torque
        limit = self._settings.torque_in_effect[index]
        return max(-limit, min(limit, torque))

    def of_rated(self, index: int) -> int:
        """Return the torque of an axis relative to the rated torque, -1000 to 1000 [%]."""
        share = self.of_max(index) * 100 / self._config.axes[index].rated_torque
        return max(-_HIGHEST_OF_RATED, min(_HIGHEST_OF_RATED, round(share)))


class Accumulated:
    """Counts, times and distances that survive a power cycle; commands reset them (guide, 4.8).

    Attributes:
        servo_on_counts: For each axis, how often its servo was switched ON.
        servo_on_us: For each axis, how long its servo was ON [us].
        distances: Moving distance of each axis [pulses].
        power_on_count: How often the controller was switched ON.
        motor_power_on_count: How often the motor power was switched ON.
        operating_us: How long the controller was ON [us].
    """

    def __init__(self, positions: list[int]) -> None:
        self._positions = list(positions)
        self._states: list[int] = []
        self._servo_on: list[int] = []
        self._motor_power = False
        self._since_us: int | None = None
        self.servo_on_counts = [0] * len(positions)
        self.servo_on_us = [0] * len(positions)
        self.distances = [0] * len(positions)
        self.power_on_count = self.motor_power_on_count = self.operating_us = 0

    def power_on(self) -> None:
        """Count a power-on of the controller."""
        self.power_on_count += 1
        self._since_us = None

    def observe(self, now_us: int, positions: list[int], servos: Servos) -> None:
        """Update the data; called in every cycle that is not skipped, while the power is ON."""
        if self._since_us is not None:
            passed_us = now_us - self._since_us
            self.operating_us += passed_us
            for index in self._servo_on:
                self.servo_on_us[index] += passed_us
        self._since_us = now_us
        if positions != self._positions:
            for index, (now, before) in enumerate(zip(positions, self._positions, strict=True)):
                self.distances[index] += abs(now - before)
            self._positions = list(positions)
        if servos.states != self._states:
            servo_on = [index for index, state in enumerate(servos.states) if state == SERVO]
            for index in servo_on:
                self.servo_on_counts[index] += index not in self._servo_on
            self._servo_on = servo_on
            self._states = list(servos.states)
        self.motor_power_on_count += servos.motor_power and not self._motor_power
        self._motor_power = servos.motor_power

    def reset_motors(self, indices: Iterable[int], item: int = 0) -> None:
        """Reset accumulated data of the axes with these indices.

        `item` is 1 for the servo ON count, 2 for the servo ON time, 3 for the moving distance, 0
        for all three.
        """
        kinds = {1: self.servo_on_counts, 2: self.servo_on_us, 3: self.distances}
        for values in kinds.values() if item == 0 else (kinds[item],):
            for index in indices:
                values[index] = 0

    def reset_system(self, item: int = 0) -> None:
        """Reset accumulated data of the controller.

        `item` is 1 for the power ON count, 2 for the motor power ON count, 3 for the operating
        time, 0 for all three.
        """
        names = ("power_on_count", "motor_power_on_count", "operating_us")
        for name in names if item == 0 else (names[item - 1],):
            setattr(self, name, 0)


@dataclass(frozen=True)
class Definition:
    """The definition of a word of the real time output: the number of an item and its options.

    The options of an axis item are the numbers of the robot and of the axis.
    """

    item: int = 0
    option1: int = 0
    option2: int = 0

    def name(self, config: RobotConfig) -> str:
        """Return the name of the quantity; empty if the configuration has no name for the item."""
        return config.real_time_items.get(self.item, "")

    def axis(self, config: RobotConfig) -> int | None:
        """Return the index of the axis that the options name; None if it does not exist."""
        every = config.axes_of(self.option1) if self.option1 else ()
        return every[self.option2 - 1] if 1 <= self.option2 <= len(every) else None

    def sound(self, config: RobotConfig) -> bool:
        """Return whether the definition is valid: its axis exists, or its item needs no axis."""
        of_axis = self.name(config).removesuffix(HIGH_WORD) in QUANTITIES_OF_AXIS
        return not of_axis or self.axis(config) is not None


class RealTimeOutput:
    """The real time output: its definitions and its current words.

    Attributes:
        enabled: Whether the words are output.
        definitions: Definition of each word by its number, 24 to 127.
    """

    def __init__(self, config: RobotConfig) -> None:
        self._config = config
        self.enabled = False
        self.definitions: dict[int, Definition] = {}
        self.words: dict[int, int] = {}
        self._due_us = 0

    def define(self, word: int, definition: Definition) -> None:
        """Define a word; the definition takes effect at the next update."""
        self.definitions[word] = definition
        self._due_us = 0

    def enable(self, enabled: bool) -> None:
        """Start or stop the output. While the output is stopped, robot programs use the words."""
        self.enabled = enabled
        self._due_us = 0
        if not enabled:
            self.words.clear()

    def next_due_us(self) -> int | None:
        """Return the time of the next update [us]; None if no word is output."""
        return self._due_us if self.enabled and self.definitions else None

    def observe(self, now_us: int, read: Callable[[str, int], int]) -> None:
        """Update the words at the interval of the configuration.

        `read` is a function that returns a word for the name of a quantity and the index of an
        axis. The word of an item without a name is 0.
        """
        config = self._config
        if not self.enabled or now_us < self._due_us or config.size < EXTENDED_SIZE:
            return
        named = (
            (word, one.name(config), one.axis(config)) for word, one in self.definitions.items()
        )
        self.words = {word: read(name, axis or 0) if name else 0 for word, name, axis in named}
        self._due_us = now_us + round(config.real_time_interval * 1000)

    def lay_over(self, area: bytearray) -> None:
        """Write the defined words into an output area."""
        for word, value in self.words.items():
            struct.pack_into("<H", area, 2 * word, value)


class Data:
    """Clock, torques, accumulated data and real time output of one controller.

    They survive a power cycle. The object reads the state of the robots once in a cycle and never
    changes it.
    """

    def __init__(
        self, config: RobotConfig, positions: list[int], servos: Servos, settings: Settings
    ) -> None:
        """Create the data from the `positions`, `servos` and `settings` of the robots."""
        self._config, self._positions, self._servos = config, positions, servos
        self.clock = Clock(config.clock)
        self.torques = Torques(config, servos, settings)
        self.accumulated = Accumulated(positions)
        self.real_time = RealTimeOutput(config)

    def observe(self, now_us: int) -> None:
        """Update all data at the end of a cycle with the power ON."""
        self.torques.observe(self._positions)
        self.accumulated.observe(now_us, self._positions, self._servos)
        self.real_time.observe(now_us, self.quantity)

    def quantity(self, name: str, index: int) -> int:
        """Return the current value of a quantity of the real time output as an unsigned word.

        `name` is one of QUANTITIES.
        """
        plain = name.removesuffix(HIGH_WORD)
        values = self._of_axis(index) if plain in QUANTITIES_OF_AXIS else self._of_system()
        value = values[plain]
        return (value >> 16 if name.endswith(HIGH_WORD) else value) & 0xFFFF

    def _of_axis(self, index: int) -> dict[str, int]:
        """Return torque or duty [%], position [pulses], time [s] or distance [mm] of an axis."""
        accumulated, torques = self.accumulated, self.torques
        return {
            "motor_duty": abs(torques.of_rated(index)),
            "torque_of_max": torques.of_max(index),
            "torque_of_rated": torques.of_rated(index),
            "position_pulses": self._positions[index],
            "servo_state": self._servos.states[index],
            "servo_on_count": accumulated.servo_on_counts[index],
            "servo_on_time": accumulated.servo_on_us[index] // _S,
            "moving_distance": int(
                accumulated.distances[index] / self._config.axes[index].pulses_per_mm
            ),
        }

    def _of_system(self) -> dict[str, int]:
        """Return a count of the controller, or a time of the controller [s]."""
        return {
            "power_on_count": self.accumulated.power_on_count,
            "motor_power_on_count": self.accumulated.motor_power_on_count,
            "operating_time": self.accumulated.operating_us // _S,
        }
