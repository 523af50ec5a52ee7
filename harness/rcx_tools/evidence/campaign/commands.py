"""The command blocks of the campaign, each with its expected telegram and expected response.

The codec of the harness makes the telegrams of the remote command guide from the values at the
pins. The code of the blocks is not used.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from rcx_harness.spec import command

__all__ = ["COMMANDS", "LEVELS", "Telegrams"]

Pins = Mapping[str, Any]
Words = tuple[int, ...]


class Telegrams(NamedTuple):
    """The expected telegram and response of a block.

    Attributes:
        inputs: Pins that determine the telegram.
        words: Function that makes the telegram, n to n + 30, from these pins.
        outputs: Pins that contain the response.
        shown: Function that makes the expected values of these pins from the words m to m + 30.
    """

    inputs: tuple[str, ...]
    words: Callable[[Pins], Words]
    outputs: tuple[str, ...] = ()
    shown: Callable[[Sequence[int]], Pins] = lambda words: {}


def _write_point(pins: Pins) -> Words:
    positions = tuple(pins["Pulses"])
    return command("WritePoint").encode({"point": pins["Point"], "positions": positions})


def _read_point(pins: Pins) -> Words:
    return command("ReadPoint").encode({"point": pins["Point"]})


def _point(words: Sequence[int]) -> Pins:
    found = command("ReadPoint").read_response(words)
    return {"Pulses": list(_numbers(found["positions"]))}


def _write_comment(pins: Pins) -> Words:
    values = {"point": pins["Point"], "comment": pins["Comment"]}
    return command("WritePointComment").encode(values)


def _read_comment(pins: Pins) -> Words:
    return command("ReadPointComment").encode({"point": pins["Point"]})


def _comment(words: Sequence[int]) -> Pins:
    return {"Comment": command("ReadPointComment").read_response(words)["comment"]}


def _write_shift(pins: Pins) -> Words:
    data = tuple(round(value * 1000) for value in pins["ShiftMm"])
    return command("WriteShift").encode({"shift": pins["ShiftNumber"], "shift_data": data})


def _assign_value(pins: Pins) -> Words:
    """Return the telegram; the operation `ARITHMETIC_ADD` is the command AddValue."""
    name = {"ARITHMETIC_ASSIGN": "AssignValue", "ARITHMETIC_ADD": "AddValue"}[pins["Operation"]]
    return command(name).encode({"variable1": pins["Variable1"], "value": pins["ValueInteger"]})


def _read_variable(pins: Pins) -> Words:
    return command("ReadVariable").encode({"variable": pins["Variable"]})


def _variable(words: Sequence[int]) -> Pins:
    return {"ValueInteger": command("ReadVariable").read_response(words)["value"]}


def _move_ptp(pins: Pins) -> Words:
    speed = round(pins["Speed"] * 100)
    return command("MovePtp").encode({"speed_mode": 1, "speed": speed, "point": pins["Point"]})


def _move_pulses(pins: Pins) -> Words:
    return command("MoveDirectPulses").encode({"targets": tuple(pins["TargetPulses"])})


def _raw(pins: Pins) -> Words:
    return (pins["Code"], *pins["Data"])


def _response(words: Sequence[int]) -> Pins:
    return {"Response": list(words[1:])}


def _jog(pins: Pins) -> Words:
    name = {"JOG_PULSES": "JogPulses", "JOG_CARTESIAN": "JogCartesian", "JOG_TOOL": "JogTool"}
    minus = int(pins["Direction"] == "DIRECTION_MINUS")
    values = {"axes": 1 << pins["Axis"] - 1, "direction": minus}
    return command(name[pins["Frame"]]).encode(values)


def _position(pins: Pins) -> Words:
    name = {"UNIT_PULSES": "ReadPositionPulses", "UNIT_MM": "ReadPositionMm"}[pins["Unit"]]
    return command(name).encode({"continuous": 1})


def _numbers(value: Any) -> tuple[int, ...]:
    return tuple(value)


def real(value: float) -> float:
    """Return the nearest REAL, which is the value that a PLC stores."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


#: Blocks with Execute, by instance name in Campaign.st.
COMMANDS: Mapping[str, Telegrams] = {
    "WritePoint": Telegrams(("Point", "Pulses"), _write_point),
    "ReadPoint": Telegrams(("Point",), _read_point, ("Pulses",), _point),
    "WriteComment": Telegrams(("Point", "Comment"), _write_comment),
    "ReadComment": Telegrams(("Point",), _read_comment, ("Comment",), _comment),
    "WriteShift": Telegrams(("ShiftNumber", "ShiftMm"), _write_shift),
    "AssignValue": Telegrams(("Operation", "Variable1", "ValueInteger"), _assign_value),
    "ReadVariable": Telegrams(("Variable",), _read_variable, ("ValueInteger",), _variable),
    "MovePtp": Telegrams(("Point", "Speed"), _move_ptp),
    "MovePulses": Telegrams(("TargetPulses",), _move_pulses),
    "Raw": Telegrams(("Code", "Data"), _raw, ("Response",), _response),
    "Again": Telegrams(("Code", "Data"), _raw, ("Response",), _response),
}

#: Blocks with Enable. Their commands do not end by themselves.
LEVELS: Mapping[str, Telegrams] = {
    "Jog": Telegrams(("Frame", "Axis", "Direction"), _jog),
    "Position": Telegrams(("Unit",), _position),
}
