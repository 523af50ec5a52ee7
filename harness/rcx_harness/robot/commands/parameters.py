"""Parameters of robots and axes (guide, 4.4.2)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, CommandError, Response, act
from rcx_harness.robot.commands.moving import chosen_places
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import parameter_names

__all__ = ["read_parameter", "write_parameter"]

#: Grams or kilograms in one kg of the maximum payload.
_PAYLOADS = {"WEIGHT": 1, "WEIGHTG": 1000, "AXWGHT": 1}


@act(0x220)
def write_parameter(machine: Machine, call: Call) -> Response:
    """Assign a value; a payload is at most the maximum payload."""
    name, axis, value = _name(call), _axis(machine, call), call.values["value"]
    if name in _PAYLOADS and value > machine.config.max_payload * _PAYLOADS[name]:
        raise CommandError(machine.config.format_alarm)
    machine.memory.parameters.set(call.robot, name, value, axis)
    return {}


@act(0x224)
def read_parameter(machine: Machine, call: Call) -> Response:
    """Give the value of a parameter back."""
    value = machine.memory.parameters.get(call.robot, _name(call), _axis(machine, call))
    asked = {key: call.values[key] for key in ("parameter", "axes")}
    return {**asked, "value": value}


def _name(call: Call) -> str:
    return parameter_names()[call.values["parameter"]]


def _axis(machine: Machine, call: Call) -> int:
    """Place of the axis in the robot; 0 for a parameter of the robot."""
    places = chosen_places(machine, call)
    return places[0] if places else 0
