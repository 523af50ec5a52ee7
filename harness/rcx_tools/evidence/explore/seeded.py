"""Seeded bugs in copies of blocks: each must be found, with a shortest trace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from rcx_tools.evidence.explore.search import LIBRARY

__all__ = ["SEEDED", "Seeded"]


@dataclass(frozen=True)
class Seeded:
    """A seeded bug.

    Attributes:
        name: A few words.
        block: The block to change in a copy.
        text: The text to replace; it must occur exactly once.
        instead: The new text.
        model: The model that finds it.
        rule: The rule that it breaks.
    """

    name: str
    block: str
    text: str
    instead: str
    model: str
    rule: str

    def library(self, folder: Path, library: Sequence[Path] = LIBRARY) -> list[Path]:
        """Write the changed copy into a folder; return the library with it."""
        files = []
        for file in library:
            if file.stem == self.block:
                source = file.read_text(encoding="utf-8")
                if source.count(self.text) != 1:
                    raise ValueError(f"{self.name}: {self.text!r} is not once in {file.name}")
                copy = folder / file.name
                copy.write_text(source.replace(self.text, self.instead), encoding="utf-8")
                files.append(copy)
            else:
                files.append(file)
        return files


SEEDED = (
    Seeded(
        "the interval is not waited for",
        "FB_RcxDedicatedInputs",
        "IF Pace.Q AND NOT Restart THEN",
        "IF NOT Restart THEN",
        "inputs",
        "interval",
    ),
    Seeded(
        "SI(06) goes ON together with SI(00)",
        "FB_RcxDedicatedInputs",
        "    Change := Change AND First;",
        "    Change := Change AND (First OR WORD#16#0040);",
        "inputs",
        "interval",
    ),
    Seeded(
        "the recovery of the link does not count as a change",
        "FB_RcxDedicatedInputs",
        "Restart := (Robot.Connected AND NOT WasUp) OR Seen <> Robot.Inner.Scan;",
        "Restart := Seen <> Robot.Inner.Scan;",
        "inputs",
        "interval",
    ),
    Seeded(
        "the code goes out with the data of the next holder",
        "FB_RcxHandshake",
        "Owner = Robot.Inner.Command.Serving\n"
        "        AND SameData AND Asked = Robot.Inner.Code THEN",
        "TRUE THEN",
        "commands",
        "data first",
    ),
    Seeded(
        "a command without its block is not held to its end",
        "FB_RcxHandshake",
        "ELSIF Endless AND Robot.Status",
        "ELSIF Robot.Status",
        "commands",
        "held",
    ),
    Seeded(
        "a holder that has gone keeps its turn",
        "FB_RcxHandshake",
        "    ELSE\n      Robot.Inner.Command.Serving := Robot.Inner.Command.Lowest;",
        "    ELSIF Robot.Inner.Command.Orphan THEN\n"
        "      Robot.Inner.Command.Serving := Robot.Inner.Command.Lowest;",
        "commands",
        "hang",
    ),
    Seeded(
        "a loss of CPU_OK does not end a command that waits",
        "FB_RcxJob",
        "IF Answer = WORD#16#8001 OR Answer = WORD#16#8002 THEN",
        "IF Answer = WORD#16#8001 OR (Answer = WORD#16#8002 AND Active) THEN",
        "commands",
        "unasked",
    ),
    Seeded(
        "a time limit that is sampled but not counted",
        "FB_RcxJob",
        "Waits := Longest > 0 AND (Active OR Channel.Orphan)",
        "Waits := FALSE",
        "alone",
        "hang",
    ),
    Seeded(
        "a falling Execute cancels",
        "FB_RcxJob",
        "  Ended := Busy; (* it may",
        "  Busy := Busy AND Execute;\n  Ended := Busy; (* it may",
        "commands",
        "contract",
    ),
    Seeded(
        "a jog that is not called any more goes on",
        "FB_RcxMakeHead",
        "(Robot.Inner.Command.Orphan OR Robot.Inner.StopJog)",
        "Robot.Inner.StopJog",
        "jog",
        "jog",
    ),
    Seeded(
        "a command goes out before SI(06) is back after a jog",
        "FB_RcxMakeHead",
        "Hold := JogHold",
        "Hold := FALSE",
        "stopped",
        "jog",
    ),
    Seeded(
        "the last comer is served first",
        "FB_RcxJob",
        "    IF Ticket = Channel.Serving THEN",
        "    IF Channel.NextTicket - Ticket = UINT#1 THEN",
        "arbitration",
        "turn",
    ),
    Seeded(
        "a hold that is asked for can be released in the same scan",
        "FB_RcxMakeHead",
        "Robot.Inner.HoldEmergency OR Robot.Inner.KeepEmergency",
        "Robot.Inner.HoldEmergency",
        "emergency",
        "hold",
    ),
    Seeded(
        "tickets of those who gave up are passed one in each scan",
        "FB_RcxDedicatedInputs",
        "    Robot.Inner.Sequence.Serving := Robot.Inner.Sequence.Lowest;",
        "    Robot.Inner.Sequence.Serving := Robot.Inner.Sequence.Serving + UINT#1;",
        "retries",
        "wait",
    ),
    Seeded(
        "a start goes out against a stop that is asked for",
        "FB_RcxDedicatedInputs",
        "Change := Change AND WORD#16#6100;",
        "Change := Change;",
        "sequences",
        "start",
    ),
)
