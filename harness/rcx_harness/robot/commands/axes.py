"""The axes that a command names, as indices into all axes of the controller."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call
from rcx_harness.robot.commands.moving import chosen_places
from rcx_harness.robot.machine import Machine

__all__ = ["chosen_axes"]


def chosen_axes(machine: Machine, call: Call) -> tuple[int, ...]:
    """Indices of the axes in the field `axes`; none where no bit is set.

    Raises:
        CommandError: the robot does not have one of them.
    """
    every = machine.config.axes_of(call.robot)
    return tuple(every[place] for place in chosen_places(machine, call))
