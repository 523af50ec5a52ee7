"""Seeded bugs in copies of the library. Each must break exactly the properties of its row."""

from __future__ import annotations

import hashlib
import shutil
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rcx_tools.evidence import broken
from rcx_tools.evidence.prove.jobs import (
    PROPERTIES,
    Job,
    jobs,
    library_at,
    property_of,
    rests_on,
    run_until_broken,
)
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.running import DIED
from rcx_tools.evidence.results import ROOT
from structured_text.errors import InputError
from structured_text.output.results import digest
from structured_text.prove.logic import PROVED

__all__ = [
    "BUGS",
    "SLOW",
    "Bug",
    "Task",
    "bugs",
    "chosen",
    "died",
    "judge",
    "summary",
    "tasks",
]

#: Folder with the tables of bugs.
BUGS = ROOT / "tests" / "tools" / "evidence" / "proof_bugs"
_HERE = Path(__file__).parent
#: Fields of each bug in the report.
_ROW = ("name", "file", "breaks", "left_out", "seconds")
#: Number of parts that are proved again for a property that must stay proved. Only parts that
#: depend on the changed file count: first parts about this file, then parts that depend on little
#: text.
_STAYS = 2
#: Slow parts of properties. They are not proved again if their property must stay proved. () means
#: all parts of the property.
SLOW: Mapping[str, tuple[str, ...]] = {
    "interval": (),
    "handshake": (),
    "bytes": ("FB_WRITEAREA", "FB_WRITEAREAWORDS"),
    "turn-once": tuple(
        f"{channel} {block}"
        for channel in ("COMMAND", "SEQUENCE")
        for block in ("FB_RCXJOB", "FB_WRITEAREA", "FB_WRITEAREAWORDS")
    ),
    "restart": ("FB_SERVOONFROMEMERGENCYSTOP", "FB_STEPPROGRAM"),
    "response": ("FB_POINTRESTORE",),
    "telegram-legal": ("REAL_TO_DINT and FC_RcxCharCode",),
    "telegram-pins": ("REAL_TO_DINT and FC_RcxCharCode", "FB_RESETSELECTEDPROGRAM"),
    "safety": ("FB_COMMANDRECORDER", "FB_MOVEARCH", "FB_PALLETMOVEARCH"),
    "contract": ("FB_COMMANDRECORDER", "FB_ENTRYTEXT"),
}
#: Time limit of the solver for a goal that a bug should break [s].
_LIMIT_S = 20.0


@dataclass(frozen=True)
class Bug(broken.Bug):
    """One row of a table of bugs, with the names of the properties that the bug breaks."""

    breaks: tuple[str, ...]

    def check(self, folder: Path) -> None:
        """Check that the bug can be inserted.

        Raises:
            InputError: `old` does not occur exactly once in the file, or a property does not exist.
        """
        super().check(folder)
        for name in self.breaks:
            property_of(name)


@dataclass(frozen=True)
class Task:
    """The work item for a bug: the parts of properties to prove, and the folder to work in.

    Attributes:
        parts: All parts of the properties that the bug breaks, and some parts of the others.
        left_out: Properties that are not proved again, because all their parts are slow (`SLOW`).
    """

    key: str
    bug: Bug
    library: str
    folder: str
    parts: tuple[Job, ...]
    left_out: tuple[str, ...] = ()


def bugs(folder: Path) -> list[Bug]:
    """Return the rows of all tables, sorted by file, in the order of the rows."""
    return broken.bugs(sorted(folder.glob("*.toml")), Bug)


def chosen(library: Library, wanted: Sequence[str], tables: Path) -> list[Bug]:
    """Return all bugs or the wanted bugs, and check that each of them can be inserted.

    Raises:
        InputError: a bug does not exist, or cannot be inserted.
    """
    known = bugs(tables)
    for name in wanted:
        if name not in {bug.name for bug in known}:
            raise InputError(f"there is no seeded bug {name!r}", hint=f"look into {tables}")
    for bug in known:
        bug.check(library.folder)
    return [bug for bug in known if not wanted or bug.name in wanted]


def tasks(
    library: Library,
    wanted: Sequence[str],
    limit_s: float,
    folder: Path,
    tables: Path,
) -> list[Task]:
    """Return the tasks for all bugs, or for the wanted bugs.

    Parts that depend on the least text come first. Unlike an order by run times, this order is the
    same on every machine.

    Raises:
        InputError: a bug does not exist, or cannot be inserted.
    """
    every = list(jobs(library, limit_s=min(limit_s, _LIMIT_S)))
    used = {
        job: library.used(rests_on(library, property_of(job.property), job.part)) for job in every
    }
    sizes = {name: Path(library.pou(name).file).stat().st_size for name in library.pous}
    every.sort(key=lambda job: (sum(sizes[name] for name in used[job]), job.part))
    return [
        _task(
            library,
            bug,
            [job for job in every if used[job] & changed or not changed],
            folder,
        )
        for bug in chosen(library, wanted, tables)
        for changed in [library.in_file(bug.file)]
    ]


def _task(library: Library, bug: Bug, parts: list[Job], folder: Path) -> Task:
    changed = library.in_file(bug.file)
    parts.sort(key=lambda job: job.part.upper() not in changed)
    names = library.state(library.named(bug.new))
    rests = "\n".join(
        [digest(_HERE, [Path(__file__)]), repr(bug), names, *(job.key for job in parts)]
    )
    key = hashlib.sha256(rests.encode()).hexdigest()[:16]
    where = str(folder / bug.name)
    asked = [job for job in parts if job.property in bug.breaks]
    left_out = []
    for name in dict.fromkeys(job.property for job in parts if job.property not in bug.breaks):
        ours = [job for job in parts if job.property == name]
        quick = [job for job in ours if not _is_slow(job)]
        asked += list({_twin(job): job for job in reversed(quick)}.values())[: -_STAYS - 1 : -1]
        if not quick:
            left_out.append(name)
    folders = str(library.folder), where
    return Task(f"bug {bug.name}:{key}", bug, *folders, tuple(asked), tuple(left_out))


def _twin(job: Job) -> str:
    """Return the name of a block without the ending of its twin for process images of words."""
    return job.part.upper().removesuffix("WORDS").removesuffix("IN")


def _is_slow(job: Job) -> bool:
    return job.property in SLOW and (not SLOW[job.property] or job.part in SLOW[job.property])


def judge(task: Task) -> dict[str, Any]:
    """Insert a bug into a copy of the library. Return the properties that are still proved."""
    begin = time.monotonic()
    copy = Path(task.folder) / "lib"
    shutil.rmtree(task.folder, ignore_errors=True)
    shutil.copytree(task.library, copy)
    task.bug.put_into(copy)
    sound = library_at(task.library)
    library = Library(copy, sound.folder)
    try:
        library.project  # noqa: B018 - check that it compiles
    except InputError as error:
        return _outcome(task, begin, {}, [f"it does not compile: {error}"])
    broken: dict[str, Any] = {}
    defects = []
    for item in sorted(PROPERTIES, key=lambda one: one.name not in task.bug.breaks):
        parts = [job for job in task.parts if job.property == item.name]
        expected = item.name in task.bug.breaks
        goal = _first_broken(parts, library)
        if goal is not None:
            broken[item.name] = goal
        if expected and goal is None:
            defects.append(f"{item.name} is still proved")
        elif goal is not None and not expected:
            defects.append(f"{item.name} is not proved any more: {goal['part']} {goal['goal']}")
    return _outcome(task, begin, broken, defects)


def _first_broken(parts: Iterable[Job], library: Library) -> dict[str, Any] | None:
    """Return the first goal that is not proved, or None."""
    for job in parts:
        outcome = run_until_broken(job, library)
        if outcome["status"] != PROVED:
            goal: dict[str, Any] = outcome["goals"][-1] if outcome["goals"] else {"goal": "none"}
            return {"part": job.part, **goal}
    return None


def died(task: Task) -> dict[str, Any]:
    """Return the outcome for a bug whose process has died."""
    return _outcome(task, time.monotonic(), {}, [DIED])


def _outcome(
    task: Task, begin: float, broken: dict[str, Any], defects: Sequence[str]
) -> dict[str, Any]:
    return {
        "key": task.key,
        "good": not defects,
        **asdict(task.bug),
        "broken": broken,
        "left_out": list(task.left_out),
        "defects": list(defects),
        "seconds": round(time.monotonic() - begin, 1),
    }


def summary(
    work: Sequence[Task], judged: Mapping[str, Mapping[str, Any]], *, whole: bool
) -> dict[str, Any]:
    """Return the figures.

    If `whole` is True, all bugs were tried. Each property must then be broken by a bug.
    """
    rows = [judged[task.key] for task in work]
    return {
        "tried": len(rows),
        "as_expected": sum(not row["defects"] for row in rows),
        "defects": list(_defects(rows, whole=whole)),
        "bugs": [{name: row[name] for name in _ROW} for row in rows],
    }


def _defects(rows: Iterable[Mapping[str, Any]], *, whole: bool) -> Iterator[str]:
    breaks = set()
    for row in rows:
        breaks |= set(row["broken"])
        for text in row["defects"]:
            yield f"the seeded bug {row['name']} in {row['file']}: {text}"
    for item in PROPERTIES if whole else ():
        if item.name not in breaks:
            yield f"no seeded bug breaks {item.name}"
