"""Current torque of each axis, by a simple model.

With the servo off it is 0; at rest it is what holds the axis, and on the way there is a share in
the direction of the movement, both from the configuration. The max. torque command value limits it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rcx_harness.robot.servos import SERVO

if TYPE_CHECKING:
    from rcx_harness.robot.machine import Machine

__all__ = ["Torques"]

_HIGHEST_OF_RATED = 1000


class Torques:
    """Remembers where the axes were one cycle ago, and so which way they go.

    Attributes:
        directions: Per axis: -1, 0 or 1.
    """

    def __init__(self, positions: list[int]) -> None:
        self._before = list(positions)
        self.directions = [0] * len(positions)

    def observe(self, positions: list[int]) -> None:
        """Once in a cycle, after the axes have moved."""
        if positions == self._before and not any(self.directions):
            return
        pairs = zip(positions, self._before, strict=True)
        self.directions = [(now > before) - (now < before) for now, before in pairs]
        self._before = list(positions)

    def of_max(self, machine: Machine, index: int) -> int:
        """Of the maximum torque, -100 to 100 [%]."""
        if machine.servos.states[index] != SERVO:
            return 0
        axis = machine.config.axes[index]
        torque = axis.holding_torque + self.directions[index] * axis.moving_torque
        limit = machine.settings.torque_in_effect[index]
        return max(-limit, min(limit, torque))

    def of_rated(self, machine: Machine, index: int) -> int:
        """Of the rated torque, -1000 to 1000 [%]."""
        share = self.of_max(machine, index) * 100 / machine.config.axes[index].rated_torque
        return max(-_HIGHEST_OF_RATED, min(_HIGHEST_OF_RATED, round(share)))
