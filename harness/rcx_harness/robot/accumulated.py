"""Accumulated data of motors and controller, which commands reset (guide, 4.8.4 to 4.8.6)."""

from __future__ import annotations

from collections.abc import Iterable

from rcx_harness.robot.servos import SERVO, Servos

__all__ = ["Accumulated"]


class Accumulated:
    """Counts, times and ways; they survive a power cycle.

    Attributes:
        servo_on_counts: Per axis: how often its servo was switched ON.
        servo_on_us: Per axis: how long it was ON [us].
        distances: Per axis: its way [pulses].
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
        """The controller is switched ON."""
        self.power_on_count += 1
        self._since_us = None

    def observe(self, now_us: int, positions: list[int], servos: Servos) -> None:
        """Once in every cycle in which something may have changed, while the power is ON."""
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
        """Reset data of these axes.

        Args:
            indices: Into the axes.
            item: 1 servo ON count, 2 servo ON time, 3 moving distance; 0 all of them.
        """
        kinds = {1: self.servo_on_counts, 2: self.servo_on_us, 3: self.distances}
        for values in kinds.values() if item == 0 else (kinds[item],):
            for index in indices:
                values[index] = 0

    def reset_system(self, item: int = 0) -> None:
        """Reset data of the controller.

        Args:
            item: 1 power ON count, 2 motor power ON count, 3 operating time; 0 all of them.
        """
        if item in (0, 1):
            self.power_on_count = 0
        if item in (0, 2):
            self.motor_power_on_count = 0
        if item in (0, 3):
            self.operating_us = 0
