"""The jobs behind `make prove`: one part of one property each, with what is known of it."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.verify.prove.logic import UnsupportedError
from rcx_harness.verify.prove.solve import UNKNOWN, ask
from rcx_tools.evidence.checks import digest
from rcx_tools.evidence.prove import contract, functions, interval, safety
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.property import Property

__all__ = ["PROPERTIES", "Job", "jobs", "run"]

#: All of them, in the order of the page.
PROPERTIES: tuple[Property, ...] = (
    *interval.PROPERTIES,
    *contract.PROPERTIES,
    *functions.PROPERTIES,
    *safety.PROPERTIES,
)

#: What a proof depends on besides the sources that it is about.
_PROVER = (
    "harness/rcx_harness/engine",
    "harness/rcx_harness/verify/prove",
    "harness/rcx_tools/evidence/prove",
    "spec",
)


@dataclass(frozen=True)
class Job:
    """A part of a property of a copy of plc/lib; `key` names it with all that it depends on."""

    folder: str
    property: str
    part: str
    limit_s: float
    key: str


@lru_cache(maxsize=4)
def _library(folder: str) -> Library:
    return Library(Path(folder))


def _property(name: str) -> Property:
    return next(item for item in PROPERTIES if item.name == name)


def jobs(library: Library, wanted: Iterable[str] = (), limit_s: float = 60.0) -> Iterator[Job]:
    """Every part of every property, or of those that are wanted.

    Raises:
        InputError: there is no property of a name.
    """
    names = [item.name for item in PROPERTIES]
    for name in wanted:
        if name not in names:
            raise InputError(f"there is no property {name!r}", hint=f"use {', '.join(names)}")
    state = digest(_PROVER)
    for item in PROPERTIES:
        if wanted and item.name not in wanted:
            continue
        for part in item.parts(library):
            rests_on = list(library.pous) if item.rests_on is None else list(item.rests_on(part))
            key = hashlib.sha256(f"{state} {library.state(rests_on)} {limit_s}".encode())
            yield Job(
                str(library.folder),
                item.name,
                part,
                limit_s,
                f"{item.name}:{part}:{key.hexdigest()[:16]}",
            )


def run(job: Job) -> dict[str, Any]:
    """Ask the solver; the outcome of each goal, and of all of them the worst."""
    library = _library(job.folder)
    goals = []
    try:
        for goal in _property(job.property).goals(library, job.part):
            answer = ask(goal.assumed, goal.claim, job.limit_s, goal.show)
            goals.append({"goal": goal.name, **asdict(answer)})
    except UnsupportedError as error:
        goals.append({"goal": job.part, "status": UNKNOWN, "seconds": 0.0, "reason": str(error)})
    order = ("refuted", "unknown", "proved")
    status = min((goal["status"] for goal in goals), key=order.index, default=UNKNOWN)
    return {
        "key": job.key,
        "property": job.property,
        "part": job.part,
        "status": status,
        "seconds": sum(goal["seconds"] for goal in goals),
        "goals": goals,
    }
