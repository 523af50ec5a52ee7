"""Stored data: points 29990 to 29995, pallet 39, hand 31 of robot 1, SGI30, SGI31 and SGR31."""

from __future__ import annotations

from rcx_harness.look.probe.asker import Asker
from rcx_harness.look.probe.question import still
from rcx_harness.spec.wire import NORMAL_END

_POINT, _PALLET, _HAND = 29_990, 39, 31
_SGI30, _SGI31, _SGR31 = 30, 31, 287
_TWO_AND_A_HALF = 0x40200000
#: The smallest positive integer that single precision cannot represent.
_ODD = 16_777_217
_DOES = "Overwrites points 29990 to 29995, pallet 39, hand 31 of robot 1, SGI30, SGI31 and SGR31."


def _point(ask: Asker, number: int, *positions: int, unit: int = 0) -> None:
    answer = ask.command("WritePoint", point=number, unit=unit, positions=positions)
    ask.needs(answer.status == NORMAL_END, f"point {number} cannot be written")


def _variable(ask: Asker, number: int) -> int:
    value = ask.command("ReadVariable", variable=number).fields.get("value")
    ask.needs(value is not None, "a variable cannot be read")
    return int(value or 0)


@still(
    {
        "overflow": ("overflow_alarm", "division_alarm"),
        "real-to-integer": ("real_to_integer",),
        "mixed-arithmetic": (),
    },
    does=_DOES,
)
def arithmetic(ask: Asker) -> None:
    """How does the controller treat numbers that do not fit?"""
    ask.command("AssignValue", variable1=_SGR31, value=_TWO_AND_A_HALF)
    ask.command("AssignVariable", variable1=_SGI31, variable2=_SGR31)
    value = _variable(ask, _SGI31)
    ask.needs(value in (2, 3), f"2.5 became {value}")
    kind = "round" if value == 3 else "truncate"
    ask.knob("real_to_integer", kind, text=f"2.5 became {value}")
    ask.command("AssignValue", variable1=_SGI31, value=_ODD)
    ask.command("AssignValue", variable1=_SGI30, value=0)
    ask.command("AddVariable", variable1=_SGI31, variable2=_SGI30)
    value = _variable(ask, _SGI31)
    ask.rule("mixed-arithmetic", value == _ODD, f"{_ODD} + 0 = {value}")
    for name, knob, second in (
        ("DivideVariable", "division_alarm", 0),
        ("MultiplyVariable", "overflow_alarm", _ODD),
    ):
        ask.command("AssignValue", variable1=_SGI30, value=second)
        answer = ask.command(name, variable1=_SGI31, variable2=_SGI30)
        ask.needs(bool(answer.alarm), f"{name} did not end in an alarm")
        ask.knob(knob, answer.alarm, text=f"{name} ended in {answer.alarm}")


@still(
    {"point-units": ("point_unit_alarm",), "several-elements": ("several_elements",)},
    does=_DOES,
)
def points(ask: Asker) -> None:
    """How does the controller treat points with different units, and several elements at a time?"""
    _point(ask, _POINT, 100, 200, 300)
    _point(ask, _POINT + 1, 10, 20, 30, unit=1)
    answer = ask.command("AssignPointElementPulses", point=_POINT, data_number=3, value=7)
    several = not answer.alarm
    text = f"an assignment to elements 1 and 2: alarm {answer.alarm or 'none'}"
    ask.knob("several_elements", several, text=text)
    answer = ask.command("AddPoint", point1=_POINT, point2=_POINT + 1)
    ask.needs(bool(answer.alarm), "pulses and millimetres were added")
    ask.knob("point_unit_alarm", answer.alarm, text=f"the addition ended in {answer.alarm}")


@still({"undefined-pallet": ("work_position_alarm",), "work-positions": ()}, does=_DOES)
def pallet(ask: Asker) -> None:
    """How does the controller count the work positions of a pallet, and where does it end?"""
    corners = ((0, 0), (1000, 0), (0, 2000), (1000, 2000), (0, 0))
    for number, corner in enumerate(corners):
        _point(ask, _POINT + number, *corner)
    sizes = {"nx": 2, "ny": 2, "nz": 1}
    answer = ask.command("WritePallet", pallet=_PALLET, first_point=_POINT, **sizes)
    ask.needs(answer.status == NORMAL_END, "pallet 39 cannot be written")
    places = []
    for work in (1, 2, 3, 4):
        ask.command("AssignPalletPoint", point=_POINT + 5, pallet=_PALLET, work=work)
        fields = ask.command("ReadPoint", point=_POINT + 5).fields
        places.append(tuple(fields.get("positions", ()))[:2])
    ask.rule("work-positions", places == list(corners[:4]), f"positions 1 to 4: {places}")
    answer = ask.command("AssignPalletPoint", point=_POINT + 5, pallet=_PALLET, work=5)
    ask.needs(bool(answer.alarm), "work position 5 of 4 was accepted")
    ask.knob("work_position_alarm", answer.alarm, text=f"position 5 of 4 ended in {answer.alarm}")


@still({"hand-data": ()}, does=_DOES)
def hand(ask: Asker) -> None:
    """Does the controller store hand data unchanged?"""
    data = {"data1": 12_345, "data2": -678, "data3": 910, "data4": 1}
    answer = ask.command("WriteHand", 1, hand_number=_HAND, **data)
    ask.needs(answer.status == NORMAL_END, "hand 31 cannot be written")
    fields = ask.command("ReadHand", 1, hand_number=_HAND).fields
    read = {name: fields.get(name) for name in data}
    ask.rule("hand-data", read == data, f"written {data}, read {read}")


@still({"taught-point": ()}, does=_DOES)
def taught_point(ask: Asker) -> None:
    """Does a taught point have a hand system or an arm rotation?"""
    answer = ask.command("TeachPoint", 1, point=_POINT, unit=1)
    ask.needs(answer.status == NORMAL_END, f"teaching ended in {answer.alarm}")
    fields = ask.command("ReadPoint", point=_POINT).fields
    shown = {name: fields.get(name) for name in ("unit", "hand", "arm1", "arm2")}
    holds = shown == {"unit": 1, "hand": 0, "arm1": 0, "arm2": 0}
    ask.rule("taught-point", holds, f"taught in mm with the servos off: {shown}")


@still(
    {"other-ports": ()},
    does="SO(270) to SO(277), which are not in the area, are written, read and set back.",
)
def other_ports(ask: Asker) -> None:
    """Does the controller store outputs that are not in the area?"""
    port = {"port_type": 6, "port": 0x27}
    before = ask.command("ReadIoPort", **port).fields
    ask.needs(bool(before), "SO27() cannot be read")
    pattern = int(before["pattern"]) ^ 0xA5
    ask.command("WriteIoPort", pattern=pattern, **port)
    after = ask.command("ReadIoPort", **port).fields.get("pattern")
    ask.command("WriteIoPort", pattern=int(before["pattern"]), **port)
    ask.rule("other-ports", after == pattern, f"written 16#{pattern:02X}, read {after}")


@still(
    {"clock": ("impossible_date_alarm",)},
    does="30 February is set as the date; if it is accepted, the date is set back.",
)
def impossible_date(ask: Asker) -> None:
    """How does the controller answer a date that does not exist?"""
    today = ask.command("ReadDate").fields
    ask.needs(bool(today), "the date cannot be read")
    answer = ask.command("SetDate", year=today["year"], month=2, day=30)
    if not answer.alarm:
        ask.command("SetDate", **{name: today[name] for name in ("year", "month", "day")})
    ask.needs(bool(answer.alarm), "30 February was accepted as a date")
    ask.knob("impossible_date_alarm", answer.alarm, text=f"30 February ended in {answer.alarm}")


@still(
    {"arm-robots": ("not_scara_alarm",)},
    does="The arm designation of robot 1 is set to its current value.",
)
def arm(ask: Asker) -> None:
    """How does a robot that is not a SCARA answer an arm designation?"""
    state = ask.command("ReadArmDesignation", 1).fields.get("arm_state")
    answer = ask.command("SelectArm", 1, arm=state if state in (0, 1) else 0)
    ask.needs(bool(answer.alarm), "robot 1 is a SCARA robot")
    ask.knob("not_scara_alarm", answer.alarm, text=f"the designation ended in {answer.alarm}")
