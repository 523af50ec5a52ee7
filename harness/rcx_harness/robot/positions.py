"""The positions of the robots for the trace, as the responses of position commands show them."""

from __future__ import annotations

from collections.abc import Sequence

from rcx_harness.robot.controller import Controller
from rcx_harness.robot.stored import ROBOTS
from structured_text.errors import InputError

__all__ = ["axes_of", "where"]

_PULSES, _MM = "pulses", "mm"
#: Names and units of the coordinates of a robot (see robot/geometry.py).
_COORDINATES = ("X [mm]", "Y [mm]", "Z [mm]", "R [deg]", "axis 5 [mm, deg]", "axis 6 [mm, deg]")


def axes_of(controllers: Sequence[Controller], unit: str) -> list[list[str]]:
    """Return the titles of the values of `where` for each controller, such as `Position X [mm]`.

    If `unit` is empty, there are no titles.
    """
    if unit not in ("", _PULSES, _MM):
        raise InputError(f"positions cannot be in {unit!r}", hint=f"use {_PULSES} or {_MM}")
    return [_titles(one, unit) for one in controllers] if unit else []


def _titles(controller: Controller, unit: str) -> list[str]:
    titles = []
    several = any(controller.config.axes_of(robot) for robot in range(2, ROBOTS + 1))
    for robot in range(1, ROBOTS + 1):
        for place, _ in enumerate(controller.config.axes_of(robot)):
            of_axis = f"axis {place + 1} [{unit}]" if unit == _PULSES else _COORDINATES[place]
            titles.append(f"{f'Robot {robot}' if several else 'Position'} {of_axis}")
    return titles


def where(controller: Controller, unit: str) -> tuple[float, ...]:
    """Return the position of each axis, robot by robot, in pulses, or in mm and degrees.

    In mm the values are the position of the tool, in the coordinates of the selected shift and
    hand.
    """
    found: list[float] = []
    for robot in range(1, ROBOTS + 1):
        axes = len(controller.config.axes_of(robot))
        if axes:
            shown = controller.machine.arm(robot).shown(mm=unit == _MM)[:axes]
            found += [value / 1000 for value in shown] if unit == _MM else shown
    return tuple(found)
