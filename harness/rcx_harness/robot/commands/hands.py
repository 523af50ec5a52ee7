"""Hand data (guide, 4.3.5)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine
from rcx_harness.robot.stored import Hand

__all__ = ["read_hand", "write_hand"]


@act(0x110)
def write_hand(machine: Machine, call: Call) -> Response:
    """Define a hand of a robot; its data are kept as they are on the wire."""
    values = call.values
    hand = Hand((values["data1"], values["data2"], values["data3"], values["data4"]))
    machine.memory.hands[call.robot, values["hand_number"]] = hand
    return {}


@act(0x111)
def read_hand(machine: Machine, call: Call) -> Response:
    """Give a hand of a robot back, with the number of the robot."""
    number = call.values["hand_number"]
    hand = machine.memory.hand(call.robot, number)
    data = {f"data{k}": value for k, value in enumerate(hand.data, 1)}
    return {"hand_number": number, "robot_number": call.robot, **data}
