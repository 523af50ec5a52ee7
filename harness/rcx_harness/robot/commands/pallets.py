"""Pallet data (guide, 4.3.3)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Pallet

__all__ = ["read_pallet", "write_pallet"]


@act(0x108)
def write_pallet(machine: Machine, call: Call) -> Response:
    """Define a pallet; its points are looked at only where a work position is wanted."""
    values = call.values
    pallet = Pallet(values["nx"], values["ny"], values["nz"], values["first_point"])
    machine.memory.pallets[values["pallet"]] = pallet
    return {}


@act(0x109)
def read_pallet(machine: Machine, call: Call) -> Response:
    """Give the definition of a pallet back."""
    number = call.values["pallet"]
    pallet = machine.memory.pallet(number)
    return {
        "pallet": number,
        "nx": pallet.nx,
        "ny": pallet.ny,
        "nz": pallet.nz,
        "first_point": pallet.first,
    }
