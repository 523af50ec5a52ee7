"""Coverage counters for executed Structured Text; used only if a user asks for coverage.

Every program that the built-in engine compiles inside `with counting(collector)` counts its
executed statements. All programs that are compiled from the same file share its counters. Programs
in other languages, such as those of devices around the PLC, bring their own lines and counters
(`Collector.text`).
"""

from __future__ import annotations

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from structured_text.output.paths import real

__all__ = [
    "Collector",
    "Counted",
    "CountedText",
    "Counts",
    "Seen",
    "TextBranch",
    "collecting",
    "counting",
]

if TYPE_CHECKING:
    from structured_text.engines.builtin.coverage import Decision, Plan
    from structured_text.language.project import Project
    from structured_text.language.tree import Pou


class Seen(dict[int, bool]):
    """The vectors in which a decision has been evaluated, each with its outcome."""

    def __init__(self, decision: Decision) -> None:
        super().__init__()
        self._decision = decision

    def __missing__(self, vector: int) -> bool:
        outcome = self[vector] = self._decision.outcome(vector)
        return outcome


class LazySeen(Seen):
    """The vectors of a decision that may skip conditions.

    Each evaluated condition calls `see`. A vector has n bits for the values of the n conditions,
    and above them n bits that mark the skipped conditions.
    """

    def __init__(self, decision: Decision) -> None:
        super().__init__(decision)
        self._size = len(decision.conditions)
        # A stack: a method that a condition calls may evaluate the same decision again.
        self._open: list[int] = []

    def begin(self) -> None:
        """Start an evaluation, with all conditions marked as skipped."""
        self._open.append((1 << self._size) - 1 << self._size)

    def see(self, number: int, value: bool) -> bool:
        """Record the value of a condition and return it."""
        self._open[-1] = self._open[-1] & ~(1 << number + self._size) | value << number
        return value

    def end(self, outcome: bool) -> bool:
        """Record the outcome of the decision and return it."""
        self[self._open.pop()] = bool(outcome)
        return outcome


class Counts:
    """The counters of one POU.

    Attributes:
        counters: Number of executions of each sequence of statements and of each empty branch.
        seen: The vectors of each decision.
    """

    def __init__(self, plan: Plan) -> None:
        self.counters = [0] * plan.size
        self.seen = [LazySeen(one) if one.lazy else Seen(one) for one in plan.decisions]


class Counted(NamedTuple):
    """A POU with counters.

    Attributes:
        hash: A hash of the file's content.
        plan: The numbers of the POU's counters and decisions.
        sources: The source paths of the program that lead to this file.
    """

    file: str
    hash: str
    pou: Pou
    plan: Plan
    counts: Counts
    sources: tuple[Path, ...]


class TextBranch(NamedTuple):
    """A branch in a program in another language.

    `line` is the first line of the branch, `at` the line of the statement that has the branch, and
    `fork` the number of this statement.
    """

    line: int
    at: int
    counter: int
    fork: int
    text: str


@dataclass(frozen=True)
class CountedText:
    """A program that is not Structured Text, such as a device's program; its interpreter counts.

    Attributes:
        file: Absolute path of the file.
        hash: A hash of the file's content.
        name: Name of the program.
        line: First line of the program in the file.
        lines: The lines of the program, by line number.
        reasons: The reasons why lines are unreachable, by line number.
        statements: Line and counter of each statement.
        counters: Number of executions; the interpreter increases them.
    """

    file: str
    hash: str
    name: str
    line: int
    lines: Mapping[int, str]
    reasons: Mapping[int, str]
    statements: Sequence[tuple[int, int]]
    branches: Sequence[TextBranch]
    counters: list[int]


class Collector:
    """The counts of all sources below a folder.

    Without `folder` all sources are counted. Libraries are counted only if `library` is true.

    Attributes:
        elsewhere: Names of engines that have run programs without counting.
    """

    def __init__(self, folder: Path | None = None, *, library: bool = True) -> None:
        self._folder = real(folder) if folder else None
        self._library = library
        self._apart: set[Path] = set()
        self.elsewhere: set[str] = set()
        self._counted: dict[tuple[str, str, str, tuple[int, ...]], Counted] = {}
        self._texts: dict[tuple[str, str, str], CountedText] = {}

    def leave_out(self, library: Path) -> None:
        """Exclude the folder of a library from the counts; do nothing if `library` is true."""
        if not self._library:
            self._apart.add(real(library))

    def counts(self, pou: Pou, plan: Plan, project: Project) -> Counts | None:
        """Return the counters of a POU; None if its source is not counted."""
        file = _resolved(os.path.abspath(pou.file))
        if not self._counts(file) or _is_generated(pou, project):
            return None
        # The plan also depends on constants of other files, so one text can have several plans.
        shape = plan.size, *(len(one.conditions) for one in plan.decisions)
        text = _hash(file, file.stat().st_mtime_ns)
        key = str(file), text, pou.name.upper(), shape
        if key not in self._counted:
            sources = tuple(one for one in project.files if str(one) == pou.file)
            self._counted[key] = Counted(str(file), text, pou, plan, Counts(plan), sources)
        return self._counted[key].counts

    def text(
        self, path: str, name: str, made: Callable[[], Mapping[str, Any]]
    ) -> CountedText | None:
        """Return the counters of a program in another language; None if it is not counted.

        Args:
            path: The file of the program.
            name: The name of the program.
            made: A function that returns the other fields of CountedText, except for the hash. It
                is called once for each content of the file.
        """
        file = _resolved(os.path.abspath(path))
        if not self._counts(file):
            return None
        key = str(file), _hash(file, file.stat().st_mtime_ns), name
        if key not in self._texts:
            self._texts[key] = CountedText(*key[:2], name=name, **made())
        return self._texts[key]

    def _counts(self, file: Path) -> bool:
        """Return whether the sources in a file are counted."""
        if self._folder is not None and self._folder not in file.parents:
            return False
        return self._apart.isdisjoint(file.parents) and file.is_file()

    @property
    def texts(self) -> list[CountedText]:
        """Return all counted programs that are not Structured Text."""
        return list(self._texts.values())

    @property
    def counted(self) -> list[Counted]:
        """Return all counted POUs."""
        return list(self._counted.values())


def _is_generated(pou: Pou, project: Project) -> bool:
    """Return whether the file of a POU has no text of it, because a reader has added the POU."""
    return any(
        getattr(one, "generated", False)
        and str(one) == pou.file
        and getattr(one, "title", "").upper() == pou.name.upper()
        for one in project.files
    )


@lru_cache(maxsize=1024)
def _resolved(file: str) -> Path:
    return real(file)


@lru_cache(maxsize=1024)
def _hash(file: Path, stamp: int) -> str:
    """Return a hash of a file; if its time of change (`stamp`) is new, the file is read again."""
    return hashlib.sha256(file.read_bytes()).hexdigest()


_collecting: list[Collector] = []


@contextmanager
def counting(collector: Collector) -> Iterator[Collector]:
    """Let every program that is compiled inside this context count its executed statements."""
    _collecting.append(collector)
    try:
        yield collector
    finally:
        _collecting.remove(collector)


def collecting() -> Collector | None:
    """Return the collector of the innermost `counting`, or None."""
    return _collecting[-1] if _collecting else None
