"""Category 1: speeds, designations, inching amount and torque (guide, 4.2.8, 4.2.14 to 4.2.22)."""

from __future__ import annotations

from rcx_harness.robot.commands.axes import chosen_axes
from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["change_setting", "select_arm", "select_hand", "select_shift", "set_max_torque"]

#: The setting that each command changes, and the field that holds its new value.
_SETTINGS = {
    0x027: ("inching_amount", "amount"),
    0x038: ("manual_speed", "speed"),
    0x039: ("auto_speed", "speed"),
    0x03A: ("program_speed", "speed"),
}


@act(*_SETTINGS)
def change_setting(machine: Machine, call: Call) -> Response:
    """Change a speed or the inching amount of a robot (4.2.8, 4.2.14 to 4.2.16)."""
    setting, field = _SETTINGS[call.code]
    setattr(machine.settings.of(call.robot), setting, call.values[field])
    return {}


@act(0x03B)
def select_shift(machine: Machine, call: Call) -> Response:
    """Select a shift (4.2.17)."""
    number = call.values["shift"]
    machine.memory.shift(number)  # ends the command where it would end a reference
    machine.settings.of(call.robot).shift = number
    return {}


@act(0x03C)
def select_hand(machine: Machine, call: Call) -> Response:
    """Select a hand (4.2.18)."""
    number = call.values["hand_number"]
    machine.memory.hand(call.robot, number)  # as above
    machine.settings.of(call.robot).hand = number
    return {}


@act(0x03D)
def select_arm(machine: Machine, call: Call) -> Response:
    """Change the arm designation of a SCARA robot (4.2.19); the arm follows when it moves."""
    if call.robot not in machine.config.scara_robots:
        raise CommandError(machine.config.not_scara_alarm)
    machine.settings.of(call.robot).arm = call.values["arm"]
    return {}


@act(0x048)
def set_max_torque(machine: Machine, call: Call) -> Response:
    """Change the max. torque command value of an axis (4.2.22), for its next movement."""
    (index,) = chosen_axes(machine, call)
    machine.settings.torque[index] = call.values["torque"]
    return {}
