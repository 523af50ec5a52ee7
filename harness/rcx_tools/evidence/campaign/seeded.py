"""Seeded bugs in blocks: the campaign must find each of them."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rcx_harness.verify.storm.storms import Failure
from rcx_tools.evidence.broken import broken_library
from rcx_tools.evidence.campaign.run import compiled, run_storms
from rcx_tools.evidence.campaign.schedule import draw_run

__all__ = ["SEEDED", "Found", "Seeded", "find"]


class Seeded(NamedTuple):
    """A seeded bug: its description, the file, and the text that is replaced."""

    name: str
    file: str
    old: str
    new: str
    kinds: tuple[str, ...]
    """The kinds of findings by which it may be found first."""


class Found(NamedTuple):
    """The seed by which a seeded bug was found, and the failure."""

    seed: int
    failure: Failure


SEEDED: tuple[Seeded, ...] = (
    Seeded(
        "a command is sent again after its end",
        "core/FB_RcxHandshake.st",
        "IF Hold OR NOT Robot.Inner.CodeRequest THEN",
        "IF Hold OR NOT (Robot.Inner.CodeRequest OR Robot.Inner.Running) THEN",
        ("starts by itself", "executed twice"),
    ),
    Seeded(
        "Done without the end status",
        "core/FB_RcxTakeHead.st",
        "  Robot.Inner.Answer := WORD#16#0000;",
        "  Robot.Inner.Answer := WORD#16#0200;",
        ("not executed", "wrong end", "wrong data", "Done without its effect"),
    ),
    Seeded(
        "a link loss does not end the work: it goes on afterwards",
        "core/FB_RcxTakeHead.st",
        "    Robot.Inner.Answer := WORD#16#8001;",
        "    Robot.Inner.Answer := WORD#16#0000;",
        ("executed twice", "executed unasked", "rule command held"),
    ),
    Seeded(
        "an abnormal end is shown as Done",
        "core/FB_RcxTakeHead.st",
        "    Robot.Inner.Answer := WORD#16#8020;",
        "    Robot.Inner.Answer := WORD#16#0200;",
        ("wrong end",),
    ),
    Seeded(
        "the words of a position are swapped",
        "command/definition/FB_WritePoint.st",
        "          Data[2 * k + 2] := FC_RcxLowWord(Value := Pulses[k]);\n"
        "          Data[2 * k + 3] := FC_RcxHighWord(Value := Pulses[k]);",
        "          Data[2 * k + 2] := FC_RcxHighWord(Value := Pulses[k]);\n"
        "          Data[2 * k + 3] := FC_RcxLowWord(Value := Pulses[k]);",
        ("starts by itself",),
    ),
    Seeded(
        "inputs are taken while the block is busy",
        "command/movement/FB_MoveDirectPulses.st",
        "  IF Execute AND NOT (Job.Busy OR Job.WasExecute) THEN",
        "  IF Execute THEN",
        ("rule command held", "rule hold-command", "starts by itself", "not executed"),
    ),
    Seeded(
        "dedicated inputs follow each other at once",
        "core/FB_RcxDedicatedInputs.st",
        "  IF Pace.Q AND NOT Restart THEN",
        "  IF NOT Restart THEN",
        ("rule interval",),
    ),
    Seeded(
        "the margin for the network is forgotten",
        "core/FB_RcxMakeHead.st",
        "  Spacing := Spacing + Extra;\n",
        "",
        ("rule interval", "rule ready-first", "rule hold-command"),
    ),
    Seeded(
        "a turn is never given back after a timeout",
        "core/FB_RcxHandshake.st",
        "    ELSE\n      Robot.Inner.Command.Serving := Robot.Inner.Command.Lowest;",
        "    ELSIF NOT Robot.Inner.Command.Orphan THEN\n"
        "      Robot.Inner.Command.Serving := Robot.Inner.Command.Lowest;",
        ("not at rest",),
    ),
    Seeded(
        "the hold of SI(00) comes back by itself",
        "core/FB_RcxMakeHead.st",
        "  Robot.EmergencyStopOk := EmergencyStopOk AND NOT Robot.Inner.HoldEmergency;",
        "  Robot.EmergencyStopOk := TRUE;",
        ("starts by itself", "Done without its effect"),
    ),
    Seeded(
        "a jog does not stop",
        "command/movement/FB_Jog.st",
        "  Robot.Inner.StopJog := Robot.Inner.StopJog OR (Out AND Halt AND Job.Busy);\n",
        "",
        ("jog goes on",),
    ),
    Seeded(
        "general-purpose words go out during a command",
        "core/FB_RcxMakeHead.st",
        "  IF Robot.Inner.Phase = PHASE_COMMAND_DATA OR Robot.Inner.Phase = PHASE_COMMAND_RUN THEN",
        "  IF Robot.Inner.Phase = PHASE_COMMAND_DATA THEN",
        ("rule command held", "rule hold-command", "starts by itself", "not executed"),
    ),
)


def find(
    seeded: Seeded,
    engine: str,
    *,
    storms: int = 2,
    most: int = 30,
    tried: Callable[[], None] = lambda: None,
) -> Found | None:
    """Run seed after seed on the broken library until a run fails; return None if none fails."""
    with broken_library(seeded.file, seeded.old, seeded.new) as lib:
        program = compiled(engine, lib)
        for seed in range(most):
            conditions, acts = draw_run(seed, storms)
            try:
                run_storms(program, conditions, acts, seed)
            except Failure as failure:
                return Found(seed, failure)
            finally:
                tried()
    return None
