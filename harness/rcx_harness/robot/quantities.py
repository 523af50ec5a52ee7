"""What a word of the real time output can show, by name (guide, 4.9).

The list of item numbers is in another manual; only motor duty, item 13, is in this one. So items
are given by name, and the configuration says which number each of them has.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rcx_harness.robot.machine import Machine

__all__ = ["QUANTITIES", "quantity", "take_axis"]

_OF_AXIS = (
    "motor_duty",
    "torque_of_max",
    "torque_of_rated",
    "position_pulses",
    "servo_state",
    "servo_on_count",
    "servo_on_time",
    "moving_distance",
)
_OF_SYSTEM = ("power_on_count", "motor_power_on_count", "operating_time")
_HIGH = ".high"

#: Names of all quantities; with `.high` the upper of two words, for values beyond 16 bits.
QUANTITIES = tuple(name + half for name in (*_OF_AXIS, *_OF_SYSTEM) for half in ("", _HIGH))
_S = 1_000_000  # [us]


def take_axis(name: str) -> bool:
    """The quantity is one of an axis: option 1 is the robot, option 2 the axis."""
    return name.removesuffix(_HIGH) in _OF_AXIS


def quantity(machine: Machine, name: str, index: int) -> int:
    """Its value now as an unsigned word.

    Args:
        machine: The controller.
        name: One of QUANTITIES.
        index: Into the axes; not used where the quantity is not one of an axis.
    """
    plain = name.removesuffix(_HIGH)
    values = _of_axis(machine, index) if take_axis(name) else _of_system(machine)
    value = values[plain]
    return (value >> 16 if name.endswith(_HIGH) else value) & 0xFFFF


def _of_axis(machine: Machine, index: int) -> dict[str, int]:
    """Torques and duty [%], position [pulses], time [s], way [mm]."""
    data, per_mm = machine.data, machine.config.axes[index].pulses_per_mm
    return {
        "motor_duty": abs(data.torques.of_rated(machine, index)),
        "torque_of_max": data.torques.of_max(machine, index),
        "torque_of_rated": data.torques.of_rated(machine, index),
        "position_pulses": machine.positions[index],
        "servo_state": machine.servos.states[index],
        "servo_on_count": data.accumulated.servo_on_counts[index],
        "servo_on_time": data.accumulated.servo_on_us[index] // _S,
        "moving_distance": int(data.accumulated.distances[index] / per_mm),
    }


def _of_system(machine: Machine) -> dict[str, int]:
    """Times in s."""
    accumulated = machine.data.accumulated
    return {
        "power_on_count": accumulated.power_on_count,
        "motor_power_on_count": accumulated.motor_power_on_count,
        "operating_time": accumulated.operating_us // _S,
    }
