"""The models with one robot for the exploration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from rcx_tools.evidence.explore.model import DOWN, SKIPPED, UP, Block, Model, Quiet, Situation, Wire

__all__ = ["MODELS"]

_CPU, _EMERGENCY, _ALARM, _MP_RDY, _AUTO = 0x0002, 0x0001, 0x0008, 0x0010, 0x0100
_STATUS = {0x0000: "ready", 0x0100: "running", 0x0200: "end", 0x4000: "abnormal"}

#: Situations with any status at any time, with and without CPU_OK, and with a lost link. A real
#: controller shows fewer situations.
_ANY_STATUS = (
    *(Situation(label, status=status, so=_CPU) for status, label in _STATUS.items()),
    Situation("ready, CPU_OK off"),
    Situation("end, CPU_OK off", status=0x0200),
    Situation("link down", connected=False),
)


def _prompt(end: str) -> Callable[[Wire], str]:
    """Return a function from the values on the wire to the next situation.

    The function describes a controller that answers at once.
    """

    def situation(wire: Wire) -> str:
        code = wire.code & 0x0FFF
        if not code:
            return "ready"
        if code in (0x505, 0x506) and wire.first & 1:
            return "running"
        if code in (0x20, 0x21, 0x22):
            return "running" if wire.bits & 0x40 else "abnormal"
        return end

    return situation


_DATA = "    DataA, DataB : RCX_WORDS;\n"
_FILL = "  DataA[1] := WORD#16#0004;\n  DataB[1] := WORD#16#0008;\n"

_QUIET = (
    Quiet("normal ends", DOWN, _prompt("end")),
    Quiet("abnormal ends", DOWN, _prompt("abnormal")),
    Quiet("blocks not called any more", SKIPPED, _prompt("end")),
)
_NEVER = Quiet("no answer ever, blocks end by Timeout", DOWN, lambda _: "ready", idle_blocks=True)

_FIRST = Block(
    "First",
    "FB_RemoteCommand",
    "Code := WORD#16#1001, Data := DataA, Timeout := T#150ms",
    code=0x1001,
)
_SECOND = Block(
    "Second",
    "FB_RemoteCommand",
    "Code := WORD#16#0102, Data := DataB, Timeout := T#0s",
    code=0x0102,
)

COMMANDS = Model(
    "commands",
    "two remote commands on one channel: arbitration and handshake",
    (_FIRST, replace(_SECOND, pins=_SECOND.pins.replace("0s", "100ms"))),
    _ANY_STATUS,
    (*_QUIET, _NEVER),
    pins=((False, False),),
    variables=_DATA,
    statements=_FILL,
)

_THIRD = Block(
    "Third", "FB_RemoteCommand", "Code := WORD#16#0203, Data := DataA, Timeout := T#0s",
    code=0x0203, does=(DOWN, UP),
)  # fmt: skip

ARBITRATION = Model(
    "arbitration",
    "three remote commands, the link stays up",
    (
        replace(_FIRST, pins=_FIRST.pins.replace("150ms", "0s")),
        replace(_SECOND, does=(DOWN, UP)),
        _THIRD,
    ),
    tuple(_ANY_STATUS[k] for k in (0, 2)),
    _QUIET[:1],
    pins=((False, False),),
    queue=4,
    variables=_DATA,
    statements=_FILL,
)

JOG = Model(
    "jog",
    "a jog and a remote command, stop pin and link",
    (
        Block("Jog", "FB_Jog", "Timeout := T#150ms", kind="jog", code=0x0020),
        replace(_SECOND, does=(DOWN, UP)),
    ),
    (
        *_ANY_STATUS[:4],
        Situation("ready, CPU_OK off"),
        Situation("running, emergency stop", status=0x0100, so=_CPU | _EMERGENCY),
        Situation("link down", connected=False),
    ),
    _QUIET,
    pins=((True, True), (True, False)),
    variables=_DATA,
    statements=_FILL,
)

CONTINUOUS = Model(
    "continuous",
    "a continuous position and a remote command",
    (
        Block("Position", "FB_ContinuousPosition", "Timeout := T#150ms", kind="continuous",
              code=0x0505),
        _SECOND,
    ),
    _ANY_STATUS,
    _QUIET,
    pins=((False, False),),
    variables=_DATA,
    statements=_FILL,
)  # fmt: skip

_SERVO = Block(
    "Servo", "FB_ServoOn", "Timeout := T#150ms", "sequence", bits=(1,), answer=(0x0004, 0x0004)
)
_START = Block(
    "Start", "FB_AutoStart", "Timeout := T#0s", "sequence", bits=(10,), answer=(0x0800, 0x0800)
)
_READY = _CPU | _MP_RDY | _AUTO


_OUTPUTS = (
    *(
        Situation(
            f"servo {'on' if servo else 'off'}, program {'runs' if start else 'stands'}",
            so=_READY | servo | start,
        )
        for servo in (0, 0x0004)
        for start in (0, 0x0800)
    ),
    Situation("emergency stop", so=_READY | _EMERGENCY | _ALARM),
    Situation("CPU_OK off", so=_MP_RDY | _AUTO),
    Situation("link down", connected=False),
)


def _both(wire: Wire) -> str:
    """Return the label of the next situation: if an input is ON, both answers are ON, else OFF."""
    there = wire.bits & 0x0402
    return "servo on, program runs" if there else "servo off, program stands"


_LEFT = (
    Quiet("answers at once", DOWN, _both),
    Quiet("blocks not called any more", SKIPPED, _both),
)

SEQUENCES = Model(
    "sequences",
    "servo on and automatic start on one channel: arbitration and the interval",
    (_SERVO, _START),
    (_OUTPUTS[0], *_OUTPUTS[3:]),
    (*_LEFT, Quiet("no answer ever", SKIPPED, lambda _: "servo off, program stands")),
    pins=((True, True), (False, False)),
)

INPUTS = Model(
    "inputs",
    "the interval with all pins, a late scan and a longer margin",
    (
        _SERVO,
        Block("Sequence", "FB_SequenceControl", "Timeout := T#150ms", "level", bits=(8,),
              does=(DOWN, UP)),
    ),
    (
        Situation("outputs off", so=_READY),
        Situation("outputs on", so=_READY | 0x0404),
        Situation("link down", connected=False),
    ),
    (
        Quiet("answers at once", DOWN, lambda wire: f"outputs {'on' if wire.bits & 2 else 'off'}"),
        Quiet("blocks not called any more", SKIPPED, lambda _: "outputs off"),
        Quiet("no answer ever, blocks end by Timeout", DOWN, lambda _: "outputs off", True),
    ),
    pins=((True, True), (True, False), (False, True), (False, False)),
    gaps=(1, 2),
    margin_ms=50,
)  # fmt: skip

EMERGENCY = Model(
    "emergency",
    "FB_EmergencyStop holds SI(00), FB_ServoOnFromEmergencyStop releases it",
    (
        Block("Stop", "FB_EmergencyStop", "Timeout := T#150ms", "emergency", does=(DOWN, UP),
              answer=(0x0005, 0x0001)),
        Block("Back", "FB_ServoOnFromEmergencyStop", "Timeout := T#150ms", "release emergency",
              bits=(14, 1), answer=(0x0004, 0x0004)),
    ),
    (
        Situation("emergency stop", so=_READY | _EMERGENCY | _ALARM),
        Situation("alarm", so=_READY | _ALARM),
        Situation("servo off", so=_READY),
        Situation("servo on", so=_READY | 0x0004),
        Situation("link down", connected=False),
    ),
    (
        Quiet("answers at once", DOWN, lambda wire: (
            "emergency stop" if not wire.bits & 1 else "servo on" if wire.bits & 2 else "servo off"
        )),
        Quiet("alarm stays, blocks end by Timeout", DOWN, lambda _: "alarm", True),
    ),
    pins=((True, False), (False, False)),
)  # fmt: skip

STOP = Model(
    "stop",
    "FB_ProgramStop holds SI(06), FB_ProgramContinue releases it",
    (
        Block("Stop", "FB_ProgramStop", "Timeout := T#150ms", "stop", does=(DOWN, UP),
              answer=(0x0800, 0)),
        Block("Back", "FB_ProgramContinue", "Timeout := T#150ms", "release stop", bits=(10,),
              answer=(0x0800, 0x0800)),
    ),
    _OUTPUTS[:2] + _OUTPUTS[4:],
    (
        Quiet("answers at once", DOWN, lambda wire: (
            f"servo off, program {'runs' if wire.bits & 0x0400 else 'stands'}"
        )),
        Quiet("no answer ever, blocks end by Timeout", DOWN,
              lambda _: "servo off, program stands", True),
    ),
    pins=((True, True), (True, False)),
)  # fmt: skip

_COUNTED = "Scan := Robot.Inner.Scan, InScan := Robot.Inner.InScan, Elapsed := Robot.Inner.Elapsed"

JOBS = Model(
    "jobs",
    "three FB_RcxJob alone on one channel, with any answer and any trouble",
    tuple(
        Block(name, "FB_RcxJob",
              f"Channel := Robot.Inner.Sequence, Longest := {limit}, {_COUNTED}, "
              "Trouble := Trouble, Settled := TRUE, Applied := Applied, "
              "Answer := BOOL_TO_WORD(Answered)",
              "job", does=does)
        for name, limit, does in (
            ("First", 100, (DOWN, UP, SKIPPED)), ("Second", 0, (DOWN, UP, SKIPPED)),
            ("Third", 50, (DOWN, UP)),
        )
    ),
    (Situation("ready", so=_CPU),),
    (Quiet("blocks not called any more", SKIPPED, lambda _: "ready"),),
    pins=((False, False),),
    variables="    Trouble : WORD;\n",
    statements="  Trouble := WORD#16#0000;\n"
    "  IF Refuse THEN Trouble := WORD#16#8003; END_IF;\n",
    switches={"Applied": (False, True), "Answered": (False, True), "Refuse": (False, True)},
)  # fmt: skip

RETRIES = Model(
    "retries",
    "three FB_RcxJob on one channel that are tried again and again, give up, and lose the link",
    tuple(
        Block(name, "FB_RcxJob",
              f"Channel := Robot.Inner.Sequence, Longest := {limit}, {_COUNTED}, "
              f"Trouble := WORD#16#0000, Settled := TRUE, Applied := {name}.Active, "
              "Answer := Robot.Status OR BOOL_TO_WORD(NOT Robot.Connected) "
              "OR SHL(BOOL_TO_WORD(NOT Robot.Connected), 15)",
              "job", does=does)
        for name, limit, does in (
            ("First", 0, (DOWN, UP)), ("Second", 50, (DOWN, UP, SKIPPED)), ("Third", 0, (DOWN, UP)),
        )
    ),
    (
        Situation("no answer", so=_CPU),
        Situation("answer", status=0x0200, so=_CPU),
        Situation("link down", connected=False),
    ),
    (Quiet("answers at once", DOWN, lambda _: "answer", idle_blocks=True, most=6),),
    pins=((False, False),),
    queue=8,
)  # fmt: skip

#: Two small models that quickly find errors which need many scans to appear.
ALONE = replace(
    COMMANDS,
    name="alone",
    title="one remote command, with any status and a link that stays",
    blocks=COMMANDS.blocks[:1],
    situations=COMMANDS.situations[:4],
)

STOPPED = replace(
    JOG,
    name="stopped",
    title="a jog that is stopped, a longer margin: the next command waits for SI(06)",
    blocks=tuple(replace(block, does=(DOWN, UP)) for block in JOG.blocks),
    situations=JOG.situations[:4],
    quiet=JOG.quiet[:2],
    pins=((True, True),),
    margin_ms=50,
)

MODELS = (
    COMMANDS, ARBITRATION, JOG, CONTINUOUS, SEQUENCES, INPUTS, EMERGENCY, STOP, JOBS, RETRIES,
    ALONE, STOPPED,
)  # fmt: skip
