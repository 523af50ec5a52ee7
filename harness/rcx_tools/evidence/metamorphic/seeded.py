"""Blocks broken on purpose: each relation must find those that break it."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from rcx_tools.evidence.broken import broken_library
from rcx_tools.evidence.metamorphic.course import Options, follow
from rcx_tools.evidence.metamorphic.programs import Subject
from rcx_tools.evidence.metamorphic.relations import RELATIONS

__all__ = ["SEEDED", "Seeded", "find"]


class Seeded(NamedTuple):
    """A broken block: what is wrong, the relation and the program that tell, and the change."""

    name: str
    relation: str
    subject: str
    file: str
    old: str
    new: str


SEEDED: tuple[Seeded, ...] = (
    Seeded(
        "the outputs are read from a fixed place",
        "offsets",
        "chart servo_on",
        "area/FB_ReadArea.st",
        "    Bits := FC_RcxWord(LowByte := Image[m + 32], HighByte := Image[m + 33]);",
        "    Bits := FC_RcxWord(LowByte := Image[32], HighByte := Image[33]);",
    ),
    Seeded(
        "the inputs are also written at the beginning of the image",
        "offsets",
        "chart servo_on",
        "area/FB_WriteArea.st",
        "    Image[n + 33] := WORD_TO_BYTE(SHR(Robot.Inner.Applied, 8));",
        "    Image[n + 33] := WORD_TO_BYTE(SHR(Robot.Inner.Applied, 8));\n"
        "    Image[32] := WORD_TO_BYTE(Robot.Inner.Applied AND WORD#16#00FF);",
    ),
    Seeded(
        "with 256 bytes a byte behind the head is written",
        "size",
        "chart servo_on",
        "area/FB_WriteArea.st",
        "    Image[n + 33] := WORD_TO_BYTE(SHR(Robot.Inner.Applied, 8));",
        "    Image[n + 33] := WORD_TO_BYTE(SHR(Robot.Inner.Applied, 8));\n"
        "    Image[n + Size - 1] := WORD_TO_BYTE(SHR(Robot.Inner.Applied, 8) OR WORD#16#0001);",
    ),
    Seeded(
        "the block for words reads the status twice",
        "areas",
        "chart remote_command_abnormal_end",
        "area/FB_ReadAreaWords.st",
        "      Words[k] := Image[Start + k];",
        "      Words[k] := Image[Start];",
    ),
    Seeded(
        "a longer Interval is ignored",
        "scan time",
        "chart servo_on_from_emergency_stop",
        "core/FB_RcxMakeHead.st",
        "    Spacing := Interval;",
        "    Spacing := T#100ms;",
    ),
)


def find(seeded: Seeded, subject: Subject, engine: str = "builtin") -> str:
    """The difference by which a broken block is found; empty if it is not.

    Args:
        seeded: The broken block.
        subject: The program it names.
        engine: Which engine runs it.
    """
    relation = RELATIONS[seeded.relation]
    with broken_library(seeded.file, seeded.old, seeded.new) as lib:
        options = Options(engine=engine, lib=lib)
        base = follow(subject, options)
        for variant in relation.variants(subject, options, 0):
            course = follow(variant.subject, replace(variant.options, lib=lib))
            if difference := relation.differs(base, course):
                return f"{variant.name}: {difference}"
    return ""
