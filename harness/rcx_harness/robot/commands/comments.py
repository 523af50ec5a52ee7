"""Point comments (guide, 4.3.2)."""

from __future__ import annotations

from rcx_harness.robot.commands.base import Call, Response, act
from rcx_harness.robot.machine import Machine

__all__ = ["read_comment", "write_comment"]

_LENGTH = 16


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
