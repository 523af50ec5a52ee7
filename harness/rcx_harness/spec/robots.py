"""The robots that a robot file can name, from `spec/robots.toml`, and their acceleration.

All types of robots follow the same law of acceleration. The force of an axis is the power of its
motor divided by its speed, times a factor. The force accelerates the load and the mass of the axis;
this mass is a share of the robot's largest load.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from math import radians
from pathlib import Path
from typing import Any

from rcx_harness.spec.tables import folder
from structured_text.errors import InputError
from structured_text.output.toml_files import load_toml

__all__ = ["Joint", "Law", "RobotModel", "law", "robot_models"]

_X, _Y, _Z, _R = range(4)


@dataclass(frozen=True)
class Law:
    """The acceleration of an axis as a function of its motor, its speed and the moved mass.

    Attributes:
        factor: Factor for the force of the motor at full speed.
        own_share: Mass of an axis itself, divided by the largest load of the axis.
        fitted: The models with the standard cycle times to which `factor` and `own_share` were
            fitted.
    """

    factor: float
    own_share: float
    fitted: tuple[str, ...]


@dataclass(frozen=True)
class Joint:
    """One axis of a model; lengths in mm, angles in degrees.

    Attributes:
        low: The lower soft limit.
        high: The upper soft limit.
        pulses_per_unit: Pulses per mm or degree.
        zero: Position at 0 mm or 0 degrees [pulses].
        speed: The highest speed, per second.
        power: Power of the axis' motor [W].
        reach: For a rotating arm, the distance from its axis to its stretched end [m]; 1 for other
            axes.
        turns: Whether the axis rotates.
        largest: The largest load [kg]; for the R axis, the largest moment of inertia [kg m^2].
        per_load: The moved mass, or moment of inertia, for each kg of the load.
        own: Mass of the axis itself [kg]. If it is 0, the mass is `own_share` times `largest`.
    """

    low: float
    high: float
    pulses_per_unit: float
    zero: float
    speed: float
    power: float
    reach: float
    turns: bool
    largest: float
    per_load: float
    own: float = 0.0

    def acceleration(self, law: Law, load: float) -> float:
        """Return the acceleration with a load [kg] in mm/s^2 or degree/s^2."""
        unit = radians(1) if self.turns else 1e-3
        mass = self._own(law) + self.per_load * load
        return law.factor * self.power / (self.speed * unit) / (mass * self.reach**2) / unit

    def slower(self, law: Law, load: float) -> float:
        """Return the acceleration with a load, divided by the acceleration without a load."""
        own = self._own(law)
        return own / (own + self.per_load * load)

    def _own(self, law: Law) -> float:
        return self.own or law.own_share * self.largest


@dataclass(frozen=True)
class RobotModel:
    """One type of robot.

    Attributes:
        also: Further remarks.
        arms: Lengths of arm 1 and 2 of a SCARA robot [mm]; empty for a Cartesian robot.
        payload: The largest load of the robot [kg].
        cycles: Standard cycle times by load: [kg] to [s]; the catalogue's value is first.
    """

    name: str
    source: str
    also: str
    arms: tuple[float, ...]
    joints: tuple[Joint, ...]
    payload: float
    cycles: tuple[tuple[float, float], ...]

    @property
    def scara(self) -> bool:
        """Return whether the robot is a SCARA robot, with two rotating arms."""
        return bool(self.arms)


@lru_cache(maxsize=1)
def law() -> Law:
    """Return the law of acceleration, for all models."""
    table = _table()["law"]
    return Law(table["factor"], table["own_share"], tuple(table["fitted"]))


@lru_cache(maxsize=1)
def robot_models() -> dict[str, RobotModel]:
    """Return all models by name."""
    table = _table()
    try:
        made = [_model(row, table) for row in table["robot"]]
    except (KeyError, IndexError, TypeError, ValueError) as error:
        raise InputError(f"a robot is not complete: {error!r}", file=_path()) from error
    return {model.name: model for model in made}


def _path() -> Path:
    return folder() / "robots.toml"


def _table() -> dict[str, Any]:
    return load_toml(_path())


def _model(row: dict[str, Any], table: dict[str, Any]) -> RobotModel:
    arms = tuple(float(arm) for arm in row.get("arms", ()))
    assumed = table["assumed"]
    if arms:
        speeds = [*_shared(row["speed_xy"], arms, assumed["axis2_to_axis1"]), *row["speed"]]
        per = assumed["pulses_per_unit"]
    else:
        speeds, per = row["speed"], [assumed["pulses_per_mm"]] * len(row["range"])
    reaches = {_X: sum(arms) / 1000, _Y: arms[1] / 1000} if arms else {}
    joints = []
    for place, (low, high) in enumerate(row["range"]):
        scale, zero = per[place], 0.0
        if "pulses" in row:
            first, last = row["pulses"][place]
            scale = (last - first) / (high - low)
            zero = first - low * scale
        payload = float(row["payload"])
        largest = row["inertia"] if place == _R else payload
        joints.append(
            Joint(
                *(low, high, scale, zero, speeds[place], row["power"][place]),
                reach=reaches.get(place, 1.0),
                turns=bool(arms) and place != _Z,
                largest=largest,
                per_load=largest / payload,
                own=row["mass"][place] if "mass" in row else 0.0,
            )
        )
    cycles = [(row["cycle_load"], row["cycle"])] if "cycle" in row else []
    cycles += [(load, seconds) for load, seconds in row.get("more_cycles", ())]
    return RobotModel(
        name=row["name"],
        source=table["sources"][row["source"]],
        also=row.get("also", ""),
        arms=arms,
        joints=tuple(joints),
        payload=row["payload"],
        cycles=tuple(cycles),
    )


def _shared(speed_xy: float, arms: tuple[float, ...], ratio: float) -> tuple[float, float]:
    """Return the speeds of axes 1 and 2 [degree/s] from the speed of the stretched arm [mm/s]."""
    first = _degrees(speed_xy / (sum(arms) + ratio * arms[1]))
    return first, ratio * first


def _degrees(value: float) -> float:
    return value / radians(1)
