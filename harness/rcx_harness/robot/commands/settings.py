"""Category 1: settings of a robot, point teaching (guide, 4.2.8, 4.2.9, 4.2.14 to 4.2.22)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Point

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
    setattr(call.arm.settings, setting, call.values[field])
    return {}


@act(0x03B)
def select_shift(machine: Machine, call: Call) -> Response:
    """Select a shift (4.2.17)."""
    number = call.values["shift"]
    machine.memory.shift(number)  # ends the command where it would end a reference
    call.arm.settings.shift = number
    return {}


@act(0x03C)
def select_hand(machine: Machine, call: Call) -> Response:
    """Select a hand (4.2.18)."""
    number = call.values["hand_number"]
    machine.memory.hand(call.arm.number, number)  # as above
    call.arm.settings.hand = number
    return {}


@act(0x03D)
def select_arm(machine: Machine, call: Call) -> Response:
    """Change the arm designation of a SCARA robot (4.2.19); the arm follows when it moves."""
    if not call.arm.scara:
        raise CommandError(machine.config.not_scara_alarm)
    call.arm.settings.arm = call.values["arm"]
    return {}


@act(0x048)
def set_max_torque(machine: Machine, call: Call) -> Response:
    """Change the max. torque command value of an axis (4.2.22), for its next movement."""
    (index,) = call.indices
    machine.settings.torque[index] = call.values["torque"]
    return {}


@act(0x028)
def teach_point(machine: Machine, call: Call) -> Response:
    """Store where the robot is as a point; axes that it does not have are 0.

    The point has no hand system and no arm rotation, as the current position reference has none.
    """
    mm = bool(call.values["unit"])
    machine.points[call.values["point"]] = Point(call.arm.shown(mm=mm), mm=mm)
    return {}
