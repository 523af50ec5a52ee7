"""The jobs of `make prove`.

Each job proves one part of one property. Its key is a hash of its inputs.
"""

from __future__ import annotations

import hashlib
import signal
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import z3

from rcx_tools.evidence.prove import (
    contract,
    functions,
    guarantee,
    handshake,
    image,
    interval,
    levels,
    overflow,
    place,
    restart,
    safety,
    telegrams,
    tickets,
)
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.property import Property
from rcx_tools.evidence.prove.running import DIED
from rcx_tools.evidence.prove.solve import ask
from rcx_tools.evidence.prove.sources import module_of, prover_state
from structured_text.errors import InputError
from structured_text.prove.logic import PROVED, REFUTED, UNKNOWN, UnsupportedError

__all__ = [
    "PROPERTIES",
    "Job",
    "answers",
    "died",
    "jobs",
    "library_at",
    "property_of",
    "rests_on",
    "run",
    "run_until_broken",
    "worst",
]

#: All properties, in the order of the evidence page.
PROPERTIES: tuple[Property, ...] = (
    *interval.PROPERTIES,
    *guarantee.PROPERTIES,
    *place.PROPERTIES,
    *image.PROPERTIES,
    *levels.PROPERTIES,
    *restart.PROPERTIES,
    *handshake.PROPERTIES,
    *tickets.PROPERTIES,
    *contract.PROPERTIES,
    *telegrams.PROPERTIES,
    *safety.PROPERTIES,
    *overflow.PROPERTIES,
    *functions.PROPERTIES,
)

#: If a goal exceeds the time limit of the solver by this time [s], its process is ended.
_HANGS = 120


@dataclass(frozen=True)
class Job:
    """A part of a property for a copy of plc/lib. `key` includes a hash of all inputs."""

    folder: str
    property: str
    part: str
    limit_s: float
    key: str


@lru_cache(maxsize=2)
def library_at(folder: str) -> Library:
    """Return the library in a folder. The last two libraries are cached."""
    return Library(Path(folder))


def property_of(name: str) -> Property:
    """Return a property by its name.

    Raises:
        InputError: there is no such property.
    """
    for item in PROPERTIES:
        if item.name == name:
            return item
    names = ", ".join(item.name for item in PROPERTIES)
    raise InputError(f"there is no property {name!r}", hint=f"use {names}")


def rests_on(library: Library, item: Property, part: str) -> list[str]:
    """Return the POUs that a part of a property is about, without the POUs that they use."""
    return list(library.pous) if item.rests_on is None else list(item.rests_on(part))


def jobs(library: Library, wanted: Iterable[str] = (), limit_s: float = 60.0) -> Iterator[Job]:
    """Yield a job for every part of all properties, or of the wanted properties.

    Raises:
        InputError: a property does not exist, or the library lacks a block.
    """
    names = {property_of(name).name for name in wanted}
    for item in PROPERTIES:
        if names and item.name not in names:
            continue
        state = prover_state(module_of(item), ask.__module__)
        for part in item.parts(library):
            sources = library.state(rests_on(library, item, part))
            key = hashlib.sha256(f"{state} {sources}".encode()).hexdigest()[:16]
            yield Job(str(library.folder), item.name, part, limit_s, f"{item.name}:{part}:{key}")


def run(job: Job) -> dict[str, Any]:
    """Prove the goals of a job.

    Return the outcome of each goal, and the worst outcome as status.
    """
    return _judged(job, answers(job, library_at(job.folder)))


def run_until_broken(job: Job, library: Library) -> dict[str, Any]:
    """Prove the goals of a job like `run`, but stop at the first goal that is not proved."""
    goals = []
    for goal in answers(job, library):
        goals.append(goal)
        if goal["status"] != PROVED:
            break
    return _judged(job, goals)


def died(job: Job) -> dict[str, Any]:
    """Return the outcome of a job whose process has died."""
    return _judged(job, [_unknown(job, DIED)])


def worst(statuses: Iterable[str]) -> str:
    """Return the worst of several statuses. For an empty list return UNKNOWN."""
    return min(statuses, key=(REFUTED, UNKNOWN, PROVED).index, default=UNKNOWN)


def answers(job: Job, library: Library) -> Iterator[dict[str, Any]]:
    """Yield the answer of the solver to each goal.

    If a goal cannot be made, the last answer is `unknown`, for the whole part.
    """
    z3.set_param("smt.random_seed", 0)
    z3.set_param("sat.random_seed", 0)
    _watch(job.limit_s)
    try:
        for goal in property_of(job.property).goals(library, job.part):
            _watch(job.limit_s)
            answer = ask(goal.assumed, goal.claim, job.limit_s, goal.show)
            yield {"goal": goal.name, **asdict(answer)}
            _watch(job.limit_s)
    except KeyError as error:
        yield _unknown(job, f"the goal needs {error}, which does not exist")
    except (UnsupportedError, z3.Z3Exception, MemoryError) as error:
        yield _unknown(job, str(error) or type(error).__name__)
    finally:
        _watch(None)


def _watch(limit_s: float | None) -> None:
    """End this process if a goal hangs. Other processes continue.

    With None the supervision ends.
    """
    if hasattr(signal, "alarm"):
        signal.alarm(0 if limit_s is None else int(limit_s) + _HANGS)


def _unknown(job: Job, reason: str) -> dict[str, Any]:
    return {"goal": job.part, "status": UNKNOWN, "seconds": 0.0, "values": {}, "reason": reason}


def _judged(job: Job, goals: Iterable[dict[str, Any]]) -> dict[str, Any]:
    found = list(goals)
    status = worst(goal["status"] for goal in found)
    return {
        "key": job.key,
        "property": job.property,
        "part": job.part,
        "status": status,
        "good": status == PROVED,
        "seconds": sum(goal["seconds"] for goal in found),
        "goals": found,
    }
