"""Bugs put into copies of the library: each breaks exactly the properties that it should."""

from __future__ import annotations

import hashlib
import shutil
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rcx_harness.errors import InputError
from rcx_harness.spec import load_toml
from rcx_harness.verify.prove.solve import PROVED
from rcx_tools.evidence.prove.claims import CLAIMS
from rcx_tools.evidence.prove.hunting import CLIENTS, Found, hunt
from rcx_tools.evidence.prove.jobs import (
    PROPERTIES,
    Job,
    jobs,
    property_of,
    rests_on,
    run_until_broken,
)
from rcx_tools.evidence.prove.library import Library
from rcx_tools.evidence.prove.running import DIED
from rcx_tools.evidence.results import ROOT
from rcx_tools.evidence.store import digest

__all__ = ["BUGS", "Bug", "Task", "bugs", "chosen", "died", "judge", "summary", "tasks"]

#: The tables.
BUGS = ROOT / "tests" / "tools" / "evidence" / "proof_bugs"
_KEYS = ("name", "file", "old", "new", "breaks")
#: What the report says of each.
_ROW = ("name", "file", "breaks", "left_out", "seconds", "run")
#: Of a property that stays proved so many of the parts that a bug touches are asked for, the
#: quickest ones, as long as they take no longer than this with the library as it is [s].
_STAYS, _STAYS_S = 2, 1.5
#: A goal that a bug breaks is given up after this time [s].
_LIMIT_S = 20.0
#: What judges a bug, beside the proofs.
_JUDGES = ("claims", "client", "hunting", "seeded")


@dataclass(frozen=True)
class Bug:
    """One row of a table; `old` stands once in `file`, and becomes `new`."""

    name: str
    file: str
    old: str
    new: str
    breaks: tuple[str, ...]

    def check(self, library: Path) -> None:
        """See that it can be put in.

        Raises:
            InputError: `old` does not stand once in the file, or `breaks` names no property.
        """
        file = library / self.file
        text = file.read_text(encoding="utf-8") if file.is_file() else ""
        times = text.count(self.old)
        if times != 1 or self.old == self.new:
            raise InputError(
                f"the seeded bug {self.name!r}: `old` stands {times} times in {self.file}",
                hint="give text that stands there once, and another one instead",
            )
        for name in self.breaks:
            property_of(name)

    def put_into(self, library: Path) -> None:
        """Change the copy of a library."""
        file = library / self.file
        text = file.read_text(encoding="utf-8")
        file.write_text(text.replace(self.old, self.new), encoding="utf-8")


@dataclass(frozen=True)
class Task:
    """A bug, with the parts of properties that rest on what it changes, and where to work.

    Attributes:
        parts: Those of the properties that it breaks, and some of the others.
        left_out: The others of which none is among them, since each takes long.
    """

    key: str
    bug: Bug
    library: str
    folder: str
    parts: tuple[Job, ...]
    left_out: tuple[str, ...] = ()


def bugs(folder: Path) -> list[Bug]:
    """The rows of all tables, by file and place.

    Raises:
        InputError: no TOML, a row that lacks something, or a name that is there twice.
    """
    found: dict[str, Bug] = {}
    for file in sorted(folder.glob("*.toml")):
        for number, row in enumerate(load_toml(file).get("bug", []), 1):
            if set(row) != set(_KEYS) or not row["breaks"]:
                raise InputError(
                    f"seeded bug {number} has {', '.join(row)}",
                    file=file,
                    hint=f"it needs {', '.join(_KEYS)}, and breaks something",
                )
            if row["name"] in found:
                raise InputError(f"a second seeded bug {row['name']!r}", file=file)
            found[row["name"]] = Bug(**{**row, "breaks": tuple(row["breaks"])})
    return list(found.values())


def chosen(library: Library, wanted: Sequence[str], tables: Path) -> list[Bug]:
    """All bugs, or those that are wanted; each can be put in.

    Raises:
        InputError: there is no bug of a name, or one cannot be put in.
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
    took: Callable[[str], float] = lambda _: 0.0,
) -> list[Task]:
    """What is to be judged: all bugs, or those that are wanted.

    `took` says how long a part takes with the library as it is, by the key of its job [s].

    Raises:
        InputError: there is no bug of a name, or one cannot be put in.
    """
    every = list(jobs(library, limit_s=min(limit_s, _LIMIT_S)))
    used = {
        job: library.used(rests_on(library, property_of(job.property), job.part)) for job in every
    }
    return [
        _task(
            library,
            bug,
            [job for job in every if used[job] & changed or not changed],
            folder,
            took,
        )
        for bug in chosen(library, wanted, tables)
        for changed in [library.in_file(bug.file)]
    ]


def _task(
    library: Library, bug: Bug, parts: list[Job], folder: Path, took: Callable[[str], float]
) -> Task:
    parts.sort(key=lambda job: job.part.upper() not in library.in_file(bug.file))
    names = library.state(library.named(bug.new))
    rests = "\n".join([_own_state(), repr(bug), names, *(job.key for job in parts)])
    key = hashlib.sha256(rests.encode()).hexdigest()[:16]
    where = str(folder / bug.name)
    asked = [job for job in parts if job.property in bug.breaks]
    left_out = []
    for name in dict.fromkeys(job.property for job in parts if job.property not in bug.breaks):
        ours = [job for job in parts if job.property == name]
        quick = [job for job in ours if took(job.key) <= _STAYS_S]
        asked += sorted(quick, key=lambda job: took(job.key))[:_STAYS]
        if not quick:
            left_out.append(name)
    folders = str(library.folder), where
    return Task(f"bug {bug.name}:{key}", bug, *folders, tuple(asked), tuple(left_out))


def _own_state() -> str:
    """Of what judges, beside the proofs."""
    files = (Path(__file__).with_name(f"{name}.py") for name in _JUDGES)
    return digest(Path(__file__).parent, files)


def judge(task: Task) -> dict[str, Any]:
    """Put the bug into a copy of the library; see which properties are still proved."""
    begin = time.monotonic()
    copy = Path(task.folder) / "lib"
    shutil.rmtree(task.folder, ignore_errors=True)
    shutil.copytree(task.library, copy)
    task.bug.put_into(copy)
    library = Library(copy)
    try:
        library.project  # noqa: B018 - is it Structured Text at all
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
    outcome = _outcome(task, begin, broken, defects)
    if not defects:
        run = _hunted(task, broken, library)
        outcome |= {"run": None if run is None else asdict(run)}
    return outcome | {"seconds": round(time.monotonic() - begin, 1)}


def _hunted(task: Task, broken: Mapping[str, Any], library: Library) -> Found | None:
    """A run from the start that breaks what the bug should break."""
    names = {pou.upper(): pou for pou in (library.pou(name).name for name in library.blocks)}
    near = {goal["part"] for goal in broken.values()} | library.in_file(task.bug.file)
    own = [names[name] for name in sorted(near & set(names)) if "AREA" not in name]
    kinds = [kind for name in task.bug.breaks for kind in CLAIMS.get(name, ())]
    if not kinds:
        return None
    for blocks in [own] if own else CLIENTS:
        found = hunt(
            task.bug.name, task.bug.file, blocks, kinds, Path(task.folder), Path(task.library)
        )
        if found is not None:
            return found
    return None


def _first_broken(parts: Iterable[Job], library: Library) -> dict[str, Any] | None:
    """The first goal that is not proved."""
    for job in parts:
        outcome = run_until_broken(job, library)
        if outcome["status"] != PROVED:
            goal: dict[str, Any] = outcome["goals"][-1] if outcome["goals"] else {"goal": "none"}
            return {"part": job.part, **goal}
    return None


def died(task: Task) -> dict[str, Any]:
    """The outcome of a bug whose process has ended by itself."""
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
        "run": None,
        "seconds": round(time.monotonic() - begin, 1),
    }


def summary(
    work: Sequence[Task], judged: Mapping[str, Mapping[str, Any]], *, whole: bool
) -> dict[str, Any]:
    """The figures; `whole` says that all bugs were tried, so that each property has one."""
    rows = [judged[task.key] for task in work]
    refuted = [row for row in rows if not row["defects"] and row["run"]]
    return {
        "tried": len(rows),
        "refuted": len(refuted),
        "as_expected": sum(not row["defects"] for row in rows),
        "unknown": [
            {"name": row["name"], "broken": row["broken"]}
            for row in rows
            if not row["defects"] and not row["run"]
        ],
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
