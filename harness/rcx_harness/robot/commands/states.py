"""Category 6: servos, speeds, arms, origins, torques, inching amount (guide, 4.7)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.commands.origins import axes_of_type
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import AXES

__all__ = [
    "read_arm",
    "read_inching_amount",
    "read_origins",
    "read_servos",
    "read_speeds",
    "read_torques",
]

_NO_AXIS = 9
_NO_SCARA = 9
_DESIGNATION = 0x50B
_OF_MAX = 0x510
_TYPES = {1: "incremental", 2: "absolute"}


@act(0x503)
def read_servos(machine: Machine, call: Call) -> Response:
    """Servo and brake of each axis (4.7.3)."""
    states = [machine.servos.states[index] for index in machine.config.axes_of(call.robot)]
    return {"servo_states": _six(states, _NO_AXIS)}


@act(0x50A, absent=True)
def read_speeds(machine: Machine, call: Call) -> Response:
    """Automatic, manual and program speed (4.7.8); 0 for a robot without axes."""
    if not machine.config.axes_of(call.robot):
        return {}
    settings = machine.settings.of(call.robot)
    return {
        "auto_speed": settings.auto_speed,
        "manual_speed": settings.manual_speed,
        "program_speed": settings.program_speed,
    }


@act(0x50B, 0x50C, absent=True)
def read_arm(machine: Machine, call: Call) -> Response:
    """The arm as it is designated (4.7.9) or as it stands (4.7.10); 0 for a robot without axes."""
    if not machine.config.axes_of(call.robot):
        return {}
    if call.robot not in machine.config.scara_robots:
        return {"arm_state": _NO_SCARA}
    settings = machine.settings.of(call.robot)
    return {"arm_state": settings.arm if call.code == _DESIGNATION else settings.arm_status}


@act(0x50F)
def read_origins(machine: Machine, call: Call) -> Response:
    """Which axes have their origin, or whether the entire system has (4.7.11)."""
    if not call.designated:
        return {"origin_states": int(machine.origin_complete)}
    every = machine.config.axes_of(call.robot)
    kind = _TYPES.get(call.values["motor_type"])
    asked = axes_of_type(machine.config, every, kind) if kind else every
    complete = machine.origins.complete
    states = [int(complete[index]) if index in asked else _NO_AXIS for index in every]
    return {"origin_states": _six(states, _NO_AXIS)}


@act(0x510, 0x516)
def read_torques(machine: Machine, call: Call) -> Response:
    """Current torques of the maximum (4.7.12) or of the rated one (4.7.18).

    0 for axes that are not there, and for those that were not asked for.
    """
    every = machine.config.axes_of(call.robot)
    asked = call.values["axes"] or ~0
    chosen = [index for k, index in enumerate(every) if asked >> k & 1]
    torques = machine.data.torques
    read = torques.of_max if call.code == _OF_MAX else torques.of_rated
    values = [read(machine, index) if index in chosen else 0 for index in every]
    return {"torques": _six(values, 0)}


@act(0x514)
def read_inching_amount(machine: Machine, call: Call) -> Response:
    """How far an inching movement goes (4.7.16)."""
    return {"amount": machine.settings.of(call.robot).inching_amount}


def _six(values: list[int], absent: int) -> tuple[int, ...]:
    """Values of all axes that an answer has; `absent` for those that are not there."""
    return tuple(values + [absent] * (AXES - len(values)))
