"""The tables of the abstraction: the variables of the blocks that influence later scans."""

from __future__ import annotations

from structured_text.explore.omitted import Omitted, Tables

__all__ = ["TABLES", "TYPES"]

_RUN = "robot.PHASE == 3"
_DATA = "robot.PHASE == 2"
_SEQUENCE = Omitted(dropped="Execute Timeout Answer Trouble", flags="ErrorID")

TYPES: dict[str, Omitted] = {
    "RCX_REF": Omitted(dropped="Connected Status Response SO"),
    "RCX_ARBITRATION": Omitted(
        dropped="Elapsed Answer Losses",
        fixed="Request StopJog CodeRequest General KeepEmergency KeepStop InScan "
        "Works Worked Carries",
        scans="Scan",
        while_true={_RUN: "Running Code Data"},
    ),
    "RCX_CHANNEL": Omitted(dropped="Holder"),
    "FB_READAREA": Omitted(
        dropped="Connected Error ErrorID Status Words Bits k", fixed="m Size ImageSize"
    ),
    "FB_RCXTAKEHEAD": Omitted(
        dropped="Connected Status Words Bits Start Shown Again", fixed="NoWords"
    ),
    # The interval of scans is in whole milliseconds, so Rest is always 0.
    "FB_RCXSCANTIME": Omitted(dropped="Milliseconds OneMs", fixed="Rest"),
    "FB_WRITEAREA": Omitted(
        dropped="Interval Margin EmergencyStopOk StopOk Error ErrorID Value Bits k",
        fixed="n Size ImageSize",
    ),
    "FB_RCXMAKEHEAD": Omitted(
        dropped="Interval Margin EmergencyStopOk StopOk Code Extra Spacing SameData k JogCode",
        while_true={_DATA: "Words"},
    ),
    "FB_RCXHANDSHAKE": Omitted(
        dropped="Interval Hold SameData Code Endless",
        while_true={_DATA: "Owner Asked"},
        tickets={"Owner": "command"},
    ),
    "FB_RCXDEDICATEDINPUTS": Omitted(
        dropped="Interval Settling Restart Wanted Unset Change First", scans="Seen"
    ),
    "FB_RCXJOB": Omitted(
        dropped="Execute Scan Elapsed Holder Trouble Answer Settled Applied Request Ended",
        flags="ErrorID",
        while_true={"o.BUSY": "Armed Ticket Longest Waited Seen"},
        tickets={"Ticket": "of its owner"},
        scans="Seen",
    ),
    "FB_REMOTECOMMAND": Omitted(
        dropped="Execute Code Data Timeout AlarmGroup AlarmCategory Response k",
        flags="ErrorID",
        while_true={"o.JOB.BUSY": "HeldCode HeldData Refused"},
    ),
    "FB_JOG": Omitted(
        dropped="Enable Timeout AlarmGroup AlarmCategory Pulses PositionMm Refused Wanted "
        "Answered k",
        fixed="RobotNumber Frame Axis Direction PositionOutput",
        flags="ErrorID Failure",
        while_true={"o.JOB.BUSY": "Code Illegal Out Halt Longest Waited"},
    ),
    "FB_CONTINUOUSPOSITION": Omitted(
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
    "FB_PROGRAMSTOP": Omitted(
        dropped=_SEQUENCE.dropped, flags="ErrorID", while_true={"o.JOB.BUSY": "Running"}
    ),
    "FB_PROGRAMCONTINUE": Omitted(
        dropped="Execute Timeout", flags="ErrorID", while_true={"o.BUSY": "WasHeld"}
    ),
    "FB_SERVOONFROMEMERGENCYSTOP": Omitted(
        dropped="Execute Timeout Started Works Failure",
        flags="ErrorID",
        while_true={"o.BUSY": "WasHeld MaxWait Clock Seen"},
        scans="Seen",
    ),
    "FB_POWERUP": Omitted(scans="Seen"),
    "FB_RCXCLAIM": Omitted(
        scans="Seen", while_true={"o.OWN": "Ticket"}, tickets={"Ticket": "command"}
    ),
    "FB_SEQUENCECONTROL": Omitted(dropped="Enable Timeout", flags="ErrorID"),
    "R_TRIG": Omitted(dropped="CLK Q"),
}

TABLES = Tables(
    types=TYPES,
    reference="RCX_REF",
    variable="ROBOT",
    member="INNER",
    shared="RCX_ARBITRATION",
    devices="robots",
    unless={"LOSSES": "FB_RCXPICKMEMORY"},
    channel="RCX_CHANNEL",
    job="FB_RCXJOB",
    owners=dict.fromkeys(("FB_REMOTECOMMAND", "FB_JOG", "FB_CONTINUOUSPOSITION"), "command"),
    own=("FB_EMERGENCYSTOP", "FB_POWERUP", "FB_PROGRAMSTOP", "FB_SERVOONFROMEMERGENCYSTOP"),
    clock="FB_RCXSCANTIME",
    core=("FB_RCX", "RCX_"),
)
