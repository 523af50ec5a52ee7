"""A small cell for campaigns that feeds a part every 200 ms while it runs, with optional bugs."""

from __future__ import annotations

from pathlib import Path

_PROGRAM = """PROGRAM Feeder
  VAR
    InputArea  : RCX_IMAGE;
    OutputArea : RCX_IMAGE;
    Connected  : BOOL;
    Closed     : BOOL;
    Go         : BOOL;
    Reset      : BOOL;
    Running    : BOOL;
    Broken     : BOOL;
    Lost       : BOOL;
    Speed      : INT := 5;
    Fed        : DINT;
    Wait       : TON;
    Robot      : RCX_REF;
    ReadArea   : FB_ReadArea;
    WriteArea  : FB_WriteArea;
  END_VAR
  VAR RETAIN
    Total      : DINT;
  END_VAR

  ReadArea(Robot := Robot, Image := InputArea, Connected := Connected);
  IF Reset AND Connected AND Closed THEN
    Broken := FALSE;
  END_IF;
  IF NOT Connected {or_open} THEN
    Broken := TRUE;
    {latch}
  END_IF;
  IF Broken OR Lost THEN
    Running := FALSE;
  ELSIF Go THEN
    Running := TRUE;
  END_IF;
  Wait(IN := Running AND NOT Wait.Q, PT := T#200ms);
  IF Wait.Q THEN
    Fed := Fed + DINT#1;
    Total := Total + DINT#1;
  END_IF;
  WriteArea(Robot := Robot, Image := OutputArea, EmergencyStopOk := TRUE, StopOk := TRUE);
END_PROGRAM
"""

#: Actions of the cell's operator, and requirements.
DEMANDS = """length = "2s"
[operator]
buttons = ["Main.Go", "Main.Reset"]
switches = ["Main.Closed"]
values = { "Main.Speed" = [1, 5, 9] }
[faults]
only = ["link_down", "plc_overrun"]
[[always]]
name = "closed"
that = "NOT (Main.Running AND NOT Main.Closed)"
[recover]
set = { "Main.Closed" = true }
steps = [ { press = "Main.Reset", wait = "50ms" }, { press = "Main.Go" } ]
when = "Main.Fed > BEFORE(Main.Fed)"
within = "1s"
"""

#: The operator closes, resets and starts the feeder. It then runs until 2 s.
GOOD_RUN = """at = [
  { time = "100ms", set = { "Main.Closed" = true } },
  { time = "300ms", set = { "Main.Reset" = true }, for = "50ms" },
  { time = "400ms", set = { "Main.Go" = true }, for = "50ms" },
  { time = "1s", set = { "Main.Speed" = 7 } },
]
"""


def feeder(folder: Path, *, runs_open: bool = False, latches: bool = False) -> Path:
    """Write program, requirements and a good run.

    Args:
        folder: Folder of the program.
        runs_open: Whether to insert a bug: the feeder continues to run when it is opened.
        latches: Whether to insert a bug: the fault after a link loss is never reset.
    """
    latch = "Lost := Lost OR (Running AND NOT Connected);" if latches else "Lost := FALSE;"
    text = _PROGRAM.format(or_open="" if runs_open else "OR NOT Closed", latch=latch)
    program = folder / "Feeder.st"
    program.write_text(text)
    (folder / "campaign.toml").write_text(DEMANDS)
    (folder / "good.toml").write_text(GOOD_RUN)
    return program
