"""The last links of all chains: what holds the robot up, and who has to act.

Name, section and remedy of most causes are those of an ErrorID (spec/errors.toml), so this table
and docs/reference/errors.md cannot differ.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

from rcx_harness.spec import alarms, folder, public_alarms
from structured_text.output.toml_files import load_toml

__all__ = ["CAUSES", "OF_ALARM", "OF_ERROR", "Cause", "Step", "alarm_name", "error_entry"]


@dataclass(frozen=True)
class Cause:
    """A last link.

    Attributes:
        key: Its name in the JSON output.
        who: Who has to act: operator, program, robot program, or nobody.
        section: The section of the manual, or a page of ours.
        error: ErrorID with the remedy; 0 if there is none.
        remedy: What to do; empty: the remedy of the ErrorID.
        stands: Whether something waits. If not, the robot works or nothing is requested.
    """

    key: str
    who: str
    section: str
    error: int = 0
    remedy: str = ""
    stands: bool = True

    @property
    def to_go_on(self) -> str:
        """Return what to do."""
        return self.remedy or str(error_entry(self.error)["remedy"])


class Step(NamedTuple):
    """A link of a chain: a sentence without a full stop, and what it is derived from.

    `since_us` is the time from which on it was so; None if it is not known. `signal` is the signal
    or variable that shows it.
    """

    text: str
    signal: str = ""
    since_us: int | None = None
    section: str = ""
    controller: int = 1


_AUTHORITY = (
    "Release the control authority of the programming box, and end a safety setting that disables "
    "inputs and commands. Then give a new rising edge."
)
_LINK = (
    "Check cable, scanner and the controller's power. When the link is back, acknowledge the fault "
    "and start again: nothing restarts by itself."
)
_ALARM = (
    "Remove the cause that the programming box shows, then run FB_AlarmReset (SI(16)), and switch "
    "the servos on."
)

CAUSES: Mapping[str, Cause] = {
    cause.key: cause
    for cause in (
        Cause("plc-stopped", "operator", "ch. 1, 5", 0, "Set the PLC to RUN."),
        Cause("controller-off", "operator", "ch. 1, 5", 0, "Switch the controller's power on."),
        Cause("link", "operator", "ch. 1, 5.2", 0, _LINK),
        Cause("connected-pin", "program", "scan-model.md", 0x8001),
        Cause("not-received", "operator", "ch. 5, 4", 0, "Check the scanner's outputs and n."),
        Cause("cpu", "operator", "ch. 5, 2", 0x8002),
        Cause("emergency-stop-input", "program", "ch. 5, 3.1", 0x8003),
        Cause("emergency-stop-robot", "operator", "ch. 5, 3.1", 0x8009),
        Cause("alarm", "operator", "ch. 5, 2", 0x8004, _ALARM),
        Cause("main-power", "operator", "ch. 5, 2", 0x8005),
        Cause("manual-mode", "operator", "ch. 5, 3.2", 0x8006),
        Cause("stop-input", "program", "ch. 5, 3.3", 0x8007),
        Cause(
            *("parallel-stop", "operator", "ch. 1, 5.1", 0),
            "Supply the DIO connector and release its stop input DI06, or set the board invalid.",
        ),
        Cause("no-authority", "operator", "guide, 3", 0, _AUTHORITY),
        Cause("servos-off", "program", "ch. 5, 3.1", 0x800C),
        Cause("origin", "operator", "ch. 5, 2", 0x807B),
        Cause(
            "interval",
            "program",
            "ch. 5, 3",
            0,
            "Set Interval to at least T#100ms and Margin "
            "of FB_WriteArea to RPI + jitter + 5 ms, then give a new rising edge.",
        ),
        Cause("program-not-running", "program", "ch. 5, 3.2", 0x8082),
        Cause(
            *("robot-program-waits", "robot program", "robot-language.md", 0),
            "Bring the condition of this line, or correct the line.",
        ),
        Cause(
            "channel-held",
            "program",
            "guide, 1.1",
            0,
            "End the command that holds the channel: "
            "set Execute or Enable of its block to FALSE, or use a Timeout.",
        ),
        Cause(
            "orphan",
            "program",
            "guide, 1.1",
            0x8012,
            "Call the block of this command in every "
            "scan until it is no longer Busy. The stop input SI(06) ends the command.",
        ),
        Cause("not-called", "program", "scan-model.md", 0x8013),
        Cause("called-twice", "program", "scan-model.md", 0x8016),
        Cause("out-of-place", "program", "scan-model.md", 0x8017),
        Cause("area-held", "program", "errors.md", 0x8078),
        Cause("area-kept", "operator", "errors.md", 0x8079),
        Cause("command-alarm", "program", "guide, 1.2", 0x8020),
        Cause("error", "program", "errors.md", 0x8020),
        Cause(
            "acknowledge",
            "operator",
            "errors.md",
            0,
            "Its cause has ended. Acknowledge the "
            "fault in the PLC program (Reset), and start again.",
        ),
        Cause("no-reset", "program", "guide, 1.2", 0, "Send the code 16#0000 (status reset)."),
        Cause("never-ready", "program", "guide, 1.2", 0x8015),
        Cause(
            *("executes", "nobody", "guide, 1.2", 0),
            "Wait. A block or the controller works, and nothing holds it up.",
            stands=False,
        ),
        Cause(
            *("not-requested", "program", "", 0),
            "Nothing is requested. Press Start, or look for the condition in the program that "
            "gives Execute.",
            stands=False,
        ),
        Cause(
            *("not-recorded", "program", "", 0),
            "The controller waits for the program. Record what its blocks wait for (see below).",
            stands=False,
        ),
        Cause("unknown", "", "", 0, "Record a trace with more variables (see below)."),
    )
}

#: The condition that an ErrorID reports. All other ErrorIDs are the last link themselves.
OF_ERROR: Mapping[int, str] = {
    0x8001: "link",
    0x8002: "cpu",
    0x8003: "emergency",
    0x8004: "alarm",
    0x8005: "main-power",
    0x8006: "manual-mode",
    0x8007: "stop-input",
    0x8009: "emergency",
    0x800A: "alarm",
    0x800B: "servo-request",
    0x800C: "servos-off",
    0x8010: "request",
    0x8011: "command",
    0x8012: "orphan",
    0x8013: "not-called",
    0x8015: "never-ready",
    0x8016: "called-twice",
    0x8017: "out-of-place",
    0x8020: "abnormal-end",
    0x8078: "area-held",
    0x8079: "area-kept",
    0x807B: "origin",
    0x8080: "robot-program",
    0x8081: "robot-program",
    0x8082: "program-not-running",
}

#: The condition that an alarm of a remote command reports (names: spec/public_alarms.toml).
OF_ALARM: Mapping[str, str] = {
    "0.20": "manual-mode",
    "0.21": "no-authority",
    "0.22": "no-authority",
    "6.300": "main-power",
    "6.301": "servos-off",
    "6.302": "origin",
    "12.76": "no-authority",
    "12.400": "stop-input",
    "12.551": "link",
    "12.552": "link",
    "12.600": "emergency",
}


@lru_cache(maxsize=1)
def _errors() -> Mapping[int, Mapping[str, Any]]:
    return {entry["id"]: entry for entry in load_toml(folder() / "errors.toml")["error"]}


def error_entry(number: int) -> Mapping[str, Any]:
    """Return the entry of an ErrorID in spec/errors.toml; empty texts if there is none."""
    return _errors().get(number, {"name": "", "cause": "", "remedy": ""})


def alarm_name(number: str) -> str:
    """Return the name of an alarm; empty if it is not known."""
    known = alarms().get(number)
    return known.name if known else public_alarms().get(number, "")
