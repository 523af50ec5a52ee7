"""Motor power of the system, servo and brake of each axis."""

from __future__ import annotations

from collections.abc import Iterable

__all__ = ["BRAKE", "FREE", "SERVO", "Servos"]

#: Servo state of an axis, as the servo status reference answers it (guide, 4.7.3).
BRAKE, SERVO, FREE = 0, 1, 2


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
