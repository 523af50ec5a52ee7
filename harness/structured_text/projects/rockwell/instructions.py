"""Blocks, functions and structures for the tags of TONR, OSRI, OSFI and of ladder instructions."""

from __future__ import annotations

from collections.abc import Mapping

from structured_text.projects.rockwell.data import Data
from structured_text.projects.rockwell.ladder.functions import FUNCTIONS

__all__ = ["BLOCKS", "HELPERS", "HELPER_MEMBERS"]

#: The instruction TONR. The first run clears the timer. A negative preset stops the timer. ACC
#: counts whole milliseconds; the rest of the time counts in the next call. Source: 1756-RM003,
#: TONR.
_TIMER = """\
FUNCTION_BLOCK FBD_TIMER
  VAR_INPUT RETAIN
    TimerEnable, Reset : BOOL;
    PRE : DINT;
  END_VAR
  VAR_OUTPUT
    EN, TT, DN, InstructFault, PresetInv : BOOL;
    ACC, Status : DINT;
  END_VAR
  VAR
    HasRun : BOOL;
    Clock : TON;
    Rest : TIME;
  END_VAR
  IF NOT HasRun THEN
    EN := FALSE;
    TT := FALSE;
    DN := FALSE;
    ACC := 0;
    HasRun := TRUE;
  END_IF;
  PresetInv := PRE < 0;
  InstructFault := PresetInv;
  Status := 0;
  IF PresetInv THEN
    Status := 3;
    RETURN;
  END_IF;
  Clock(IN := TRUE, PT := T#100s);
  Rest := Rest + Clock.ET;
  Clock(IN := FALSE, PT := T#100s);
  Clock(IN := TRUE, PT := T#100s);
  IF NOT EN THEN
    Rest := T#0s;
  END_IF;
  EN := TimerEnable AND NOT Reset;
  IF NOT EN THEN
    ACC := 0;
  END_IF;
  WHILE Rest >= T#1s DO
    Rest := Rest - T#1s;
    IF EN AND NOT DN THEN
      ACC := ACC + 1000;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#10ms DO
    Rest := Rest - T#10ms;
    IF EN AND NOT DN THEN
      ACC := ACC + 10;
    END_IF;
  END_WHILE;
  WHILE Rest >= T#1ms DO
    Rest := Rest - T#1ms;
    IF EN AND NOT DN THEN
      ACC := ACC + 1;
    END_IF;
  END_WHILE;
  DN := EN AND ACC >= PRE;
  TT := EN AND NOT DN;
END_FUNCTION_BLOCK"""
#: The one-shot instructions OSRI and OSFI.
_ONESHOT = """\
FUNCTION_BLOCK FBD_ONESHOT
  VAR_INPUT RETAIN
    InputBit, Falling : BOOL;
  END_VAR
  VAR_OUTPUT
    OutputBit : BOOL;
  END_VAR
  VAR
    Before : BOOL;
  END_VAR
  IF Falling THEN
    OutputBit := Before AND NOT InputBit;
  ELSE
    OutputBit := InputBit AND NOT Before;
  END_IF;
  Before := InputBit;
END_FUNCTION_BLOCK"""
#: Structures for the tags of ladder instructions.
_LADDER = {
    "TIMER": {"BOOL": ("EN", "TT", "DN"), "DINT": ("PRE", "ACC")},
    "COUNTER": {"BOOL": ("CU", "CD", "DN", "OV", "UN"), "DINT": ("PRE", "ACC")},
    "CONTROL": {
        "BOOL": ("EN", "EU", "DN", "EM", "ER", "UL", "IN", "FD"),
        "DINT": ("LEN", "POS"),
    },
}
#: Members that a structure has in addition, and that no statement of the project can use.
_HIDDEN = {"TIMER": "    Clock : TON;\n    Rest : TIME;\n"}
#: Names of the helper types that are function blocks.
BLOCKS = ("FBD_TIMER", "FBD_ONESHOT")
#: The Structured Text of the helper types, by name.
HELPERS = {
    "FBD_TIMER": _TIMER,
    "FBD_ONESHOT": _ONESHOT,
    **FUNCTIONS,
    **{
        name: f"TYPE {name} : STRUCT\n"
        + "".join(f"    {', '.join(names)} : {kind};\n" for kind, names in members.items())
        + _HIDDEN.get(name, "")
        + "  END_STRUCT;\nEND_TYPE"
        for name, members in _LADDER.items()
    },
}
#: The members of the helper types, in upper case.
HELPER_MEMBERS: dict[str, Mapping[str, Data]] = {
    "FBD_TIMER": {
        **dict.fromkeys(("TIMERENABLE", "RESET", "EN", "TT", "DN"), Data("BOOL")),
        **dict.fromkeys(("INSTRUCTFAULT", "PRESETINV"), Data("BOOL")),
        **dict.fromkeys(("PRE", "ACC", "STATUS"), Data("DINT")),
    },
    "FBD_ONESHOT": dict.fromkeys(("INPUTBIT", "OUTPUTBIT"), Data("BOOL")),
    **{
        name: {one: Data(kind) for kind, names in members.items() for one in names}
        for name, members in _LADDER.items()
    },
}
