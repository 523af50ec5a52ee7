"""Stand-stills with a known cause: an example or a small program, and what was done to it.

`expected` is the last link as derived by hand from what was planted, never from the code.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["CELL", "STAND_STILLS", "StandStill", "cell_text"]

#: Variables that show what each block does.
WATCH = "Main.*,Main.*.Busy,Main.*.Active,Main.*.ErrorID"
_OF_TWO = "Main.*,Main.*.*,Main.*.Lock.*,Main.*.*.Busy,Main.*.*.Active,Main.*.*.ErrorID"
_SAFE = {"time": "100ms", "set": {"Main.CellSafe": True}}
_START = [
    _SAFE,
    {"time": "500ms", "set": {"Main.Start": True}},
    {"time": "700ms", "set": {"Main.Start": False}},
]

#: A program of our own. `{calls}` are the calls between FB_ReadArea and FB_WriteArea.
CELL = """
PROGRAM Cell
  VAR
    InputArea, OutputArea : RCX_IMAGE;
    Connected, CellSafe   : BOOL;
    NoStop                : BOOL := TRUE;
    Start, Now            : BOOL;
    k                     : INT;
    Robot     : RCX_REF;
    ReadArea  : FB_ReadArea;
    WriteArea : FB_WriteArea;
    ServoOn   : FB_ServoOn;
    Begin     : FB_AutoStart;
    Halt      : FB_EmergencyStop;
    Move, Slow : FB_MovePtp;
    Jog       : FB_Jog;
    Read      : FB_ReadPoint;
    Call      : FB_ProgramCall;
  END_VAR
  {before}
  ReadArea(Robot := Robot, Image := InputArea, m := 0, Size := 48, Connected := {connected});
  Now := Now OR Start;
  k := k + 1;
  ServoOn(Robot := Robot, Execute := {servo});
  {calls}
  WriteArea(Robot := Robot, Image := OutputArea, n := 0, Size := 48, {margin}
            EmergencyStopOk := CellSafe, StopOk := CellSafe AND NoStop);
END_PROGRAM
CONFIGURATION Config0
  RESOURCE Res0 ON PLC
    TASK Cyclic(INTERVAL := T#10ms, PRIORITY := 0);
    PROGRAM Main WITH Cyclic : Cell;
  END_RESOURCE
END_CONFIGURATION
"""


def cell_text(
    calls: str = "",
    *,
    before: str = "",
    connected: str = "Connected",
    servo: str = "Now",
    margin: str = "",
) -> str:
    """Return the text of the program of our own."""
    return CELL.format(calls=calls, before=before, connected=connected, servo=servo, margin=margin)


@dataclass(frozen=True)
class StandStill:
    """A planted stand-still.

    Attributes:
        name: What was planted.
        expected: The key of the last link, or the ErrorID of the last link.
        program: Folder of an example, or the text of a program.
        at: Moments of the stimulus after those that start the cell.
        watch: The watched variables; empty: the areas alone.
        robot: Text of the robot file; None for the robot file of the example.
        starts: Whether the operator starts the cell.
        length: How long the run is.
        controller: The controller of the last link.
        alone: The last link that the areas alone show, if it is another.
        robot_program: A robot program instead of that of the example: (old, new) text.
    """

    name: str
    expected: str | int
    program: str = "01_power_up"
    at: Sequence[dict[str, Any]] = ()
    watch: str = WATCH
    robot: str | None = None
    starts: bool = True
    safe: bool = True
    length: str = "3s"
    controller: int = 1
    robot_program: tuple[str, str] | None = None
    alone: str = ""

    def moments(self) -> list[dict[str, Any]]:
        """Return the moments of the stimulus."""
        begin = (_START if self.starts else [_SAFE]) if self.safe else _START[1:]
        return [*begin, *self.at]


def _event(time: str, event: str, **more: Any) -> dict[str, Any]:
    return {"time": time, "robot": event, **more}


_ONE_MOVE = (
    "Move(Robot := Robot, Execute := ServoOn.Done, Point := 19,\n"
    "       SpeedMode := SPEED_PERCENT, Speed := 50.0);"
)
_JOB = (
    "Begin(Robot := Robot, Execute := ServoOn.Done);\n"
    "  Call(Robot := Robot, InputImage := InputArea, OutputImage := OutputArea,\n"
    "       Execute := Begin.Done, JobNumber := 1);"
)
_JOG = "Jog(Robot := Robot, Enable := ServoOn.Done, Timeout := T#0s);"
_MOVE_LATE = "Move(Robot := Robot, Execute := k > 200, Point := 19, Timeout := T#0s);"
_SLOW = (
    "Slow(Robot := Robot, Execute := ServoOn.Done, Point := 19, SpeedMode := SPEED_DIRECT,\n"
    "       Speed := 0.1, Timeout := T#0s);"
)
_FAR = "points.10.pulses = [9000000, 0, 0, 0]\npoints.20.pulses = [0, 0, 0, 0]\n"
_POINTS = "points.10.pulses = [100000, 20000, 0, 0]\npoints.20.pulses = [0, 0, 0, 0]\n"
_NO_POINTS = "points.20.pulses = [0, 0, 0, 0]\n"

STAND_STILLS = (
    StandStill("the cell is never safe, areas alone", "emergency-stop-input", safe=False, watch=""),
    StandStill("the cell is never safe", "emergency-stop-input", safe=False),
    StandStill(
        "the link is lost, areas alone",
        "link",
        watch="",
        at=[_event("600ms", "link_down")],
    ),
    StandStill("the link is lost", "link", at=[_event("1200ms", "link_down")]),
    StandStill(
        "the link was lost for a time",
        "alarm",
        at=[_event("900ms", "link_down"), _event("1400ms", "link_up")],
    ),
    StandStill("MANUAL mode", "manual-mode", at=[_event("50ms", "manual_mode")]),
    StandStill("MANUAL mode later", "manual-mode", watch="", at=[_event("700ms", "manual_mode")]),
    StandStill("the box has authority", "no-authority", at=[_event("300ms", "pendant_on")]),
    StandStill(
        "the box has authority, and the block gave up",
        "no-authority",
        at=[_event("300ms", "pendant_on")],
        length="7s",
    ),
    StandStill(
        "the box has authority, areas alone",
        "no-authority",
        watch="",
        at=[_event("300ms", "pendant_on")],
        length="7s",
    ),
    StandStill("a safety setting", "no-authority", at=[_event("300ms", "safety_on")]),
    StandStill("an alarm", "alarm", at=[_event("900ms", "alarm")]),
    StandStill("an alarm, areas alone", "alarm", watch="", at=[_event("900ms", "alarm")]),
    StandStill("an emergency stop", "emergency-stop-robot", at=[_event("1s", "emergency_stop")]),
    StandStill(
        "an emergency stop, areas alone",
        "emergency-stop-robot",
        watch="",
        at=[_event("1s", "emergency_stop")],
    ),
    StandStill(
        "an emergency stop that was released",
        "alarm",
        at=[_event("1s", "emergency_stop"), _event("1500ms", "emergency_stop_release")],
    ),
    StandStill("no main power", "main-power", at=[_event("300ms", "main_power_off")]),
    StandStill("the controller has no power", "controller-off", at=[_event("1s", "power_off")]),
    StandStill(
        "the cell is no longer safe",
        "emergency-stop-input",
        at=[{"time": "1500ms", "set": {"Main.CellSafe": False}}],
    ),
    StandStill("Start was not pressed", "not-requested", starts=False),
    StandStill("Start was not pressed, areas alone", "not-recorded", starts=False, watch=""),
    StandStill(
        "the PLC is in STOP", "plc-stopped", at=[{"time": "1200ms", "plc": "stop"}], watch=""
    ),
    StandStill("a point beyond the soft limits", "command-alarm", "04_pick_and_place", robot=_FAR),
    StandStill(
        "a point that is not defined",
        "command-alarm",
        "04_pick_and_place",
        robot=_NO_POINTS,
    ),
    StandStill(
        "the box takes authority between two commands",
        "no-authority",
        "04_pick_and_place",
        at=[_event("2s", "pendant_on")],
        length="4s",
    ),
    StandStill(
        "the parallel stop input",
        "parallel-stop",
        "04_pick_and_place",
        at=[_event("1s", "parallel_stop")],
        robot='parallel_io = "valid"\n' + _POINTS,
    ),
    StandStill(
        "the link is lost in a movement",
        "link",
        "04_pick_and_place",
        at=[_event("2s", "link_down")],
    ),
    StandStill(
        "another robot holds the area and has lost its link",
        "link",
        "12_two_robots",
        watch=_OF_TWO,
        starts=False,
        at=[
            {"time": "500ms", "set": {"Main.Key1.Start": True, "Main.Key2.Start": True}},
            _event("2300ms", "link_down", controller=2),
        ],
        length="6s",
        controller=2,
    ),
    StandStill(
        "the robot program has ended",
        "program-not-running",
        "16_robot_program",
        at=[_event("2s", "program_end")],
        length="4s",
    ),
    StandStill(
        "a handshake on another bit than the PLC's",
        "robot-program-waits",
        "16_robot_program",
        robot_program=("WAIT SI(20)=1", "WAIT SI(21)=1"),
        length="4s",
    ),
    StandStill(
        "the robot program waits for a sensor",
        "robot-program-waits",
        "16_robot_program",
        robot_program=("  DO(20)=1\n", "  WAIT DI(20)=1\n"),
        length="5s",
    ),
    StandStill(
        "a block in front of FB_ReadArea",
        "out-of-place",
        cell_text(before="Move(Robot := Robot, Execute := Now, Point := 19);"),
    ),
    StandStill(
        "a block that is called twice", "called-twice", cell_text(_ONE_MOVE + "\n" + _ONE_MOVE)
    ),
    StandStill(
        "a block in an IF",
        "not-called",
        cell_text("IF k < 100 OR k > 110 THEN " + _ONE_MOVE + " END_IF;"),
    ),
    StandStill(
        "a jog holds the channel",
        "channel-held",
        cell_text(_JOG + "\n  " + _MOVE_LATE),
        alone="executes",
        length="4s",
    ),
    StandStill(
        "a command whose block is no longer called",
        "orphan",
        cell_text("IF k < 150 THEN " + _SLOW + " END_IF;\n  " + _MOVE_LATE),
        alone="executes",
        length="4s",
    ),
    StandStill(
        "an interval that is too short for the controller",
        "interval",
        cell_text(_ONE_MOVE, margin="Margin := T#0ms,"),
        robot="min_interval = 400\n",
    ),
    StandStill("an illegal speed", 0x8042, cell_text(_ONE_MOVE.replace("50.0", "150.0"))),
    StandStill(
        "the stop input is held",
        "stop-input",
        cell_text(_ONE_MOVE),
        at=[{"time": "0ms", "set": {"Main.NoStop": False}}],
    ),
    StandStill(
        "the stop input is held, and a program is started",
        "stop-input",
        cell_text("Begin(Robot := Robot, Execute := ServoOn.Done);"),
        at=[{"time": "0ms", "set": {"Main.NoStop": False}}],
    ),
    StandStill(
        "the servos are off",
        "servos-off",
        cell_text(_ONE_MOVE.replace("ServoOn.Done", "Now"), servo="FALSE"),
    ),
    StandStill(
        "Execute never rises",
        "not-requested",
        cell_text(_ONE_MOVE.replace("ServoOn.Done", "FALSE")),
    ),
    StandStill(
        "Connected is not wired",
        "connected-pin",
        cell_text(_ONE_MOVE, connected="FALSE"),
        alone="emergency-stop-input",
    ),
    StandStill(
        "a block holds the emergency stop",
        "emergency-stop-input",
        cell_text(_ONE_MOVE + "\n  Halt(Robot := Robot, Execute := k > 100);"),
    ),
    StandStill(
        "a size that does not exist",
        0x8030,
        cell_text(_ONE_MOVE).replace("Size := 48, Connected", "Size := 40, Connected"),
        alone="emergency-stop-input",
    ),
    StandStill(
        "a slow movement holds the channel",
        "channel-held",
        cell_text(_SLOW + "\n  " + _MOVE_LATE),
        alone="executes",
        length="4s",
    ),
    StandStill(
        "another robot lost its link in the area, and the link is back",
        "alarm",
        "12_two_robots",
        watch=_OF_TWO,
        starts=False,
        at=[
            {"time": "500ms", "set": {"Main.Key1.Start": True, "Main.Key2.Start": True}},
            _event("2300ms", "link_down", controller=2),
            _event("3s", "link_up", controller=2),
        ],
        length="6s",
        controller=2,
    ),
    StandStill(
        "the robot program never runs",
        "program-not-running",
        cell_text(
            _JOB.replace("Begin.Done", "Now").replace("Execute := ServoOn.Done", "Execute := FALSE")
        ),
        robot='[[programs]]\nname = "MAIN"\nsteps = ["WAIT SI(20)=1"]\n',
        length="4s",
        watch=f"{WATCH},Main.Call",
    ),
)
