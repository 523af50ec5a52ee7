"""The axes of the robot models in a robot file, from the figures in spec/robots.toml."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from rcx_harness.robot.config.checks import check_value
from rcx_harness.spec.robots import RobotModel, law, robot_models

__all__ = ["axis_keys", "merged", "model_of"]


def model_of(name: str) -> RobotModel:
    """Return the model of that name."""
    check_value("robot", "models", name)
    return robot_models()[name]


def axis_keys(name: str, robot: int) -> list[dict[str, Any]]:
    """Return the keys of each axis of a model as robot number `robot`, without a load."""
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
    """Return the keys of all axes: those of the models, changed by `[[axes]]` of a robot file.

    The first table of a robot belongs to its axis 1, and so on; a table beyond the axes of its
    model adds an axis. The model of robot 1 is the first name.
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
