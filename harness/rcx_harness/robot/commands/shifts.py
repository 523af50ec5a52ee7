"""Shift data (guide, 4.3.4)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["read_shift", "write_shift"]


@act(0x10C)
def write_shift(machine: Machine, call: Call) -> Response:
    """Define a shift."""
    machine.memory.shifts[call.values["shift"]] = call.values["shift_data"]
    return {}


@act(0x10D)
def read_shift(machine: Machine, call: Call) -> Response:
    """Give a shift back."""
    number = call.values["shift"]
    return {"shift": number, "shift_data": machine.memory.shift(number)}
