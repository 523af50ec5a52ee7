"""Category 6: versions, configuration and current position (guide, 4.7.1 to 4.7.4, 4.7.15)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import (
    Action,
    Call,
    CommandError,
    Execution,
    Response,
    act,
    last,
)
from rcx_harness.robot.commands.moving import positions_of
from rcx_harness.robot.machine import Machine

__all__ = [
    "read_configuration",
    "read_option_slots",
    "read_position",
    "read_position_once",
    "read_version",
]

_MM = 0x506
_DRIVERS = 4


@act(0x501)
def read_version(machine: Machine, call: Call) -> Response:
    """Software versions (4.7.1); drivers that are not there show 0."""
    config = machine.config
    present = min(len(config.axes), _DRIVERS)
    return {
        "host_version": config.host_version,
        "host_revision": config.host_revision,
        "fpga_version": config.fpga_version,
        "driver_versions": (config.driver_version,) * present,
    }


@act(0x502)
def read_configuration(machine: Machine, call: Call) -> Response:
    """Type of a robot and of its axes (4.7.2)."""
    config = machine.config
    types = tuple(config.axes[index].robot_type for index in config.axes_of(call.robot))
    return {"robot_type": types[0], "axis_types": types}


@act(0x513)
def read_option_slots(machine: Machine, call: Call) -> Response:
    """Units in the option slots (4.7.15); there is one controller."""
    if call.values["controller"] != 1:
        raise CommandError(machine.config.absent_controller_alarm)
    return {"slots": machine.config.option_slots, "ivy2": machine.config.ivy2_unit}


@act(0x505, 0x506)
def read_position_once(machine: Machine, call: Call) -> Response:
    """Current position (4.7.4)."""
    mm = call.code == _MM
    values = {"positions": positions_of(machine, call.robot, mm=mm)}
    if not mm:
        return values
    config = machine.config
    hand = config.position_hand and call.robot in config.scara_robots
    return {
        **values,
        "flag_bit0": int(config.position_flag_bit0),
        "hand": 1 + machine.settings.of(call.robot).arm_status if hand else 0,
    }


@last(0x505, 0x506)
def read_position(machine: Machine, call: Call) -> Execution:
    """Current position, once or until the status reset command (4.7.4)."""
    return _Continuous(call) if call.values["continuous"] else Action(machine, call)


class _Continuous:
    """Status 0x0100 with the position of every cycle; it has no end of its own."""

    stoppable = True

    def __init__(self, call: Call) -> None:
        self._call = call

    def step(self, machine: Machine) -> Response | None:
        return None

    def interim(self, machine: Machine) -> Response:
        return read_position_once(machine, self._call)
