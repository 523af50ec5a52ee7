"""Seeded bugs in blocks: each relation must find the bugs that break it."""

from __future__ import annotations

from dataclasses import dataclass, replace

from rcx_tools.evidence.broken import Bug, broken_library, bugs
from rcx_tools.evidence.metamorphic.course import Options, follow
from rcx_tools.evidence.metamorphic.programs import Subject
from rcx_tools.evidence.metamorphic.relations import RELATIONS
from rcx_tools.evidence.results import ROOT

__all__ = ["SEEDED", "Seeded", "find"]


@dataclass(frozen=True)
class Seeded(Bug):
    """A seeded bug, with the relation and the program that reveal it."""

    relation: str
    subject: str


SEEDED = tuple(bugs([ROOT / "tests" / "tools" / "evidence" / "relation_bugs.toml"], Seeded))


def find(seeded: Seeded, subject: Subject, engine: str = "builtin") -> str:
    """Return the difference that reveals a seeded bug; empty if there is none.

    Args:
        seeded: The bug.
        subject: The program it names.
        engine: The engine that runs it.
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
