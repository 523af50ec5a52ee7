"""Category 2: points, comments, pallets, shifts and hands (guide, 4.3)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Hand, Pallet, Point

_TURNS = {1: 1, 15: -1}  # four bits to arm rotation; all other patterns mean 0
_LENGTH = 16


@act(0x100)
def write_point(machine: Machine, call: Call) -> Response:
    """Define a point (4.3.1); hand and arm rotation count only in mm, and with a SCARA robot."""
    values = call.values
    mm = bool(values["unit"])
    scara = mm and bool(machine.config.scara_robots)
    machine.points[values["point"]] = Point(
        data=values["positions"],
        mm=mm,
        hand=values["hand"] % 3 if scara else 0,  # 3 is none, as 0
        arm1=_TURNS.get(values["arm1"], 0) if scara else 0,
        arm2=_TURNS.get(values["arm2"], 0) if scara else 0,
    )
    return {}


@act(0x101)
def read_point(machine: Machine, call: Call) -> Response:
    """Give a point back in its own unit (4.3.1)."""
    number = call.values["point"]
    point = machine.memory.point(number)
    return {
        "point": number,
        "unit": int(point.mm),
        "hand": point.hand,
        "arm1": point.arm1 & 0xF,
        "arm2": point.arm2 & 0xF,
        "positions": point.data,
    }


@act(0x104)
def write_comment(machine: Machine, call: Call) -> Response:
    """Define the comment of a point; the point itself need not be defined."""
    machine.memory.comments[call.values["point"]] = call.values["comment"].rstrip(" ")
    return {}


@act(0x105)
def read_comment(machine: Machine, call: Call) -> Response:
    """Give the comment of a point back, filled up behind the text."""
    number = call.values["point"]
    filler = "\0" if machine.config.comment_filler == "zeros" else " "
    return {"point": number, "comment": machine.memory.comment(number).ljust(_LENGTH, filler)}


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


@act(0x110)
def write_hand(machine: Machine, call: Call) -> Response:
    """Define a hand of a robot; its data are kept as they are on the wire."""
    values = call.values
    hand = Hand((values["data1"], values["data2"], values["data3"], values["data4"]))
    machine.memory.hands[call.arm.number, values["hand_number"]] = hand
    return {}


@act(0x111)
def read_hand(machine: Machine, call: Call) -> Response:
    """Give a hand of a robot back, with the number of the robot."""
    number = call.values["hand_number"]
    hand = machine.memory.hand(call.arm.number, number)
    data = {f"data{k}": value for k, value in enumerate(hand.data, 1)}
    return {"hand_number": number, "robot_number": call.arm.number, **data}
