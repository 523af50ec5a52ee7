"""Predefined structures of Logix, as data: their members are known, their meaning is not computed.

A file contains the members of most of these types in the values of its tags. This table has the
types whose values have another form there, or that can occur without values. Members that are not
in the table are refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator

from structured_text.projects.xml import Element

__all__ = ["predefined"]

#: The members of each type: `TYPE NAME NAME ...`, separated by semicolons. `NAME[n]` is an array.
#: Source: 1756-RM003 (MESSAGE, PID, ALARM), MOTION-RM002 (axes), as far as programs use them.
_TABLE = {
    "MESSAGE": (
        "INT Flags ERR DN_LEN REQ_LEN DestinationLink DestinationNode SourceLink Class Attribute;"
        " BOOL EW ER DN ST EN TO EN_CC; DINT EXERR Instance LocalIndex RemoteIndex"
        " UnconnectedTimeout ConnectionRate; SINT ERR_SRC Channel Rack Group Slot"
        " TimeoutMultiplier; STRING Path RemoteElement"
    ),
    "CONNECTION_STATUS": "BOOL RunMode ConnectionFaulted",
    "MOTION_INSTRUCTION": (
        "DINT FLAGS SEGMENT; BOOL EN DN ER PC IP AC ACCEL DECEL; INT ERR; SINT STATUS STATE EXERR"
    ),
    "PID": (
        "DINT CTL; BOOL EN CT CL PVT DOE SWM CA MO PE NDF NOBC NOZC INI SPOR OLL OLH EWD DVNA DVPA"
        " PVLA PVHA; REAL SP KP KI KD BIAS MAXS MINS DB SO MAXO MINO UPD PV ERR OUT PVH PVL DVP"
        " DVN PVDB DVDB MAXI MINI TIE MAXCV MINCV MINTIE MAXTIE DATA[17]"
    ),
    "SERIAL_PORT_CONTROL": "BOOL EN EU DN RN EM ER FD; DINT LEN POS ERROR",
    "ALARM_DIGITAL": (
        "BOOL EnableIn In InFault Condition AckRequired Latched ProgAck OperAck ProgReset OperReset"
        " ProgSuppress OperSuppress ProgUnsuppress OperUnsuppress ProgDisable OperDisable"
        " ProgEnable OperEnable AlarmCountReset EnableOut InAlarm Acked InAlarmUnack Suppressed"
        " Shelved Disabled Commissioned; DINT Severity MinDurationPRE MinDurationACC AlarmCount"
    ),
    "ALARM_ANALOG": (
        "BOOL EnableIn InFault HHEnabled HEnabled LEnabled LLEnabled AckRequired ProgAckAll"
        " OperAckAll EnableOut InAlarm AnyInAlarmUnack HHInAlarm HInAlarm LInAlarm LLInAlarm"
        " HHAcked HAcked LAcked LLAcked Suppressed Disabled; REAL In HHLimit HLimit LLimit LLLimit"
    ),
}
#: The members that axes and coordinate systems of all kinds have.
_AXIS = (
    "DINT AxisFault AxisStatus MotionStatus AxisEvent CIPAxisFaults; REAL ActualPosition"
    " CommandPosition StrobeActualPosition AverageVelocity ActualVelocity CommandVelocity"
    " ActualAcceleration CommandAcceleration PositionError VelocityError; BOOL ServoActionStatus"
    " DriveEnableStatus AxisHomedStatus HomedStatus ShutdownStatus PhysicalAxisFault ModuleFault"
    " ConfigFault AccelStatus DecelStatus MoveStatus JogStatus GearingStatus HomingStatus"
    " StoppingStatus TimeCamStatus PositionCamStatus InterpolatedMotionStatus TuneStatus"
    " TestStatus MoveTransitionStatus GroupFault MotionFault"
)
_AXES = (
    "AXIS_CIP_DRIVE",
    "AXIS_CONSUMED",
    "AXIS_GENERIC",
    "AXIS_GENERIC_DRIVE",
    "AXIS_SERVO",
    "AXIS_SERVO_DRIVE",
    "AXIS_VIRTUAL",
    "COORDINATE_SYSTEM",
    "MOTION_GROUP",
)
#: Types with data that no statement can read. The only member is for the declaration.
_CLOSED = (
    "ALARM_SET",
    "ALARM_SET_CONTROL",
    "BUS_OBJ",
    "CAM",
    "CAM_PROFILE",
    "DATALOG_INSTRUCTION",
    "HMIBC",
    "PHASE",
    "SEQUENCER",
)
_HIDDEN = "BOOL Closed_"


def predefined(name: str, at: int) -> Element | None:
    """Return the DataType element of a predefined type; None if the type is not predefined."""
    key = name.upper()
    text = _TABLE.get(key, _AXIS if key in _AXES else _HIDDEN if key in _CLOSED else "")
    if not text:
        return None
    members = Element("Members", {}, at, list(_members(text, at)), at)
    return Element("DataType", {"Name": name}, at, [members], at)


def _members(text: str, at: int) -> Iterator[Element]:
    for group in text.split(";"):
        kind, *names = group.split()
        for given in names:
            name, _, size = given.partition("[")
            size = size.rstrip("]")
            yield Element(
                "Member", {"Name": name, "DataType": kind, "Dimension": size or "0"}, at, [], at
            )
