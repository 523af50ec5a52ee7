"""The axes of the robot models that a robot file names, from the data in spec/robots.toml."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rcx_harness.robot.config.checks import check_value
from rcx_harness.spec.robots import RobotModel, law, robot_models

__all__ = ["axis_keys", "merged", "model_of"]


def model_of(name: str) -> RobotModel:
    """Return the robot model with this name; raise InputError if the name is unknown."""
    check_value("robot", "models", name)
    return robot_models()[name]


def axis_keys(name: str, robot: int) -> list[dict[str, Any]]:
    """Return an `[[axes]]` table for each axis of a model as robot `robot`, without a load."""
    model = model_of(name)
    return [
        {
            "robot": robot,
            "pulses_per_mm": joint.pulses_per_unit,
            "zero": round(joint.zero),
            "max_speed": joint.speed * joint.pulses_per_unit,
            "max_acceleration": joint.acceleration(law(), 0.0) * joint.pulses_per_unit,
            "soft_low": round(joint.zero + joint.low * joint.pulses_per_unit),
            "soft_high": round(joint.zero + joint.high * joint.pulses_per_unit),
        }
        for joint in model.joints
    ]


def merged(names: Sequence[str], given: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return the `[[axes]]` tables of the models, changed by the `[[axes]]` of a robot file.

    The first table of a robot in the file changes axis 1 of its model, the second table axis 2, and
    so on. A table beyond the axes of the model adds an axis. The first name is the model of robot
    1.
    """
    axes = [keys for robot, name in enumerate(names, 1) for keys in axis_keys(name, robot)]
    own = {robot: [k for k, keys in enumerate(axes) if keys["robot"] == robot]
           for robot in range(1, len(names) + 1)}  # fmt: skip
    for table in given:
        places = own.get(table.get("robot", 1))
        if places:
            axes[places.pop(0)].update(table)
        else:
            axes.append(dict(table))
    return axes
