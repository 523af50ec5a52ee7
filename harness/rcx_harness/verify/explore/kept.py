"""What of a program's state has an effect later: the tables behind the abstraction.

A variable that is not named here is kept as it is. One is named only if every call writes it
before it is read (dropped), or if it has the same value after every scan (fixed), or if it is read
only under a condition. No entry is believed: for every state that is found one scan is repeated
with arbitrary values in whatever the tables leave out, with all tickets shifted and at another
time, and must lead to the same state (`search`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["TYPES", "Kept"]


@dataclass(frozen=True)
class Kept:
    """Which variables of one type are not kept as they are.

    Attributes:
        dropped: Written before they are read, in every scan in which they are read.
        fixed: The same after every scan: constants, and requests that are cleared at its end.
        flags: Words of which only "is it 0" has an effect later: the shown ErrorID.
        while_true: Condition -> what is read only while it is true. The condition is Python, with
            `o` for the object itself and `robot` for the program's RCX_ARBITRATION.
        tickets: Ticket -> channel on which it stands, as `command`, `sequence` or `own`.
        scans: Numbers of scans: that of the last one, or of one before.
    """

    dropped: str = ""
    fixed: str = ""
    flags: str = ""
    while_true: Mapping[str, str] = field(default_factory=dict)
    tickets: Mapping[str, str] = field(default_factory=dict)
    scans: str = ""


_RUN = "robot.PHASE == 3"
_DATA = "robot.PHASE == 2"
_SEQUENCE = Kept(dropped="Execute Timeout Answer Trouble", flags="ErrorID")

TYPES: dict[str, Kept] = {
    "RCX_REF": Kept(dropped="Connected Status Response SO"),
    "RCX_ARBITRATION": Kept(
        dropped="Elapsed Answer Losses",
        fixed="Request StopJog CodeRequest General KeepEmergency KeepStop InScan "
        "Works Worked Carries",
        scans="Scan",
        while_true={_RUN: "Running Code Data"},
    ),
    "RCX_CHANNEL": Kept(dropped="Holder"),
    "FB_READAREA": Kept(
        dropped="Connected Error ErrorID Status Words Bits k", fixed="m Size ImageSize"
    ),
    "FB_RCXTAKEHEAD": Kept(
        dropped="Connected Status Words Bits Start Shown Again", fixed="NoWords"
    ),
    # Scans are whole milliseconds apart: nothing is left over.
    "FB_RCXSCANTIME": Kept(dropped="Milliseconds OneMs", fixed="Rest"),
    "FB_WRITEAREA": Kept(
        dropped="Interval Margin EmergencyStopOk StopOk Error ErrorID Value Bits k",
        fixed="n Size ImageSize",
    ),
    "FB_RCXMAKEHEAD": Kept(
        dropped="Interval Margin EmergencyStopOk StopOk Code Extra Spacing SameData k JogCode",
        while_true={_DATA: "Words"},
    ),
    "FB_RCXHANDSHAKE": Kept(
        dropped="Interval Hold SameData Code Endless",
        while_true={_DATA: "Owner Asked"},
        tickets={"Owner": "command"},
    ),
    "FB_RCXDEDICATEDINPUTS": Kept(
        dropped="Interval Settling Restart Wanted Unset Change First", scans="Seen"
    ),
    "FB_RCXJOB": Kept(
        dropped="Execute Scan Elapsed Holder Trouble Answer Settled Applied Request Ended",
        flags="ErrorID",
        while_true={"o.BUSY": "Armed Ticket Longest Waited Seen"},
        tickets={"Ticket": "of its owner"},
        scans="Seen",
    ),
    "FB_REMOTECOMMAND": Kept(
        dropped="Execute Code Data Timeout AlarmGroup AlarmCategory Response k",
        flags="ErrorID",
        while_true={"o.JOB.BUSY": "HeldCode HeldData Refused"},
    ),
    "FB_JOG": Kept(
        dropped="Enable Timeout AlarmGroup AlarmCategory Pulses PositionMm Refused Wanted "
        "Answered k",
        fixed="RobotNumber Frame Axis Direction PositionOutput",
        flags="ErrorID Failure",
        while_true={"o.JOB.BUSY": "Code Illegal Out Halt Longest Waited"},
    ),
    "FB_CONTINUOUSPOSITION": Kept(
        dropped="Enable Timeout AlarmGroup AlarmCategory Pulses PositionMm HandSystem Arm1 Arm2 "
        "Refused k",
        fixed="RobotNumber Unit",
        flags="ErrorID Failure",
        while_true={"o.JOB.BUSY": "Code Out Longest Waited"},
    ),
    "FB_SERVOON": _SEQUENCE,
    "FB_ALARMRESET": _SEQUENCE,
    "FB_AUTOSTART": _SEQUENCE,
    "FB_EMERGENCYSTOP": _SEQUENCE,
    "FB_PROGRAMSTOP": Kept(
        dropped=_SEQUENCE.dropped, flags="ErrorID", while_true={"o.JOB.BUSY": "Running"}
    ),
    "FB_PROGRAMCONTINUE": Kept(
        dropped="Execute Timeout", flags="ErrorID", while_true={"o.BUSY": "WasHeld"}
    ),
    "FB_SERVOONFROMEMERGENCYSTOP": Kept(
        dropped="Execute Timeout Started Works Failure",
        flags="ErrorID",
        while_true={"o.BUSY": "WasHeld MaxWait Clock Seen"},
        scans="Seen",
    ),
    "FB_POWERUP": Kept(scans="Seen"),
    "FB_RCXCLAIM": Kept(
        scans="Seen", while_true={"o.OWN": "Ticket"}, tickets={"Ticket": "command"}
    ),
    "FB_SEQUENCECONTROL": Kept(dropped="Enable Timeout", flags="ErrorID"),
    "R_TRIG": Kept(dropped="CLK Q"),
}
